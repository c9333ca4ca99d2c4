//! Layers of a picture beside its light (arbitrary output variables): which there are, and what a finished one holds.

use crate::Method;

/// A layer that a picture may have beside its light. Every value is the mean over the pixel's samples (a box filter of
/// one pixel) of what they meet first: mirrors and glass are surfaces like others here, and where a BLEND surface
/// covers a part, it counts for that part and what lies behind it for the rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Aov {
    /// The fraction of light that the surface sends on, linear RGB in [0, 1]: its diffuse albedo, and where it is a
    /// mirror or glass the weights of the mirrored and the refracted direction besides. Black where nothing is hit and
    /// for unlit surfaces.
    Albedo,
    /// Shading normal on the viewer's side, world space; shorter than 1 where a pixel sees several, 0 where nothing is
    /// hit.
    Normal,
    /// Distance from the camera along the axis that it looks along, metres: the mean over that part of the pixel that
    /// hits something, and [`Aov::FAR_M`] where nothing does.
    Depth,
    /// The part of the light, cd/m², that comes from lamps, sky and emission with no diffuse reflection before the one
    /// that is seen: what shines itself, directly or in mirrors and glass, and the direct light of what is lit.
    Direct,
    /// The rest of the light, cd/m²: [`Aov::Direct`] + [`Aov::Indirect`] is the picture but for rounding. All black for
    /// [`Method::Standard`]. The light of emitters that only gather rays find counts here for methods with a mesh.
    Indirect,
    /// How often the cell of the direct mesh that a surface reads has been refined, the most within the pixel; 0 is the
    /// spacing.
    MeshLevel,
    /// The part, by weight, of the points of the direct mesh which surfaces ask for that they can use, in [0, 1]; 0:
    /// shadow rays are shot instead. 1 where nothing is asked: no surface, no diffuse one, or one that faces no light.
    MeshValid,
    /// A picture of the meshes' points over the grey scene, display colours in [0, 1] (linear): green those of the
    /// direct mesh, blue of the indirect one, and where they are inside solids red and orange. Points that a surface
    /// hides are not drawn, but for those inside solids just behind it, which shine through.
    Points,
}

impl Aov {
    /// All there are.
    pub const ALL: [Self; 8] = [
        Self::Albedo,
        Self::Normal,
        Self::Depth,
        Self::Direct,
        Self::Indirect,
        Self::MeshLevel,
        Self::MeshValid,
        Self::Points,
    ];

    /// [`Aov::Depth`] where nothing is hit, metres: farther than anything and finite, as Blender has it.
    pub const FAR_M: f32 = 1e10;

    /// The name of each, in the order of [`Self::ALL`], and one line about it.
    pub(super) const NAMES: [(&'static str, &'static str); 8] = [
        ("albedo", "The fraction of light that the surface sends on"),
        ("normal", "Shading normal on the viewer's side"),
        ("depth", "Distance from the camera along its axis, metres"),
        ("direct", "Light with no diffuse reflection before the surface"),
        ("indirect", "The rest of the light"),
        ("mesh_level", "How often the mesh has been refined there"),
        ("mesh_valid", "The part of the mesh points that can be used there"),
        ("points", "The points of both meshes over the grey scene"),
    ];

    /// Returns the layer's name, in files and on the command line.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize].0
    }

    /// Returns the layer of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|aov| aov.name() == name)
    }

    /// The names of its channels, in the order of [`Layer::values`]: colours are R, G, B, vectors X, Y, Z, a depth is Z
    /// and any other single value V.
    pub fn channels(self) -> &'static [&'static str] {
        match self {
            Self::Albedo | Self::Direct | Self::Indirect | Self::Points => &["R", "G", "B"],
            Self::Normal => &["X", "Y", "Z"],
            Self::Depth => &["Z"],
            Self::MeshLevel | Self::MeshValid => &["V"],
        }
    }

    /// Whether it shows a mesh, which not every method has.
    pub fn needs_mesh(self) -> bool {
        matches!(self, Self::MeshLevel | Self::MeshValid | Self::Points)
    }

    /// Whether pictures made by `method` have it.
    pub fn is_known_to(self, method: Method) -> bool {
        !self.needs_mesh() || method.has_mesh()
    }
}

/// A set of layers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Aovs(u8);

impl Aovs {
    /// Whether there are none.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether `aov` is one of them.
    pub fn contains(self, aov: Aov) -> bool {
        self.0 >> (aov as u8) & 1 != 0
    }

    /// Them, in the order of [`Aov::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Aov> {
        Aov::ALL.into_iter().filter(move |&aov| self.contains(aov))
    }

    /// Them, and those that they are made from.
    pub(crate) fn with_sources(self) -> Self {
        let sources = if self.contains(Aov::Points) { &[Aov::Albedo, Aov::Normal, Aov::Depth][..] } else { &[] };
        self.iter().chain(sources.iter().copied()).collect()
    }

    /// Memory that collecting them takes, bytes per pixel.
    pub fn bytes_per_pixel(self) -> u64 {
        let collected = self.with_sources();
        let channels: usize = collected.iter().map(|aov| aov.channels().len()).sum();
        (channels + usize::from(collected.contains(Aov::Depth))) as u64 * size_of::<f32>() as u64
    }
}

impl FromIterator<Aov> for Aovs {
    fn from_iter<T: IntoIterator<Item = Aov>>(aovs: T) -> Self {
        Self(aovs.into_iter().fold(0, |set, aov| set | 1 << (aov as u8)))
    }
}

/// A finished layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Which one.
    pub aov: Aov,
    /// One value for each of [`Aov::channels`], pixel by pixel, row by row from the upper left.
    pub values: Vec<f32>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_holds_what_it_was_made_of() {
        let set: Aovs = [Aov::Points, Aov::Direct, Aov::Direct].into_iter().collect();
        assert!(set.iter().eq([Aov::Direct, Aov::Points]));
        assert!(set.with_sources().iter().eq([Aov::Albedo, Aov::Normal, Aov::Depth, Aov::Direct, Aov::Points]));
        // Five layers of 3, 3, 1, 3 and 3 channels and the weight of the depth.
        assert_eq!((set.bytes_per_pixel(), Aovs::default().bytes_per_pixel()), (4 * 14, 0));
    }

    #[test]
    fn names_are_found_again() {
        for aov in Aov::ALL {
            assert_eq!(Aov::named(aov.name()), Some(aov));
        }
        assert_eq!(Aov::named("Albedo"), None);
    }
}
