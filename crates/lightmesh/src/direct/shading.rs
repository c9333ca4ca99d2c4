//! Batches of surface points and their direct light: from exact shadow rays or from the direct mesh.

use std::time::Instant;

use fearless_simd::{Simd, dispatch};
use glam::Vec3;
use rayon::prelude::*;

use super::exact::ExactShader;
use super::few_rays::FewRaysShader;
use super::field::DirectField;
use super::per_light::{PerLightShader, Shaded};
use super::plan::{LightingPlan, Shading};
use super::read::Reading;
use super::read_lights::LightsReading;
use crate::interaction::{MirroredLights, MirroredShader, ShadingPoint};
use crate::light::{LightCut, LightSamples, PARTS, SUNS};
use crate::mesh::{CornerVisibility, Marks};
use crate::progress::Reporter;
use crate::sampling::{fold_seed, hash, seed_of_position};
use crate::{Error, Falloff, RenderOptions, RenderStats, Scene};

/// Shadow rays from a surface without a usable mesh point, at most, fewer where it counts for less in the picture; and
/// from such a hit of a gather ray, of which only the sum counts. In a room whose faces are turned inside out all surfaces are such: with a ray to each of the 64
/// samples of the sky it took 37 times as long as `path`.
const FALLBACK_RAYS: u32 = 16;
const FALLBACK_RAYS_OF_GATHER_HITS: u32 = 1;

/// Vertices and their direct irradiance; buffers are kept from use to use.
#[derive(Debug, Default)]
pub(crate) struct ShadingBatch {
    pub vertices: Vec<ShadingPoint>,
    /// Direct irradiance of each vertex, lux.
    pub direct: Vec<Vec3>,
    /// Without shadows, by parts of the lights, where the mesh keeps these for themselves; else empty.
    parts: Vec<[Vec3; PARTS]>,
    /// Vertices that have not been shaded yet.
    waiting: Vec<u32>,
    exact: ExactShader,
    few_rays: FewRaysShader,
    per_light: PerLightShader,
    mirrored: MirroredShader,
    shadow_rays: u64,
    visibility_rays: u64,
    fallbacks: u64,
}

impl ShadingBatch {
    /// Shades every vertex with a shadow ray to each of the light samples, or to a random point of what it stands for.
    pub(crate) fn shade_exactly(&mut self, scene: &Scene, lights: &LightSamples, falloff: Falloff, seed: u64) {
        self.direct.clear();
        let lights = LightCut::all(lights);
        for vertex in &self.vertices {
            let (irradiance, rays) = self.exact.irradiance(scene, &lights, falloff, vertex, fold_seed(seed));
            self.direct.push(irradiance);
            self.shadow_rays += rays;
        }
        self.waiting.clear();
    }

    /// Adds the light of punctual lights that are seen in plane mirrors.
    pub(crate) fn add_mirrored(&mut self, scene: &Scene, falloff: Falloff, visibility: CornerVisibility) {
        if scene.mirrored_lights().is_empty() {
            return;
        }
        for (vertex, irradiance) in self.vertices.iter().zip(&mut self.direct) {
            let which = match visibility {
                CornerVisibility::Stochastic => MirroredLights::One { seed: seed_of_position(vertex.position) },
                CornerVisibility::All | CornerVisibility::Deferred { .. } => MirroredLights::All,
            };
            *irradiance += self.mirrored.irradiance(scene, falloff, vertex, which);
        }
        self.shadow_rays += self.mirrored.take_rays();
    }

    /// Computes Σ of formula (2), without visibility, over every light, for every vertex; those that receive any light
    /// wait to be shaded.
    fn sum_unshadowed(&mut self, scene: &Scene, falloff: Falloff, has_parts: bool) {
        let (lights, level) = (scene.lights(), scene.simd_level());
        let vertices = self.vertices.iter().map(|vertex| (vertex.position, vertex.n));
        if has_parts {
            lights.irradiance_of_parts(level, falloff, vertices, &mut self.parts);
            self.direct.clear();
            self.direct.extend(self.parts.iter().map(|parts| parts.iter().sum::<Vec3>()));
        } else {
            self.parts.clear();
            lights.irradiance(level, falloff, vertices, &mut self.direct);
        }
        self.await_lit();
    }

