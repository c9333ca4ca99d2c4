//! FLIP against the authors' own program.

use glam::Vec3;
use lightmesh::metrics::flip;

const WIDTH: usize = 96;
const HEIGHT: usize = 64;
const PIXELS_PER_DEGREE: f64 = 67.0;

/// A byte picture from a function of the pixel.
fn picture(f: impl Fn(usize, usize) -> [u8; 3]) -> Vec<u8> {
    (0..WIDTH * HEIGHT).flat_map(|i| f(i % WIDTH, i / WIDTH)).collect()
}

/// The linear values of sRGB bytes (IEC 61966-2-1).
fn linear(bytes: &[u8]) -> Vec<Vec3> {
    let decode = |b: u8| {
        let c = f32::from(b) / 255.0;
        if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    };
    bytes.chunks_exact(3).map(|p| Vec3::new(decode(p[0]), decode(p[1]), decode(p[2]))).collect()
}

/// A small, plain hash of the pixel: noise without a generator.
fn noise(x: usize, y: usize, seed: usize) -> u8 {
    let mut h = (x * 73_856_093) ^ (y * 19_349_663) ^ (seed * 83_492_791);
    h = (h ^ (h >> 13)).wrapping_mul(1_274_126_177) & 0xffff_ffff;
    (h >> 16) as u8
}

/// Noise, a gradient with discs that move, thin lines, saturated colours: means within 1e-4. Empirical: their program
/// counts in f32, ours in f64, and the largest deviation seen is 6e-6.
///
/// The second column is the mean that the authors' C++ program gave for these bytes, rounded to eight digits: crate
/// `nv-flip` 0.1.2, which wraps it (`nv-flip-sys` 0.1.1), `FlipPool::mean` of `flip(reference, test, 67)`. The crate
/// needs a C++17 compiler and is therefore no dependency.
#[test]
fn agrees_with_the_authors() {
    let disc = |x: usize, y: usize, cx: f64, cy: f64| {
        let (dx, dy) = (x as f64 - cx, y as f64 - cy);
        dx * dx + dy * dy < 150.0
    };
    let gradient = |x: usize, y: usize| [(x * 2) as u8, (y * 3) as u8, 90];
    let pairs = [
        (
            "noise",
            0.430_110_69,
            picture(|x, y| [0, 1, 2].map(|k| noise(x, y, k))),
            picture(|x, y| [3, 4, 5].map(|k| noise(x, y, k))),
        ),
        (
            "a moved disc",
            0.081_756_50,
            picture(|x, y| if disc(x, y, 40.0, 30.0) { [240, 200, 20] } else { gradient(x, y) }),
            picture(|x, y| if disc(x, y, 43.0, 31.0) { [240, 200, 20] } else { gradient(x, y) }),
        ),
        (
            "lines that are missing",
            0.311_240_05,
            picture(|x, y| if x % 16 == 0 || y % 11 == 0 { [255, 255, 255] } else { [60, 70, 80] }),
            picture(|x, _| if x % 16 == 0 { [255, 255, 255] } else { [60, 70, 80] }),
        ),
        ("green and blue", 1.0, picture(|_, _| [0, 255, 0]), picture(|_, _| [0, 0, 255])),
        (
            "a little noise",
            0.166_544_48,
            picture(gradient),
            picture(|x, y| gradient(x, y).map(|c| c.saturating_add(noise(x, y, 9) / 16))),
        ),
    ];
    for (name, theirs, reference, test) in &pairs {
        let ours = flip(&linear(test), &linear(reference), WIDTH, HEIGHT, PIXELS_PER_DEGREE);
        let deviation: f64 = ours - theirs;
        assert!(deviation.abs() < 1e-4, "{name}: {ours} and {theirs}");
    }
}
