//! Bright spots: surfaces close to a lamp, whose light few of evenly spread rays find. A lamp 3 cm below a ceiling lights
//! a disk of a hand's breadth on it as strongly as a lamp of its own.
//!
//! Probe rays from each lamp find what is near. Surfaces in one plane that get a good part of the lamp's light are one
//! spot, whose directions are sampled in proportion to its light; what else is near, as the walls of a can, is a ball
//! around the lamp. Both have a density in closed form for every direction, whatever the rays really meet. So has the
//! ball around the image of a shining surface in a plane mirror.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::gather::sphere_directions;
use crate::Scene;
use crate::geometry::Ray;
use crate::interaction::evaluate;
use crate::light::PlaneMirror;
use crate::light::sample::{LightEmission, SampledLight};
use crate::sampling::basis;

/// Rays that look for surfaces near a lamp.
const PROBES: u32 = 48;

/// Lamps that are probed, at most: with more of them, none is much brighter than the rest.
const MOST_LAMPS: usize = 2048;

/// Shining surfaces whose mirror images are looked for, at most.
const MOST_EMITTERS: usize = 64;

/// The part of a lamp's rays that makes a spot.
const LEAST_PART: f32 = 0.12;

/// Light of a lamp at a surface more aslant than this is left to even rays: at a distance of 20 times the lamp's
/// height.
const LEAST_COS: f32 = 0.05;

/// The bright spots of a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct BrightSpots {
    spots: Vec<BrightSpot>,
}

/// Surfaces near a lamp.
#[derive(Clone, Copy, Debug)]
pub(super) struct BrightSpot {
    shape: SpotShape,
    /// Luminous flux that the surfaces reflect, lumen; the largest channel.
    flux: f32,
    /// The mirror behind which it is seen.
    mirror: Option<PlaneMirror>,
}

/// Where the surfaces of a spot are.
#[derive(Clone, Copy, Debug)]
enum SpotShape {
    /// In the plane through `foot` with normal `n`, which faces the lamp; lit by rays that are even in a cone.
    Plane { lamp: Vec3, foot: Vec3, n: Vec3, cone: EvenCone },
    /// Within a distance of the lamp.
    Ball { center: Vec3, radius: f32 },
}

/// Directions evenly spread in a cone.
#[derive(Clone, Copy, Debug)]
struct EvenCone {
    /// Unit.
    axis: Vec3,
    cos: f32,
}

impl EvenCone {
    fn sample(&self, u: Vec2) -> Vec3 {
        let z = 1.0 - u.x * (1.0 - self.cos);
        let (r, phi) = ((1.0 - z * z).max(0.0).sqrt(), TAU * u.y);
        let (t, b) = basis(self.axis);
        t * (r * libm::cosf(phi)) + b * (r * libm::sinf(phi)) + self.axis * z
    }

    /// Density per steradian.
    fn pdf(&self, direction: Vec3) -> f32 {
        if direction.dot(self.axis) < self.cos { 0.0 } else { 1.0 / self.solid_angle() }
    }

    fn solid_angle(&self) -> f32 {
        (TAU * (1.0 - self.cos)).max(1e-6)
    }
}

/// How a spot looks from a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpotView {
    /// Irradiance on a surface that faces it, lux, if nothing stands between.
    pub irradiance: f32,
    /// Its solid angle, steradian: of a disk as wide as the lamp is high.
    pub solid_angle: f32,
}

impl BrightSpot {
    /// Returns how the spot looks from `x`, `None` from behind and from within.
    pub(super) fn seen_from(&self, x: Vec3) -> Option<SpotView> {
        match self.shape {
            SpotShape::Plane { lamp, foot, n, .. } => {
                let d = x - foot;
                let (r2, height2) = (d.length_squared(), lamp.distance_squared(foot));
                let cos = n.dot(d) / r2.sqrt();
                (cos > 0.0).then(|| SpotView {
                    irradiance: self.flux * cos / (PI * (r2 + height2)),
                    solid_angle: PI * height2 * cos / r2,
                })
            }
            SpotShape::Ball { center, radius } => {
                if self.mirror.is_some_and(|mirror| mirror.height(x) * mirror.height(center) >= 0.0) {
                    return None;
                }
                let r2 = x.distance_squared(center);
                (r2 > 4.0 * radius * radius).then(|| SpotView {
                    irradiance: self.flux / (4.0 * PI * r2),
                    solid_angle: PI * radius * radius / r2,
                })
            }
        }
    }

    /// Returns a ray from `x` to the middle of the spot, which ends before it; `None` where the way is by a mirror.
    pub(super) fn ray_from(&self, x: Vec3) -> Option<Ray> {
        let (to, before) = match self.shape {
            SpotShape::Plane { foot, .. } => (foot, 0.01),
            SpotShape::Ball { center, radius } => (center, 1.01 * radius / x.distance(center)),
        };
        self.mirror.is_none().then(|| Ray { t_max: (1.0 - before).max(0.0), ..Ray::segment(x, to) })
    }

    /// A unit direction from `x` to the spot, by u in [0, 1)²; `None` where the lamp's ray does not meet the plane.
    pub(super) fn sample(&self, x: Vec3, u: Vec2) -> Option<Vec3> {
        match self.shape {
            SpotShape::Plane { lamp, foot, n, cone } => {
                let l = cone.sample(u);
                let cos = -n.dot(l);
                (cos > 0.0).then(|| (lamp + l * (n.dot(lamp - foot) / cos) - x).normalize_or_zero())
            }
            SpotShape::Ball { center, radius } => Some(cone_of_ball(x, center, radius).sample(u)),
        }
    }

