//! All tests of the library from the outside, as one program: it links once.

mod accuracy;
mod adaptive_samples;
mod aov;
mod area_lights;
mod common;
mod contents;
mod direct_light;
mod environment;
mod first_light;
mod flip;
mod floors;
mod focus;
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
