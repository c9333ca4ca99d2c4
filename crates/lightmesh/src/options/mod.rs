//! What the user may choose; the command line and Python take everything about it from [`schema`].

mod aov;
mod chosen;
mod falloff;
mod interpolation;
mod limits;
mod mesh;
mod mesh_key;
mod method;
mod picture;
mod resolve;
pub mod schema;
mod spacing;
mod transport;
mod validate;
mod value;

pub use aov::{Aov, Aovs, Layer};
pub use falloff::Falloff;
pub use interpolation::{Interpolation, MissingCorners, PointWeight};
pub use limits::Limits;
pub use mesh::MeshOptions;
pub(crate) use mesh_key::PointKind;
pub use mesh_key::{KeyDifference, MeshKey};
pub use method::{Method, PaperScale, Quality};
pub use picture::PictureOptions;
pub(crate) use resolve::IndirectMesh;
pub use spacing::Spacing;
pub use transport::TransportOptions;
use value::Expected;

/// Everything that decides what a picture looks like, apart from scene and camera.
///
/// ```
/// use lightmesh::{Method, RenderOptions};
///
/// let exact = RenderOptions { method: Method::Standard, ..RenderOptions::default() };
/// let small = exact.with(|o| (o.picture.width, o.picture.height) = (64, 48));
/// assert_eq!((small.method, small.picture.height), (Method::Standard, 48));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderOptions {
    /// How light is computed, with what only that method has.
    pub method: Method,
    /// The picture's size, samples and layers.
    pub picture: PictureOptions,
    /// How far light is followed, and with what attenuation.
    pub transport: TransportOptions,
    /// Where mesh points are, and how they are read.
    pub mesh: MeshOptions,
    /// What the render may take of the machine.
    pub limits: Limits,
    /// Seed of all randomness.
    pub seed: u64,
}

impl RenderOptions {
    /// Returns them changed.
    #[must_use]
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }
}
