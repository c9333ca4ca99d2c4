//! Meters: irradiance at places that no camera looks at, wave by wave as a picture's hits get it.
//!
//! A meter is a vertex that no ray has led to: what follows is the code that lights a picture. What it gets depends on its own place
//! alone, not on the meters beside it, so neither the size of waves nor that of blocks shows.

use glam::Vec3;

use super::block::{BLOCK, RayBlock};
use super::wave::{BLOCKS_PER_WAVE, Lighting, RAYS, light};
use crate::direct::{Indirect, LightingPlan, Shading};
use crate::progress::Reporter;
use crate::{Error, Meter, Progress, RenderOptions, RenderStats, Scene, Stage};

/// Direct and indirect irradiance of every meter, lux, from exact or mesh light.
pub(crate) fn measure_waves(
    scene: &Scene,
    meters: &[Meter],
    options: &RenderOptions,
    mut lighting: Lighting<'_>,
    progress: &dyn Progress,
) -> Result<([Vec<Vec3>; 2], RenderStats), Error> {
    let mut stats = RenderStats::default();
    let reporter = Reporter::new(progress, Stage::Measure, meters.len() as u64);
    let mut marks = match &lighting {
        Lighting::Exact => None,
        Lighting::Mesh(mesh) => Some(mesh.marks()),
    };
    // Where no mesh reaches, light is exact, but for what gather rays read where they end.
    let plan = LightingPlan::of(options);
    let outside = match plan.indirect {
        Indirect::Mesh => LightingPlan { primary: Shading::Exact, indirect: Indirect::FinalGather { seed: 0 }, ..plan },
        Indirect::FinalGather { .. } | Indirect::Unbiased { .. } => LightingPlan { primary: Shading::Exact, ..plan },
    };
    let mut blocks: Vec<RayBlock> = (0..BLOCKS_PER_WAVE).map(|_| RayBlock::default()).collect();
    let [mut direct, mut indirect] = [(); 2].map(|()| vec![Vec3::ZERO; meters.len()]);
    for (wave, first) in meters.chunks(RAYS).zip((0..).step_by(RAYS)) {
        let is_inside = |&i: &usize| match &lighting {
            Lighting::Exact => true,
            Lighting::Mesh(mesh) => mesh.reaches(scene, meters[i].position),
        };
        let (inside, beyond): (Vec<usize>, Vec<usize>) = (first..first + wave.len()).partition(is_inside);
        for (indices, plan) in [(inside, plan), (beyond, outside)] {
            if indices.is_empty() {
                continue;
            }
            let used = take_meters(scene, meters, &indices, &mut blocks);
            let blocks = &mut blocks[..used];
            light((scene, options, plan), blocks, &mut lighting, marks.as_mut(), &reporter, &mut stats)?;
            let mut indices = indices.into_iter();
            for block in blocks {
                let given = block.indirect.iter().copied().chain(std::iter::repeat(Vec3::ZERO));
                for ((&e, further), i) in block.lit.direct.iter().zip(given).zip(&mut indices) {
                    (direct[i], indirect[i]) = (e, further);
                }
                block.lit.take_counts(&mut stats);
                stats.rays.secondary += std::mem::take(&mut block.visibility_rays);
            }
        }
    }
    Ok(([direct, indirect], stats))
}

/// Spreads some meters over as many blocks as there may be; how many these are.
fn take_meters(scene: &Scene, meters: &[Meter], indices: &[usize], blocks: &mut [RayBlock]) -> usize {
    let together = indices.len().div_ceil(blocks.len()).min(BLOCK);
    for (block, indices) in blocks.iter_mut().zip(indices.chunks(together)) {
        block.lit.vertices.clear();
        block.lit.vertices.extend(indices.iter().map(|&i| meters[i].shading_point(scene)));
        block.indirect.clear();
    }
    indices.len().div_ceil(together)
}
