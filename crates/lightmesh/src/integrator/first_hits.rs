//! What samples meet first, for the layers of a picture.

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
    /// Its place among the vertices that want light, if it is one.
    vertex: Option<u32>,
    /// The part of the mesh points it asked for that it can use, and the refinement of their cell.
    usable: f32,
    refinement: u32,
}

/// The first hits of a block's samples; nothing where nobody asks. Buffers are kept from use to use.
#[derive(Debug, Default)]
pub(super) struct FirstHits {
    hits: Vec<FirstHit>,
}

impl FirstHits {
    pub(super) fn clear(&mut self) {
        self.hits.clear();
    }

    /// Remembers a surface that covers the part `weight` of a sample.
    pub(super) fn push(&mut self, pixel: u32, weight: f32, surface: &ShadedHit, vertex: Option<u32>) {
        self.hits.push(FirstHit {
            pixel,
            weight,
            position: surface.position,
            albedo: (surface.diffuse + surface.mirror + surface.refraction).min(Vec3::ONE),
            normal: surface.n,
            vertex,
            usable: 1.0,
            refinement: 0,
        });
    }

    /// Looks up what the mesh, which has been filled for them, answered to the `vertices` among the hits. Returns the
    /// rays that it took.
    pub(super) fn read_mesh(
        &mut self,
        scene: &Scene,
        options: &RenderOptions,
        (field, marks): (&DirectField, &Marks),
        vertices: &[ShadingPoint],
    ) -> u64 {
        if self.hits.is_empty() || !options.picture.aovs.iter().any(Aov::needs_mesh) {
            return 0;
        }
        // Vertices that face no light have asked for nothing.
        let points: Vec<_> = vertices.iter().map(|v| (v.position, v.n)).collect();
        let unshadowed = field.lights().read_irradiance(scene, options.transport.falloff, &points);
        let mut reader = field.reader(scene, CornerVisibility::All);
        for hit in &mut self.hits {
            let Some(i) = hit.vertex.map(|i| i as usize).filter(|&i| unshadowed[i] != Vec3::ZERO) else {
                continue;
            };
            hit.usable = reader.usable_fraction(&vertices[i], marks);
            hit.refinement = field.level_at(&vertices[i]);
        }
        reader.visibility_rays()
    }

    /// Adds them to the film's layers, in order.
    pub(super) fn add_to(&self, film: &mut Film) {
        for hit in &self.hits {
            film.add_surface(hit.pixel, hit.weight, hit.albedo, hit.normal, hit.position);
            if hit.vertex.is_some() {
                film.layers().add_reading(hit.pixel, hit.weight, hit.usable, hit.refinement);
            }
        }
    }
}
