//! How much noise each pixel of a picture has, and which pixels more samples help most.
//!
//! A pixel's samples are taken in two parts. Their means A of a samples and B of b differ by chance: (A − B)² has the
//! expectation σ² (1/a + 1/b), and the mean of both the variance σ² / (a + b). Samples are strata of their pixel, so that
//! together they are better than that; by how much has been measured. Where a pixel's parts agree by chance its
//! neighbours tell: pixels are chosen by the mean over 3 × 3 of them.

use glam::Vec3;

/// What is brighter than so many times the picture's mean counts as that, wherever errors of pictures are estimated: on a
/// display it is white.
pub(crate) const BRIGHTEST: f32 = 8.0;

/// The variance of a pixel's mean as a part of what independent samples would have: of the first few, whose halves miss
/// more strata, and of more. Measured: docs/near-light.md.
const OF_FIRST: f32 = 0.3;
const OF_MORE: f32 = 0.6;

/// The part of a pixel's variance that four times as many samples leave. As the above.
const KEPT: f64 = 1.0 / 6.0;

/// The noise of each pixel.
#[derive(Debug, Default)]
pub(super) struct SampleNoise {
    /// The sums of the first part of the samples: of every pixel, or of those that are being sampled; empty where no
    /// noise is wanted.
    pub(super) first: Vec<Vec3>,
    /// The variance of each pixel's mean over the squared mean of the picture, as a mean over channels.
    variances: Vec<f32>,
}

/// A mean, and of how many samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct PartMean {
    pub(super) mean: Vec3,
    pub(super) count: u32,
}

impl SampleNoise {
    /// Takes the noise of every pixel from both parts of its first samples.
    pub(super) fn set_all(&mut self, picture_mean: f32, parts: impl Iterator<Item = [PartMean; 2]>) {
        self.variances.clear();
        self.variances.extend(parts.map(|parts| OF_FIRST * variance(parts, picture_mean)));
        self.first = Vec::new();
    }

    /// Takes the noise of a pixel from what it had and what it has got.
    pub(super) fn set(&mut self, pixel: u32, picture_mean: f32, parts: [PartMean; 2]) {
        self.variances[pixel as usize] = OF_MORE * variance(parts, picture_mean);
    }

    /// Says that a pixel has no noise to speak of.
    pub(super) fn forget(&mut self, pixel: u32) {
        self.variances[pixel as usize] = 0.0;
    }

    /// The error of the picture by the noise of its pixels: root mean square over its mean.
    pub(super) fn error(&self) -> f64 {
        (self.variances.iter().copied().map(f64::from).sum::<f64>() / self.variances.len().max(1) as f64).sqrt()
    }

    /// Chooses the pixels that are to have four times as many samples so that the error falls to `error`, of those that
    /// may have them, the worst first; at most so many. Ascending.
    pub(super) fn choose(&self, width: u32, error: f64, most: usize, may_have: impl Fn(u32) -> bool) -> Vec<u32> {
        let mut left = self.variances.iter().copied().map(f64::from).sum::<f64>();
        let enough = error * error * self.variances.len() as f64;
        let smooth = self.means_of_neighbours(width as usize);
        let mut candidates: Vec<u32> =
            (0..smooth.len() as u32).filter(|&pixel| smooth[pixel as usize] > 0.0 && may_have(pixel)).collect();
        // Stable: equal pixels keep their order.
        candidates.sort_by(|&a, &b| smooth[b as usize].total_cmp(&smooth[a as usize]));
        candidates.truncate(most);
        let chosen = candidates.iter().take_while(|&&pixel| {
            let goes_on = left > enough;
            left -= (1.0 - KEPT) * f64::from(smooth[pixel as usize]);
            goes_on
        });
        let count = chosen.count();
        candidates.truncate(count);
        candidates.sort_unstable();
        candidates
    }

    /// The mean variance of each pixel and the eight around it.
    fn means_of_neighbours(&self, width: usize) -> Vec<f32> {
        let height = self.variances.len() / width.max(1);
        let mean = |pixel: usize| {
            let (x, y) = (pixel % width, pixel / width);
            let rows = y.saturating_sub(1)..(y + 2).min(height);
            let columns = x.saturating_sub(1)..(x + 2).min(width);
            let count = rows.len() * columns.len();
            let sum: f32 = rows.flat_map(|y| &self.variances[y * width..][columns.clone()]).sum();
            sum / count as f32
        };
        (0..self.variances.len()).map(mean).collect()
    }
}

/// The variance of the mean of two parts, were their samples independent, over the squared mean of the picture.
fn variance([a, b]: [PartMean; 2], picture_mean: f32) -> f32 {
    if a.count == 0 || b.count == 0 || picture_mean <= 0.0 {
        return 0.0;
    }
    let part = |p: PartMean| (p.mean / picture_mean).min(Vec3::splat(BRIGHTEST));
    let (n, m) = (a.count as f32, b.count as f32);
    (part(a) - part(b)).length_squared() / 3.0 * n * m / (n + m).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 64 pixels, eight in one corner are noisy: they are chosen, and no more than the error asks for.
    #[test]
    fn the_noisy_pixels_get_more() {
        let part = |mean: f32, count| PartMean { mean: Vec3::splat(mean), count };
        let mut noise = SampleNoise::default();
        let is_noisy = |pixel: usize| pixel % 8 >= 6 && pixel / 8 >= 4;
        let parts = |pixel: usize| [part(1.0, 2), part(if is_noisy(pixel) { 2.0 } else { 1.0 }, 2)];
        noise.set_all(1.0, (0..64).map(parts));
        assert!((noise.error() - f64::from(OF_FIRST * 0.25 * 8.0 / 64.0).sqrt()).abs() < 1e-6);
        let chosen = noise.choose(8, 0.0, 64, |_| true);
        assert!((0..64).filter(|&p| is_noisy(p)).all(|p| chosen.contains(&(p as u32))), "{chosen:?}");
        assert!(chosen.len() < 20 && noise.choose(8, 0.0, 5, |_| true).len() == 5);
        assert!(noise.choose(8, noise.error(), 64, |_| true).is_empty());
        let some = noise.choose(8, 0.8 * noise.error(), 64, |_| true).len();
        assert!(0 < some && some < chosen.len(), "{some}");
        noise.set(63, 1.0, [part(1.0, 4), part(1.0, 12)]);
        assert!((noise.error() - f64::from(OF_FIRST * 0.25 * 7.0 / 64.0).sqrt()).abs() < 1e-6);
    }
}
