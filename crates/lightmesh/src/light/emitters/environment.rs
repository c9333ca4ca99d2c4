//! The environment as a light: radiance by direction, and directions in proportion to it.

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use glam::{Quat, Vec2, Vec3};

use super::super::sample::{LightEmission, LightSample, SampledLight};
use super::super::stratum::{LaneStratum, Reach, Stratum};
use super::luminance;
use super::primitive::sample_sphere;
use super::sky_cells::{SkyCells, SkyPatch, direction_of};
use crate::sampling::Table;
use crate::scene::{ColorEncoding, Environment, Filter, ImageData, Light, Texture, Wrap};

/// Largest side of the table of importance; larger maps are averaged down to it.
const MAX_SIDE: u32 = 1024;

/// A checked environment that is not black.
#[derive(Debug)]
pub(crate) struct EnvironmentLight {
    environment: Environment,
    map_from_world: Quat,
    map: Option<Map>,
    mean_luminance: f64,
    strata: Option<SkyCells>,
}

/// The importance of a map's directions.
#[derive(Debug)]
struct Map {
    table: Table,
    width: usize,
    /// Mean radiance of each cell of the table, in texels' units.
    cells: Vec<Vec3>,
}

/// The sampler of maps.
const SAMPLER: Texture =
    Texture { image: 0, wrap_s: Wrap::Repeat, wrap_t: Wrap::ClampToEdge, filter: Filter::Bilinear };

impl EnvironmentLight {
    /// `None` for a black one.
    pub(crate) fn new(environment: &Environment) -> Option<Self> {
        let map = environment.map.as_ref().map(Map::new);
        // The mean over the sphere: rows in proportion to sin θ.
        let mean = match &map {
            None => Vec3::ONE,
            Some(map) => {
                let height = map.cells.len() / map.width;
                let (mut sum, mut weights) = (glam::DVec3::ZERO, 0.0);
                for (row, cells) in map.cells.chunks_exact(map.width).enumerate() {
                    let sin = f64::from(sin_of_row(row, height));
                    sum += cells.iter().map(|c| c.as_dvec3()).sum::<glam::DVec3>() * sin;
                    weights += sin * map.width as f64;
                }
                (sum / weights).as_vec3()
            }
        };
        let mean_luminance = f64::from(luminance(mean * environment.radiance));
        (mean_luminance > 0.0).then(|| Self {
            environment: environment.clone(),
            map_from_world: environment.world_from_map.conjugate(),
            map,
            mean_luminance,
            strata: None,
        })
    }

    /// Luminance, averaged over all directions, cd/m².
    pub(super) fn mean_luminance(&self) -> f64 {
        self.mean_luminance
    }

    /// Returns the radiance that arrives along a unit direction of the world, cd/m² per channel.
    pub(crate) fn radiance(&self, direction: Vec3) -> Vec3 {
        let Some(image) = &self.environment.map else { return self.environment.radiance };
        let texel = SAMPLER.sample(image, uv_of(self.map_from_world * direction), ColorEncoding::Srgb);
        texel.truncate() * self.environment.radiance
    }

    /// Samples a direction of the world by u in [0, 1)². Returns it and its density per steradian.
    pub(crate) fn sample(&self, u: Vec2) -> (Vec3, f32) {
        match &self.map {
            None => (sample_sphere(u), 0.25 * FRAC_1_PI),
            Some(map) => {
                let uv = map.table.sample(u);
                (self.environment.world_from_map * direction_of(uv), map.pdf(uv))
            }
        }
    }

    /// The density with which [`EnvironmentLight::sample`] finds a unit direction, per steradian.
    pub(crate) fn pdf(&self, direction: Vec3) -> f32 {
        match &self.map {
            None => 0.25 * FRAC_1_PI,
            Some(map) => map.pdf(uv_of(self.map_from_world * direction)),
        }
    }

    /// Divides the sky into `n` strata, and returns directional lights that represent them.
    pub(super) fn arrange(&mut self, n: u32) -> Vec<(LightSample, LaneStratum)> {
        const EVEN: [Vec3; 1] = [Vec3::ONE];
        let (cells, width) = self.map.as_ref().map_or((EVEN.as_slice(), 1), |map| (map.cells.as_slice(), map.width));
        let (strata, patches) = SkyCells::new(cells, width, n);
        self.strata = Some(strata);
        let light = |(i, patch): (usize, SkyPatch)| {
            let reach = Reach { radius: patch.radius, spread: 0.0 };
            let direction = -(self.environment.world_from_map * patch.direction);
            let illuminance_lux = patch.illuminance * self.environment.radiance;
            let sample = LightSample::Punctual(Light::Directional { direction, illuminance_lux });
            (sample, LaneStratum { stratum: Stratum::Sky(i as u32), reach })
        };
        patches.into_iter().enumerate().map(light).collect()
    }