    /// [`Self::sum_unshadowed`] with sums that have been computed.
    fn set_unshadowed(&mut self, sums: &[Vec3]) {
        self.parts.clear();
        self.direct.clear();
        self.direct.extend_from_slice(sums);
        self.await_lit();
    }

    /// Lets the vertices that receive any light wait to be shaded.
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

    /// Multiplies formula (2) with formula (3g) for the vertices that wait; those whose mesh points are empty mark them
    /// and stay in the list. In the picture itself suns get shadow rays: their shadows are sharp.
    fn shade_by_mesh(&mut self, context: MeshContext<'_>) {
        let MeshContext { scene, falloff, field, marks, visibility, .. } = context;
        let mut reader = field.reader(scene, visibility);
        let mut lights = field.lights().at(scene);
        let suns = LightCut::all(&scene.emitters().suns);
        let Self { waiting, vertices, direct, parts, exact, few_rays, shadow_rays, fallbacks, .. } = self;
        waiting.retain(|&i| {
            let (vertex, irradiance) = (&vertices[i as usize], &mut direct[i as usize]);
            let mut by_suns = Vec3::ZERO;
            let reading = match parts.get(i as usize) {
                Some(&(mut parts)) => {
                    if visibility == CornerVisibility::All {
                        by_suns = std::mem::take(&mut parts[SUNS]);
                    }
                    *irradiance = parts.iter().sum();
                    match *irradiance == Vec3::ZERO {
                        true => Reading::Visibility(Vec3::ONE),
                        false => reader.read_parts(vertex, parts, marks),
                    }
                }
                None => reader.read(vertex, *irradiance, marks),
            };
            match reading {
                Reading::Visibility(visibility) => {
                    *irradiance *= visibility;
                    if by_suns != Vec3::ZERO {
                        let (sum, rays) = exact.irradiance(scene, &suns, falloff, vertex, 0);
                        *irradiance += sum;
                        *shadow_rays += rays;
                    }
                }
                // Without a usable point, trace shadow rays.
                Reading::Unavailable => {
                    lights.set_receiver(vertex.position, falloff);
                    let (seed, most) =
                        (seed_of_position(vertex.position), fallback_rays(visibility, vertex, scene.lights().len()));
                    let (sum, rays) = few_rays.irradiance(scene, &lights, falloff, vertex, most, seed);
                    *irradiance = sum;
                    *shadow_rays += rays;
                    *fallbacks += 1;
                }
                Reading::Pending => return true,
            }
            false
        });
        self.visibility_rays += reader.visibility_rays();
    }

    /// Shades the vertices that wait light by light; those whose mesh points are empty mark them and stay in the list.
    fn shade_per_light(&mut self, context: MeshContext<'_>, shading: Shading) {
        let visibility = match (shading, context.visibility) {
            (Shading::PerLight { .. }, CornerVisibility::All) => CornerVisibility::Deferred { finer: true },
            (_, CornerVisibility::Stochastic) => CornerVisibility::Deferred { finer: false },
            (_, visibility) => visibility,
        };
        let context = MeshContext { visibility, ..context };
        dispatch!(context.scene.simd_level(), simd => self.shade_per_light_simd(simd, context, shading));
    }

