//! Area lights: which surfaces they are, random points on them in proportion to the emitted light, and the patches that
//! represent them.

use std::f64::consts::PI;
use std::ops::Range;

use glam::{Vec2, Vec3};

use super::primitive::{EmissivePrimitive, emission_of};
use super::{LightSample, Patch, luminance, radical_inverse};
use crate::bvh::Target;
use crate::scene::{Material, SceneData};

/// An emitter is weak if its mean luminance is at most this many times that of the scene's walls, if these were white
/// and reflected all light once. It is then about as bright as a well-lit wall, and gather rays find its light. A box
/// that glows all over has 1; the bound is a choice, not measured.
const WEAK_TIMES_WALL: f64 = 4.0;

/// All emissive meshes and spheres.
#[derive(Debug, Default)]
pub(crate) struct AreaLights {
    lights: Vec<AreaLight>,
    primitives: Vec<EmissivePrimitive>,
    /// Luminous flux of all primitives up to and with each, in units of the whole: ends with 1.
    cdf: Vec<f64>,
    /// The index of the light of each instance and sphere; `NONE` for those that do not shine.
    light_of_instance: Vec<u32>,
    light_of_sphere: Vec<u32>,
}

const NONE: u32 = u32::MAX;

/// How an emitter's light is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum EmitterClass {
    /// By shadow rays to its samples.
    Sampled,
    /// By gather rays that hit it.
    Weak,
}

#[derive(Clone, Debug)]
struct AreaLight {
    primitives: Range<usize>,
    material: usize,
    is_weak: bool,
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
    /// The area lights of a checked scene in which other emitters give `other_flux` lumen.
    pub(crate) fn new(data: &SceneData, other_flux: f64) -> Self {
        let mut lights = Self {
            light_of_instance: vec![NONE; data.instances.len()],
            light_of_sphere: vec![NONE; data.spheres.len()],
            ..Self::default()
        };
        let shines = |m: &Material| m.emission != Vec3::ZERO && !m.unlit;
        // An emissive mesh is one light for each of its instances.
        for (i, instance) in data.instances.iter().enumerate() {
            let mesh = &data.meshes[instance.mesh];
            if !shines(&data.materials[mesh.material]) {
                continue;
            }
            let handedness = instance.world_from_object.matrix3.determinant().signum();
            let world_position = |v: u32| instance.world_from_object.transform_point3(mesh.positions[v as usize]);
            let triangle = |&indices: &[u32; 3]| EmissivePrimitive::Triangle {
                corners: indices.map(world_position),
                indices,
                mesh: instance.mesh as u32,
                handedness,
            };
            lights.light_of_instance[i] = lights.add(mesh.triangles.iter().map(triangle), mesh.material);
        }
        for (i, sphere) in data.spheres.iter().enumerate() {
            if shines(&data.materials[sphere.material]) {
                lights.light_of_sphere[i] =
                    lights.add([EmissivePrimitive::Sphere(i as u32)].into_iter(), sphere.material);
            }
        }
        lights.measure(data, other_flux);
        lights
    }

    fn add(&mut self, primitives: impl Iterator<Item = EmissivePrimitive>, material: usize) -> u32 {
        let first = self.primitives.len();
        self.primitives.extend(primitives);
        self.lights.push(AreaLight { primitives: first..self.primitives.len(), material, is_weak: false });
        self.lights.len() as u32 - 1
    }

    /// Sums the flux, and finds out which lights are weak.
    fn measure(&mut self, data: &SceneData, other_flux: f64) {
        // Sum the flux of the primitives, and average each light's luminance.
        let mut sum = 0.0;
        let mut means = Vec::new();
        for light in &self.lights {
            let material = &data.materials[light.material];
            let (mut area, before) = (0.0, sum);
            for primitive in &self.primitives[light.primitives.clone()] {
                let primitive_area = f64::from(primitive.area(data));
                area += primitive_area;
                sum += primitive_area * f64::from(luminance(primitive.mean_emission(data, material)));
                self.cdf.push(sum);
            }
            means.push(if area > 0.0 { (sum - before) / area } else { 0.0 });
        }
        if self.lights.is_empty() {
            return;
        }
        // Compare each light with the scene's walls.
        let two_sided = |light: &AreaLight| data.materials[light.material].double_sided;
        let flux: f64 = self
            .lights
            .iter()
            .map(|light| {
                let Range { start, end } = light.primitives;
                let share = if end > start {
                    self.cdf[end - 1] - if start > 0 { self.cdf[start - 1] } else { 0.0 }
                } else {
                    0.0
                };
                PI * share * if two_sided(light) { 2.0 } else { 1.0 }
            })
            .sum();
        let wall = (flux + other_flux) / (PI * surface_area(data));
        for (light, mean) in self.lights.iter_mut().zip(means) {
            light.is_weak = mean <= WEAK_TIMES_WALL * wall;
        }
        // Normalize the sums.
        if sum > 0.0 {
            self.cdf.iter_mut().for_each(|c| *c /= sum);
        }
    }

    /// How many area lights there are.
    pub(crate) fn len(&self) -> usize {
        self.lights.len()
    }

