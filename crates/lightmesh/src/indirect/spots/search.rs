//! The search for bright spots: probe rays from each lamp find what is near.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::super::gather::sphere_directions;
use super::bright_spots::{BrightSpot, BrightSpots, SpotShape};
use super::directions::EvenCone;
use super::sun_patches::sun_patches;
use crate::Scene;
use crate::geometry::{Aabb, Ray};
use crate::interaction::evaluate;
use crate::light::PlaneMirror;
use crate::light::sample::{LightEmission, SampledLight};
use crate::sampling::{basis, hash, sample_cosine_hemisphere, unit_f32};

/// Rays that look for surfaces near a lamp.
const PROBES: u32 = 48;

/// Lamps that are probed, at most: with more of them, none is much brighter than the rest.
const MOST_LAMPS: usize = 2048;

/// Shining surfaces whose mirror images are looked for, at most.
const MOST_EMITTERS: usize = 64;

/// The part of a lamp's rays that makes a spot.
const LEAST_PART: f32 = 0.12;

/// Surfaces in a ball are not taken for brighter than so many times their mean. A judgement.
const MOST_CONTRAST: f32 = 64.0;

/// Light of a lamp at a surface more aslant than this is left to even rays: at a distance of 20 times the lamp's
/// height.
const LEAST_COS: f32 = 0.05;

/// A surface that a probe ray has met.
#[derive(Clone, Copy)]
struct Probed {
    distance: f32,
    /// Towards the lamp.
    n: Vec3,
    /// Of the plane, from the lamp.
    height: f32,
    albedo: f32,
}

impl BrightSpots {
    /// Looks for the spots around the lamps of a scene, and for patches of sunlight in a box.
    pub(crate) fn find(scene: &Scene, bounds: &Aabb) -> Self {
        let mut spots = images_of_emitters(scene);
        spots.extend(sun_patches(scene, bounds));
        let lights = scene.lights();
        if lights.len() > MOST_LAMPS {
            return Self { spots };
        }
        let even = sphere_directions(PROBES);
        let near_lamps = (0..lights.lanes())
            .into_par_iter()
            .filter_map(|lane| lights.sample(lane))
            .flat_map_iter(|light| spots_of(scene, &light, &even));
        spots.par_extend(near_lamps);
        let shining = scene.emitters().area.len().min(MOST_EMITTERS);
        spots.par_extend((0..shining).into_par_iter().filter_map(|i| spot_of_emitter(scene, i, &even)));
        Self { spots }
    }
}

/// The images of shining surfaces in plane mirrors.
fn images_of_emitters(scene: &Scene) -> Vec<BrightSpot> {
    // Put a ball around each of them.
    let data = scene.data();
    let emission = |material: usize| {
        let material = &data.materials[material];
        if material.unlit { 0.0 } else { material.emission.max_element() }
    };
    let meshes = data.instances.iter().filter_map(|instance| {
        let mesh = &data.meshes[instance.mesh];
        let emission = emission(mesh.material);
        (emission > 0.0).then(|| (mesh.bounds().transformed(&instance.world_from_object), emission))
    });
    let spheres = data.spheres.iter().map(|sphere| (sphere.bounds(), emission(sphere.material)));
    let balls = meshes.chain(spheres.filter(|(_, emission)| *emission > 0.0)).take(MOST_EMITTERS);
    let balls: Vec<(Vec3, f32, f32)> = balls
        .map(|(bounds, emission)| (0.5 * (bounds.min + bounds.max), 0.5 * bounds.size().length(), emission))
        .collect();

    // Mirror them.
    let image = |mirror: &PlaneMirror, &(center, radius, emission): &(Vec3, f32, f32)| BrightSpot {
        shape: SpotShape::Ball { center: mirror.image_of(center), radius },
        flux: 2.0 * PI * PI * radius * radius * emission,
        contrast: 1.0,
        mirror: Some(*mirror),
    };
    let mirrors = scene.plane_mirrors();
    mirrors.iter().flat_map(|mirror| balls.iter().map(move |ball| image(mirror, ball))).collect()
}

