//! What a display needs to know of the samples: the colours of unlit surfaces.

use glam::{Vec3, Vec4};

/// The part of a sample that shows an unlit surface, whose colour no exposure changes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct UnlitSample {
    pub pixel: u32,
    /// Its part of the sample's radiance, cd/m².
    pub radiance: Vec3,
    /// The part of the sample that it covers.
    pub part: f32,
}

/// Sums over samples, by pixel: see [`DisplayData::unlit`](crate::DisplayData::unlit). Empty for scenes without unlit
/// surfaces.
#[derive(Clone, Debug, Default)]
pub(crate) struct UnlitSums(Vec<Vec4>);

impl UnlitSums {
    /// Values of a pixel.
    const CHANNELS: usize = 4;

    pub(super) fn new(pixels: usize) -> Self {
        Self(vec![Vec4::ZERO; pixels])
    }

    pub(super) fn add(&mut self, sample: UnlitSample) {
        if let Some(sum) = self.0.get_mut(sample.pixel as usize) {
            *sum += sample.radiance.extend(sample.part);
        }
    }

    /// How many values [`UnlitSums::copy_to`] gives.
    pub(super) fn channels(&self) -> usize {
        if self.0.is_empty() { 0 } else { Self::CHANNELS }
    }

    pub(super) fn copy_to(&self, pixel: u32, values: &mut Vec<f32>) {
        values.extend(self.0.get(pixel as usize).iter().flat_map(|sum| sum.to_array()));
    }

    pub(super) fn copy_from(&mut self, pixel: u32, values: &[f32]) {
        if let Some(values) = values.first_chunk::<{ Self::CHANNELS }>() {
            self.0[pixel as usize] = Vec4::from_array(*values);
        }
    }

    /// Clears some pixels.
    pub(super) fn clear(&mut self, pixels: &[u32]) {
        if !self.0.is_empty() {
            pixels.iter().for_each(|&pixel| self.0[pixel as usize] = Vec4::ZERO);
        }
    }

    /// Returns the sums of each pixel multiplied with its `scale`. Where no unlit surface is seen there is no list.
    pub(super) fn means(&self, scale: impl Fn(u32) -> f32) -> Vec<Vec4> {
        if self.0.iter().all(|sum| *sum == Vec4::ZERO) {
            return Vec::new();
        }
        (0..).zip(&self.0).map(|(pixel, &sum)| sum * scale(pixel)).collect()
    }
}