    /// Whether no light shines.
    pub(crate) fn is_dark(&self) -> bool {
        self.cdf.last().is_none_or(|&sum| sum <= 0.0)
    }

    /// Whether any light is weak, and so left to gather rays.
    pub(crate) fn has_weak(&self) -> bool {
        self.lights.iter().any(|light| light.is_weak)
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

    /// Whether a surface is sampled as a light, and not left to gather rays.
    pub(crate) fn is_sampled(&self, target: Target) -> bool {
        self.light_of(target).is_some_and(|light| !light.is_weak)
    }

    /// Returns the patches of one class of lights: `n` each, stratified along their primitives.
    pub(super) fn samples(&self, data: &SceneData, n: u32, class: EmitterClass) -> Vec<LightSample> {
        let lights = self.lights.iter().filter(|light| light.is_weak == (class == EmitterClass::Weak));
        lights.flat_map(|light| (0..n).filter_map(|i| self.patch(data, light, i, n))).collect()
    }

    /// Returns the i-th of n patches: a Hammersley point of (flux along the primitives, radical inverse).
    fn patch(&self, data: &SceneData, light: &AreaLight, i: u32, n: u32) -> Option<LightSample> {
        let Range { start, end } = light.primitives;
        let before = if start > 0 { self.cdf[start - 1] } else { 0.0 };
        let whole = self.cdf[end.checked_sub(1)?] - before;
        if whole <= 0.0 {
            return None;
        }
        let u = before + whole * (f64::from(i) + 0.5) / f64::from(n);
        let point = self.point_at(data, start..end, u, radical_inverse(i))?;
        let area = (1.0 / (f64::from(point.pdf) / whole * f64::from(n))) as f32;
        let patch = Patch {
            position: point.position,
            normal: point.normal,
            intensity_cd: point.emission * area,
            area,
            two_sided: point.two_sided,
        };
        (patch.intensity_cd != Vec3::ZERO).then_some(LightSample::Patch(patch))
    }

    /// Returns the point at which the flux, summed from the first primitive of all, reaches `u`; `v` is its other
    /// coordinate.
    fn point_at(&self, data: &SceneData, range: Range<usize>, u: f64, v: f32) -> Option<AreaPoint> {
        let index = range.start + self.cdf[range.clone()].partition_point(|&c| c <= u);
        let primitive = self.primitives.get(index).filter(|_| index < range.end)?;
        let before = if index > 0 { self.cdf[index - 1] } else { 0.0 };
        let share = self.cdf[index] - before;
        let inside = (((u - before) / share) as f32).clamp(0.0, 1.0 - f32::EPSILON);
        let light = &self.lights[self.lights.partition_point(|light| light.primitives.end <= index)];
        let material = &data.materials[light.material];
        let point = primitive.point(data, Vec2::new(inside, v));
        Some(AreaPoint {
            position: point.position,
            normal: point.normal,
            emission: emission_of(data, material, point.uvs),
            two_sided: material.double_sided,
            pdf: (share / f64::from(primitive.area(data))) as f32,
        })
    }

    /// Samples a point on any of the lights by u in [0, 1)²; `None` if nothing shines.
    pub(crate) fn sample(&self, data: &SceneData, u: Vec2) -> Option<AreaPoint> {
        if self.is_dark() {
            return None;
        }
        self.point_at(data, 0..self.primitives.len(), f64::from(u.x), u.y)
    }

    /// Returns the density with which [`AreaLights::sample`] finds a point of a surface, 1/m²; 0 for surfaces that are
    /// no lights.
    pub(crate) fn pdf(&self, data: &SceneData, target: Target) -> f32 {
        let Some(light) = self.light_of(target) else { return 0.0 };
        let index = match target {
            Target::Triangle { triangle, .. } => light.primitives.start + triangle as usize,
            _ => light.primitives.start,
        };
        let share = self.cdf[index] - if index > 0 { self.cdf[index - 1] } else { 0.0 };
        let area = f64::from(self.primitives[index].area(data));
        if area > 0.0 { (share / area) as f32 } else { 0.0 }
    }
}

/// Returns the area of all surfaces but user-defined ones, m².
fn surface_area(data: &SceneData) -> f64 {
    let triangles = data.instances.iter().flat_map(|instance| {
        let mesh = &data.meshes[instance.mesh];
        let world_position = |v: u32| instance.world_from_object.transform_point3(mesh.positions[v as usize]);
        mesh.triangles.iter().map(move |t| {
            let [a, b, c] = t.map(world_position);
            f64::from(0.5 * (b - a).cross(c - a).length())
        })
    });
    let spheres = data.spheres.iter().map(|s| 4.0 * PI * f64::from(s.radius).powi(2));
    (triangles.sum::<f64>() + spheres.sum::<f64>()).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use glam::Affine3A;

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
        let lights = AreaLights::new(&data, 0.0);
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
            assert!((lights.pdf(&data, targets[on]) / point.pdf - 1.0).abs() < 1e-4);
        }
        let flux = [1.0, 3.0, 2.0 * PI];
        assert_follows(&counts, &flux);
    }
}