    /// The density of [`Self::sample`] per steradian.
    #[inline]
    pub(super) fn pdf(&self, x: Vec3, direction: Vec3) -> f32 {
        match self.shape {
            SpotShape::Plane { lamp, foot, n, cone } => {
                // Where the ray meets the plane, and the lamp's ray there.
                let cos = -n.dot(direction);
                let t = n.dot(x - foot) / cos;
                if cos <= 1e-6 || t <= 0.0 {
                    return 0.0;
                }
                let l = x + direction * t - lamp;
                let r2 = l.length_squared();
                let l = l / r2.sqrt();
                cone.pdf(l) * (-n.dot(l)).max(0.0) / r2 * (t * t / cos)
            }
            SpotShape::Ball { center, radius } => cone_of_ball(x, center, radius).pdf(direction),
        }
    }
}

/// The cone in which a ball is seen from outside.
fn cone_of_ball(x: Vec3, center: Vec3, radius: f32) -> EvenCone {
    let d = center - x;
    let r2 = d.length_squared();
    EvenCone { axis: d / r2.sqrt(), cos: (1.0 - radius * radius / r2).max(0.0).sqrt() }
}

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
    /// Looks for the spots around the lamps of a scene.
    pub(crate) fn find(scene: &Scene) -> Self {
        let mut spots = images_of_emitters(scene);
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
        Self { spots }
    }

    /// The spots.
    pub(super) fn iter(&self) -> impl Iterator<Item = &BrightSpot> {
        self.spots.iter()
    }

    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.spots.is_empty()
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
        let same = |p: &Probed| p.n.dot(first.n) > 0.999 && p.height < 1.05 * first.height;
        let (plane, remaining): (Vec<_>, Vec<_>) = rest.into_iter().partition(same);
        rest = remaining;
        if (plane.len() as f32) < LEAST_PART * count {
            others.extend(plane);
            continue;
        }
        let cone = cone.unwrap_or(EvenCone { axis: -first.n, cos: LEAST_COS });
        let shape = SpotShape::Plane { lamp, foot: lamp - first.n * first.height, n: first.n, cone };
        spots.push(BrightSpot { shape, flux: flux(&plane), mirror: None });
    }

    // What else is near is a ball.
    let nearest = others.iter().map(|p| p.distance).fold(f32::INFINITY, f32::min);
    others.retain(|p| p.distance < 3.0 * nearest);
    let radius = others.iter().map(|p| p.distance).fold(0.0, f32::max);
    if others.len() as f32 >= LEAST_PART * count {
        let shape = SpotShape::Ball { center: lamp, radius };
        spots.push(BrightSpot { shape, flux: flux(&others), mirror: None });
    }
    spots.retain(|spot| spot.flux > 0.0);
    spots
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{hash, unit_f32};

    const LAMP: Vec3 = Vec3::new(0.3, 2.9, -0.2);
    const X: Vec3 = Vec3::new(-1.0, 1.0, 0.5);

    fn plane() -> BrightSpot {
        let cone = EvenCone { axis: Vec3::Y, cos: LEAST_COS };
        let shape = SpotShape::Plane { lamp: LAMP, foot: LAMP.with_y(3.0), n: Vec3::NEG_Y, cone };
        BrightSpot { shape, flux: 1.0, mirror: None }
    }

    fn ball() -> BrightSpot {
        BrightSpot { shape: SpotShape::Ball { center: LAMP, radius: 0.4 }, flux: 1.0, mirror: None }
    }

    /// The mean of f / pdf over samples is the integral of f: of 1 over a region of known solid angle, and of a plane's
    /// irradiance from a point lamp over the disk of radius a, 2π (1 − h / √(h² + a²)) for unit intensity.
    #[test]
    fn samples_over_their_density_integrate() {
        let n = 20_000;
        let u = |i: u32| Vec2::new((i as f32 + 0.5) / n as f32, unit_f32(hash(i)));
        let mut inside = 0.0;
        for i in 0..n {
            let w = plane().sample(X, u(i)).expect("a direction");
            let q = X + w * ((3.0 - X.y) / w.y);
            let (r2, cos) = ((q - LAMP).length_squared(), 0.1 / (q - LAMP).length());
            let (radius2, d2) = ((q - LAMP.with_y(3.0)).length_squared(), (q - X).length_squared());
            if radius2 < 0.25 {
                // Irradiance times the area that a steradian sees, over the density.
                inside += cos / r2 * d2 / w.y / plane().pdf(X, w) / n as f32;
            }
        }
        let disk = TAU * (1.0 - 0.1 / 0.26_f32.sqrt());
        assert!((inside / disk - 1.0).abs() < 0.01, "{inside} {disk}");

        let solid: f32 = (0..n).map(|i| 1.0 / ball().pdf(X, ball().sample(X, u(i)).expect("a direction"))).sum();
        let sin2 = 0.16 / X.distance_squared(LAMP);
        let cap = TAU * (1.0 - (1.0 - sin2).sqrt());
        assert!((solid / n as f32 / cap - 1.0).abs() < 0.01);
    }

    /// No light from behind, and none in directions away from it.
    #[test]
    fn directions_away_have_no_density() {
        assert_eq!((plane().pdf(X, Vec3::NEG_Y), ball().pdf(X, Vec3::NEG_Y)), (0.0, 0.0));
        assert!(plane().seen_from(Vec3::new(0.0, 3.5, 0.0)).is_none() && ball().seen_from(LAMP).is_none());
    }
}
