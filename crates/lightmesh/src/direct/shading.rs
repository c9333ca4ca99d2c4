//! Surface points that want light, and the direct light that they get: from exact shadow rays or from the direct mesh.

use std::time::Instant;

use fearless_simd::{Simd, dispatch};
use glam::Vec3;
use rayon::prelude::*;

use super::exact::Scratch;
use super::field::DirectField;
use super::per_light::{PerLightShader, Shaded};
use super::plan::{LightingPlan, Shading};
use super::read::{DirectReader, Reading};
use super::read_lights::LightsReading;
use crate::interaction::ShadingPoint;
use crate::light::{LightCut, LightSamples};
use crate::mesh::{CornerVisibility, Marks};
use crate::progress::Reporter;
use crate::sampling::seed_of_position;
use crate::{Error, Falloff, RenderOptions, RenderStats, Scene};

/// Shadow rays of unbiased light to clusters, at least, from a surface that no mesh point knows about. Empirical, not varied: few are.
const FALLBACK_RAYS: u32 = 64;

/// A list of vertices and their direct irradiance; buffers are kept from use to use.
#[derive(Debug, Default)]
pub(crate) struct ShadingBatch {
    pub vertices: Vec<ShadingPoint>,
    /// Direct irradiance of each vertex, lux.
    pub direct: Vec<Vec3>,
    /// Vertices that the mesh has not answered yet.
    waiting: Vec<u32>,
    scratch: Scratch,
    per_light: PerLightShader,
    shadow_rays: u64,
    visibility_rays: u64,
    fallbacks: u64,
}

impl ShadingBatch {
    /// A shadow ray to each of the light samples from every vertex.
    pub(crate) fn shade_exactly(&mut self, scene: &Scene, lights: &LightSamples, falloff: Falloff) {
        self.direct.clear();
        let lights = LightCut::all(lights);
        for vertex in &self.vertices {
            let (irradiance, rays) = self.scratch.irradiance(scene, &lights, falloff, vertex);
            self.direct.push(irradiance);
            self.shadow_rays += rays;
        }
        self.waiting.clear();
    }

    /// Computes Σ of formula (2), without visibility, over every light, for every vertex; those that face any light wait to be shaded.
    fn sum_unshadowed(&mut self, scene: &Scene, falloff: Falloff) {
        let vertices = self.vertices.iter().map(|vertex| (vertex.position, vertex.n));
        scene.lights().irradiance(scene.simd_level(), falloff, vertices, &mut self.direct);
        self.await_lit();
    }

    /// Takes the same sums.
    fn take_unshadowed(&mut self, sums: &[Vec3]) {
        self.direct.clear();
        self.direct.extend_from_slice(sums);
        self.await_lit();
    }

    fn await_lit(&mut self) {
        self.waiting.clear();
        let lit = |&i: &u32| self.direct[i as usize] != Vec3::ZERO;
        self.waiting.extend((0..self.vertices.len() as u32).filter(lit));
    }

    /// Lets every vertex wait to be shaded.
    fn await_all(&mut self) {
        self.direct.clear();
        self.direct.resize(self.vertices.len(), Vec3::ZERO);
        self.waiting.clear();
        self.waiting.extend(0..self.vertices.len() as u32);
    }

    /// Formula (2) times formula (3g) for the vertices that wait; those whose mesh points are empty mark them and go on
    /// waiting.
    fn shade_by_mesh(
        &mut self,
        scene: &Scene,
        falloff: Falloff,
        field: &DirectField,
        marks: &Marks,
        sight: CornerVisibility,
    ) {
        let mut reader = field.reader(scene, sight);
        let mut lights = field.lights().at(scene);
        let Self { waiting, vertices, direct, scratch, shadow_rays, fallbacks, .. } = self;
        waiting.retain(|&i| {
            let (vertex, irradiance) = (&vertices[i as usize], &mut direct[i as usize]);
            match reader.read(vertex, marks) {
                Reading::Visibility(visibility) => *irradiance *= visibility,
                Reading::Unavailable => {
                    lights.set_receiver(vertex.position, falloff);
                    let (exact, rays) = scratch.irradiance(scene, &lights, falloff, vertex);
                    *irradiance = exact;
                    *shadow_rays += rays;
                    *fallbacks += 1;
                }
                Reading::Pending => return true,
            }
            false
        });
        self.visibility_rays += reader.visibility_rays();
    }

