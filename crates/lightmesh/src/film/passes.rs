//! In which order a picture's samples are taken: all of a pixel's in a row, or in passes over the whole picture.
//!
//! | | sketches | then |
//! |---|---|---|
//! | nobody looks, no time limit | none | all samples, tile by tile |
//! | somebody looks | every 8th and 4th pixel, with 4 samples or more every 2nd | tiles or passes, whichever sums to the same bits: [`SumOrder`] |
//! | time limit | every 8th and 4th pixel if somebody looks | passes, until the time is up |

use super::Film;
use super::clock::RenderClock;
use crate::progress::Reporter;
use crate::{Error, RenderOptions, Stage};

/// What a tracer's sums in the film depend on, in their last bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SumOrder {
    /// On the order of a pixel's own samples alone: passes give the same picture.
    Samples,
    /// On which samples share a wave: only tiles give the same picture.
    Waves,
}

/// Samples that are taken together, at most: all of as many pixels as there is room for. A fixed number: the order in which a pixel's light
/// is summed must not depend on the machine.
pub(crate) const WAVE: u64 = 1 << 16;

/// Pixels from sample to sample of the sketches, the coarsest first.
const SKETCHES: [u32; 3] = [8, 4, 2];

/// What a sketch may cost: one part in so many of the first pass.
const SKETCH_PART: u32 = 16;

/// A pass takes an eighth of the samples that there are, at least one per pixel: where time ends in the middle of it, the
/// first pixels have an eighth more than the last.
const GROWTH: u32 = 8;

/// Takes the samples of the whole picture; `trace` takes those of the film's pass, in waves that `watch` allows.
pub(crate) fn take_samples(
    film: &mut Film,
    options: &RenderOptions,
    sums: SumOrder,
    watch: &mut RenderClock<'_>,
    mut trace: impl FnMut(&mut Film, &mut RenderClock<'_>, &Reporter<'_>) -> Result<(), Error>,
) -> Result<(), Error> {
    let passes = watch.is_limited() || (watch.viewer.is_some() && sums == SumOrder::Samples);
    let first_pass = if passes { 1 } else { options.picture.spp };

    // Something to see, soon.
    if watch.viewer.is_some() {
        for stride in SKETCHES.into_iter().filter(|stride| stride * stride * first_pass >= SKETCH_PART) {
            film.begin_sketch(stride);
            let reporter = Reporter::new(watch.progress, Stage::Sketch, film.sample_count());
            trace(film, watch, &reporter)?;
            film.finish_sketch(stride);
            watch.show(film);
        }
    }

    let reporter = Reporter::new(watch.progress, Stage::Render, film.pixel_count() * u64::from(options.picture.spp));
    let mut taken = 0;
    while taken < options.picture.spp {
        let samples = if taken == 0 { first_pass } else { (taken / GROWTH).max(1) };
        let end = taken + samples.min(options.picture.spp - taken);
        film.begin_pass(taken..end);
        trace(film, watch, &reporter)?;
        taken = film.whole_passes();
        if taken < end {
            break;
        }
    }
    Ok(())
}
