//! Area lights: which surfaces they are, random points on them in proportion to the emitted light, and the strata that
//! light samples stand for.
//!
//! A light is an emissive mesh, once for each of its instances, or an emissive sphere. It is divided into *pieces*,
//! sub-triangles down to texels of its picture ([`Pieces`]), and these are gathered into *strata* of about the same
//! flux (`arrange.rs`). A stratum has a representative, a flat patch in its middle, and random points. Pieces that are
//! no brighter than what they light are *weak*: gather rays find their emission (`surroundings.rs`).

use std::ops::Range;

use glam::{Vec2, Vec3};

use super::super::sample::{LightEmission, SampledLight};
use super::bulb::Bulb;
use super::pieces::{Pieces, Surface};
use super::primitive::{Primitive, Source, emission_of, piece_of_sphere};
use super::strata::Item;
use super::subdivision;
use crate::bvh::{Hit, Target};
use crate::scene::{Material, SceneData};

/// All emissive meshes and spheres.
#[derive(Debug, Default)]
pub(crate) struct AreaLights {
    pub(super) lights: Vec<AreaLight>,
    pub(super) pieces: Pieces,
    /// The pieces, light by light, in each light stratum by stratum.
    pub(super) order: Vec<u32>,
    /// By place in the order: luminance times area of all pieces up to and with it, cd.
    cdf: Vec<f64>,
    /// Places in the order.
    pub(super) strata: Vec<Range<u32>>,
    pub(super) bulbs: Vec<Bulb>,
    /// The index of the light of each instance and sphere; `NONE` for those that do not shine.
    light_of_instance: Vec<u32>,
    light_of_sphere: Vec<u32>,
}

const NONE: u32 = u32::MAX;

#[derive(Clone, Debug)]
pub(super) struct AreaLight {
    surface: Surface,
    /// The number of its first primitive among those of all lights.
    first_primitive: u32,
    /// Its pieces, which are its places in the order, too.
    pub pieces: Range<u32>,
    /// Pieces up to this luminance are left to gather rays, cd/m².
    pub weak_below: f32,
}

/// A random point on an area light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AreaPoint {
    /// Metres.
    pub position: Vec3,
    /// Unit; the front.
    pub normal: Vec3,
    /// cd/m² per channel.
    pub emission: Vec3,
    /// Whether its back shines as well.
    pub two_sided: bool,
    /// Density over area, 1/m².
    pub pdf: f32,
}

impl AreaLights {
    /// The area lights of a checked scene, not yet divided into strata.
    pub(crate) fn new(data: &SceneData) -> Self {
        let mut lights = Self {
            light_of_instance: vec![NONE; data.instances.len()],
            light_of_sphere: vec![NONE; data.spheres.len()],
            ..Self::default()
        };
        // An emissive mesh is one light for each of its instances.
        let shines = |m: usize| data.materials[m].emission != Vec3::ZERO && !data.materials[m].unlit;
        let spheres = data.spheres.iter().filter(|sphere| shines(sphere.material)).count();
        let mut surfaces = Vec::new();
        for (i, instance) in data.instances.iter().enumerate() {
            let mesh = &data.meshes[instance.mesh];
            if shines(mesh.material) {
                lights.light_of_instance[i] = surfaces.len() as u32;
                let (source, primitives) = (Source::Instance(i as u32), mesh.triangles.len() as u32);
                surfaces.push(Surface { source, material: mesh.material, primitives });
            }
        }
        for (i, sphere) in data.spheres.iter().enumerate() {
            if shines(sphere.material) {
                lights.light_of_sphere[i] = surfaces.len() as u32;
                let rows = Surface::sphere_rows(data, &data.materials[sphere.material], spheres);
                let source = Source::Sphere { index: i as u32, rows };
                surfaces.push(Surface { source, material: sphere.material, primitives: 1 });
            }
        }
        if surfaces.is_empty() {
            return lights;
        }
        // Divide them into pieces.
        lights.pieces = Pieces::new(data, &surfaces);
        let mut first_primitive = 0;
        for surface in surfaces {
            let end = first_primitive + surface.primitives;
            let first = &lights.pieces.first;
            let pieces = first[first_primitive as usize]..first[end as usize];
            lights.lights.push(AreaLight { surface, first_primitive, pieces, weak_below: 0.0 });
            first_primitive = end;
        }
        lights.order = (0..lights.pieces.cells.len() as u32).collect();
        lights.sum();
        lights
    }

