//! A renderer for scenes with many lights. It caches visibility and indirect light at the points of a sparse 3D grid,
//! the *light mesh*, and interpolates them to surfaces, so that shadow rays are traced for each mesh point and not for
//! each pixel. Points are evaluated when a surface first needs them, and stay valid when the camera moves.
//!
//! After V. A. Debelov and I. M. Sevastyanov, "Original approach to simulation of soft shadows and diffuse color
//! bleeding in ray tracing", GraphiCon 2001, which all documentation calls *the paper*.
//!
//! # Front doors
//!
//! - [`SceneData`] describes a scene in plain arrays; [`Scene::new`] checks it and builds what rays need.
//! - [`LightMesh`] holds the cached values from frame to frame; [`RenderOptions`] says how they are made and used.
//! - [`render`] makes a picture, [`measure`] the irradiance at given points ([`Meter`]). Both report to a [`Progress`].
//! - [`Snapshot`] is a light mesh's values as plain arrays, to be stored or merged into another mesh.
//! - [`distributed`] shares a picture, or the evaluation of a mesh, among processes.
//! - [`bvh`], [`geometry`] and [`metrics`] are of use by themselves: ray queries, shapes, and differences of pictures.
//!
//! Units are metres, candela, lux and cd/m². The crate reads and writes no files: `lightmesh-io` does.
//!
//! # Floors
//!
//! Folders are stacked, and none imports from one above it. From the ground up: `sampling`, `geometry` and `options`;
//! the description of a `scene`, its `bvh`, its `light` and all together, the `world`; the `interaction` of rays with
//! surfaces; the `mesh` without light, `direct` and `indirect` light on it, and both in a `light_mesh`; the `film`, the
//! `integrator`, and the `api` on top of them.
//!
//! ```
//! use lightmesh::geometry::{Sphere, TriangleMesh};
//! use lightmesh::{Camera, Instance, Light, LightMesh, Material, RenderOptions, Scene, SceneData, render};
//! # use glam::{Affine3A, Vec3};
//! # fn main() -> Result<(), lightmesh::Error> {
//! // A sphere on a floor, and a point light.
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
//! let options = RenderOptions::default().with(|o| (o.picture.width, o.picture.height) = (64, 48));
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

mod api;
pub mod bvh;
mod direct;
pub mod distributed;
mod error;
mod film;
mod fingerprint;
mod first_light;
pub mod geometry;
mod image;
mod indirect;
mod integrator;
mod interaction;
pub(crate) mod light;
mod light_mesh;
mod mesh;
pub mod metrics;
mod options;
mod progress;
mod sampling;
mod scene;
mod viewer;
mod world;

pub use api::{Frame, Measured, measure, render};
pub use error::{Error, human_bytes};
pub use fingerprint::Fingerprint;
pub use first_light::{FirstLight, Survey};
pub use image::{DisplayData, ErrorEstimate, Image, MeshStats, RayCounts, RenderStats, Seconds};
pub use interaction::Meter;
pub use light_mesh::{Cursor, DirectSnapshot, DirectValues, IndirectSnapshot, LightMesh, PointSnapshot, Snapshot};
pub use mesh::{Focus, LatticeShape};
pub use options::{
    Aov, Aovs, Falloff, Interpolation, KeyDifference, Layer, Limits, MeshKey, MeshOptions, Method, MissingCorners,
    PaperScale, PictureOptions, PointWeight, Quality, RenderOptions, Spacing, TransportOptions, schema,
};
pub use progress::{Progress, Stage};
pub use scene::{
    AlphaMode, Camera, EmitterOptions, Environment, FilmRays, Filter, ImageData, Instance, Light, Material, Projection,
    SceneData, ShapeEntry, Texels, Texture, TextureRef, UvTransform, Wrap, soft_environment,
};
pub use viewer::Viewer;
pub use world::Scene;
