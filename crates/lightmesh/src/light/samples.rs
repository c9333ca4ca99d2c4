//! All emitters as point-like or directional samples, in structure-of-arrays blocks of sixteen for SIMD.
//!
//! Light i gives the irradiance `I_i · f_i · max(0, n · d_i)` on a surface of unit normal n, where d_i points from the
//! surface to the light *with its length r kept*, and
//!
//! | | f |
//! |---|---|
//! | point, φ = r² | 1 / r³ |
//! | point, φ = Const + r (the paper) | 1 / ((Const + r) r) |
//! | spot | the same × (clamp((cosθ − cos outer) / (cos inner − cos outer)))² |
//! | with a range R | the same × clamp(1 − (r / R)⁴) |
//! | directional | 1, d the unit vector towards the light |
//! | patch of area A that faces a, φ = r² | cosθ_a / (r max(r² + A/π (3cos²θ_a − 2), A/π)), cosθ_a = max(0, −a · d / r), or its magnitude if two-sided |
//! | patch, φ = Const + r | cosθ_a / ((Const + r) r) |
//!
//! A patch is a disk of area A = πR²: its mean of cos cos / r² over a plane that is parallel to it is, to the second
//! order in R, that of its middle times 1 − R² (3cos²θ_a − 2) / r². On the axis I / (r² + R²) is exact; further off
//! than cos²θ_a = ⅔ a disk gives more than its middle. R² keeps it finite on surfaces close to it.
//!
//! Lanes do the same additions in the same order at every SIMD level, so the sums are the same bit for bit.

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f32x16};
use glam::Vec3;

use super::sample::{LightEmission, LightSample, MIN_R2, SampledLight};
use super::stratum::{LaneStratum, Stratum};
use crate::Falloff;
use crate::geometry::Ray;

/// Lights per block.
pub(crate) const LANES: usize = 16;

/// A shadow ray stops this part of its length short of its light, so that an emitter's own surface on which the sample
/// lies does not hide it: about what the other end is kept off its surface (`offset_origin`). Empirical; not varied.
const SEGMENT_END: f32 = 1.0 - 1e-4;

/// Positions (or directions) and intensities of sixteen lights.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct LightBlock {
    pub(crate) x: [f32; LANES],
    pub(crate) y: [f32; LANES],
    pub(crate) z: [f32; LANES],
    pub(super) r: [f32; LANES],
    pub(super) g: [f32; LANES],
    pub(super) b: [f32; LANES],
}

/// The part of a block of spots, ranged points and directional lights that plain points do not have.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct SpotLanes {
    /// 1 for a position, 0 for a direction.
    pub(crate) w: [f32; LANES],
    /// Axis of the cone, against the way the light shines.
    pub(crate) ax: [f32; LANES],
    pub(crate) ay: [f32; LANES],
    pub(crate) az: [f32; LANES],
    /// The cone factor is clamp(cosθ · scale + offset)².
    pub(crate) cone_scale: [f32; LANES],
    pub(crate) cone_offset: [f32; LANES],
    /// 1 / R²; 0 for no range.
    pub(crate) inv_range2: [f32; LANES],
}

/// The part of a block of patches that plain points do not have.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct PatchLanes {
    /// The normal of the side that shines.
    pub(crate) ax: [f32; LANES],
    pub(crate) ay: [f32; LANES],
    pub(crate) az: [f32; LANES],
    /// 0, or −1 for a patch that shines from both sides.
    pub(crate) back: [f32; LANES],
    /// A / π, square metres.
    pub(crate) area_over_pi: [f32; LANES],
}

/// The light samples of a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct LightSamples {
    /// Blocks of isotropic points first, then of patches, then those that have [`SpotLanes`].
    pub(crate) blocks: Vec<LightBlock>,
    pub(crate) patches: Vec<PatchLanes>,
    pub(crate) spots: Vec<SpotLanes>,
    pub(crate) count: usize,
    /// Lanes of the last block that have a light.
    pub(crate) last_lanes: usize,
    /// By lane; nothing where all lights are points or directions.
    pub(super) strata: Vec<LaneStratum>,
    /// By block; nothing where all lights are points or directions.
    pub(super) reaches: Vec<ReachLanes>,
}

/// How far the strata of the lights of a block reach: see [`Reach`](super::stratum::Reach).
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct ReachLanes {
    pub(super) radius: [f32; LANES],
    pub(super) spread: [f32; LANES],
}

