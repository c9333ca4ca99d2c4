//! Light at surfaces: the four tracers and what they share.
//!
//! # Reflection model
//! A surface is Lambert plus mirror, after glTF 2.0's metallic-roughness model with its lobe narrowed to a mirror:
//!
//! - F0 = mix(min(((ior − 1) / (ior + 1))² · specularColor, 1) · specular, baseColor, metallic),
//!   F90 = mix(specular, 1, metallic), F = F0 + (F90 − F0)(1 − cosθ)⁵ (Schlick 1994; KHR_materials_specular, _ior).
//! - roughness ≤ [`Material::MIRROR_ROUGHNESS`](crate::Material::MIRROR_ROUGHNESS): the mirror direction carries F, the
//!   diffuse albedo is baseColor · (1 − metallic)(1 − transmission)(1 − F).
//! - rougher: no mirror; Lambert of the base colour, metals included. `specular` = 0 is exactly Lambert at any roughness.
//! - transmission (at any roughness, seen sharp): the refracted direction carries baseColor · (1 − metallic) · transmission ·
//!   (1 − F). A `double_sided` surface is a thin sheet with no inside: its ray goes on unbent.
//! - alpha: BLEND covers the fraction alpha, the ray goes on with the rest; MASK is there or not.
//!
//! Shadow rays go straight through what is not solid, and take its colour along: a BLEND surface passes
//! (1 − α) · mix(1, baseColor, α), a transmissive one what it would refract. Caustics are not followed.
//!
//! Both sides of a surface shade and block light alike.

mod direct;
mod path;
mod place;
mod sampling;
mod surface;
mod visibility;
mod wave;

pub(crate) use path::render_path;
pub(crate) use sampling::{film_samples, hash};
pub(crate) use surface::{Vertex, is_back_face};
pub(crate) use visibility::{VisibilityScratch, visibility};
pub(crate) use wave::{Lighting, render_waves};
