//! What bounces after the last one would add to a picture: as if the ratio of the last two went on for ever.
//!
//! It is measured in the picture: in a room with a sun outside, most mesh points may be in the sunshine.

use crate::direct::LightingPlan;
use crate::film::{Film, RenderClock};
use crate::indirect::{IndirectReading, further_bounces};
use crate::integrator::lighting::Lighting;
use crate::integrator::wave::{WaveFrame, WaveSink};
use crate::mesh::{CornerVisibility, Marks};
use crate::progress::Reporter;
use crate::{Error, RenderStats, Stage};

/// Pixels that are looked at, at most. A judgement.
const PIXELS: u64 = 512;

/// Returns the estimate as a part of all light in the picture, with what is left out, after the picture has been drawn;
/// `None` where nothing can be said.
pub(crate) fn truncated_light(
    frame: &mut WaveFrame<'_>,
    film: &Film,
    plan: LightingPlan,
    clock: &mut RenderClock<'_>,
) -> Result<Option<f64>, Error> {
    let bounces = frame.options.transport.bounces;
    if bounces == 0 || !frame.lighting.has_indirect() {
        return Ok(None);
    }
    // Look at some pixels once more.
    let mut points = Vec::new();
    let mut pixels = film.of_pixels(film.draw(frame.options.seed, 7, PIXELS), 1);
    let reporter = Reporter::new(&(), Stage::Check, pixels.sample_count());
    let sink = WaveSink::ShadedPoints(&mut points);
    frame.draw(&mut pixels, plan, sink, clock, &reporter, &mut RenderStats::default())?;

    // Sum what arrives there after N, N − 1 and N − 2 bounces.
    let (scene, marks) = (frame.scene, Marks::default());
    let Lighting::Mesh { mesh, .. } = &frame.lighting else { return Ok(None) };
    let Some(field) = &mesh.indirect else { return Ok(None) };
    let after = |k: u32| field.reader(scene, k, CornerVisibility::All);
    let mut readers = [after(bounces), after(bounces - 1), after(bounces.saturating_sub(2))];
    let (mut sums, mut all) = ([0.0; 3], 0.0);
    for shaded in &points {
        let weighted = |light: glam::Vec3| f64::from((shaded.point.weight * light).element_sum());
        let readings = readers.each_mut().map(|reader| match reader.read(&shaded.point, &marks) {
            IndirectReading::Irradiance(irradiance) => Some(weighted(irradiance)),
            IndirectReading::Unavailable | IndirectReading::Pending => None,
        });
        let [Some(last), Some(before), Some(first)] = readings else { continue };
        // After one bounce there is none before the last but direct light.
        let direct = weighted(shaded.direct);
        let first = if bounces == 1 { -direct } else { first };
        sums = [sums[0] + last, sums[1] + before, sums[2] + first];
        all += direct + last;
    }

    // Let the ratio go on.
    let [last, before, first] = sums;
    Ok(if all > 0.0 { further_bounces(all, last - before, before - first) } else { None })
}
