//! Some pixels of a picture, lit as they would be in it, to find out how good its light is.

use crate::direct::LightingPlan;
use crate::film::{Film, RenderClock};
use crate::integrator::point_block::ShadedPoint;
use crate::integrator::wave::{WaveFrame, WaveSink};
use crate::progress::Reporter;
use crate::{Error, RenderStats, Stage};

/// A frame that lights pixels of a picture which is still to be drawn.
pub(super) struct Pilot<'a, 'f, 'c> {
    pub(super) frame: &'a mut WaveFrame<'f>,
    /// The picture's film; it stays empty.
    pub(super) film: &'a Film,
    pub(super) clock: &'a mut RenderClock<'c>,
    pub(super) stats: &'a mut RenderStats,
}

impl Pilot<'_, '_, '_> {
    /// Lights the first `spp` samples of some pixels as the plan says. Returns a film of them.
    pub(super) fn light_pixels(&mut self, pixels: &[u32], spp: u32, plan: LightingPlan) -> Result<Film, Error> {
        self.draw(pixels, spp, plan, WaveSink::Film)
    }

    /// Lights the first sample of some pixels as the plan says. Returns the surface points that they meet.
    pub(super) fn light_points(&mut self, pixels: &[u32], plan: LightingPlan) -> Result<Vec<ShadedPoint>, Error> {
        let mut points = Vec::new();
        self.draw(pixels, 1, plan, WaveSink::ShadedPoints(&mut points))?;
        Ok(points)
    }

    fn draw(&mut self, pixels: &[u32], spp: u32, plan: LightingPlan, sink: WaveSink<'_>) -> Result<Film, Error> {
        let mut film = self.film.of_pixels(pixels.to_vec(), spp);
        let reporter = Reporter::new(self.clock.progress, Stage::Check, film.sample_count());
        self.frame.draw(&mut film, plan, sink, self.clock, &reporter, self.stats)?;
        Ok(film)
    }
}
