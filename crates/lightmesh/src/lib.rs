//! Light meshes: illumination computed lazily at points of a mesh in space and interpolated to surfaces, so that shadow
//! rays are paid per mesh point and not per pixel.
//!
//! After V. A. Debelov and I. M. Sevastyanov, "Original approach to simulation of soft shadows and diffuse color
//! bleeding in ray tracing", GraphiCon 2001; *the paper* in all that follows.
//!
//! A [`SceneData`] says what there is, a [`Scene`] is checked and ready for rays, a [`LightMesh`] keeps the light from frame
//! to frame, and [`render`] makes a picture. [`measure`] reads irradiance at given places instead. [`Contents`] are what a mesh knows
//! as plain arrays. Reading and writing files is the business of `lightmesh-io`. Metres, candela, lux and cd/m² throughout.
//!
//! ```
//! use lightmesh::geometry::{Sphere, TriangleMesh};
//! use lightmesh::{Camera, Instance, Light, LightMesh, Material, RenderOptions, Scene, SceneData, render};
//! # use glam::{Affine3A, Vec3};
//! # fn main() -> Result<(), lightmesh::Error> {
//! // A ball on a floor under a lamp.
//! let floor = TriangleMesh {
//!     positions: vec![Vec3::ZERO, Vec3::new(0.0, 0.0, 4.0), Vec3::new(4.0, 0.0, 4.0), Vec3::new(4.0, 0.0, 0.0)],
//!     triangles: vec![[0, 1, 2], [0, 2, 3]],
//!     ..TriangleMesh::default()
//! };
//! let scene = Scene::new(SceneData {
//!     meshes: vec![floor],
//!     instances: vec![Instance { mesh: 0, world_from_object: Affine3A::IDENTITY }],
//!     spheres: vec![Sphere { center: Vec3::new(2.0, 0.5, 2.0), radius: 0.5, material: 0 }],
//!     materials: vec![Material::lambert(Vec3::splat(0.7))],
//!     lights: vec![Light::Point { position: Vec3::new(1.0, 3.0, 2.0), intensity_cd: Vec3::splat(100.0), range: None }],
//!     ..SceneData::default()
//! })?;
//!
//! // Two pictures; the second only reads what the first one filled.
//! let options = RenderOptions { width: 64, height: 48, ..RenderOptions::default() };
//! let camera = Camera::look_at(Vec3::new(2.0, 2.0, 6.0), Vec3::new(2.0, 0.5, 2.0), 0.8);
//! let mut mesh = LightMesh::new(&scene, &options)?;
//! let first = render(&scene, &camera, &options, &mut mesh, &())?;
//! let second = render(&scene, &camera, &options, &mut mesh, &())?;
//! assert_eq!(first.image, second.image);
//! assert_eq!(second.stats.seconds.fill_direct, 0.0);
//! # Ok(())
//! # }
//! ```

#![forbid(unsafe_code)]

mod aov;
pub mod bvh;
mod error;
pub mod filling;
mod film;
mod fingerprint;
pub mod geometry;
mod image;
mod integrator;
mod light_mesh;
mod measure;
pub mod metrics;
mod options;
pub mod portions;
mod progress;
mod render;
mod scene;
mod viewer;

pub use aov::{Aov, Aovs, Layer};
pub use error::Error;
pub use fingerprint::Fingerprint;
pub use image::{Image, MeshStats, RayCounts, RenderStats, Seconds};
pub use light_mesh::{
    Contents, Counts, DirectContents, DirectValues, IndirectContents, LatticeShape, LightMesh, PointContents,
};
pub use measure::{Measured, Meter, measure};
pub use options::{Falloff, Interpolation, Method, MissingCorners, PaperScale, PointWeight, RenderOptions, Spacing};
pub use progress::{Progress, Stage};
pub use render::{Frame, render};
pub use scene::{
    AlphaMode, Camera, EmitterOptions, Environment, FilmRays, Filter, ImageData, Instance, Light, Material, Projection,
    Scene, SceneData, ShapeEntry, Texels, Texture, TextureRef, UvTransform, Wrap, soft_environment,
};
pub use viewer::Viewer;
