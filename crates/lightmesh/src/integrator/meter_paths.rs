//! Path-traced irradiance at meters, as by Mitsuba's `irradiancemeter`: the truth that meters of the other methods are
//! tested against.
//!
//! A sample is what a sample of a picture finds at a white Lambertian surface: a light sample of every kind, and paths
//! that leave in directions in proportion to the cosine.

use glam::DVec3;
use rayon::prelude::*;

use super::meters::MeterIrradiance;
use super::path::PathTracer;
use crate::progress::Reporter;
use crate::sampling::{Sampler, hash, seed_of_position};
use crate::{Error, Meter, Progress, RayCounts, RenderOptions, RenderStats, Scene, Stage};

/// Samples per unit of parallel work, and samples between two visits to the results.
const BLOCK: u32 = 256;
const WAVE: usize = 1 << 16;

/// Sums over some samples of a meter, and the rays that they took.
#[derive(Default)]
struct SampleSums {
    direct: DVec3,
    indirect: DVec3,
    rays: RayCounts,
}

/// Measures direct and indirect irradiance at every meter, by path tracing.
pub(crate) fn measure_paths(
    scene: &Scene,
    meters: &[Meter],
    options: &RenderOptions,
    progress: &dyn Progress,
) -> Result<(MeterIrradiance, RenderStats), Error> {
    let started = std::time::Instant::now();
    let mut stats = RenderStats::default();
    let spp = options.picture.spp;
    let reporter = Reporter::new(progress, Stage::Measure, meters.len() as u64 * u64::from(spp));
    let empty = || Vec::with_capacity(meters.len());
    let mut measured = MeterIrradiance { direct: empty(), indirect: empty() };
    let blocks_per_meter = spp.div_ceil(BLOCK);
    for wave in meters.chunks((WAVE / spp as usize).max(1)) {
        // Few meters with many samples are as much work for many threads as many with few.
        let blocks: Vec<SampleSums> = (0..wave.len() as u32 * blocks_per_meter)
            .into_par_iter()
            .map(|i| {
                let (meter, first) = (&wave[(i / blocks_per_meter) as usize], i % blocks_per_meter * BLOCK);
                trace(scene, meter, options, first..(first + BLOCK).min(spp), &reporter)
            })
            .collect();
        if reporter.cancelled() {
            return Err(Error::Cancelled);
        }
        for blocks in blocks.chunks(blocks_per_meter as usize) {
            let (mut direct, mut indirect) = (DVec3::ZERO, DVec3::ZERO);
            for block in blocks {
                direct += block.direct;
                indirect += block.indirect;
                stats.rays += block.rays;
            }
            measured.direct.push((direct / f64::from(spp)).as_vec3());
            measured.indirect.push((indirect / f64::from(spp)).as_vec3());
        }
    }
    stats.seconds.shade = started.elapsed().as_secs_f64();
    stats.spp = spp;
    Ok((measured, stats))
}

/// Takes some samples of a meter, until the work is cancelled. Random numbers are seeded by the meter's position and
/// direction.
fn trace(
    scene: &Scene,
    meter: &Meter,
    options: &RenderOptions,
    samples: std::ops::Range<u32>,
    reporter: &Reporter<'_>,
) -> SampleSums {
    let mut sums = SampleSums::default();
    if reporter.cancelled() {
        return sums;
    }
    let point = meter.shading_point(scene, 0);
    let seed = hash(seed_of_position(point.position)) ^ seed_of_position(point.n);
    let mut tracer = PathTracer::new(scene, options);
    let count = u64::from(samples.end - samples.start);
    for sample in samples {
        let e = tracer.irradiance(&point, &mut Sampler::new(options.seed, seed, sample));
        sums.direct += e.direct.as_dvec3();
        sums.indirect += e.indirect.as_dvec3();
    }
    reporter.add(count, tracer.rays.total());
    sums.rays = tracer.rays;
    sums
}