/// The spots around one lamp.
fn spots_of(scene: &Scene, light: &SampledLight, even: &[Vec3]) -> Vec<BrightSpot> {
    // Only points and spot lamps have a place, and all their light there.
    let cone = match light.emission {
        LightEmission::Isotropic => None,
        LightEmission::Spot { cone, .. } if cone.scale == 0.0 => None,
        LightEmission::Spot { cone, .. } => {
            Some(EvenCone { axis: -cone.axis, cos: (-cone.offset / cone.scale).clamp(-1.0, 1.0) })
        }
        LightEmission::Patch { .. } | LightEmission::Directional => return Vec::new(),
    };
    let solid_angle = cone.map_or(4.0 * PI, |cone| cone.solid_angle());

    // Probe what the lamp lights.
    let lamp = light.position;
    let direction = |i: usize, d: Vec3| match &cone {
        None => d,
        Some(cone) => cone.sample(Vec2::new((i as f32 + 0.5) / even.len() as f32, (i as f32 * 0.618_034).fract())),
    };
    let probe = |(i, &d): (usize, &Vec3)| {
        let ray = Ray::new(lamp, direction(i, d));
        let hit = scene.bvh().closest(&ray)?;
        let surface = evaluate(scene, &ray, &hit);
        let albedo = surface.diffuse.max_element();
        Some(Probed { distance: hit.t, n: surface.ng, height: -surface.ng.dot(ray.direction) * hit.t, albedo })
    };
    let mut rest: Vec<Probed> = even.iter().enumerate().filter_map(probe).filter(|p| p.height > 0.0).collect();
    rest.sort_by(|a, b| a.height.total_cmp(&b.height));

    // Surfaces in one plane with a good part of the light are a spot.
    let count = even.len() as f32;
    let flux = |probed: &[Probed]| {
        light.intensity.max_element() * solid_angle / count * probed.iter().map(|p| p.albedo).sum::<f32>()
    };
    let mut spots = Vec::new();
    let mut others = Vec::new();
    while let Some(&first) = rest.first() {
        // The first itself always is: 1.05 times the smallest number is that number.
        let same = |p: &Probed| p.n.dot(first.n) > 0.999 && p.height <= 1.05 * first.height;
        let (plane, remaining): (Vec<_>, Vec<_>) = rest.into_iter().partition(same);
        rest = remaining;
        if (plane.len() as f32) < LEAST_PART * count {
            others.extend(plane);
            continue;
        }
        let cone = cone.unwrap_or(EvenCone { axis: -first.n, cos: LEAST_COS });
        let shape = SpotShape::Plane { lamp, foot: lamp - first.n * first.height, n: first.n, cone };
        spots.push(BrightSpot { shape, flux: flux(&plane), contrast: 1.0, mirror: None });
    }

    // What else is near is a ball.
    let others: Vec<(f32, f32)> = others.iter().map(|p| (p.distance, p.albedo)).collect();
    let lumen_a_probe = light.intensity.max_element() * solid_angle / count;
    spots.extend(ball(lamp, 0.0, &others, even.len()).map(|(shape, albedos)| BrightSpot {
        shape,
        flux: lumen_a_probe * albedos,
        contrast: contrast(&shape, others.iter().map(|&(distance, _)| distance)),
        mirror: None,
    }));
    spots.retain(|spot| spot.flux > 0.0);
    spots
}

/// Returns the ball of what is near a lamp of some radius, of the distances and albedos of what its `probes` met, and the
/// sum of the albedos in it; `None` if too little is near.
fn ball(center: Vec3, lamp_radius: f32, met: &[(f32, f32)], probes: usize) -> Option<(SpotShape, f32)> {
    let nearest = met.iter().map(|&(distance, _)| distance).fold(f32::INFINITY, f32::min).max(lamp_radius);
    let near = || met.iter().filter(|(distance, _)| *distance < 3.0 * nearest);
    let radius = near().map(|&(distance, _)| distance).fold(0.0, f32::max);
    let is_enough = near().count() as f32 >= LEAST_PART * probes as f32;
    is_enough.then(|| (SpotShape::Ball { center, radius }, near().map(|(_, albedo)| albedo).sum()))
}