/// Returns the shadow ray from a point to a light.
pub(crate) fn shadow_ray_to(light: &SampledLight, from: Vec3) -> Ray {
    match light.emission {
        LightEmission::Directional => Ray::new(from, light.position),
        _ => Ray { t_max: SEGMENT_END, ..Ray::segment(from, light.position) },
    }
}

/// d and f of the module's table for each lane of some blocks.
#[derive(Clone, Debug, Default)]
pub(crate) struct Directions {
    pub dx: Vec<f32>,
    pub dy: Vec<f32>,
    pub dz: Vec<f32>,
    pub f: Vec<f32>,
}

impl LightSamples {
    /// Packs the samples that shine: isotropic points first, then patches, then the others.
    pub(crate) fn new(samples: &[LightSample]) -> Self {
        let samples: Vec<_> = samples.iter().map(|&sample| (sample, LaneStratum::default())).collect();
        Self::of_strata(&samples)
    }

    /// [`LightSamples::new`] with the strata that samples stand for.
    pub(crate) fn of_strata(samples: &[(LightSample, LaneStratum)]) -> Self {
        let mut lights: Vec<_> = samples.iter().map(|(sample, stratum)| (SampledLight::of(sample), *stratum)).collect();
        lights.retain(|(light, _)| light.intensity != Vec3::ZERO);
        lights.sort_by_key(|(light, _)| light.emission.order());
        let has_strata = lights.iter().any(|(_, lane)| lane.stratum != Stratum::Point);
        let mut packed = Self::default();
        for (light, stratum) in &lights {
            let lane = packed.push(light);
            if has_strata {
                packed.strata.resize(lane + 1, LaneStratum::default());
                packed.strata[lane] = *stratum;
            }
        }
        if has_strata {
            packed.strata.resize(packed.lanes(), LaneStratum::default());
            let reaches = |block: &[LaneStratum]| ReachLanes {
                radius: std::array::from_fn(|i| block[i].reach.radius),
                spread: std::array::from_fn(|i| block[i].reach.spread),
            };
            packed.reaches = packed.strata.chunks_exact(LANES).map(reaches).collect();
        }
        packed
    }

    /// Whether any light stands for more than a point or a direction.
    pub(crate) fn has_strata(&self) -> bool {
        !self.strata.is_empty()
    }

    /// Returns what a lane's light stands for.
    #[inline(always)]
    pub(crate) fn stratum(&self, lane: usize) -> Stratum {
        self.strata.get(lane).map_or(Stratum::Point, |lane| lane.stratum)
    }

    /// Returns how far from its light, and in which other directions than it, a lane's stratum reaches.
    pub(crate) fn radius(&self, lane: usize) -> f32 {
        self.strata.get(lane).map_or(0.0, |lane| lane.reach.radius)
    }

    /// How many lights there are.
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// How many lanes all blocks have, with those that pad the last block of each kind: the length of per-lane arrays.
    pub(crate) fn lanes(&self) -> usize {
        self.blocks.len() * LANES
    }

    /// Intensity (candela) or illuminance (lux) of a lane; zero for padding.
    pub(crate) fn intensity(&self, lane: usize) -> Vec3 {
        let (block, i) = (&self.blocks[lane / LANES], lane % LANES);
        Vec3::new(block.r[i], block.g[i], block.b[i])
    }

    /// The shadow ray from a point to a lane's light.
    pub(crate) fn shadow_ray(&self, lane: usize, from: Vec3) -> Ray {
        let (block, i) = (&self.blocks[lane / LANES], lane % LANES);
        let target = Vec3::new(block.x[i], block.y[i], block.z[i]);
        if self.is_directional(lane) {
            Ray::new(from, target)
        } else if let Stratum::Bulb(_) = self.stratum(lane) {
            // It ends where the lamp's own surface begins.
            let ray = Ray::segment(from, target);
            let free = 1.0 - self.radius(lane) / ray.direction.length().max(f32::MIN_POSITIVE);
            Ray { t_max: (free * SEGMENT_END).max(0.0), ..ray }
        } else {
            Ray { t_max: SEGMENT_END, ..Ray::segment(from, target) }
        }
    }

