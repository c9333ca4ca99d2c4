//! Differences of linear values.

use glam::Vec3;

/// The difference of a picture to a reference, linear values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// √(mean over pixels and channels of (a − b)²) / mean(b).
    pub relrmse: f64,
    /// mean(a) / mean(b) − 1.
    pub bias: f64,
    /// The largest |a − b| of a channel, cd/m².
    pub max: f64,
}

/// Compares `a` with the reference `b`, pixel by pixel, in f64.
///
/// # Panics
/// If the lengths differ; compare the sizes first.
pub fn difference(a: &[Vec3], b: &[Vec3]) -> Difference {
    assert_eq!(a.len(), b.len(), "pictures of different sizes");
    let (mut squares, mut sum_a, mut sum_b, mut max) = (0.0, 0.0, 0.0, 0.0_f64);
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a.as_dvec3(), b.as_dvec3());
        let d = a - b;
        squares += d.length_squared();
        sum_a += a.element_sum();
        sum_b += b.element_sum();
        max = max.max(d.abs().max_element());
    }
    let n = 3.0 * a.len() as f64;
    Difference { relrmse: (squares / n).sqrt() / (sum_b / n), bias: sum_a / sum_b - 1.0, max }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture 10% brighter everywhere: relrmse = |1.1 − 1| · rms(b) / mean(b), bias 0.1.
    #[test]
    fn a_scaled_constant_has_its_factor_as_error_and_bias() {
        let b = vec![Vec3::splat(2.0); 12];
        let a = vec![Vec3::splat(2.2); 12];
        let d = difference(&a, &b);
        assert!((d.relrmse - 0.1).abs() < 1e-6 && (d.bias - 0.1).abs() < 1e-6 && (d.max - 0.2).abs() < 1e-6);
    }
}