    #[inline(always)]
    fn shade_per_light_simd<S: Simd>(&mut self, simd: S, context: MeshContext<'_>, shading: Shading) {
        let MeshContext { scene, falloff, field, marks, visibility, .. } = context;
        let mut reader = field.reader(scene, visibility);
        let clusters = field.lights().has_clusters();
        let (all, mut cut) = (LightCut::all(scene.lights()), field.lights().at(scene));
        let Self { waiting, vertices, direct, exact, few_rays, per_light, shadow_rays, fallbacks, .. } = self;

        // Sort by region, where there are regions: neighbours share its lights.
        if clusters {
            waiting.sort_by_cached_key(|&i| (field.lights().region(vertices[i as usize].position), i));
        }
        let mut kept = 0;
        for i in 0..waiting.len() {
            // Read the mesh; a vertex whose points are missing stays in the list.
            let surface = waiting[i];
            let vertex = &vertices[surface as usize];
            let reading = reader.read_lights(vertex, marks);
            if reading == LightsReading::Pending {
                waiting[kept] = surface;
                kept += 1;
                continue;
            }

            // Shade, and queue shadow rays.
            let most = fallback_rays(visibility, vertex, scene.lights().len());
            let shaded = |seed| Shaded {
                scene,
                falloff,
                vertex,
                surface,
                lights: reader.lights(),
                seed: seed ^ seed_of_position(vertex.position),
            };
            direct[surface as usize] = match (reading, shading) {
                (LightsReading::Known, Shading::PerLight { policy, seed }) => {
                    per_light.sample_by_policy(simd, &shaded(seed), policy)
                }
                // With as many rays as lights, or more, each light gets its own.
                (LightsReading::Known, Shading::Unbiased { rays, seed }) if (rays as usize) < scene.lights().len() => {
                    per_light.sample_unbiased(simd, &shaded(seed), rays)
                }
                // Clusters, each as one light, would be biased.
                (LightsReading::Unknown, Shading::Unbiased { rays, seed })
                    if (rays as usize) < scene.lights().len() =>
                {
                    *fallbacks += 1;
                    per_light.sample_unbiased(simd, &shaded(seed), rays.max(most))
                }
                (reading, _) => {
                    let by_cut = clusters && matches!(shading, Shading::PerLight { .. });
                    if by_cut {
                        cut.set_receiver(vertex.position, falloff);
                    }
                    let lights = if by_cut { &cut } else { &all };
                    let (sum, rays) = if reading == LightsReading::Known {
                        exact.irradiance(scene, lights, falloff, vertex, context.seed)
                    } else {
                        *fallbacks += 1;
                        let seed = shaded(hash(FALLBACK_RAYS)).seed;
                        few_rays.irradiance(scene, lights, falloff, vertex, most, seed)
                    };
                    *shadow_rays += rays;
                    sum
                }
            };
            if per_light.is_full() {
                *shadow_rays += per_light.trace(scene, direct);
            }
        }
        waiting.truncate(kept);
        *shadow_rays += per_light.trace(scene, direct);
        self.visibility_rays += reader.visibility_rays();
    }

    /// Returns the rays since the last call of [`ShadingBatch::take_counts`].
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

/// Returns how many shadow rays a surface gets, at most, for which no mesh point is usable.
fn fallback_rays(visibility: CornerVisibility, vertex: &ShadingPoint, lights: usize) -> u32 {
    match visibility {
        CornerVisibility::Stochastic | CornerVisibility::Deferred { finer: false } => FALLBACK_RAYS_OF_GATHER_HITS,
        // To choose among a few lights would save little, and add noise.
        _ if lights <= FALLBACK_RAYS as usize => FALLBACK_RAYS,
        CornerVisibility::All | CornerVisibility::Deferred { finer: true } => {
            let share = std::f32::consts::PI * vertex.weight.max_element();
            (share * FALLBACK_RAYS as f32).ceil().clamp(1.0, FALLBACK_RAYS as f32) as u32
        }
    }
}

/// What a batch is shaded with.
#[derive(Clone, Copy)]
struct MeshContext<'a> {
    scene: &'a Scene,
    falloff: Falloff,
    field: &'a DirectField,
    marks: &'a Marks,
    visibility: CornerVisibility,
    /// For rays that do not come from a plan.
    seed: u32,
}