    /// Sums the flux of the pieces in their order.
    pub(super) fn sum(&mut self) {
        let mut sum = 0.0;
        self.cdf.clear();
        for light in &self.lights {
            for place in light.pieces.clone() {
                let piece = self.order[place as usize];
                sum += f64::from(self.pieces.areas[piece as usize]) * f64::from(self.pieces.luminance[piece as usize]);
                self.cdf.push(sum);
            }
        }
    }

    /// How many area lights there are, dark ones too.
    pub(crate) fn len(&self) -> usize {
        self.lights.len()
    }

    /// Whether no light shines.
    pub(crate) fn is_dark(&self) -> bool {
        self.whole() <= 0.0
    }

    /// Returns luminance times area of all lights, cd.
    fn whole(&self) -> f64 {
        self.cdf.last().copied().unwrap_or(0.0)
    }

    /// Returns luminance times area of the pieces before a place, cd.
    fn before(&self, place: u32) -> f64 {
        if place > 0 { self.cdf[place as usize - 1] } else { 0.0 }
    }

    /// Returns the area of a light's pieces that are brighter than `weak_below`, m².
    pub(super) fn bright_area(&self, light: usize, weak_below: f32) -> f32 {
        let bright = self.lights[light].pieces.clone().filter(|&p| self.pieces.luminance[p as usize] > weak_below);
        bright.map(|piece| f64::from(self.pieces.areas[piece as usize])).sum::<f64>() as f32
    }

    /// Whether any shining piece is weak, and so left to gather rays.
    pub(crate) fn has_weak(&self) -> bool {
        let is_weak = |light: &AreaLight, piece: u32| {
            let l = self.pieces.luminance[piece as usize];
            l > 0.0 && l <= light.weak_below
        };
        self.lights.iter().any(|light| light.weak_below > 0.0 && light.pieces.clone().any(|p| is_weak(light, p)))
    }

    /// Returns the light that a surface belongs to.
    fn light_of(&self, target: Target) -> Option<&AreaLight> {
        let index = match target {
            Target::Triangle { instance, .. } => self.light_of_instance[instance as usize],
            Target::Sphere(i) => self.light_of_sphere[i as usize],
            Target::Shape(_) => NONE,
        };
        self.lights.get(index as usize)
    }

    /// Returns the light and the piece that were hit at a position.
    fn piece_at(&self, data: &SceneData, hit: &Hit, position: Vec3) -> Option<(&AreaLight, usize)> {
        let light = self.light_of(hit.target)?;
        let piece = match (hit.target, light.surface.source) {
            (Target::Triangle { triangle, .. }, _) => {
                let primitive = (light.first_primitive + triangle) as usize;
                let (first, end) = (self.pieces.first[primitive] as usize, self.pieces.first[primitive + 1] as usize);
                let w = Vec3::new(1.0 - hit.u - hit.v, hit.u, hit.v);
                first + subdivision::find(&self.pieces.cells[first..end], w)
            }
            (_, Source::Sphere { index, rows }) => {
                let direction = data.spheres[index as usize].normal(position);
                light.pieces.start as usize + piece_of_sphere(direction, rows) as usize
            }
            (_, Source::Instance(_)) => return None,
        };
        Some((light, piece))
    }

    /// Whether the emission of what was hit at a position is sampled as a light, and not left to gather rays.
    pub(crate) fn is_sampled(&self, data: &SceneData, hit: &Hit, position: Vec3) -> bool {
        self.piece_at(data, hit, position).is_some_and(|(light, piece)| self.pieces.luminance[piece] > light.weak_below)
    }

