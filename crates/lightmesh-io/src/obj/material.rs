//! MTL materials as ours.
//!
//! | MTL | becomes |
//! |---|---|
//! | `Kd`, `map_Kd` | base colour; 0.8 where neither is given; a `Kd` of 0 under a map is taken as 1 |
//! | `Ke`, `map_Ke` | emission, cd/m² |
//! | `d`, 1 − `Tr`, `map_d` | alpha, [`AlphaMode::Blend`] where it is below 1 or has a map |
//! | `norm` | normal map; `bump` holds heights and is left out with a warning |
//! | `Ks`, `Ns` | nothing: the surface is exactly Lambert, unless `illum` says otherwise |
//! | `illum` 3 | a metal mirror of colour `Ks` (`Kd` where there is none) |
//! | `illum` 5 | Lambert under a smooth clear coat of index `Ni` |
//! | `illum` 4, 6, 7, 9 | smooth glass of index `Ni` and colour `Tf` |

use std::collections::{BTreeMap, BTreeSet};

use glam::{Mat2, Vec2, Vec3};
use lightmesh::{AlphaMode, Filter, ImageData, Material, SceneData, Texels, Texture, TextureRef, UvTransform, Wrap};

use super::Context;
use super::image_file::{note_file, read_beside, read_image};
use super::mtl::{self, Map, Mtl};
use crate::error::{Error, one_line};

/// Albedo where a file says nothing.
const DEFAULT_ALBEDO: f32 = 0.8;

/// The materials that the libraries describe, and those that are in use.
pub(super) struct Materials {
    described: BTreeMap<String, Mtl>,
    /// Index in the scene by name.
    used: BTreeMap<String, usize>,
    /// Index of the image by the paths of its colours and its alpha; `None`: it could not be read.
    images: BTreeMap<[String; 2], Option<usize>>,
}

impl Materials {
    /// Reads the libraries that can be read. The first description of a name counts.
    pub(super) fn load(context: &mut Context<'_>, libraries: &[String]) -> Result<Self, Error> {
        let mut described = BTreeMap::new();
        let mut seen: BTreeSet<&str> = BTreeSet::new();
        for library in libraries {
            for name in library_names(library) {
                if !seen.insert(name) {
                    continue;
                }
                note_file(context, name);
                let Some(bytes) = read_beside(context, name)? else { continue };
                // A material is many times the text that it takes.
                context.budget.take(context.file, name, bytes.len() as u64, 64)?;
                let warnings = &mut context.warnings;
                let materials = mtl::parse(&bytes, |line, what| warnings.add(format_args!("{name} line {line}"), what));
                for material in materials {
                    let maps =
                        [&material.diffuse_map, &material.alpha_map, &material.emission_map, &material.normal_map];
                    maps.into_iter().flatten().for_each(|map| note_file(context, &map.path));
                    material.other_maps.iter().for_each(|path| note_file(context, path));
                    described.entry(material.name.clone()).or_insert(material);
                }
            }
        }
        Ok(Self { described, used: BTreeMap::new(), images: BTreeMap::new() })
    }

    /// The index in `data.materials` of the material that the file calls `name`; empty: none was chosen.
    pub(super) fn index_of(
        &mut self,
        context: &mut Context<'_>,
        name: &str,
        data: &mut SceneData,
    ) -> Result<usize, Error> {
        if let Some(&index) = self.used.get(name) {
            return Ok(index);
        }
        let material = match self.described.get(name).cloned() {
            Some(mtl) => self.convert(context, &mtl, data)?,
            None => {
                if !name.is_empty() {
                    let place = format!("material {:?}", one_line(name));
                    context.warnings.add(place, "no material library describes it: its surfaces are grey");
                }
                Material { name: name.to_owned(), ..Material::lambert(Vec3::splat(DEFAULT_ALBEDO)) }
            }
        };
        data.materials.push(material);
        self.used.insert(name.to_owned(), data.materials.len() - 1);
        Ok(data.materials.len() - 1)
    }

    fn convert(&mut self, context: &mut Context<'_>, mtl: &Mtl, data: &mut SceneData) -> Result<Material, Error> {
        // Read colour and alpha, which share a texture.
        let alpha = mtl.alpha.unwrap_or(1.0).clamp(0.0, 1.0);
        let color_texture = self.texture(context, mtl.diffuse_map.as_ref(), mtl.alpha_map.as_ref(), data)?;
        let has_color = color_texture.is_some() && mtl.diffuse_map.is_some();
        let base_color = match mtl.diffuse {
            Some(color) if !(has_color && color == Vec3::ZERO) => color.min(Vec3::ONE),
            _ if has_color => Vec3::ONE,
            _ => Vec3::splat(DEFAULT_ALBEDO),
        };
        let covered = alpha < 1.0 || (color_texture.is_some() && mtl.alpha_map.is_some());

        // Take an emission map without a colour, or with a black one, as it is.
        let emission_texture = self.texture(context, mtl.emission_map.as_ref(), None, data)?;
        let emission = match mtl.emission {
            Some(color) if !(emission_texture.is_some() && color == Vec3::ZERO) => color,
            _ if emission_texture.is_some() => Vec3::ONE,
            _ => Vec3::ZERO,
        };
        // Fill in what every illumination model has.
        let lambert = Material {
            name: mtl.name.clone(),
            alpha,
            base_color_texture: color_texture,
            alpha_mode: if covered { AlphaMode::Blend } else { AlphaMode::Opaque },
            emission,
            emission_texture,
            normal_texture: self.texture(context, mtl.normal_map.as_ref(), None, data)?,
            normal_scale: mtl.normal_map.as_ref().map_or(1.0, |map| map.strength),
            ior: mtl.ior.unwrap_or(1.5).clamp(1.0, Material::MOST_IOR),
            ..Material::lambert(base_color)
        };
        // Make it a metal, a gloss or a glass by the number of the illumination model.
        Ok(match mtl.illumination {
            3 => Material {
                base_color: mtl.specular.unwrap_or(base_color).min(Vec3::ONE),
                metallic: 1.0,
                roughness: 0.0,
                ..lambert
            },
            5 => Material { specular: 1.0, roughness: 0.0, ..lambert },
            4 | 6 | 7 | 9 => Material {
                base_color: mtl.filter.unwrap_or(Vec3::ONE).min(Vec3::ONE),
                base_color_texture: None,
                alpha: 1.0,
                alpha_mode: AlphaMode::Opaque,
                specular: 1.0,
                roughness: 0.0,
                transmission: 1.0,
                ..lambert
            },
            _ => lambert,
        })
    }