    /// Returns a random direction of a stratum as a light, by u in [0, 1)²: its light at any place has the stratum's
    /// light there as expectation.
    pub(crate) fn sample_stratum(&self, stratum: u32, u: Vec2) -> Option<SampledLight> {
        let point = self.strata.as_ref()?.sample(stratum, u);
        let position = self.environment.world_from_map * point.direction;
        let intensity = self.radiance(position) * point.solid_angle;
        Some(SampledLight { position, intensity, emission: LightEmission::Directional })
    }
}

impl Map {
    pub(crate) fn new(image: &ImageData) -> Self {
        let (width, height) = (image.width.min(MAX_SIDE), image.height.min(MAX_SIDE));
        // Average the map down to the cells of the table.
        let texel =
            |x: u32, y: u32| ColorEncoding::Srgb.texel(&image.texels, y as usize * image.width as usize + x as usize);
        let range = |i: u32, cells: u32, texels: u32| {
            let at = |i: u32| (u64::from(i) * u64::from(texels) / u64::from(cells)) as u32;
            at(i)..at(i + 1)
        };
        let mut cells = Vec::with_capacity(width as usize * height as usize);
        for y in 0..height {
            for x in 0..width {
                let (columns, rows) = (range(x, width, image.width), range(y, height, image.height));
                let count = columns.len() * rows.len();
                let sum: Vec3 = rows.flat_map(|j| columns.clone().map(move |i| texel(i, j).truncate())).sum();
                cells.push(sum / count as f32);
            }
        }
        // Blur them like lookups, and weigh them by luminance and solid angle.
        let sides = [(image.width, width), (image.height, height)].map(|(texels, cells)| texels as f32 / cells as f32);
        let cells = blur_like_lookups(&cells, width as usize, sides);
        let weight = |(i, c): (usize, &Vec3)| luminance(*c) * sin_of_row(i / width as usize, height as usize);
        let weights: Vec<f32> = cells.iter().enumerate().map(weight).collect();
        Self { table: Table::new(width as usize, &weights), width: width as usize, cells }
    }

    /// Returns the density at (u, v) per steradian: dω = 2π² sin θ du dv.
    pub(crate) fn pdf(&self, uv: Vec2) -> f32 {
        let sin = libm::sinf(PI * uv.y);
        if sin <= 0.0 { 0.0 } else { self.table.pdf(uv) / (2.0 * PI * PI * sin) }
    }
}

/// Blurs cells as bilinear lookup carries light from each into its neighbours. The mean of a lookup over a texel is an
/// eighth of the texel before, six of its own and an eighth of the next; over a cell of n texels a neighbour's share is
/// 1/8n. Without the blur the rim of a small sun is bright where the table is dark, and few samples with huge weights
/// find it. Columns wrap around; rows do not.
fn blur_like_lookups(cells: &[Vec3], width: usize, texels_per_cell: [f32; 2]) -> Vec<Vec3> {
    let [a, b] = texels_per_cell.map(|n| 0.125 / n);
    let height = cells.len() / width;
    let across = |x: usize, y: usize| {
        let at = |x: usize| cells[y * width + x % width];
        at(x) * (1.0 - 2.0 * a) + (at(x + width - 1) + at(x + 1)) * a
    };
    let rows: Vec<Vec3> = (0..cells.len()).map(|i| across(i % width, i / width)).collect();
    let down = |x: usize, y: usize| {
        let at = |y: usize| rows[y * width + x];
        at(y) * (1.0 - 2.0 * b) + (at(y.saturating_sub(1)) + at((y + 1).min(height - 1))) * b
    };
    (0..cells.len()).map(|i| down(i % width, i / width)).collect()
}

fn sin_of_row(row: usize, height: usize) -> f32 {
    libm::sinf(PI * (row as f32 + 0.5) / height as f32)
}

/// Returns the (u, v) in [0, 1] of a unit direction of the map.
fn uv_of(d: Vec3) -> Vec2 {
    let phi = libm::atan2f(-d.z, -d.x) / TAU;
    Vec2::new(if phi < 0.0 { phi + 1.0 } else { phi }, libm::acosf(d.y.clamp(-1.0, 1.0)) / PI)
}

#[cfg(test)]
mod tests {
    use super::super::radical_inverse;
    use super::*;
    use crate::sampling::chi_square::assert_follows;
    use crate::sampling::{hash, unit_f32};
    use crate::scene::Texels;

    /// A map that is brighter above, with a small sun.
    fn sky() -> EnvironmentLight {
        let (width, height) = (64, 32);
        let texel = |i: usize| {
            let sky = 1.0 - (i / width) as f32 / height as f32;
            if i == 8 * width + 40 { [500.0, 400.0, 300.0, 1.0] } else { [0.5 * sky, 0.7 * sky, sky, 1.0] }
        };
        let texels: Vec<[f32; 4]> = (0..width * height).map(texel).collect();
        let map = ImageData {
            name: String::new(),
            width: width as u32,
            height: height as u32,
            texels: Texels::Rgba32F(texels.into()),
        };
        let world_from_map = Quat::from_rotation_y(0.7);
        EnvironmentLight::new(&Environment { map: Some(map), radiance: Vec3::splat(2.0), world_from_map })
            .expect("bright")
    }