    /// Returns the luminance of the emission of what was hit at a position, mean over its piece, cd/m².
    pub(super) fn luminance_at(&self, data: &SceneData, hit: &Hit, position: Vec3) -> f32 {
        self.piece_at(data, hit, position).map_or(0.0, |(_, piece)| self.pieces.luminance[piece])
    }

    /// Returns the density with which [`AreaLights::sample`] finds the point that was hit, 1/m²; 0 for surfaces that are
    /// no lights.
    pub(crate) fn pdf(&self, data: &SceneData, hit: &Hit, position: Vec3) -> f32 {
        match self.piece_at(data, hit, position) {
            Some((_, piece)) if !self.is_dark() => (f64::from(self.pieces.luminance[piece]) / self.whole()) as f32,
            _ => 0.0,
        }
    }

    /// Samples a point on any of the lights by u in [0, 1)²; `None` if nothing shines.
    pub(crate) fn sample(&self, data: &SceneData, u: Vec2) -> Option<AreaPoint> {
        self.sample_places(data, 0..self.order.len() as u32, u)
    }

    /// Samples a point of one light.
    pub(crate) fn sample_light(&self, data: &SceneData, light: usize, u: Vec2) -> Option<AreaPoint> {
        self.sample_places(data, self.lights[light].pieces.clone(), u)
    }

    /// Returns the ball that a small lamp is for what it lights.
    pub(super) fn bulb(&self, index: u32) -> Bulb {
        self.bulbs[index as usize]
    }

    /// Returns a random point of a stratum as a light, by u in [0, 1)²: its light at any place has the stratum's light
    /// there as expectation.
    pub(crate) fn sample_stratum(&self, data: &SceneData, stratum: u32, u: Vec2) -> Option<SampledLight> {
        let point = self.sample_places(data, self.strata[stratum as usize].clone(), u)?;
        let emission = LightEmission::Patch {
            normal: point.normal,
            back: if point.two_sided { -1.0 } else { 0.0 },
            area_over_pi: 0.0,
        };
        Some(SampledLight { position: point.position, intensity: point.emission / point.pdf, emission })
    }

    /// Samples a point of the pieces at some places, with its density among them.
    fn sample_places(&self, data: &SceneData, places: Range<u32>, u: Vec2) -> Option<AreaPoint> {
        let before = self.before(places.start);
        let whole = self.before(places.end) - before;
        if whole <= 0.0 {
            return None;
        }
        // Find the piece, and how far into it.
        let target = before + whole * f64::from(u.x);
        let cdf = &self.cdf[places.start as usize..places.end as usize];
        let place = places.start + cdf.partition_point(|&c| c <= target) as u32;
        let place = place.min(places.end - 1);
        let (below, above) = (self.before(place), self.cdf[place as usize]);
        let inside = (((target - below) / (above - below)) as f32).clamp(0.0, 1.0 - f32::EPSILON);
        // Take a point of it.
        let piece = self.order[place as usize];
        let light = &self.lights[self.lights.partition_point(|light| light.pieces.end <= place)];
        let material = self.material(data, light);
        let point = self.primitive(data, light, piece).point(self.pieces.cells[piece as usize], Vec2::new(inside, u.y));
        Some(AreaPoint {
            position: point.position,
            normal: point.normal,
            emission: emission_of(data, material, point.uvs),
            two_sided: material.double_sided,
            pdf: (f64::from(self.pieces.luminance[piece as usize]) / whole) as f32,
        })
    }

