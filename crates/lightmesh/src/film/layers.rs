//! Layers while samples come in: sums, and which pixel they belong to.

use glam::Vec3;

use crate::options::{Aov, Aovs, Layer};

/// The sums of a picture's layers; those that the options do not name are empty.
#[derive(Debug, Default)]
pub(crate) struct Layers {
    collected: Aovs,
    /// By layer: the sum over samples, channel by channel; for [`Aov::MeshLevel`] the maximum, for [`Aov::MeshValid`]
    /// the sum of 1 − valid.
    values: [Vec<f32>; Aov::ALL.len()],
    /// By pixel: the weight of the samples that hit something, which depths are divided by.
    hit: Vec<f32>,
}

impl Layers {
    /// Empty layers for `pixels` pixels: of `aovs`, and of those that they are made from.
    pub(crate) fn new(aovs: Aovs, pixels: usize) -> Self {
        let collected = aovs.with_sources();
        let zeros = |wanted, channels| if wanted { vec![0.0; pixels * channels] } else { Vec::new() };
        Self {
            collected,
            values: Aov::ALL.map(|aov| zeros(collected.contains(aov), aov.channels().len())),
            hit: zeros(collected.contains(Aov::Depth), 1),
        }
    }

    /// Whether any is collected.
    pub(crate) fn any(&self) -> bool {
        !self.collected.is_empty()
    }

    /// Adds the first surface that a sample saw, which covers the part `weight` of it, `depth_m` metres away.
    pub(crate) fn add_surface(&mut self, pixel: u32, weight: f32, albedo: Vec3, normal: Vec3, depth_m: f32) {
        self.add(Aov::Albedo, pixel, albedo * weight);
        self.add(Aov::Normal, pixel, normal * weight);
        if let Some(hit) = self.hit.get_mut(pixel as usize) {
            *hit += weight;
            self.values[Aov::Depth as usize][pixel as usize] += depth_m * weight;
        }
    }

    /// Adds to a layer of three channels.
    pub(crate) fn add(&mut self, aov: Aov, pixel: u32, value: Vec3) {
        if let Some(sum) = self.values[aov as usize].get_mut(pixel as usize * 3..).and_then(<[f32]>::first_chunk_mut) {
            let [x, y, z]: &mut [f32; 3] = sum;
            (*x, *y, *z) = (*x + value.x, *y + value.y, *z + value.z);
        }
    }

    /// Adds how a surface that covers the part `weight` of a sample read the direct mesh: the part `usable` of the
    /// corners' weights, in a cell of refinement `level`.
    pub(crate) fn add_reading(&mut self, pixel: u32, weight: f32, usable: f32, level: u32) {
        if let Some(missing) = self.values[Aov::MeshValid as usize].get_mut(pixel as usize) {
            *missing += weight * (1.0 - usable);
        }
        if let Some(most) = self.values[Aov::MeshLevel as usize].get_mut(pixel as usize) {
            *most = most.max(level as f32);
        }
    }

    /// How many values a pixel has in all layers.
    pub(crate) fn channels(&self) -> usize {
        self.collected.iter().map(|aov| aov.channels().len()).sum::<usize>() + usize::from(!self.hit.is_empty())
    }

    /// Adds a pixel's values to a list, [`Layers::channels`] of them.
    pub(crate) fn copy_to(&self, pixel: u32, values: &mut Vec<f32>) {
        for aov in self.collected.iter() {
            let channels = aov.channels().len();
            values.extend_from_slice(&self.values[aov as usize][pixel as usize * channels..][..channels]);
        }
        values.extend(self.hit.get(pixel as usize));
    }

    /// Sets a pixel's values to those that [`Layers::copy_to`] gave.
    pub(crate) fn copy_from(&mut self, pixel: u32, mut values: &[f32]) {
        for aov in self.collected.iter() {
            let channels = aov.channels().len();
            let (own, rest) = values.split_at(channels);
            self.values[aov as usize][pixel as usize * channels..][..channels].copy_from_slice(own);
            values = rest;
        }
        if let (Some(hit), Some(&value)) = (self.hit.get_mut(pixel as usize), values.first()) {
            *hit = value;
        }
    }

    /// Clears some pixels.
    pub(crate) fn clear(&mut self, pixels: &[u32]) {
        for aov in self.collected.iter() {
            let channels = aov.channels().len();
            let values = &mut self.values[aov as usize];
            pixels.iter().for_each(|&pixel| values[pixel as usize * channels..][..channels].fill(0.0));
        }
        if !self.hit.is_empty() {
            pixels.iter().for_each(|&pixel| self.hit[pixel as usize] = 0.0);
        }
    }

    /// Returns the finished layers, in the order of [`Aov::ALL`]: the sums of each pixel multiplied with its `scale`;
    /// [`Aov::Points`] is black.
    pub(crate) fn finish(mut self, scale: impl Fn(u32) -> f32) -> Vec<Layer> {
        // Depths are means over hits alone, and the highest level is no sum.
        for aov in self.collected.iter().filter(|aov| !matches!(aov, Aov::Depth | Aov::MeshLevel)) {
            for (pixel, values) in (0..).zip(self.values[aov as usize].chunks_exact_mut(aov.channels().len())) {
                let scale = scale(pixel);
                values.iter_mut().for_each(|value| *value *= scale);
            }
        }
        for (depth, hit) in self.values[Aov::Depth as usize].iter_mut().zip(&self.hit) {
            *depth = if *hit > 0.0 { *depth / hit } else { Aov::FAR_M };
        }
        for valid in &mut self.values[Aov::MeshValid as usize] {
            *valid = (1.0 - *valid).clamp(0.0, 1.0);
        }
        self.collected.iter().map(|aov| Layer { aov, values: std::mem::take(&mut self.values[aov as usize]) }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two samples of one pixel, one of which hits nothing: colours are averaged with black, the depth is not averaged.
    #[test]
    fn depth_is_averaged_over_hits_alone() {
        let mut layers = Layers::new([Aov::Albedo, Aov::Depth].into_iter().collect(), 2);
        layers.add_surface(1, 1.0, Vec3::ONE, Vec3::X, 7.0);
        let [albedo, depth] = <[Layer; 2]>::try_from(layers.finish(|_| 0.5)).expect("two layers");
        assert_eq!(albedo.values, [0.0, 0.0, 0.0, 0.5, 0.5, 0.5]);
        assert_eq!(depth.values, [Aov::FAR_M, 7.0]);
    }

    /// Half of the weights cannot be used; a pixel that does not read the mesh has 1.
    #[test]
    fn a_pixel_that_does_not_read_the_mesh_is_valid() {
        let mut layers = Layers::new([Aov::MeshLevel, Aov::MeshValid].into_iter().collect(), 2);
        layers.add_reading(0, 1.0, 0.5, 2);
        layers.add_reading(0, 1.0, 1.0, 1);
        let [level, valid] = <[Layer; 2]>::try_from(layers.finish(|_| 0.5)).expect("two layers");
        assert_eq!((level.values, valid.values), (vec![2.0, 0.0], vec![0.75, 1.0]));
    }
}
