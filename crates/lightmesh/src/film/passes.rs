//! In which order a picture's samples are taken: all of a pixel's in a row, or in passes over the whole picture.
//!
//! | | coarse previews | then |
//! |---|---|---|
//! | no viewer, no time limit | none | all samples, tile by tile |
//! | samples that follow the noise | as without | half of the samples, the other half, then more of some pixels |
//! | a viewer | every 8th and 4th pixel, with 4 samples or more every 2nd | tiles or passes, whichever sums to the same bits: [`SumOrder`] |
//! | time limit | every 8th and 4th pixel if there is a viewer | passes, until the time is up |

use super::Film;
use super::clock::RenderClock;
use crate::progress::Reporter;
use crate::{Error, RenderOptions, Stage};

/// What the last bits of a tracer's sums on the film depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SumOrder {
    /// On the order of a pixel's own samples alone: passes give the same picture.
    Samples,
    /// On which samples share a wave: only tiles give the same picture.
    Waves,
}

/// The most samples of a wave, which has all samples of as many pixels as fit in. A fixed number: the order in which a
/// pixel's light is summed must not depend on the machine.
pub(crate) const WAVE: u64 = 1 << 16;

/// Distances between the samples of the coarse previews in pixels, the coarsest first.
const PREVIEW_STRIDES: [u32; 3] = [8, 4, 2];

/// A coarse preview may cost one part in so many of the first pass.
const PREVIEW_PART: u32 = 16;

/// A pass takes an eighth of the samples that there are, at least one per pixel: where time ends in the middle of it,
/// the first pixels have an eighth more than the last.
const GROWTH: u32 = 8;

/// How many times as many samples a pixel has after a round of more: as many again are strata of their own.
const ROUND: u32 = 4;

/// Takes all samples of the picture. `trace` takes those of the film's pass, in waves as long as `clock` allows.
pub(crate) fn take_samples(
    film: &mut Film,
    options: &RenderOptions,
    sums: SumOrder,
    clock: &mut RenderClock<'_>,
    mut trace: impl FnMut(&mut Film, &mut RenderClock<'_>, &Reporter<'_>) -> Result<(), Error>,
) -> Result<(), Error> {
    let passes = clock.is_limited() || (clock.viewer.is_some() && sums == SumOrder::Samples);
    let spp = options.picture.spp;
    let first_pass = match (passes, options.most_spp()) {
        (true, _) => 1,
        (false, Some(_)) => first_part(spp),
        (false, None) => spp,
    };

    // Show coarse previews first.
    if clock.viewer.is_some() {
        for stride in PREVIEW_STRIDES.into_iter().filter(|stride| stride * stride * first_pass >= PREVIEW_PART) {
            film.begin_coarse_preview(stride);
            let reporter = Reporter::new(clock.progress, Stage::CoarsePreview, film.sample_count());
            trace(film, clock, &reporter)?;
            film.finish_coarse_preview(stride);
            clock.show(film);
        }
    }

    // Take the samples, in one pass or in passes that grow.
    let reporter = Reporter::new(clock.progress, Stage::Render, film.pixel_count() * u64::from(spp));
    let mut taken = 0;
    while taken < spp {
        let samples = match (taken, passes) {
            (0, _) => first_pass,
            (_, true) => (taken / GROWTH).max(1),
            (_, false) => spp,
        };
        let end = taken + samples.min(spp - taken);
        film.begin_pass(taken..end);
        trace(film, clock, &reporter)?;
        taken = film.whole_passes();
        if taken < end {
            break;
        }
        if !passes && taken < spp {
            film.keep_first_part();
        }
    }
    Ok(())
}

/// How many of so many samples are taken first, to compare the rest with them.
fn first_part(spp: u32) -> u32 {
    spp.div_ceil(2)
}

/// How good the samples of a picture are to be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NoiseBound {
    /// The most that a pixel gets.
    pub(crate) most_spp: u32,
    /// The error by noise, relative to the picture's mean, below which no more are taken.
    pub(crate) error: f64,
    /// How many may be taken in all beside those that every pixel has.
    pub(crate) most: u64,
}

/// Takes more samples of the pixels with most noise, up to four times as many in each round, until the picture's error by
/// noise is within the bound. Returns it. Half of the first samples must have been kept.
pub(crate) fn take_more_samples(
    film: &mut Film,
    bound: NoiseBound,
    clock: &mut RenderClock<'_>,
    mut trace: impl FnMut(&mut Film, &mut RenderClock<'_>, &Reporter<'_>) -> Result<(), Error>,
) -> Result<f64, Error> {
    let NoiseBound { most_spp, error: enough, mut most } = bound;
    let mut count = film.whole_passes();
    let mut error = film.find_noise(first_part(count));
    while count < most_spp {
        let samples = count.saturating_mul(ROUND).min(most_spp);
        if error <= enough || !film.begin_resampling(count, samples, enough, most) {
            break;
        }
        let reporter = Reporter::new(clock.progress, Stage::Resample, film.sample_count());
        most -= film.sample_count();
        trace(film, clock, &reporter)?;
        (error, count) = (film.end_resampling(), samples);
    }
    Ok(error)
}
