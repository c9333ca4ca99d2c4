//! Meters: irradiance at points that no camera ray has found, lit in waves by the code that lights a picture's hits.
//!
//! What a meter reads depends on its own position and direction alone, not on the meters beside it: neither the size
//! of waves nor that of blocks shows.

use glam::Vec3;

use super::block::BLOCK;
use super::lighting::{Lighting, LightingContext};
use super::point_block::PointBlock;
use super::wave::{BLOCKS_PER_WAVE, RAYS};
use crate::direct::{Indirect, LightingPlan, Shading};
use crate::progress::Reporter;
use crate::{Error, Meter, Progress, RenderOptions, RenderStats, Scene, Stage};

/// Irradiance by meter, lux.
pub(crate) struct MeterIrradiance {
    pub(crate) direct: Vec<Vec3>,
    pub(crate) indirect: Vec<Vec3>,
}

/// Measures direct and indirect irradiance at every meter, by exact or mesh light.
pub(crate) fn measure_waves(
    scene: &Scene,
    meters: &[Meter],
    options: &RenderOptions,
    mut lighting: Lighting<'_>,
    progress: &dyn Progress,
) -> Result<(MeterIrradiance, RenderStats), Error> {
    let mut stats = RenderStats::default();
    let reporter = Reporter::new(progress, Stage::Measure, meters.len() as u64);
    // Where no mesh reaches, light is exact, except for what gather rays read where they end.
    let plan = LightingPlan::of_meters(options);
    let plan_outside = match plan.indirect {
        Indirect::None | Indirect::Mesh { .. } => LightingPlan {
            primary: Shading::Exact,
            indirect: Indirect::FinalGather { rays: LightingPlan::gather_rays(1), seed: 0 },
            ..plan
        },
        Indirect::FinalGather { .. } | Indirect::Unbiased { .. } => LightingPlan { primary: Shading::Exact, ..plan },
    };
    let mut blocks: Vec<PointBlock> = (0..BLOCKS_PER_WAVE).map(|_| PointBlock::default()).collect();
    let zeros = || vec![Vec3::ZERO; meters.len()];
    let mut measured = MeterIrradiance { direct: zeros(), indirect: zeros() };
    for (wave, first) in meters.chunks(RAYS).zip((0..).step_by(RAYS)) {
        // Part the meters that the mesh reaches from the others.
        let is_inside = |&i: &usize| match &lighting {
            Lighting::Exact => true,
            Lighting::Mesh { mesh, .. } => mesh.covers(scene, meters[i].position),
        };
        let (inside, outside): (Vec<usize>, Vec<usize>) = (first..first + wave.len()).partition(is_inside);
        for (indices, plan) in [(inside, plan), (outside, plan_outside)] {
            if indices.is_empty() {
                continue;
            }
            // Light them together.
            let used = take_meters(scene, meters, &indices, &mut blocks);
            let mut used: Vec<&mut PointBlock> = blocks[..used].iter_mut().collect();
            lighting.shade(LightingContext { scene, options, plan, reporter: &reporter }, &mut used, &mut stats)?;

            // Put their irradiance in its place.
            let mut indices = indices.into_iter();
            for block in used {
                for (shaded, i) in block.shaded_points().zip(&mut indices) {
                    (measured.direct[i], measured.indirect[i]) = (shaded.direct, shaded.indirect);
                }
                block.take_counts(&mut stats);
            }
        }
    }
    Ok((measured, stats))
}

/// Spreads some meters over as many blocks as possible. Returns how many blocks it used.
fn take_meters(scene: &Scene, meters: &[Meter], indices: &[usize], blocks: &mut [PointBlock]) -> usize {
    let together = indices.len().div_ceil(blocks.len()).min(BLOCK);
    for (block, indices) in blocks.iter_mut().zip(indices.chunks(together)) {
        block.clear();
        block.batch.vertices.extend(indices.iter().map(|&i| meters[i].shading_point(scene, i as u32)));
        block.completes = indices.len() as u64;
    }
    indices.len().div_ceil(together)
}