/// Returns how many times as bright as the mean the brightest part of a ball may be, if what is lit was met at these
/// distances from where it is lit from.
fn contrast(shape: &SpotShape, distances: impl Iterator<Item = f32>) -> f32 {
    let SpotShape::Ball { radius, .. } = shape else { return 1.0 };
    let nearest = distances.fold(f32::INFINITY, f32::min);
    (radius / nearest.max(f32::MIN_POSITIVE)).powi(2).clamp(1.0, MOST_CONTRAST)
}

/// The spot around a shining surface, as where a panel lies in a can: a ball of what light from random points of it
/// meets.
fn spot_of_emitter(scene: &Scene, emitter: usize, even: &[Vec3]) -> Option<BrightSpot> {
    let (data, area) = (scene.data(), &scene.emitters().area);
    let count = even.len();
    let u = |i: usize, d: u32| unit_f32(hash(i as u32 * 4 + d));
    let points: Vec<_> =
        (0..count).filter_map(|i| area.sample_light(data, emitter, Vec2::new(u(i, 0), u(i, 1)))).collect();
    let center = points.iter().map(|point| point.position).sum::<Vec3>() / points.len().max(1) as f32;
    let radius = points.iter().map(|point| point.position.distance(center)).fold(0.0, f32::max);

    // Follow light from the points.
    let (mut met, mut lengths) = (Vec::new(), Vec::new());
    let mut flux = 0.0;
    for (i, point) in points.iter().enumerate() {
        let sides = if point.two_sided { 2.0 } else { 1.0 };
        flux += sides * PI * point.emission.max_element() / point.pdf / count as f32;
        let n = if point.two_sided && i % 2 == 1 { -point.normal } else { point.normal };
        let (t, b) = basis(n);
        let local = sample_cosine_hemisphere(Vec2::new((i as f32 + 0.5) / count as f32, u(i, 2)));
        let offset = 1e-3 * radius.max(f32::MIN_POSITIVE);
        let ray = Ray::new(point.position + n * offset, t * local.x + b * local.y + n * local.z);
        if let Some(hit) = scene.bvh().closest(&ray) {
            let surface = evaluate(scene, &ray, &hit);
            lengths.push(hit.t);
            met.push((surface.position.distance(center), surface.diffuse.max_element()));
        }
    }
    let (shape, albedos) = ball(center, radius, &met, count)?;
    let flux = flux * albedos / count as f32;
    let contrast = contrast(&shape, lengths.into_iter());
    (flux > 0.0).then_some(BrightSpot { shape, flux, contrast, mirror: None })
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;
    use std::thread;
    use std::time::Duration;

    use glam::Affine3A;

    use super::*;
    use crate::geometry::TriangleMesh;
    use crate::{Instance, Light, Material, SceneData};

    /// A lamp as near to a triangle as numbers can be.
    #[test]
    fn a_lamp_next_to_a_plane_ends_the_search() {
        let tiny = f32::from_bits(2);
        let triangle = TriangleMesh {
            positions: vec![Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.0), Vec3::new(1.0, 1.0, tiny)],
            triangles: vec![[0, 1, 2]],
            ..TriangleMesh::default()
        };
        let lamp = |y| Light::Point { position: Vec3::new(0.5, y, 0.0), intensity_cd: Vec3::ONE, range: None };
        let scene = Scene::new(SceneData {
            meshes: vec![triangle],
            instances: vec![Instance { mesh: 0, world_from_object: Affine3A::IDENTITY }],
            materials: vec![Material::lambert(Vec3::splat(0.5))],
            lights: [-0.9, -0.5, 0.0, 0.25].map(lamp).into(),
            ..SceneData::default()
        });
        let scene = scene.expect("a sound scene");
        let (done, waits) = mpsc::channel();
        thread::spawn(move || done.send(BrightSpots::find(&scene, &scene.bounds()).spots.len()));
        assert!(waits.recv_timeout(Duration::from_secs(30)).is_ok(), "the search goes on for ever");
    }
}