    /// Whether a lane's light is parallel.
    pub(crate) fn is_directional(&self, lane: usize) -> bool {
        let plain = self.blocks.len() - self.spots.len();
        (lane / LANES).checked_sub(plain).is_some_and(|e| self.spots[e].w[lane % LANES] == 0.0)
    }

    /// Sums the unshadowed irradiance per channel (lux) on each of the surface points `(position, unit normal)`: Σ_i of
    /// formula (2).
    pub(crate) fn irradiance(
        &self,
        level: Level,
        falloff: Falloff,
        points: impl ExactSizeIterator<Item = (Vec3, Vec3)>,
        out: &mut Vec<Vec3>,
    ) {
        out.clear();
        out.reserve(points.len());
        dispatch!(level, simd => irradiance_simd(simd, self, falloff, points, out));
    }

    /// Evaluates d and f of every lane at a point.
    pub(crate) fn directions(&self, level: Level, falloff: Falloff, point: Vec3, out: &mut Directions) {
        let n = self.lanes();
        for array in [&mut out.dx, &mut out.dy, &mut out.dz, &mut out.f] {
            array.resize(n, 0.0);
        }
        dispatch!(level, simd => directions_simd(simd, self, falloff, point, out));
    }
}

/// The lanes of one block: d, and f times 0 or more.
pub(super) struct Lanes<S: Simd> {
    pub(super) dx: f32x16<S>,
    pub(super) dy: f32x16<S>,
    pub(super) dz: f32x16<S>,
    pub(super) f: f32x16<S>,
}

#[inline(always)]
fn irradiance_simd<S: Simd>(
    simd: S,
    lights: &LightSamples,
    falloff: Falloff,
    points: impl ExactSizeIterator<Item = (Vec3, Vec3)>,
    out: &mut Vec<Vec3>,
) {
    let zero = f32x16::splat(simd, 0.0);
    for (p, n) in points {
        let (mut r, mut g, mut b) = (zero, zero, zero);
        for_each_block(
            simd,
            lights,
            falloff,
            p,
            #[inline(always)]
            |block, _, l| {
                let cos = l.dx * n.x + l.dy * n.y + l.dz * n.z;
                let e = cos.max(zero) * l.f;
                r += e * f32x16::from_slice(simd, &block.r);
                g += e * f32x16::from_slice(simd, &block.g);
                b += e * f32x16::from_slice(simd, &block.b);
            },
        );
        out.push(Vec3::new(sum(r), sum(g), sum(b)));
    }
}

#[inline(always)]
fn directions_simd<S: Simd>(simd: S, lights: &LightSamples, falloff: Falloff, p: Vec3, out: &mut Directions) {
    for_each_block(
        simd,
        lights,
        falloff,
        p,
        #[inline(always)]
        |_, first, l| {
            let range = first..first + LANES;
            l.dx.store_slice(&mut out.dx[range.clone()]);
            l.dy.store_slice(&mut out.dy[range.clone()]);
            l.dz.store_slice(&mut out.dz[range.clone()]);
            l.f.store_slice(&mut out.f[range]);
        },
    );
}

/// Calls `visit(block, first lane, d and f)` for every block, plain ones first.
#[inline(always)]
pub(super) fn for_each_block<S: Simd>(
    simd: S,
    lights: &LightSamples,
    falloff: Falloff,
    p: Vec3,
    mut visit: impl FnMut(&LightBlock, usize, Lanes<S>),
) {
    let (plain, rest) = lights.blocks.split_at(lights.blocks.len() - lights.patches.len() - lights.spots.len());
    let (patches, spots) = rest.split_at(lights.patches.len());
    let mut first = 0;
    for block in plain {
        visit(block, first, plain_lanes(simd, block, falloff, p));
        first += LANES;
    }
    for (block, lanes) in patches.iter().zip(&lights.patches) {
        visit(block, first, patch_lanes(simd, block, lanes, falloff, p));
        first += LANES;
    }
    for (block, lanes) in spots.iter().zip(&lights.spots) {
        visit(block, first, spot_lanes(simd, block, lanes, falloff, p));
        first += LANES;
    }
}

/// d and f of plain point lights.
#[inline(always)]
fn plain_lanes<S: Simd>(simd: S, block: &LightBlock, falloff: Falloff, p: Vec3) -> Lanes<S> {
    let [dx, dy, dz] = offset(simd, block, p, f32x16::splat(simd, 1.0));
    let r2 = (dx * dx + dy * dy + dz * dz).max(f32x16::splat(simd, MIN_R2));
    Lanes { dx, dy, dz, f: falloff.attenuation_over_distance_simd(r2, r2.sqrt()) }
}

