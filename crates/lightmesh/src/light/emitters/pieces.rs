//! Dividing emissive surfaces into pieces: so small that strata of them are compact, and down to texels where a picture
//! of emission has contrast.

use std::collections::HashMap;

use glam::Vec2;

use super::emission_bounds::EmissionBounds;
use super::luminance;
use super::primitive::{Primitive, Source};
use super::subdivision::{self, LEVELS, WHOLE};
use crate::scene::{Material, SceneData};

/// Most pieces that subdivision adds in all: 20 MiB of them. With more, pictures are resolved less finely.
const MOST_PIECES: usize = 1 << 20;

/// Pieces that a light without texture is divided into, at most, and those of all lights together.
const PIECES: u32 = 2048;
const PIECES_OF_ALL: u32 = 1 << 19;

/// A piece whose least and most luminance differ by less than this factor is not divided for it.
const CONTRAST: f32 = 2.0;

/// Pieces are not divided below this part of a texel.
const TEXELS: f32 = 0.35;

/// A piece counts at least with this part of its most luminance: the points that its mean is taken from may miss it.
const LEAST: f32 = 1.0 / 64.0;

/// The pieces of all area lights.
#[derive(Debug, Default)]
pub(super) struct Pieces {
    /// By piece: which part of its primitive it is.
    pub cells: Vec<u32>,
    /// By piece: mean luminance, cd/m², 0 only where nothing shines.
    pub luminance: Vec<f32>,
    /// By piece: square metres.
    pub areas: Vec<f32>,
    /// By piece: the primitive that it belongs to, by its number among those of all lights.
    pub primitives: Vec<u32>,
    /// By primitive: its first piece; and the number of all pieces.
    pub first: Vec<u32>,
}

/// The surface of one light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    pub source: Source,
    pub material: usize,
    /// How many triangles it has; 1 for a sphere.
    pub primitives: u32,
}

impl Surface {
    /// Returns how many bands of pieces an emissive sphere has.
    pub(super) fn sphere_rows(data: &SceneData, material: &Material, lights: usize) -> u32 {
        let texels = material.emission_texture.map_or(0, |r| {
            let image = &data.images[data.textures[r.texture].image];
            image.width.max(image.height)
        });
        let most = if lights > 64 { 8 } else { 128 };
        texels.clamp(16.min(most), most)
    }
}

impl Pieces {
    /// Divides the surfaces of a checked scene.
    pub(super) fn new(data: &SceneData, surfaces: &[Surface]) -> Self {
        // Pictures are read once.
        let mut bounds = HashMap::new();
        for surface in surfaces {
            if let Some(r) = data.materials[surface.material].emission_texture {
                let image = data.textures[r.texture].image;
                bounds.entry(image).or_insert_with(|| EmissionBounds::new(&data.images[image]));
            }
        }
        // Divide less finely until the pieces are few enough.
        let mut deepest = LEVELS;
        loop {
            let most = MOST_PIECES + surfaces.iter().map(|surface| surface.primitives as usize).sum::<usize>();
            if let Some(pieces) = Self::divide(data, surfaces, &bounds, deepest, most) {
                return pieces;
            }
            deepest -= 1;
        }
    }

    /// Divides the surfaces; `None` if that makes more than `most` pieces.
    fn divide(
        data: &SceneData,
        surfaces: &[Surface],
        bounds: &HashMap<usize, EmissionBounds>,
        deepest: u32,
        most: usize,
    ) -> Option<Self> {
        let mut pieces = Self::default();
        let per_light = (PIECES_OF_ALL / surfaces.len().max(1) as u32).clamp(16, PIECES) as f32;
        for surface in surfaces {
            let material = &data.materials[surface.material];
            let primitive = |i: u32| Primitive::of(data, surface.source, i);
            let area: f64 = (0..surface.primitives).map(|i| f64::from(primitive(i).area())).sum();
            for i in 0..surface.primitives {
                pieces.first.push(pieces.cells.len() as u32);
                let primitive = primitive(i);
                if let Source::Sphere { rows, .. } = surface.source {
                    pieces.cells.extend(0..2 * rows * rows);
                } else {
                    // The level at which the light has about so many pieces.
                    let share = (f64::from(primitive.area()) / area.max(f64::MIN_POSITIVE)) as f32 * per_light;
                    let mut level = 0;
                    while level < deepest && (1_u32 << (2 * level + 2)) as f32 <= share {
                        level += 1;
                    }
                    let division = Division { data, material, primitive, bounds, level, deepest, most };
                    if !division.divide(WHOLE, &mut pieces.cells) {
                        return None;
                    }
                }
                // Measure each, and average its emission.
                let whole = primitive.area();
                for &cell in &pieces.cells[pieces.luminance.len()..] {
                    let mean = luminance(primitive.mean_emission(data, material, cell));
                    let division = Division { data, material, primitive, bounds, level: 0, deepest, most };
                    let highest = division.range(cell).map_or(mean, |[_, most]| most * material.emission.max_element());
                    pieces.luminance.push(mean.max(LEAST * highest));
                    pieces.areas.push(whole * primitive.part(cell));
                    pieces.primitives.push(pieces.first.len() as u32 - 1);
                }
            }
        }
        pieces.first.push(pieces.cells.len() as u32);
        Some(pieces)
    }
}

