//! What a display needs to know of the samples: unlit colours, and what light meters leave out.

use glam::{Vec2, Vec3, Vec4};

use crate::image::DisplayData;

/// Why a part of a sample's light says nothing of the exposure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shown {
    /// An unlit surface, whose colour no exposure changes.
    Unlit,
    /// The background, or a lamp.
    Unmetered,
}

/// A part of a sample that is no lit surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShownSample {
    pub pixel: u32,
    pub shown: Shown,
    /// Its part of the sample's radiance, cd/m².
    pub radiance: Vec3,
    /// The part of the sample that it covers.
    pub part: f32,
}

/// Sums over samples, by pixel.
#[derive(Debug, Default)]
pub(crate) struct DisplaySums {
    /// See [`DisplayData::unlit`]; empty for scenes without unlit surfaces.
    unlit: Vec<Vec4>,
    /// See [`DisplayData::unmetered`].
    unmetered: Vec<Vec2>,
}

impl DisplaySums {
    /// Values of a pixel.
    const CHANNELS: usize = 6;

    pub(super) fn new(pixels: usize) -> Self {
        Self { unlit: vec![Vec4::ZERO; pixels], unmetered: vec![Vec2::ZERO; pixels] }
    }

    pub(super) fn add(&mut self, sample: ShownSample) {
        let ShownSample { pixel, shown, radiance, part } = sample;
        if let Some(sum) = self.unmetered.get_mut(pixel as usize) {
            *sum += Vec2::new(part, radiance.dot(Vec3::new(0.2126, 0.7152, 0.0722)));
        }
        if shown == Shown::Unlit
            && let Some(sum) = self.unlit.get_mut(pixel as usize)
        {
            *sum += radiance.extend(part);
        }
    }

    /// How many values [`DisplaySums::copy_to`] gives.
    pub(super) fn channels(&self) -> usize {
        if self.unmetered.is_empty() { 0 } else { Self::CHANNELS }
    }

    pub(super) fn copy_to(&self, pixel: u32, values: &mut Vec<f32>) {
        if let (Some(unlit), Some(unmetered)) = (self.unlit.get(pixel as usize), self.unmetered.get(pixel as usize)) {
            values.extend(unlit.to_array());
            values.extend(unmetered.to_array());
        }
    }

    pub(super) fn copy_from(&mut self, pixel: u32, values: &[f32]) {
        if let Some(values) = values.first_chunk::<{ Self::CHANNELS }>() {
            self.unlit[pixel as usize] = Vec4::from_slice(values);
            self.unmetered[pixel as usize] = Vec2::from_slice(&values[4..]);
        }
    }

    pub(super) fn scale(&mut self, pixels: impl Iterator<Item = u32>, factor: f32) {
        if !self.unmetered.is_empty() {
            for pixel in pixels {
                self.unlit[pixel as usize] *= factor;
                self.unmetered[pixel as usize] *= factor;
            }
        }
    }

    /// Returns the means; the sums must have been scaled to them. Without an unlit surface there is no list of them.
    pub(super) fn finish(self, white_cd_m2: Option<f32>) -> DisplayData {
        let Self { mut unlit, unmetered } = self;
        if unlit.iter().all(|sum| *sum == Vec4::ZERO) {
            unlit = Vec::new();
        }
        DisplayData { unlit, unmetered, white_cd_m2 }
    }

    /// A copy of what there is so far, each pixel scaled by the function of its number.
    pub(super) fn so_far(&self, scale: impl Fn(u32) -> f32, white_cd_m2: Option<f32>) -> DisplayData {
        let mut copy = Self { unlit: self.unlit.clone(), unmetered: self.unmetered.clone() };
        for pixel in 0..copy.unmetered.len() as u32 {
            copy.scale(std::iter::once(pixel), scale(pixel));
        }
        copy.finish(white_cd_m2)
    }
}