/// The direct mesh, and what shading by it needs.
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
    /// Computes the direct light at every vertex of the batches, batch by batch; the mesh is filled as far as they need it.
    /// Rays of the fill are added to the frame's; those of the rest stay with the batches.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] before anything is allocated, [`Error::Cancelled`].
    pub(super) fn shade_together(
        &mut self,
        visibility: CornerVisibility,
        batches: &mut [&mut ShadingBatch],
    ) -> Result<ShadingSeconds, Error> {
        // Compute what needs no mesh: exact light, or sums without shadows.
        let (scene, falloff) = (self.scene, self.options.transport.falloff);
        let shading = self.plan.shading(visibility);
        let started = Instant::now();
        let mut seconds = ShadingSeconds::default();
        match shading {
            Shading::Exact => {
                let seed = self.options.seed;
                batches.par_iter_mut().for_each(|batch| batch.shade_exactly(scene, scene.lights(), falloff, seed));
            }
            Shading::PerLight { .. } | Shading::Unbiased { .. } => {
                if self.field.lights().has_clusters() {
                    let vertices = batches.iter().flat_map(|batch| &batch.vertices).map(|v| (v.position, v.n));
                    self.field.lights_mut().prepare(falloff, &vertices.collect::<Vec<_>>());
                }
                batches.iter_mut().for_each(|batch| batch.await_all());
            }
            Shading::MeanVisibility if !self.field.lights().has_clusters() => {
                let has_parts = self.field.has_parts();
                batches.par_iter_mut().for_each(|batch| batch.sum_unshadowed(scene, falloff, has_parts));
            }
            Shading::MeanVisibility => {
                let vertices = batches.iter().flat_map(|batch| &batch.vertices).map(|v| (v.position, v.n));
                let sums = self.field.lights_mut().irradiance(scene, falloff, &vertices.collect::<Vec<_>>());
                let mut sums = sums.as_slice();
                for batch in batches.iter_mut() {
                    batch.set_unshadowed(sums.split_off(..batch.vertices.len()).unwrap_or_default());
                }
            }
        }
        seconds.shade += started.elapsed().as_secs_f64();

        // Demand and shade are one loop: what can be read is shaded, the rest waits for the fill.
        loop {
            let started = Instant::now();
            let seed = fold_seed(self.options.seed);
            let context = MeshContext { scene, falloff, field: self.field, marks: self.marks, visibility, seed };
            batches.par_iter_mut().for_each(|batch| match shading {
                Shading::Exact => {}
                Shading::MeanVisibility => batch.shade_by_mesh(context),
                _ => batch.shade_per_light(context, shading),
            });
            let waiting = batches.iter().any(|batch| !batch.waiting.is_empty());
            let step = if waiting { &mut seconds.demand } else { &mut seconds.shade };
            *step += started.elapsed().as_secs_f64();
            if !waiting {
                let started = Instant::now();
                if matches!(shading, Shading::PerLight { .. }) {
                    // What a ray takes from the estimate may be more than is there.
                    let direct = batches.iter_mut().flat_map(|batch| &mut batch.direct);
                    direct.for_each(|irradiance| *irradiance = irradiance.max(Vec3::ZERO));
                }
                batches.par_iter_mut().for_each(|batch| batch.add_mirrored(scene, falloff, visibility));
                seconds.shade += started.elapsed().as_secs_f64();
                return Ok(seconds);
            }

            // Fill the points that were marked.
            let started = Instant::now();
            let rays = self.field.fill(scene, self.marks, self.reporter)?;
            self.stats.rays += rays;
            self.stats.fill_shadow_rays += rays.shadow;
            seconds.fill += started.elapsed().as_secs_f64();
            if self.reporter.cancelled() {
                return Err(Error::Cancelled);
            }
        }
    }
}

/// Where the time of [`DirectLighting::shade`] went, seconds.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ShadingSeconds {
    pub demand: f64,
    pub fill: f64,
    pub shade: f64,
}
