//! Near light: what the indirect mesh blurs away, found by short rays.
//!
//! Points of the mesh are a spacing apart, and what is nearer than that to a surface — the leg of a chair, the back of a
//! shelf — shades it or lights it within less. As Arikan, Forsyth and O'Brien ("Fast and Detailed Approximate Global
//! Illumination by Irradiance Decomposition", SIGGRAPH 2005) split irradiance into a far part, which is smooth, and a
//! near part, which rays gather, so here: of K rays in proportion to the cosine, those that meet something within the
//! reach R bring what is really there in place of what the mesh says of that direction ω,
//!
//! > E(y) = M(n) + π/K Σ_met [L(ω) − L_M(ω)], L = Le + a/π (D + M) where the ray ends,
//!
//! with L_M(ω) the radiance that gives the six faces of the mesh at y their irradiance ([`AmbientCube::radiance`]). Where all rays
//! meet something, what the mesh says of a surface that faces along an axis is taken off whole, in the mean. Rays that meet nothing change nothing: in the open
//! there is no noise, and a short ray through nothing is cheap. R, K and what they are worth: docs/near-light.md.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::field::IndirectField;
use super::gather::GatherRays;
use crate::direct::DirectLighting;
use crate::geometry::Ray;
use crate::interaction::ShadingPoint;
use crate::mesh::{AmbientCube, CornerVisibility, Marks};
use crate::sampling::{INV_GOLDEN, basis, hash, sample_cosine_hemisphere, seed_of_surface, unit_f32};
use crate::{Error, Scene};

/// How far short rays go, in spacings of the indirect mesh. Empirical: docs/near-light.md.
const REACH: f32 = 1.5;

/// Rays that are alive at a time, some 200 B each and as much again where they meet something, and rays that make a list.
/// Of a point with more rays than that, all are alive.
const AT_ONCE: usize = 1 << 17;
const RAYS: usize = 1 << 11;

/// How many rays are shot from each point, and how far light is followed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearRays {
    /// Rays per point.
    pub count: u32,
    /// Most reflections of the light that arrives.
    pub bounces: u32,
}

/// Surface points that have read the mesh, and their irradiance, lux, which is to be corrected.
#[derive(Debug, Default)]
pub(crate) struct NearPoints<'a> {
    /// Those of a pixel follow each other and share an id: their rays are strata of one hemisphere.
    pub points: Vec<ShadingPoint>,
    /// By point.
    pub irradiance: Vec<&'a mut Vec3>,
}

impl IndirectField {
    /// Corrects what surface points have read by short rays from each.
    ///
    /// # Errors
    /// As [`IndirectField::fill`].
    pub(crate) fn correct_near(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        marks: &mut Marks,
        near: NearPoints<'_>,
        rays: NearRays,
    ) -> Result<(), Error> {
        let NearRays { count, bounces } = rays;
        let NearPoints { points, mut irradiance } = near;
        let together = (RAYS / count as usize).max(1);
        let at_once = (AT_ONCE / (together * count as usize)).max(1) * together;
        let mut gathers: Vec<GatherRays> = Vec::new();
        for (points, irradiance) in points.chunks(at_once).zip(irradiance.chunks_mut(at_once)) {
            // Shoot the rays of several points as one list.
            let lists = points.len().div_ceil(together);
            gathers.resize_with(gathers.len().max(lists), GatherRays::default);
            let batch = &mut gathers[..lists];
            let (scene, options, field) = (direct.scene, direct.options, &*self);
            batch.par_iter_mut().zip(points.par_chunks(together)).for_each(|(gather, points)| {
                gather.shoot(scene, options, PI / count as f32, field.short_rays(points, count, options.seed));
                if bounces == 0 {
                    gather.hits.vertices.clear();
                }
            });

            // Light what they meet.
            let mut hits: Vec<_> = batch.iter_mut().map(|gather| &mut gather.hits).collect();
            let seconds = direct.shade(CornerVisibility::Stochastic, &mut hits)?;
            direct.stats.seconds.fill_direct += seconds.fill;
            let indirect = match bounces.checked_sub(1) {
                Some(bounces) => self.read_hits(direct, marks, batch, bounces)?,
                None => Vec::new(),
            };

            // Put it in the place of what the mesh says.
            let mut rest = indirect.as_slice();
            let mut of_list = Vec::with_capacity(batch.len());
            for gather in &*batch {
                let (own, others) = rest.split_at(gather.hits.vertices.len());
                of_list.push(own);
                rest = others;
            }
            let field = &*self;
            let surfaces = points.par_chunks(together).zip(irradiance.par_chunks_mut(together));
            let traced =
                batch.par_iter().zip(of_list).zip(surfaces).map(|((gather, indirect), (points, irradiance))| {
                    field.replace_near(scene, gather, indirect, (points, irradiance), rays, marks)
                });
            direct.stats.rays.secondary += traced.sum::<u64>();
            for gather in batch.iter_mut() {
                let short = gather.take_rays(direct);
                direct.stats.rays.secondary += short;
            }
            if direct.reporter.cancelled() {
                return Err(Error::Cancelled);
            }
        }
        Ok(())
    }

