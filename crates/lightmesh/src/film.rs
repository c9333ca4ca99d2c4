//! The film: which samples belong to which pixel, and their sum.

use glam::Vec3;

use crate::geometry::Ray;
use crate::integrator::Sampler;
use crate::scene::FilmRays;
use crate::{Camera, Image, RenderOptions};

/// Accumulates radiance with a box filter of one pixel.
#[derive(Debug)]
pub(crate) struct Film {
    rays: FilmRays,
    width: u32,
    height: u32,
    spp: u32,
    seed: u64,
    pixels: Vec<Vec3>,
}

impl Film {
    pub(crate) fn new(camera: &Camera, options: &RenderOptions) -> Self {
        let (width, height) = (options.width, options.height);
        Self {
            rays: camera.film(width, height),
            width,
            height,
            spp: options.spp,
            seed: options.seed,
            pixels: vec![Vec3::ZERO; width as usize * height as usize],
        }
    }

    /// Bytes that a film of this size takes.
    pub(crate) fn bytes(options: &RenderOptions) -> u64 {
        u64::from(options.width) * u64::from(options.height) * size_of::<Vec3>() as u64
    }

    /// Samples of the whole picture; sample s belongs to pixel s / spp.
    pub(crate) fn sample_count(&self) -> u64 {
        self.pixels.len() as u64 * u64::from(self.spp)
    }

    /// The pixel, camera ray and random numbers of sample `s`. A single sample goes through the pixel's centre.
    pub(crate) fn sample(&self, s: u64) -> (u32, Ray, Sampler) {
        let pixel = (s / u64::from(self.spp)) as u32;
        let mut sampler = Sampler::new(self.seed, pixel, (s % u64::from(self.spp)) as u32);
        let jitter = sampler.next_pair();
        let offset = if self.spp == 1 { glam::Vec2::splat(0.5) } else { jitter };
        let x = (pixel % self.width) as f32 + offset.x;
        let y = (pixel / self.width) as f32 + offset.y;
        (pixel, self.rays.ray(x, y), sampler)
    }

    /// Adds one sample's radiance, or a part of it.
    pub(crate) fn add(&mut self, pixel: u32, radiance: Vec3) {
        self.pixels[pixel as usize] += radiance;
    }

    /// The mean over each pixel's samples.
    pub(crate) fn into_image(self) -> Image {
        let scale = 1.0 / self.spp as f32;
        let pixels = self.pixels.into_iter().map(|p| p * scale).collect();
        Image { width: self.width, height: self.height, pixels }
    }
}