    /// A texture of the colours of one map and the alpha of another; `None` where neither is given or can be read.
    fn texture(
        &mut self,
        context: &mut Context<'_>,
        color: Option<&Map>,
        alpha: Option<&Map>,
        data: &mut SceneData,
    ) -> Result<Option<TextureRef>, Error> {
        let Some(map) = color.or(alpha) else { return Ok(None) };
        let path = |map: Option<&Map>| map.map_or(String::new(), |map| map.path.clone());
        let key = [path(color), path(alpha)];
        let image = match self.images.get(&key) {
            Some(&image) => image,
            None => {
                let image = read_pair(context, color, alpha)?.map(|image| {
                    data.images.push(image);
                    data.images.len() - 1
                });
                self.images.insert(key, image);
                image
            }
        };
        let Some(image) = image else { return Ok(None) };
        let wrap = if map.clamp { Wrap::ClampToEdge } else { Wrap::Repeat };
        let texture = Texture { image, wrap_s: wrap, wrap_t: wrap, filter: Filter::Bilinear };
        let index = data.textures.iter().position(|&t| t == texture).unwrap_or_else(|| {
            data.textures.push(texture);
            data.textures.len() - 1
        });
        // MTL: (u, v) · scale + offset with v upward. Our v is 1 − v: 1 − ((1 − v) s + o) = s v + (1 − s − o).
        let transform = UvTransform {
            matrix: Mat2::from_diagonal(map.scale),
            offset: Vec2::new(map.offset.x, 1.0 - map.scale.y - map.offset.y),
        };
        Ok(Some(TextureRef { texture: index, uv_set: 0, transform }))
    }
}

/// Reads an image of the colours of `color` (white where there is none) and the alpha of `alpha` (opaque where there is
/// none).
fn read_pair(context: &mut Context<'_>, color: Option<&Map>, alpha: Option<&Map>) -> Result<Option<ImageData>, Error> {
    let color = color.map(|map| read_image(context, &map.path)).transpose()?.flatten();
    let alpha = alpha.map(|map| read_image(context, &map.path)).transpose()?.flatten();
    let texels_of = |image: &ImageData| match &image.texels {
        Texels::Rgba8(texels) => Some(texels.clone()),
        Texels::Rgba32F(_) => None,
    };
    // The colours' size, and the alpha's where there are no colours.
    let Some(base) = color.as_ref().or(alpha.as_ref()) else { return Ok(None) };
    let (width, height, name) = (base.width, base.height, base.name.clone());
    let Some(mut texels) = texels_of(base).map(|texels| texels.to_vec()) else { return Ok(None) };
    if color.is_none() {
        texels.fill([255; 4]);
    }
    // MTL's colour maps have no alpha of their own meaning.
    texels.iter_mut().for_each(|texel| texel[3] = 255);
    if let Some(image) = &alpha
        && let Some(mask) = texels_of(image)
    {
        // A mask with an alpha channel means that channel; one without means its grey. Nearest texel where sizes
        // differ.
        let by_alpha = mask.iter().any(|texel| texel[3] != 255);
        for (i, texel) in texels.iter_mut().enumerate() {
            let (x, y) = (i as u64 % u64::from(width), i as u64 / u64::from(width));
            let column = x * u64::from(image.width) / u64::from(width);
            let row = y * u64::from(image.height) / u64::from(height);
            let [r, g, b, a] = mask[(row * u64::from(image.width) + column) as usize];
            texel[3] = if by_alpha { a } else { ((u32::from(r) + u32::from(g) + u32::from(b)) / 3) as u8 };
        }
    }
    Ok(Some(ImageData { name, width, height, texels: Texels::Rgba8(texels.into()) }))
}

/// The names on the rest of an `mtllib` line. Several are allowed, in quotes or not, and so are spaces in a name: a line
/// with one `.mtl` and without quotes is one name.
fn library_names(line: &str) -> Vec<&str> {
    if line.contains('"') {
        let parts = line.split('"').enumerate();
        let names = parts.flat_map(|(i, part)| {
            // Every second part is between quotes.
            let is_quoted = i % 2 == 1;
            let names = part.split(move |c: char| !is_quoted && c.is_ascii_whitespace());
            names.filter(|name| !name.is_empty())
        });
        return names.collect();
    }
    let is_one = line.to_ascii_lowercase().matches(".mtl").count() <= 1;
    if is_one { vec![line] } else { line.split_ascii_whitespace().collect() }
}
