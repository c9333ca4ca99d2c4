//! Waves of a picture, some of them at a time: planned, requested and drawn as in one go.

use crate::direct::LightingPlan;
use crate::film::{Film, RenderClock};
use crate::integrator::{Lighting, WaveFrame, WaveSink, adapt, trace_pass};
use crate::light_mesh::{LightMarks, LightMesh};
use crate::progress::Reporter;
use crate::{Error, RenderOptions, RenderStats, Scene, Stage};

/// How the waves of a picture are drawn.
pub(super) enum WaveMethod<'a> {
    /// By path tracing.
    Paths,
    /// Lit as the plan says.
    Lit { lighting: Lighting<'a>, plan: LightingPlan },
}

/// Adapts the lighting to the whole picture. Returns the plan for its waves, and what finding it took.
pub(super) fn plan_waves(
    scene: &Scene,
    film: &Film,
    options: &RenderOptions,
    lighting: Lighting<'_>,
    clock: &mut RenderClock<'_>,
) -> Result<(LightingPlan, RenderStats), Error> {
    let mut stats = RenderStats::default();
    let plan = adapt(&mut WaveFrame::new(scene, options, lighting), film, clock, &mut stats)?;
    Ok((plan, stats))
}

/// Takes the samples of the waves to which the film's pass is restricted.
pub(super) fn draw_waves(
    scene: &Scene,
    film: &mut Film,
    options: &RenderOptions,
    method: WaveMethod<'_>,
    clock: &mut RenderClock<'_>,
) -> Result<RenderStats, Error> {
    let mut stats = RenderStats::default();
    let reporter = Reporter::new(clock.progress, Stage::Render, film.sample_count() - film.done());
    match method {
        WaveMethod::Paths => trace_pass(scene, options, film, clock, &reporter, &mut stats)?,
        WaveMethod::Lit { lighting, plan } => {
            let mut frame = WaveFrame::new(scene, options, lighting);
            frame.draw(film, plan, WaveSink::Film, clock, &reporter, &mut stats)?;
        }
    }
    Ok(stats)
}

/// Marks the mesh points that the same samples read and that are empty.
pub(super) fn request_waves(
    scene: &Scene,
    film: &mut Film,
    options: &RenderOptions,
    mesh: &mut LightMesh,
    plan: LightingPlan,
    clock: &mut RenderClock<'_>,
) -> Result<LightMarks, Error> {
    let reporter = Reporter::new(clock.progress, Stage::Demand, film.sample_count() - film.done());
    let marks = mesh.marks();
    let mut frame = WaveFrame::new(scene, options, Lighting::from_mesh(mesh));
    frame.draw(film, plan, WaveSink::Requests(&marks), clock, &reporter, &mut RenderStats::default())?;
    Ok(marks)
}