    /// The middle of the map is +X, a quarter on is +Z, the top +Y.
    #[test]
    fn the_map_lies_as_it_is_documented() {
        for (u, v, d) in [(0.5, 0.5, Vec3::X), (0.75, 0.5, Vec3::Z), (0.3, 0.0, Vec3::Y), (0.25, 0.5, Vec3::NEG_Z)] {
            assert!((direction_of(Vec2::new(u, v)) - d).length() < 1e-5, "{u} {v}");
        }
        for i in 0..1000 {
            let u = Vec2::new(sobol_burley::sample(i, 0, 7), sobol_burley::sample(i, 1, 7)) * 0.99 + 0.005;
            assert!((uv_of(direction_of(u)) - u).length() < 1e-3, "{u}");
        }
    }

    /// ∫ pdf dω = 1, and the pdf of a sample is the pdf of its direction.
    #[test]
    fn the_density_is_one_in_all() {
        let sky = sky();
        let n = 200_000;
        let mut integral = 0.0_f64;
        for i in 0..n {
            let u = Vec2::new((i as f32 + 0.5) / n as f32, radical_inverse(i));
            integral += f64::from(sky.pdf(sample_sphere(u))) * 4.0 * std::f64::consts::PI / f64::from(n);
        }
        assert!((integral - 1.0).abs() < 0.02, "{integral}");
        for i in 0..200 {
            let (direction, pdf) = sky.sample(Vec2::new(sobol_burley::sample(i, 0, 2), sobol_burley::sample(i, 1, 2)));
            assert!((sky.pdf(direction) / pdf - 1.0).abs() < 0.05, "{i}: {} {pdf}", sky.pdf(direction));
        }
    }

    /// One sample's weight, luminance over density, against the mean of all, which is the integral over the sphere.
    /// Where texels meet, bilinear lookup is at most half of the brighter one while its neighbour's cell holds an
    /// eighth: 4, and 16 in a corner; sin θ changes by less than that.
    #[test]
    fn no_sample_is_far_brighter_than_its_density() {
        let sky = sky();
        let mut largest = 0.0_f32;
        let (mut sum, n) = (0.0_f64, 50_000);
        for i in 0..n {
            let u = Vec2::new((i as f32 + 0.5) / n as f32, radical_inverse(i));
            let (direction, pdf) = sky.sample(u);
            // At the very pole a direction has no density.
            if pdf == 0.0 {
                continue;
            }
            let weight = luminance(sky.radiance(direction)) / pdf;
            (largest, sum) = (largest.max(weight), sum + f64::from(weight));
        }
        let mean = (sum / f64::from(n)) as f32;
        assert!(largest < 20.0 * mean, "{largest} {mean}");
    }

    /// Irradiance from above: Σ E_i cos θ_i of the samples is ∫ L cos θ dω, whatever the sun.
    #[test]
    fn samples_bring_all_of_the_light() {
        let mut sky = sky();
        let n = 400_000;
        let mut truth = Vec3::ZERO;
        for i in 0..n {
            let d = sample_sphere(Vec2::new((i as f32 + 0.5) / n as f32, radical_inverse(i)));
            truth += sky.radiance(d) * d.y.max(0.0) * (4.0 * PI / n as f32);
        }
        let sum: Vec3 = sky
            .arrange(1024)
            .iter()
            .map(|(sample, _)| match sample {
                LightSample::Punctual(Light::Directional { direction, illuminance_lux }) => {
                    *illuminance_lux * (-direction.y).max(0.0)
                }
                other => panic!("{other:?}"),
            })
            .sum();
        assert!(((sum - truth) / truth).abs().max_element() < 0.02, "{sum} {truth}");
    }

    /// Directions against the density, in 8 × 8 cells of equal solid angle with 64 × 64 midpoints each. The sun's texel
    /// alone has most of them.
    #[test]
    fn directions_come_in_proportion_to_the_density() {
        let sky = sky();
        let cell = |d: Vec3| {
            let phi = libm::atan2f(d.z, d.x) / TAU + 0.5;
            ((d.y + 1.0) * 4.0).min(7.0) as usize * 8 + (phi * 8.0).min(7.0) as usize
        };
        let mut expected = [0.0_f64; 64];
        let side = 8 * 64;
        for i in 0..side * side {
            let (y, phi) =
                ((2 * (i / side) + 1) as f32 / side as f32 - 1.0, TAU * ((i % side) as f32 + 0.5) / side as f32);
            let r = (1.0 - y * y).sqrt();
            let d = Vec3::new(-r * libm::cosf(phi), y, -r * libm::sinf(phi));
            expected[cell(d)] += f64::from(sky.pdf(d)) * 4.0 * std::f64::consts::PI / (side * side) as f64;
        }
        let mut cells = [0; 64];
        for i in 0..20_000 {
            let unit = |k: u32| unit_f32(hash(2 * i + k));
            cells[cell(sky.sample(Vec2::new(unit(0), unit(1))).0)] += 1;
        }
        let integral: f64 = expected.iter().sum();
        assert!((integral - 1.0).abs() < 0.01, "{integral}");
        assert_follows(&cells, &expected);
    }
}
