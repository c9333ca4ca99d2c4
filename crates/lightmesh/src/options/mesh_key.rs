//! All that the values of a light mesh depend on beside the scene: the one list of it.

use std::fmt;

use super::{Falloff, Interpolation, Method, PaperScale, PointWeight, RenderOptions, Spacing};

/// What the points of the direct mesh keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PointKind {
    /// Irradiance on six planes.
    SixAxis,
    /// The paper's scalar.
    Scalar {
        /// φ1.
        field_falloff: Falloff,
        /// How it is scaled.
        scale: PaperScale,
    },
    /// Which lights they see.
    ByLight,
}

/// All that the values of a light mesh depend on beside the scene. Frames, mesh files and the parts of a picture
/// compare it: meshes of the same key and scene have the same values.
///
/// Not in it is the number of bounces: a mesh that was made for more of them serves fewer.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshKey {
    pub(crate) kind: PointKind,
    method: Method,
    pub(crate) error_bound: bool,
    pub(crate) falloff: Falloff,
    pub(crate) spacing: Spacing,
    pub(crate) indirect_spacing: Spacing,
    /// Resolved.
    pub(crate) interpolation: Interpolation,
    pub(crate) weight: PointWeight,
    /// Levels beyond the first.
    pub(crate) finer_levels: u32,
    pub(crate) light_error: f32,
    pub(crate) gather_rays: Option<u32>,
    pub(crate) depth: u32,
    pub(crate) seed: u64,
}

/// An option in which two meshes differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyDifference {
    /// The option, in words.
    pub option: &'static str,
    /// Its value of the mesh.
    pub mesh: String,
    /// Its value of the options.
    pub asked: String,
}

impl fmt::Display for KeyDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { option, mesh, asked } = self;
        write!(f, "was made with {option} {mesh}, and the options ask for {asked}")
    }
}

impl MeshKey {
    /// The key of the meshes of these options.
    pub fn of(options: &RenderOptions) -> Self {
        let resolved = options.resolved();
        Self {
            kind: match options.method {
                method if method.knows_lights() => PointKind::ByLight,
                Method::Paper { field_falloff, scale } => PointKind::Scalar { field_falloff, scale },
                _ => PointKind::SixAxis,
            },
            method: options.method,
            error_bound: options.method.error().is_some(),
            falloff: options.transport.falloff,
            spacing: options.mesh.spacing,
            indirect_spacing: options.mesh.indirect_spacing,
            interpolation: resolved.interpolation,
            weight: options.mesh.weight,
            finer_levels: resolved.finer_levels,
            light_error: options.transport.light_error,
            gather_rays: options.mesh.gather_rays,
            depth: options.transport.depth,
            seed: options.seed,
        }
    }

    /// Returns the first option in which a mesh of this key and one of `asked` differ; `None` where their values are
    /// the same.
    pub fn difference(&self, asked: &Self) -> Option<KeyDifference> {
        self.direct_difference(asked).or_else(|| self.indirect_difference(asked))
    }

    /// The same of the direct mesh alone, which has no rays of its own.
    pub(crate) fn direct_difference(&self, asked: &Self) -> Option<KeyDifference> {
        let scalars = match (self.kind, asked.kind) {
            (
                PointKind::Scalar { field_falloff, scale },
                PointKind::Scalar { field_falloff: other_falloff, scale: other_scale },
            ) => differ("field falloff", &field_falloff, &other_falloff)
                .or_else(|| differ("scale", &scale.name(), &other_scale.name())),
            (mine, other) if mine == other => differ("falloff", &self.falloff, &asked.falloff),
            _ => differ("method", &self.method_in_words(), &asked.method_in_words()),
        };
        scalars
            .or_else(|| differ("spacing", &self.spacing, &asked.spacing))
            .or_else(|| differ("indirect spacing", &self.indirect_spacing, &asked.indirect_spacing))
            .or_else(|| differ("interpolation", &self.interpolation, &asked.interpolation))
            .or_else(|| differ("weight", &self.weight.name(), &asked.weight.name()))
            .or_else(|| differ("levels", &(self.finer_levels + 1), &(asked.finer_levels + 1)))
            .or_else(|| differ("light error", &self.light_error, &asked.light_error))
    }

    /// The same of what only the indirect mesh depends on.
    pub(crate) fn indirect_difference(&self, asked: &Self) -> Option<KeyDifference> {
        differ("falloff", &self.falloff, &asked.falloff)
            .or_else(|| differ("a bound on the error:", &yes(self.error_bound), &yes(asked.error_bound)))
            .or_else(|| {
                // A mesh of as many as there are by default, few lamps or many, serves who does not ask.
                let asked = asked.gather_rays.or(self.gather_rays.filter(|&rays| rays == RenderOptions::GATHER_RAYS));
                let in_words = |rays: Option<u32>| rays.map_or("auto".to_owned(), |rays| rays.to_string());
                differ("gather rays", &in_words(self.gather_rays), &in_words(asked))
            })
            .or_else(|| differ("depth", &self.depth, &asked.depth))
            .or_else(|| differ("seed", &self.seed, &asked.seed))
    }

    fn method_in_words(&self) -> String {
        self.method.to_string()
    }
}

fn yes(is: bool) -> &'static str {
    if is { "yes" } else { "no" }
}

fn differ<T: PartialEq + fmt::Display>(option: &'static str, mesh: &T, asked: &T) -> Option<KeyDifference> {
    (mesh != asked).then(|| KeyDifference { option, mesh: mesh.to_string(), asked: asked.to_string() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn difference(change: impl FnOnce(&mut RenderOptions)) -> Option<String> {
        let options = RenderOptions::default();
        let asked = MeshKey::of(&options.clone().with(change));
        MeshKey::of(&options).difference(&asked).map(|difference| difference.to_string())
    }

    #[test]
    fn the_first_difference_is_named() {
        assert_eq!(
            difference(|o| o.mesh.spacing = Spacing::Fraction(80.0)).expect("differs"),
            "was made with spacing auto, and the options ask for 1/80"
        );
        let message = difference(|o| o.method = Method::with_error(0.1)).expect("differs");
        assert_eq!(message, "was made with method mesh, and the options ask for auto");
        assert!(difference(|o| o.seed = 7).expect("differs").contains("seed 0"));
    }

    #[test]
    fn pictures_and_other_names_of_the_same_make_no_difference() {
        let same: [fn(&mut RenderOptions); 4] = [
            |o| o.picture.width = 7,
            |o| o.transport.bounces = 1,
            |o| o.transport.cutoff = 0.5,
            |o| o.mesh.interpolation = Interpolation::Trilinear,
        ];
        assert!(same.into_iter().all(|change| difference(change).is_none()));
    }
}