    pub(super) fn material<'a>(&self, data: &'a SceneData, light: &AreaLight) -> &'a Material {
        &data.materials[light.surface.material]
    }

    pub(super) fn primitive<'a>(&self, data: &'a SceneData, light: &AreaLight, piece: u32) -> Primitive<'a> {
        let primitive = self.pieces.primitives[piece as usize] - light.first_primitive;
        Primitive::of(data, light.surface.source, primitive)
    }

    pub(super) fn area_of(&self, item: &Item) -> f32 {
        self.pieces.areas[item.index as usize]
    }

    /// Returns the mean emission of a piece, cd/m².
    pub(super) fn emission(&self, data: &SceneData, light: &AreaLight, piece: u32) -> Vec3 {
        let material = self.material(data, light);
        match material.emission_texture {
            None => material.emission,
            Some(_) => {
                let primitive = self.primitive(data, light, piece);
                primitive.mean_emission(data, material, self.pieces.cells[piece as usize])
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glam::Affine3A;

    use super::super::arrange::Arrangement;
    use super::*;
    use crate::geometry::{Sphere, TriangleMesh};
    use crate::sampling::chi_square::assert_follows;
    use crate::sampling::{hash, unit_f32};
    use crate::scene::Instance;

    /// Two triangles of 1 and 3 m², a sphere, brightness 1 and 2.
    fn emitters() -> (SceneData, AreaLights) {
        let emissive = |e: f32| Material { emission: Vec3::splat(e), ..Material::default() };
        let mesh = TriangleMesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y * 2.0, Vec3::X * 4.0],
            triangles: vec![[0, 1, 2], [1, 3, 2]],
            ..TriangleMesh::default()
        };
        let data = SceneData {
            meshes: vec![mesh],
            instances: vec![Instance { mesh: 0, world_from_object: Affine3A::IDENTITY }],
            spheres: vec![Sphere { center: Vec3::new(0.0, 0.0, 9.0), radius: 0.5, material: 1 }],
            materials: vec![emissive(1.0), emissive(2.0)],
            ..SceneData::default()
        };
        let mut lights = AreaLights::new(&data);
        let arrangement = Arrangement { strata: [16, 16], weak_below: 0.0, is_small: false };
        let strata = lights.arrange(&data, &[arrangement; 2]);
        assert_eq!(strata.iter().map(|s| (s.sampled.len(), s.weak.len())).collect::<Vec<_>>(), [(16, 0), (16, 0)]);
        (data, lights)
    }

    /// Flux per primitive 1 : 3 : 2π. The density of a sample is that of its surface, flux share over area.
    #[test]
    fn points_come_in_proportion_to_the_light_that_leaves_there() {
        let (data, lights) = emitters();
        let targets = [
            Target::Triangle { instance: 0, triangle: 0 },
            Target::Triangle { instance: 0, triangle: 1 },
            Target::Sphere(0),
        ];
        let mut counts = [0; 3];
        for i in 0..20_000 {
            let unit = |k: u32| unit_f32(hash(2 * i + k));
            let point = lights.sample(&data, Vec2::new(unit(0), unit(1))).expect("it shines");
            let on =
                if point.position.z > 1.0 { 2 } else { usize::from(point.position.x + 0.5 * point.position.y > 1.0) };
            counts[on] += 1;
            let hit = Hit { t: 1.0, u: 0.2, v: 0.3, target: targets[on] };
            assert!((lights.pdf(&data, &hit, point.position) / point.pdf - 1.0).abs() < 1e-4);
        }
        let flux = [1.0, 3.0, 2.0 * PI];
        assert_follows(&counts, &flux);
    }

    /// The strata have all of the light, and a random point of each has the stratum's intensity as expectation: here it
    /// is constant.
    #[test]
    fn strata_share_the_light() {
        let (data, lights) = emitters();
        let mut sum = 0.0;
        for stratum in 0..lights.strata.len() as u32 {
            let intensity = |u: Vec2| lights.sample_stratum(&data, stratum, u).expect("it shines").intensity.x;
            let first = intensity(Vec2::new(0.1, 0.7));
            assert!((intensity(Vec2::new(0.9, 0.2)) / first - 1.0).abs() < 1e-3);
            sum += f64::from(first);
        }
        assert!((sum / (4.0 + 2.0 * PI) - 1.0).abs() < 1e-3, "{sum}");
    }
}