    /// The same, light by light.
    fn shade_per_light(
        &mut self,
        scene: &Scene,
        falloff: Falloff,
        field: &DirectField,
        marks: &Marks,
        (shading, sight): (Shading, CornerVisibility),
    ) {
        let sight = match (shading, sight) {
            (Shading::PerLight { .. }, CornerVisibility::All) => CornerVisibility::Deferred { finer: true },
            (_, CornerVisibility::Stochastic) => CornerVisibility::Deferred { finer: false },
            _ => sight,
        };
        let reader = field.reader(scene, sight);
        dispatch!(scene.simd_level(), simd => self.shade_per_light_simd(simd, scene, falloff, (field, reader, marks), shading));
    }

    #[inline(always)]
    fn shade_per_light_simd<S: Simd>(
        &mut self,
        simd: S,
        scene: &Scene,
        falloff: Falloff,
        (field, mut reader, marks): (&DirectField, DirectReader<'_>, &Marks),
        shading: Shading,
    ) {
        let clusters = field.lights().has_clusters();
        let (every, mut lights) = (LightCut::all(scene.lights()), field.lights().at(scene));
        let Self { waiting, vertices, direct, scratch, per_light: by_light, shadow_rays, fallbacks, .. } = self;
        if clusters {
            // Neighbours share what is known of a region.
            waiting.sort_by_cached_key(|&i| (field.lights().region(vertices[i as usize].position), i));
        }
        let mut kept = 0;
        for at in 0..waiting.len() {
            let surface = waiting[at];
            let vertex = &vertices[surface as usize];
            let reading = reader.read_lights(vertex, marks);
            if reading == LightsReading::Pending {
                waiting[kept] = surface;
                kept += 1;
                continue;
            }
            let lit = |seed| Shaded {
                scene,
                falloff,
                vertex,
                surface,
                lights: reader.lights(),
                seed: seed ^ seed_of_position(vertex.position),
                origins: vertex.origins(),
            };
            direct[surface as usize] = match (reading, shading) {
                (LightsReading::Known, Shading::PerLight { care, seed }) => {
                    by_light.sample_by_policy(simd, &lit(seed), care)
                }
                // More rays than lights: each gets its own.
                (LightsReading::Known, Shading::Unbiased { rays, seed }) if (rays as usize) < scene.lights().len() => {
                    by_light.unbiased(simd, &lit(seed), rays)
                }
                // Clusters, each as one light, would not be the truth.
                (LightsReading::Unknown, Shading::Unbiased { rays, seed })
                    if (rays as usize) < scene.lights().len() =>
                {
                    *fallbacks += 1;
                    by_light.unbiased(simd, &lit(seed), rays.max(FALLBACK_RAYS))
                }
                (reading, _) => {
                    *fallbacks += u64::from(reading != LightsReading::Known);
                    let by_cut = clusters && matches!(shading, Shading::PerLight { .. });
                    if by_cut {
                        lights.set_receiver(vertex.position, falloff);
                    }
                    let seen = if by_cut { &lights } else { &every };
                    let (exact, rays) = scratch.irradiance(scene, seen, falloff, vertex);
                    *shadow_rays += rays;
                    exact
                }
            };
            if by_light.is_full() {
                *shadow_rays += by_light.shoot(scene, direct);
            }
        }
        waiting.truncate(kept);
        *shadow_rays += by_light.shoot(scene, direct);
        self.visibility_rays += reader.visibility_rays();
    }

    /// Rays since the last call of [`ShadingBatch::take_counts`].
    pub(crate) fn rays(&self) -> u64 {
        self.shadow_rays + self.visibility_rays
    }

    /// Moves the counts of rays and fallbacks into the frame's.
    pub(crate) fn take_counts(&mut self, stats: &mut RenderStats) {
        stats.rays.shadow += std::mem::take(&mut self.shadow_rays);
        stats.rays.secondary += std::mem::take(&mut self.visibility_rays);
        stats.exact_fallbacks += std::mem::take(&mut self.fallbacks);
    }
}

/// The direct mesh and what lighting by it takes.
pub(crate) struct DirectLighting<'a, 'b> {
    pub scene: &'a Scene,
    pub options: &'a RenderOptions,
    pub plan: LightingPlan,
    pub field: &'a mut DirectField,
    pub marks: &'a mut Marks,
    pub reporter: &'a Reporter<'b>,
    pub stats: &'a mut RenderStats,
}

impl DirectLighting<'_, '_> {
    /// Direct light at every vertex of the lists, from the mesh, which is filled as far as they ask for it. Rays of the fill
    /// are added to the frame's; those of the rest stay with the lists.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] before anything is allocated, [`Error::Cancelled`].
    pub(crate) fn light(
        &mut self,
        sight: CornerVisibility,
        lists: &mut [&mut ShadingBatch],
    ) -> Result<LightSeconds, Error> {
        let (scene, falloff) = (self.scene, self.options.transport.falloff);
        let shading = self.plan.shading(sight);
        let started = Instant::now();
        let mut seconds = LightSeconds::default();
        match shading {
            Shading::Exact => lists.par_iter_mut().for_each(|list| list.shade_exactly(scene, scene.lights(), falloff)),
            Shading::PerLight { .. } | Shading::Unbiased { .. } => {
                if self.field.lights().has_clusters() {
                    let vertices = lists.iter().flat_map(|list| &list.vertices).map(|v| (v.position, v.n));
                    self.field.lights_mut().prepare(falloff, &vertices.collect::<Vec<_>>());
                }
                lists.iter_mut().for_each(|list| list.await_all());
            }
            Shading::MeanVisibility if !self.field.lights().has_clusters() => {
                lists.par_iter_mut().for_each(|list| list.sum_unshadowed(scene, falloff));
            }
            Shading::MeanVisibility => {
                let vertices = lists.iter().flat_map(|list| &list.vertices).map(|v| (v.position, v.n));
                let sums = self.field.lights_mut().irradiance(scene, falloff, &vertices.collect::<Vec<_>>());
                let mut sums = sums.as_slice();
                for list in lists.iter_mut() {
                    list.take_unshadowed(sums.split_off(..list.vertices.len()).unwrap_or_default());
                }
            }
        }
        seconds.shade += started.elapsed().as_secs_f64();
        // Demand and shade are one loop: what can be read is shaded, the rest waits for the fill.
        loop {
            let started = Instant::now();
            let (field, marks) = (&*self.field, &*self.marks);
            lists.par_iter_mut().for_each(|list| match shading {
                Shading::Exact => {}
                Shading::MeanVisibility => list.shade_by_mesh(scene, falloff, field, marks, sight),
                _ => list.shade_per_light(scene, falloff, field, marks, (shading, sight)),
            });
            let waiting = lists.iter().any(|list| !list.waiting.is_empty());
            let step = if waiting { &mut seconds.demand } else { &mut seconds.shade };
            *step += started.elapsed().as_secs_f64();
            if !waiting {
                return Ok(seconds);
            }
            let started = Instant::now();
            let rays = self.field.fill(scene, self.marks)?;
            self.stats.rays += rays;
            self.stats.fill_shadow_rays += rays.shadow;
            self.reporter.add(0, rays.total());
            seconds.fill += started.elapsed().as_secs_f64();
            if self.reporter.cancelled() {
                return Err(Error::Cancelled);
            }
        }
    }
}

/// Where the time of [`DirectLighting::light`] went.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LightSeconds {
    pub demand: f64,
    pub fill: f64,
    pub shade: f64,
}