/// Returns d of each lane: of positions, `w` 1, or directions, `w` 0.
#[inline(always)]
fn offset<S: Simd>(simd: S, block: &LightBlock, p: Vec3, w: f32x16<S>) -> [f32x16<S>; 3] {
    [
        f32x16::from_slice(simd, &block.x) - w * p.x,
        f32x16::from_slice(simd, &block.y) - w * p.y,
        f32x16::from_slice(simd, &block.z) - w * p.z,
    ]
}

/// d and f of patches.
#[inline(always)]
fn patch_lanes<S: Simd>(simd: S, block: &LightBlock, lanes: &PatchLanes, falloff: Falloff, p: Vec3) -> Lanes<S> {
    let load = |array: &[f32; LANES]| f32x16::from_slice(simd, array);
    let [dx, dy, dz] = offset(simd, block, p, f32x16::splat(simd, 1.0));
    let r2 = (dx * dx + dy * dy + dz * dz).max(f32x16::splat(simd, MIN_R2));
    let r = r2.sqrt();
    let ahead = -(dx * load(&lanes.ax) + dy * load(&lanes.ay) + dz * load(&lanes.az)) / r;
    let cos = ahead.max(ahead * load(&lanes.back));
    let f = match falloff {
        Falloff::InverseSquare => {
            let area_over_pi = load(&lanes.area_over_pi);
            cos / ((r2 + area_over_pi * (cos * cos * 3.0 - 2.0)).max(area_over_pi) * r)
        }
        Falloff::ConstantPlusDistance { .. } => falloff.attenuation_over_distance_simd(r2, r) * cos,
    };
    Lanes { dx, dy, dz, f }
}

/// d and f of spots, ranges and directions.
#[inline(always)]
fn spot_lanes<S: Simd>(simd: S, block: &LightBlock, lanes: &SpotLanes, falloff: Falloff, p: Vec3) -> Lanes<S> {
    let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
    let load = |array: &[f32; LANES]| f32x16::from_slice(simd, array);
    let w = load(&lanes.w);
    let [dx, dy, dz] = offset(simd, block, p, w);
    let r2 = (dx * dx + dy * dy + dz * dz).max(f32x16::splat(simd, MIN_R2));
    let r = r2.sqrt();
    let cos = (dx * load(&lanes.ax) + dy * load(&lanes.ay) + dz * load(&lanes.az)) / r;
    let cone = (cos * load(&lanes.cone_scale) + load(&lanes.cone_offset)).max(zero).min(one);
    let q = r2 * load(&lanes.inv_range2);
    let window = (one - q * q).max(zero);
    let f = falloff.attenuation_over_distance_simd(r2, r) * cone * cone * window;
    Lanes { dx, dy, dz, f: w.simd_gt(zero).select(f, one) }
}

