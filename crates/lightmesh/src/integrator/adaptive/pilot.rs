//! Some pixels of a picture, lit as they would be in it, to find out how good its light is.

use super::super::wave::WaveFrame;
use crate::direct::LightingPlan;
use crate::film::{Film, RenderClock};
use crate::progress::Reporter;
use crate::{Error, RenderStats, Stage};

/// Lights the first `spp` samples of some pixels by a plan; the film that they are on.
pub(super) fn light_pixels(
    frame: &mut WaveFrame<'_>,
    film: &Film,
    (pixels, spp): (&[u32], u32),
    plan: LightingPlan,
    watch: &mut RenderClock<'_>,
    stats: &mut RenderStats,
) -> Result<Film, Error> {
    let mut film = film.of_pixels(pixels.to_vec(), spp);
    let reporter = Reporter::new(watch.progress, Stage::Check, film.sample_count());
    let before = std::mem::replace(&mut frame.plan, plan);
    let lit = frame.render_pass(&mut film, watch, &reporter, stats);
    frame.plan = before;
    lit.map(|()| film)
}
