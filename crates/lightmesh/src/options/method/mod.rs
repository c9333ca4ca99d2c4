//! The seven methods, each with what only it has.

mod paper_scale;
mod quality;

use std::fmt;

pub use paper_scale::PaperScale;
pub use quality::Quality;
pub(super) use quality::SamplesOfPixel;

use super::Falloff;

/// How light is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Whatever keeps the error of the picture at least cost, verified by paths: the mesh light by light, shadow rays, short
    /// rays, gather rays. Of many lights, [`RenderOptions::for_scene`](crate::RenderOptions::for_scene) takes
    /// [`Method::Mesh`] in its place.
    Auto {
        /// The error that the picture may have, root mean square relative to its mean; above 0.
        error: f32,
    },
    /// The light mesh, six-axis directional.
    Mesh {
        /// As of [`Method::Auto`], with the mesh for direct light as far as that keeps it, and a ray to each light sample
        /// else. `None`: whatever the mesh gives.
        error: Option<f32>,
    },
    /// The light mesh as the paper writes it: one scalar per channel, formulas (1)-(3g).
    Paper {
        /// φ1: attenuation inside the direct field.
        field_falloff: Falloff,
        /// Scale of Ĩ.
        scale: PaperScale,
    },
    /// A shadow ray to every light sample at every hit: the paper's "standard tracing". Also called `exact`.
    Standard,
    /// What the mesh points know of each single light, and shadow rays to those about which they disagree.
    Hybrid,
    /// The mesh as control variate of light sampling, and the indirect mesh as that of gather rays: converges to the
    /// exact picture.
    Unbiased {
        /// Shadow rays at each hit, and gather rays where there is indirect light; 1 to 65536.
        rays: u32,
    },
    /// Unidirectional path tracing with next-event estimation over all lights: the truth.
    Path,
}

impl Default for Method {
    fn default() -> Self {
        Self::MESH
    }
}

/// The name of each method, as files and both faces spell it, and one line about it.
pub(super) const NAMES: [(&str, &str); 7] = [
    ("auto", "What keeps the error within --quality or --error at least cost: the mesh, shadow, short and gather rays"),
    ("mesh", "Light mesh, six-axis directional"),
    ("paper", "Light mesh as the paper writes it: one scalar per channel, sphere neighbourhood"),
    ("standard", "Shadow ray to every light sample at every hit; also called exact"),
    ("hybrid", "Light mesh by single lights, and shadow rays to those about which it disagrees"),
    ("unbiased", "Light mesh as control variate of light sampling (--rays): converges to the exact picture"),
    ("path", "Path tracer, the reference"),
];

/// Another name that a method may be called by, and its own.
pub(super) const ALIASES: [(&str, &str); 1] = [("exact", "standard")];

impl Method {
    /// Whatever keeps an error of 5% at least cost.
    pub const AUTO: Self = Self::with_error(0.05);
    /// The mesh, with no bound on its error.
    pub const MESH: Self = Self::Mesh { error: None };
    /// The paper's method, attenuated by r² and scaled to a mean visibility.
    pub const PAPER: Self = Self::Paper { field_falloff: Falloff::InverseSquare, scale: PaperScale::Visibility };
    /// The unbiased method with four rays at each hit.
    pub const UNBIASED: Self = Self::Unbiased { rays: 4 };
    /// All of them, each with its defaults.
    pub const ALL: [Self; 7] =
        [Self::AUTO, Self::MESH, Self::PAPER, Self::Standard, Self::Hybrid, Self::UNBIASED, Self::Path];

    /// Whatever keeps this error.
    pub const fn with_error(error: f32) -> Self {
        Self::Auto { error }
    }

    /// The unbiased method with so many rays at each hit.
    pub const fn unbiased(rays: u32) -> Self {
        Self::Unbiased { rays }
    }

    /// Returns the method of that name, or of that alias, with its defaults.
    pub fn named(name: &str) -> Option<Self> {
        let own = ALIASES.iter().find(|(alias, _)| *alias == name).map_or(name, |(_, own)| own);
        Self::ALL.into_iter().find(|method| method.name() == own)
    }

    /// Returns its name, as files and both faces spell it.
    pub fn name(self) -> &'static str {
        let index = match self {
            Self::Auto { .. } => 0,
            Self::Mesh { .. } => 1,
            Self::Paper { .. } => 2,
            Self::Standard => 3,
            Self::Hybrid => 4,
            Self::Unbiased { .. } => 5,
            Self::Path => 6,
        };
        NAMES[index].0
    }

    /// Returns whether it fills and reads a [`LightMesh`](crate::LightMesh).
    pub fn has_mesh(self) -> bool {
        match self {
            Self::Auto { .. } | Self::Mesh { .. } | Self::Paper { .. } | Self::Hybrid | Self::Unbiased { .. } => true,
            Self::Standard | Self::Path => false,
        }
    }

    /// Returns whether it is the paper's.
    pub fn is_paper(self) -> bool {
        matches!(self, Self::Paper { .. })
    }

    /// Returns the bound on the error of the light, where there is one.
    pub fn error(self) -> Option<f32> {
        match self {
            Self::Auto { error } => Some(error),
            Self::Mesh { error } => error,
            _ => None,
        }
    }

    /// Returns whether mesh points keep what they know of each light.
    pub(crate) fn knows_lights(self) -> bool {
        matches!(self, Self::Hybrid | Self::Unbiased { .. } | Self::Auto { .. })
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_aliases_are_found_again() {
        for method in Method::ALL {
            assert_eq!(Method::named(method.name()), Some(method));
        }
        assert_eq!(Method::named("exact"), Some(Method::Standard));
        assert_eq!(Method::named("Mesh"), None);
    }
}
