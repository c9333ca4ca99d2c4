//! Where mesh points are, and how they are read.

use super::{Interpolation, PointWeight, Spacing};

/// Where the points of both meshes are, what they cost and how they are read; for the methods with a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshOptions {
    /// Spacing of the direct mesh.
    pub spacing: Spacing,
    /// Spacing of the indirect mesh; [`Spacing::Auto`]: 1/30, in scenes of 64 punctual lamps or more 1/45.
    pub indirect_spacing: Spacing,
    /// Rays that gather light at a point of the indirect mesh; 1 to 65536. `None`: 256, or half of it where the spacing is
    /// left open too and many lamps make it finer.
    pub gather_rays: Option<u32>,
    /// Short rays at each pixel that find the light and shade of what is nearer to a surface than 1.5 spacings of the
    /// indirect mesh, shared by its samples; 0 to 65536. 0: surfaces get what the mesh says. For the methods
    /// [`Mesh`](super::Method::Mesh) and [`Hybrid`](super::Method::Hybrid), where meshes are read trilinear.
    pub near_rays: u32,
    /// How often the meshes may halve their spacing where their light is not good enough; 0 to 4. `None`: not at all,
    /// or where there is a bound on the error twice.
    pub refine: Option<u32>,
    /// Density that falls with the distance from the eye: mesh points nearer to the camera's position than so many
    /// metres, above 0, have half the spacing, nearer than half of it a quarter, nearer than a quarter of it an eighth.
    /// The spacings above are those of what is farther away. Where points would not fit into half of the memory, fewer
    /// of these steps are taken. It is for meshes that are read trilinear, and what [`Self::refine`] does comes after
    /// it. `None`: one spacing everywhere.
    pub lod_distance: Option<f32>,
    /// How mesh points are combined.
    pub interpolation: Interpolation,
    /// φ4 and φ5: how much each point of a sphere counts, where [`Self::interpolation`] is one.
    pub weight: PointWeight,
}

impl Default for MeshOptions {
    fn default() -> Self {
        Self {
            spacing: Spacing::default(),
            indirect_spacing: Spacing::default(),
            gather_rays: None,
            near_rays: 16,
            refine: None,
            lod_distance: None,
            interpolation: Interpolation::default(),
            weight: PointWeight::default(),
        }
    }
}
