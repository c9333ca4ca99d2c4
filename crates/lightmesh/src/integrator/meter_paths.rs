//! Path-traced irradiance at meters: the truth that meters of the other methods are tested against. Mitsuba's `irradiancemeter` is the model.
//!
//! A sample is what a sample of a picture finds at a white Lambertian surface: a light sample of every kind, and paths that leave in
//! directions in proportion to the cosine.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::path::PathTracer;
use crate::progress::Reporter;
use crate::sampling::{Sampler, hash, seed_of_position};
use crate::{Error, Meter, Progress, RayCounts, RenderOptions, RenderStats, Scene, Stage};

/// Samples per unit of parallel work, and samples between two visits to the results.
const BLOCK: u32 = 256;
const WAVE: usize = 1 << 16;

/// Sums over some samples of a meter, direct and indirect, and the rays that they took.
type Sums = ([DVec3; 2], RayCounts);

/// Direct and indirect irradiance of every meter, lux.
pub(crate) fn measure_paths(
    scene: &Scene,
    meters: &[Meter],
    options: &RenderOptions,
    progress: &dyn Progress,
) -> Result<([Vec<Vec3>; 2], RenderStats), Error> {
    let started = std::time::Instant::now();
    let mut stats = RenderStats::default();
    let spp = options.picture.spp;
    let reporter = Reporter::new(progress, Stage::Measure, meters.len() as u64 * u64::from(spp));
    let [mut direct, mut indirect] = [(); 2].map(|()| Vec::with_capacity(meters.len()));
    let blocks_per_meter = spp.div_ceil(BLOCK);
    for wave in meters.chunks((WAVE / spp as usize).max(1)) {
        // Few meters with many samples are as much work for many threads as many with few.
        let blocks: Vec<Sums> = (0..wave.len() as u32 * blocks_per_meter)
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
            let mut sums = [DVec3::ZERO; 2];
            for (part, rays) in blocks {
                sums = [sums[0] + part[0], sums[1] + part[1]];
                stats.rays += *rays;
            }
            let [e, further] = sums.map(|sum| (sum / f64::from(spp)).as_vec3());
            direct.push(e);
            indirect.push(further);
        }
    }
    stats.seconds.shade = started.elapsed().as_secs_f64();
    stats.spp = spp;
    Ok(([direct, indirect], stats))
}

/// Takes some samples of a meter, until the work is cancelled. Its numbers are seeded by its own place and direction.
fn trace(
    scene: &Scene,
    meter: &Meter,
    options: &RenderOptions,
    samples: std::ops::Range<u32>,
    reporter: &Reporter<'_>,
) -> Sums {
    if reporter.cancelled() {
        return Sums::default();
    }
    let vertex = meter.shading_point(scene);
    let seed = hash(seed_of_position(vertex.position)) ^ seed_of_position(vertex.n);
    let mut tracer = PathTracer::new(scene, options);
    let mut sums = [DVec3::ZERO; 2];
    let count = u64::from(samples.end - samples.start);
    for sample in samples {
        let e = tracer.irradiance(&vertex, &mut Sampler::new(options.seed, seed, sample));
        sums = [sums[0] + e.direct.as_dvec3(), sums[1] + e.indirect.as_dvec3()];
    }
    reporter.add(count, tracer.rays.total());
    (sums, tracer.rays)
}