    /// The short rays of some points, and what the random numbers of each are made from. A pixel's are the strata of
    /// one hemisphere, dealt to its points in turn.
    fn short_rays<'a>(
        &'a self,
        points: &'a [ShadingPoint],
        count: u32,
        seed: u64,
    ) -> impl Iterator<Item = (Ray, u32)> + 'a {
        points.chunk_by(|a, b| a.id == b.id).flat_map(move |pixel| {
            let seed = seed_of_surface(seed, pixel[0].position);
            let (turns, strata) = (pixel.len() as u32, pixel.len() as u32 * count);
            (0..).zip(pixel).flat_map(move |(turn, point)| {
                let reach = REACH * self.points.spacing_at(point);
                let (t, b) = basis(point.n);
                (0..count).map(move |i| {
                    let stratum = i * turns + turn;
                    let height = unit_f32(hash(seed ^ hash(!stratum)));
                    let azimuth = unit_f32(stratum.wrapping_mul(INV_GOLDEN).wrapping_add(seed));
                    let u = Vec2::new((stratum as f32 + height) / strata as f32, azimuth);
                    let local = sample_cosine_hemisphere(u);
                    let direction = t * local.x + b * local.y + point.n * local.z;
                    let ray = Ray { t_max: reach, ..Ray::new(point.light_origin(direction), direction) };
                    (ray, hash(seed ^ hash(stratum)))
                })
            })
        })
    }

    /// Adds the difference that the rays make to the irradiance of their points. Returns how many rays found out which
    /// mesh points the points see.
    fn replace_near(
        &self,
        scene: &Scene,
        gather: &GatherRays,
        indirect: &[Option<Vec3>],
        (points, irradiance): (&[ShadingPoint], &mut [&mut Vec3]),
        NearRays { count, bounces }: NearRays,
        marks: &Marks,
    ) -> u64 {
        // Sum what each ray brings; none where the mesh cannot be read at its end, and of what mirrors and glass show,
        // which few rays find by chance: white dots where a lamp is mirrored.
        let mut found: Vec<Option<Vec3>> = gather.met().map(|met| met.then_some(Vec3::ZERO)).collect();
        for &(ray, radiance) in &gather.emitted {
            found[ray as usize].iter_mut().for_each(|sum| *sum += radiance);
        }
        for ((hit, &direct), indirect) in gather.hits.vertices.iter().zip(&gather.hits.direct).zip(indirect) {
            let sum = &mut found[hit.id as usize];
            *sum = sum.zip(*indirect).map(|(sum, indirect)| sum + hit.weight * (direct + indirect));
        }

        let mut reader = self.reader(scene, bounces, CornerVisibility::All);
        let rays = found.chunks_exact(count as usize).zip(gather.batch().chunks_exact(count as usize));
        for ((found, rays), (point, irradiance)) in rays.zip(points.iter().zip(irradiance)) {
            if found.iter().all(Option::is_none) {
                continue;
            }
            let Some(cube) = reader.read_cube(point, marks) else { continue };
            let said = |ray: &Ray| AmbientCube::radiance(ray.direction, &cube).truncate();
            let differences: Vec3 = found.iter().zip(rays).filter_map(|(sum, ray)| Some((*sum)? - said(ray))).sum();
            **irradiance = (**irradiance + differences * (PI / count as f32)).max(Vec3::ZERO);
        }
        reader.visibility_rays()
    }
}
