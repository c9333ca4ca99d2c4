//! The methods of Scene and LightMesh. They need both classes, which know less of each other: a mesh belongs to a
//! scene, and a scene knows no mesh.

mod light_mesh;
mod scene;