/// The sum of all lanes, by halves: lane i + lane i + 8, then + 4, + 2, + 1.
#[inline(always)]
pub(super) fn sum<S: Simd>(v: f32x16<S>) -> f32 {
    let (low, high) = v.split();
    let (low, high) = (low + high).split();
    let four = low + high;
    (four[0] + four[2]) + (four[1] + four[3])
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_4;

    use super::*;
    use crate::scene::Light;

    fn from_lights(lights: &[Light]) -> LightSamples {
        LightSamples::new(&lights.iter().map(|&light| LightSample::Punctual(light)).collect::<Vec<_>>())
    }

    fn irradiance(lights: &[Light], p: Vec3, n: Vec3) -> Vec3 {
        let samples = from_lights(lights);
        let mut out = Vec::new();
        samples.irradiance(Level::new(), Falloff::InverseSquare, [(p, n)].into_iter(), &mut out);
        out[0]
    }

    const LAMP: Light =
        Light::Point { position: Vec3::new(0.0, 2.0, 0.0), intensity_cd: Vec3::new(8.0, 4.0, 2.0), range: None };

    /// E = I cosθ / r²: 2 m above, and at 45° from √8 m.
    #[test]
    fn point_light_is_cosine_over_distance_squared() {
        assert_eq!(irradiance(&[LAMP], Vec3::ZERO, Vec3::Y), Vec3::new(2.0, 1.0, 0.5));
        let slanted = irradiance(&[LAMP], Vec3::new(2.0, 0.0, 0.0), Vec3::Y).x;
        assert!((slanted - 8.0 * FRAC_PI_4.cos() / 8.0).abs() < 1e-6);
        assert_eq!(irradiance(&[LAMP], Vec3::ZERO, Vec3::NEG_Y), Vec3::ZERO);
    }

    #[test]
    fn a_sum_is_the_sum_of_its_lights() {
        let lights: Vec<Light> = (0..37)
            .map(|i| Light::Point {
                position: Vec3::new(i as f32 * 0.3 - 5.0, 2.0, 1.0),
                intensity_cd: Vec3::splat(1.0 + i as f32),
                range: (i % 3 == 0).then_some(9.0),
            })
            .collect();
        let p = Vec3::new(0.2, 0.1, -0.3);
        let all = irradiance(&lights, p, Vec3::Y);
        let one_by_one: Vec3 = lights.iter().map(|&l| irradiance(&[l], p, Vec3::Y)).sum();
        assert!((all - one_by_one).length() < 1e-4 * all.length());
    }

    /// KHR_lights_punctual: 1 − (r/R)⁴ at r = 2, R = 4 is 15/16, and nothing beyond R.
    #[test]
    fn range_fades_to_zero() {
        let Light::Point { position, intensity_cd, .. } = LAMP else { unreachable!() };
        let ranged = |r| Light::Point { position, intensity_cd, range: Some(r) };
        assert!((irradiance(&[ranged(4.0)], Vec3::ZERO, Vec3::Y).x - 2.0 * 15.0 / 16.0).abs() < 1e-6);
        assert_eq!(irradiance(&[ranged(1.5)], Vec3::ZERO, Vec3::Y).x, 0.0);
    }

    /// Full inside the inner cone, squared ramp of cosines between, zero outside the outer one.
    #[test]
    fn spot_cone() {
        let spot = Light::Spot {
            position: Vec3::Y,
            direction: Vec3::NEG_Y,
            intensity_cd: Vec3::ONE,
            range: None,
            inner_cone_angle: 0.2,
            outer_cone_angle: 0.6,
        };
        let at = |angle: f32| {
            let x = angle.tan();
            irradiance(&[spot], Vec3::new(x, 0.0, 0.0), Vec3::Y).x * (1.0 + x * x).powf(1.5)
        };
        assert!((at(0.1) - 1.0).abs() < 1e-5 && at(0.61) == 0.0);
        let ramp = (0.4_f32.cos() - 0.6_f32.cos()) / (0.2_f32.cos() - 0.6_f32.cos());
        assert!((at(0.4) - ramp * ramp).abs() < 1e-5);
    }

    #[test]
    fn directional_does_not_fade() {
        let sun = Light::Directional { direction: Vec3::new(0.0, -0.6, -0.8), illuminance_lux: Vec3::splat(10.0) };
        for y in [0.0, 1e6] {
            assert!((irradiance(&[sun], Vec3::new(3.0, y, 0.0), Vec3::Y).x - 6.0).abs() < 1e-5);
        }
        let samples = from_lights(&[LAMP, sun]);
        assert_eq!(samples.shadow_ray(LANES, Vec3::ONE).t_max, f32::INFINITY);
        assert!(samples.shadow_ray(0, Vec3::ONE).t_max < 1.0);
    }

    /// Every SIMD level gives the bits of the widest.
    #[test]
    fn bits_do_not_depend_on_the_simd_level() {
        let lights: Vec<Light> = (0..100)
            .map(|i| Light::Point {
                position: Vec3::new(libm::sinf(i as f32), libm::cosf(2.0 * i as f32), 1.0 + i as f32 * 0.1),
                intensity_cd: Vec3::new(1.0, 0.3, 0.7),
                range: (i % 7 == 0).then_some(8.0),
            })
            .collect();
        let samples = from_lights(&lights);
        let points = || (0..50).map(|i| (Vec3::new(i as f32 * 0.1, 0.0, 0.2), Vec3::new(0.6, 0.0, 0.8)));
        let run = |level| {
            let mut out = Vec::new();
            samples.irradiance(level, Falloff::InverseSquare, points(), &mut out);
            out
        };
        assert_eq!(run(Level::new()), run(Level::baseline()));
    }
}
