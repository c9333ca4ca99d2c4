//! Dither: 8-bit steps become invisible where neighbouring pixels round in different directions.

use std::sync::OnceLock;

use glam::Vec3;

use crate::srgb::srgb_from_linear;

/// Side of the mask, which repeats over the picture.
const SIDE: usize = 32;
/// Standard deviation of the energy about a point of the mask, pixels (Ulichney 1993: 1.5).
const SIGMA: f32 = 1.5;
/// How near to a byte a value counts as that byte, in bytes: rounding errors of the way from sRGB to linear and back.
const EXACT: f32 = 1.0 / 256.0;

/// The sRGB bytes nearest to a display-linear colour.
pub(super) fn nearest_bytes(color: Vec3) -> [u8; 3] {
    color.to_array().map(|c| (255.0 * srgb_from_linear(c)).round() as u8)
}

/// The sRGB bytes of a display-linear colour at the pixel (x, y).
///
/// A value between two bytes becomes one of them, so that the mean over neighbouring pixels is the value; which one
/// depends on the pixel alone. A value that is a byte stays it: black, white, and flat colours of 8 bits. All channels
/// round alike, so that grey stays grey. The mask is blue noise (Ulichney, "The void-and-cluster method for dither array
/// generation", 1993; its third phase alone, from an empty pattern): errors of neighbours cancel, and there are no
/// patterns to be seen.
pub(super) fn bytes(color: Vec3, x: u32, y: u32) -> [u8; 3] {
    let threshold = mask()[y as usize % SIDE * SIDE + x as usize % SIDE];
    color.to_array().map(|c| {
        let value = 255.0 * srgb_from_linear(c);
        let nearest = value.round();
        if (value - nearest).abs() < EXACT { nearest as u8 } else { (value + threshold).floor().min(255.0) as u8 }
    })
}

/// Numbers in (0, 1), each of 1024 once.
fn mask() -> &'static [f32; SIDE * SIDE] {
    static MASK: OnceLock<[f32; SIDE * SIDE]> = OnceLock::new();
    MASK.get_or_init(make)
}

/// Places points one after the other, each in the largest void: where the energy of those before is least. On a torus
/// that is the tightest cluster of what is left, too. The order is the threshold.
fn make() -> [f32; SIDE * SIDE] {
    let wrapped = |d: usize| d.min(SIDE - d) as f32;
    let kernel: Vec<f32> = (0..SIDE * SIDE)
        .map(|i| {
            let (dx, dy) = (wrapped(i % SIDE), wrapped(i / SIDE));
            libm::expf(-(dx * dx + dy * dy) / (2.0 * SIGMA * SIGMA))
        })
        .collect();
    // A little disorder keeps the first points off a regular lattice.
    let disorder = |i: usize| ((i as u32).wrapping_mul(2_654_435_769) >> 8) as f32 * (0.05 / (1 << 24) as f32);
    let mut energy: Vec<f32> = (0..SIDE * SIDE).map(disorder).collect();
    let mut thresholds = [0.0; SIDE * SIDE];
    for rank in 0..SIDE * SIDE {
        let (place, _) = energy.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).unwrap_or((0, &0.0));
        thresholds[place] = (rank as f32 + 0.5) / (SIDE * SIDE) as f32;
        let (x, y) = (place % SIDE, place / SIDE);
        for (i, e) in energy.iter_mut().enumerate() {
            *e += kernel[(i / SIDE + SIDE - y) % SIDE * SIDE + (i % SIDE + SIDE - x) % SIDE];
        }
        energy[place] = f32::INFINITY;
    }
    thresholds
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::srgb::linear_from_srgb;

    /// The mean over a mask of a value between two bytes is the value, to half a 1024th; no byte is farther than one.
    #[test]
    fn the_mean_is_kept() {
        for value in [0.3_f32, 17.25, 127.5, 200.9, 254.5] {
            let linear = Vec3::splat(linear_from_srgb(value / 255.0));
            let all: Vec<u8> = (0..1024).map(|i| bytes(linear, i % 32, i / 32)[0]).collect();
            assert!(all.iter().all(|&b| (f32::from(b) - value).abs() < 1.0));
            let mean = all.iter().map(|&b| f32::from(b)).sum::<f32>() / 1024.0;
            assert!((mean - value).abs() < 2e-3, "{value}: {mean}");
        }
    }

    #[test]
    fn bytes_black_and_white_stay() {
        for byte in 0..=255_u8 {
            let linear = Vec3::splat(linear_from_srgb(f32::from(byte) / 255.0));
            assert!((0..64).all(|i| bytes(linear, i, 3 * i + 1) == [byte; 3]), "{byte}");
        }
        assert_eq!(bytes(Vec3::new(0.0, 1.0, 7.0), 3, 4), [0, 255, 255]);
    }

    /// Means over 4 × 4 pixels of half a byte: white noise would have a standard deviation of √(1/4/16) = 0.125, the mask
    /// has 0.062. That of 64 such means is within 0.011 of it for white noise.
    #[test]
    fn errors_of_neighbours_cancel() {
        let linear = Vec3::splat(linear_from_srgb(100.5 / 255.0));
        let mean = |bx: u32, by: u32| {
            (0..16).map(|i| f32::from(bytes(linear, 4 * bx + i % 4, 4 * by + i / 4)[0])).sum::<f32>() / 16.0 - 100.5
        };
        let variance = (0..64).map(|i| mean(i % 8, i / 8).powi(2)).sum::<f32>() / 64.0;
        assert!(variance.sqrt() < 0.08, "{}", variance.sqrt());
    }
}
