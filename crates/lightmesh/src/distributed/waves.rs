//! A picture's light by portions: the same waves as in one go, some of them at a time.

use crate::direct::LightingPlan;
use crate::film::{Film, RenderClock};
use crate::integrator::{Lighting, Purpose, WaveFrame, trace_pass};
use crate::light_mesh::{LightMarks, LightMesh};
use crate::progress::Reporter;
use crate::{Error, RenderOptions, RenderStats, Scene, Stage};

/// How surfaces take their light, where the whole picture has been looked at; what that took.
pub(crate) fn plan_waves(
    scene: &Scene,
    film: &Film,
    options: &RenderOptions,
    lighting: Lighting<'_>,
    watch: &mut RenderClock<'_>,
) -> Result<(LightingPlan, RenderStats), Error> {
    let mut frame = WaveFrame::new(scene, options, lighting);
    let mut stats = RenderStats::default();
    frame.prepare(film, watch, &mut stats)?;
    Ok((frame.plan, stats))
}

/// Takes the samples of the film's portion; `None`: by path tracing.
pub(crate) fn render_portion_on(
    scene: &Scene,
    film: &mut Film,
    options: &RenderOptions,
    lighting: Option<(Lighting<'_>, LightingPlan)>,
    watch: &mut RenderClock<'_>,
) -> Result<RenderStats, Error> {
    let mut stats = RenderStats::default();
    let reporter = Reporter::new(watch.progress, Stage::Render, film.sample_count() - film.done());
    match lighting {
        None => trace_pass(scene, options, film, watch, &reporter, &mut stats)?,
        Some((lighting, plan)) => {
            let mut frame = WaveFrame::new(scene, options, lighting);
            frame.plan = plan;
            frame.render_pass(film, watch, &reporter, &mut stats)?;
        }
    }
    Ok(stats)
}

/// Marks the mesh points that the samples of the film's portion read and that are empty.
pub(crate) fn demand_of_portion(
    scene: &Scene,
    film: &mut Film,
    options: &RenderOptions,
    (mesh, plan): (&mut LightMesh, LightingPlan),
    watch: &mut RenderClock<'_>,
) -> Result<Option<LightMarks>, Error> {
    let reporter = Reporter::new(watch.progress, Stage::Demand, film.sample_count() - film.done());
    let mut frame = WaveFrame::new(scene, options, Lighting::Mesh(mesh));
    (frame.plan, frame.purpose) = (plan, Purpose::Demand);
    frame.render_pass(film, watch, &reporter, &mut RenderStats::default())?;
    Ok(frame.marks)
}
