//! The clock of a render: it sizes waves by the time limit, and shows the picture so far to the viewer.

use std::time::{Duration, Instant};

use super::Film;
use crate::{Progress, Viewer};

/// How long a wave may take where there is a time limit, so that the limit is not passed by much.
const WAVE_TIME: Duration = Duration::from_millis(100);

/// Samples per thread of the shortest wave: fewer do not keep the threads busy.
const LEAST_SAMPLES: u64 = 512;

/// Decides how long each wave is, and is told when it is done.
pub(crate) struct RenderClock<'a> {
    pub(crate) progress: &'a dyn Progress,
    pub(super) viewer: Option<&'a dyn Viewer>,
    started: Instant,
    limit: Option<Duration>,
    wave_started: Instant,
    /// Camera samples per second in the last wave, with everything that follows from them; `None` before the first.
    rate: Option<f64>,
}

impl<'a> RenderClock<'a> {
    /// A clock for a render that started at `started` and may take `limit`.
    pub(crate) fn new(
        progress: &'a dyn Progress,
        viewer: Option<&'a dyn Viewer>,
        started: Instant,
        limit: Option<Duration>,
    ) -> Self {
        Self { progress, viewer, started, limit, wave_started: started, rate: None }
    }

    /// Whether there is a time limit.
    pub(super) fn is_limited(&self) -> bool {
        self.limit.is_some()
    }

    /// Returns how many samples of the film's pass the next wave takes; `None` where the pass is done, or the time is
    /// up and every pixel has a sample.
    pub(crate) fn next_wave(&mut self, film: &Film) -> Option<u64> {
        self.wave_started = Instant::now();
        let left = (film.sample_count() - film.done()).min(film.samples_per_wave());
        if left == 0 {
            return None;
        }
        let Some(time) = self.time_left().filter(|_| film.may_end()) else { return Some(left) };
        if time.is_zero() {
            return None;
        }
        // Without a limit the size is fixed: the size of waves decides in which order light is summed.
        let in_time = self.samples_in(time.min(WAVE_TIME));
        Some(left.min(in_time.max(LEAST_SAMPLES * rayon::current_num_threads() as u64)))
    }

    /// Records that all light of the next `samples` samples is on the film, and shows the picture to the viewer.
    pub(crate) fn wave_done(&mut self, film: &mut Film, samples: u64) {
        film.add_done(samples);
        self.rate = Some(samples as f64 / self.wave_started.elapsed().as_secs_f64().max(1e-9));
        self.show(film);
    }

    /// Shows the picture to the viewer, if there is one that wants it now.
    pub(super) fn show(&self, film: &Film) {
        if let Some(viewer) = self.viewer.filter(|viewer| viewer.wants_picture())
            && let Some(picture) = film.picture()
        {
            viewer.show(picture);
        }
    }

    /// Returns how many samples can be taken in the time left, at the rate of the last wave.
    pub(crate) fn samples_left(&self) -> u64 {
        self.time_left().map_or(u64::MAX, |time| self.samples_in(time))
    }

    fn samples_in(&self, time: Duration) -> u64 {
        // The cast saturates.
        self.rate.map_or(u64::MAX, |rate| (rate * time.as_secs_f64()) as u64)
    }

    fn time_left(&self) -> Option<Duration> {
        self.limit.map(|limit| limit.saturating_sub(self.started.elapsed()))
    }
}
