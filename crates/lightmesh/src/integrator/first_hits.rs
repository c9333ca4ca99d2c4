//! The surfaces that samples meet first, for the layers of a picture.

use glam::Vec3;

use crate::direct::DirectField;
use crate::film::Film;
use crate::interaction::{ShadedHit, ShadingPoint};
use crate::mesh::{CornerVisibility, Marks};
use crate::{Aov, RenderOptions, Scene};

/// A surface that a sample meets before any mirror, glass or diffuse reflection.
#[derive(Clone, Copy, Debug)]
struct FirstHit {
    pixel: u32,
    /// The part of the sample that it covers.
    weight: f32,
    position: Vec3,
    albedo: Vec3,
    normal: Vec3,
    /// Its index among the points to be lit, if it is one.
    point: Option<u32>,
    /// The fraction of the mesh points around it that it can use.
    usable: f32,
    /// The refinement of the mesh cell around it.
    refinement: u32,
}

/// The first hits of a block's samples; empty where the picture has no layers. Buffers are kept from use to use.
#[derive(Debug, Default)]
pub(super) struct FirstHits {
    hits: Vec<FirstHit>,
}

impl FirstHits {
    pub(super) fn clear(&mut self) {
        self.hits.clear();
    }

    /// Adds a surface that covers the part `weight` of a sample; `point` is its index among the points to be lit.
    pub(super) fn push(&mut self, pixel: u32, weight: f32, surface: &ShadedHit, point: Option<u32>) {
        self.hits.push(FirstHit {
            pixel,
            weight,
            position: surface.position,
            albedo: (surface.diffuse + surface.mirror + surface.refraction).min(Vec3::ONE),
            normal: surface.n,
            point,
            usable: 1.0,
            refinement: 0,
        });
    }

    /// Looks up how the `points` among the hits read the mesh, which is filled by now. Returns how many rays that took.
    pub(super) fn read_mesh(
        &mut self,
        scene: &Scene,
        options: &RenderOptions,
        field: &DirectField,
        marks: &Marks,
        points: &[ShadingPoint],
    ) -> u64 {
        if self.hits.is_empty() || !options.picture.aovs.iter().any(Aov::needs_mesh) {
            return 0;
        }
        // Points that face no light did not read the mesh.
        let receivers: Vec<_> = points.iter().map(|point| (point.position, point.n)).collect();
        let unshadowed = field.lights().read_irradiance(scene, options.transport.falloff, &receivers);
        let mut reader = field.reader(scene, CornerVisibility::All);
        for hit in &mut self.hits {
            let Some(i) = hit.point.map(|i| i as usize).filter(|&i| unshadowed[i] != Vec3::ZERO) else {
                continue;
            };
            hit.usable = reader.usable_fraction(&points[i], marks);
            hit.refinement = field.level_at(&points[i]);
        }
        reader.visibility_rays()
    }

    /// Adds them to the film's layers, in order.
    pub(super) fn add_to(&self, film: &mut Film) {
        for hit in &self.hits {
            film.add_surface(hit.pixel, hit.weight, hit.albedo, hit.normal, hit.position);
            if hit.point.is_some() {
                film.layers().add_reading(hit.pixel, hit.weight, hit.usable, hit.refinement);
            }
        }
    }
}
