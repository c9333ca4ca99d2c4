//! Path-traced light of some samples of a picture: the truth that a cheaper picture is verified against.

use glam::Vec3;
use rayon::prelude::*;

use super::path::{PathTracer, Radiance};
use crate::film::{Film, Sample};
use crate::progress::Reporter;
use crate::sampling::Sampler;
use crate::{Aovs, RayCounts, RenderOptions, Scene};

/// Shadow rays at each surface of a path, at most: of a thousand lamps few count. A judgement.
const MOST_RAYS: u32 = 16;

/// Pixels per unit of parallel work.
const BLOCK: usize = 8;

/// The light of a pixel, cd/m², summed over some paths of each of its samples.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PathSums {
    pub(super) all: Vec3,
    /// The part that [`Aov::Direct`](crate::Aov::Direct) shows.
    pub(super) direct: Vec3,
    /// The part that reaches diffuse surfaces by way of mirrors and glass.
    pub(super) caustics: Vec3,
}

impl std::ops::AddAssign for PathSums {
    fn add_assign(&mut self, other: Self) {
        self.all += other.all;
        self.direct += other.direct;
        self.caustics += other.caustics;
    }
}

impl std::ops::Mul<f32> for PathSums {
    type Output = Self;

    fn mul(self, factor: f32) -> Self {
        Self { all: self.all * factor, direct: self.direct * factor, caustics: self.caustics * factor }
    }
}

/// Follows `count` paths from each sample of the film's pass, whose pixels are a list. Returns their sums by pixel, in
/// the order of the list, and the rays that they took; paths of other seeds are independent.
pub(super) fn trace_pixels(
    scene: &Scene,
    options: &RenderOptions,
    film: &Film,
    count: u32,
    seed: u64,
    reporter: &Reporter<'_>,
) -> (Vec<PathSums>, RayCounts) {
    // Paths do not fill layers.
    let options = options.clone().with(|o| o.picture.aovs = Aovs::default());
    let samples: Vec<Sample> = film.samples(0..film.sample_count()).collect();
    let pixels: Vec<&[Sample]> = samples.chunk_by(|a, b| a.pixel == b.pixel).collect();

    // Trace blocks of pixels in parallel.
    let trace = |pixels: &[&[Sample]]| {
        let mut tracer = PathTracer::new(scene, &options).with_most_rays(MOST_RAYS);
        let sums: Vec<PathSums> = pixels
            .iter()
            .take_while(|_| !reporter.cancelled())
            .map(|samples| {
                let mut sums = PathSums::default();
                for &sample in *samples {
                    let (ray, cone) = film.ray(sample);
                    for path in 0..count {
                        let mut sampler = Sampler::new(seed, sample.pixel, sample.index * count + path);
                        let Radiance { all, direct, caustics, .. } = tracer.li(ray, cone, sample.pixel, &mut sampler);
                        sums += PathSums { all, direct, caustics };
                    }
                }
                sums
            })
            .collect();
        reporter.add(pixels.iter().map(|samples| samples.len() as u64).sum(), tracer.rays.total());
        (sums, tracer.rays)
    };
    let blocks: Vec<_> = pixels.par_chunks(BLOCK).map(trace).collect();

    // Put them together in order.
    let mut rays = RayCounts::default();
    let mut sums = Vec::with_capacity(pixels.len());
    for (block, block_rays) in blocks {
        sums.extend(block);
        rays += block_rays;
    }
    (sums, rays)
}