/// How one primitive is divided.
struct Division<'a> {
    data: &'a SceneData,
    material: &'a Material,
    primitive: Primitive<'a>,
    bounds: &'a HashMap<usize, EmissionBounds>,
    /// Everywhere this often, but where it is black.
    level: u32,
    /// Not more often than this.
    deepest: u32,
    most: usize,
}

impl Division<'_> {
    /// Adds the parts of a cell; false if there are too many pieces.
    fn divide(&self, cell: u32, cells: &mut Vec<u32>) -> bool {
        let level = subdivision::level(cell);
        let is_done = match self.rectangle(cell) {
            None => level >= self.level,
            Some([min, max, size]) => {
                let [least, most] = self.range(cell).unwrap_or([1.0; 2]);
                let even = most <= CONTRAST * least || (max - min).cmple(size * TEXELS).all();
                most == 0.0 || level >= self.deepest || (even && level >= self.level)
            }
        };
        if is_done {
            cells.push(cell);
            return cells.len() <= self.most;
        }
        (0..4).all(|k| self.divide(subdivision::child(cell, k), cells))
    }

    /// Returns the rectangle of texture coordinates around a cell, and the size of a texel; `None` where there is no
    /// texture.
    fn rectangle(&self, cell: u32) -> Option<[Vec2; 3]> {
        let r = self.material.emission_texture?;
        let Primitive::Triangle { uvs, .. } = self.primitive else { return None };
        let [p, q, s] = uvs[r.uv_set].map(|uv| r.transform.apply(uv));
        let [a, b, c] = subdivision::corners(cell).map(|w| p * w.x + q * w.y + s * w.z);
        let image = &self.data.images[self.data.textures[r.texture].image];
        let size = Vec2::new(image.width as f32, image.height as f32).recip();
        Some([a.min(b).min(c), a.max(b).max(c), size])
    }

    /// Returns the least and the most luminance of the picture in a cell; `None` where there is no texture.
    fn range(&self, cell: u32) -> Option<[f32; 2]> {
        let [min, max, _] = self.rectangle(cell)?;
        let texture = &self.data.textures[self.material.emission_texture?.texture];
        Some(self.bounds.get(&texture.image)?.within(texture, min, max))
    }
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Vec3};

    use super::*;
    use crate::geometry::TriangleMesh;
    use crate::scene::{Filter, ImageData, Instance, Texels, Texture, TextureRef, UvTransform, Wrap};

    /// A square of two triangles whose picture of 256 × 256 is black but for one texel.
    #[test]
    fn one_bright_texel_is_found() {
        let texel = |i: usize| if i == 77 * 256 + 130 { [1.0; 4] } else { [0.0, 0.0, 0.0, 1.0] };
        let texels: Vec<[f32; 4]> = (0..256 * 256).map(texel).collect();
        let mesh = TriangleMesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y],
            uvs: [vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y], Vec::new()],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..TriangleMesh::default()
        };
        let material = Material {
            emission: Vec3::splat(1000.0),
            emission_texture: Some(TextureRef { texture: 0, uv_set: 0, transform: UvTransform::default() }),
            ..Material::default()
        };
        let (wrap_s, wrap_t) = (Wrap::Repeat, Wrap::Repeat);
        let data = SceneData {
            meshes: vec![mesh],
            instances: vec![Instance { mesh: 0, world_from_object: Affine3A::IDENTITY }],
            materials: vec![material],
            images: vec![ImageData {
                name: String::new(),
                width: 256,
                height: 256,
                texels: Texels::Rgba32F(texels.into()),
            }],
            textures: vec![Texture { image: 0, wrap_s, wrap_t, filter: Filter::Nearest }],
            ..SceneData::default()
        };
        let surface = Surface { source: Source::Instance(0), material: 0, primitives: 2 };
        let pieces = Pieces::new(&data, &[surface]);
        // All of the light, as exactly as sixteen points tell for the pieces on the texel's rim, from about its area:
        // pieces beside it count with the least that any counts.
        let (mut flux, mut shining) = (0.0, 0.0);
        for (piece, (&cell, &l)) in pieces.cells.iter().zip(&pieces.luminance).enumerate() {
            let primitive = Primitive::of(&data, surface.source, pieces.primitives[piece]);
            let area = primitive.area() * primitive.part(cell);
            flux += area * l;
            shining += if l > 2.0 * LEAST * 1000.0 { area } else { 0.0 };
        }
        let expected = 1000.0 / 256.0 / 256.0;
        assert!((flux / expected - 1.0).abs() < 0.1, "{flux} {expected}");
        assert!(shining * 256.0 * 256.0 < 3.0, "{shining}");
        assert!(pieces.cells.len() < 1000, "{}", pieces.cells.len());
    }
}
