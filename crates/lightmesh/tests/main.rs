//! All tests of the library from the outside, as one program: it links once.

mod accuracy;
mod aov;
mod area_lights;
mod common;
mod contents;
mod direct_light;
mod environment;
mod flip;
mod floors;
mod graded;
mod indirect_light;
mod invariants;
mod many_lights;
mod materials;
mod meters;
mod neighbourhoods;
mod partial_images;
mod shapes;
mod shared_meshes;
mod textures;
mod verification;
mod viewer;
