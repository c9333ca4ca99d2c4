//! FLIP: the difference that an observer sees when flipping between two pictures.
//!
//! P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström, M. D. Fairchild, "FLIP: A difference
//! evaluator for alternating images", Proc. ACM on Computer Graphics and Interactive Techniques 3(2), 2020; *FLIP*
//! below. Written from the formulas of its section 4; a test holds it to the authors' own program.

use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;

/// FLIP's default observer: 0.7 m from a screen 0.7 m wide with 3840 pixels across.
pub const FLIP_PIXELS_PER_DEGREE: f64 = 67.0;

/// Exponent of the colour difference, q_c (FLIP 4.1).
const COLOR_EXPONENT: f64 = 0.7;
/// The fraction p_c of the largest colour difference that is mapped to [`KNEE_VALUE`] (FLIP 4.1).
const KNEE: f64 = 0.4;
/// p_t (FLIP 4.1).
const KNEE_VALUE: f64 = 0.95;
/// Width of the feature detectors in degrees of visual angle, w (FLIP 4.2).
const FEATURE_WIDTH: f64 = 0.082;
/// Exponent of the feature difference, q_f (FLIP 4.2).
const FEATURE_EXPONENT: f64 = 0.5;

/// Contrast sensitivity in space (FLIP 4.1, table 1): each channel's filter is a sum of terms
/// a √(π/b) exp(−π² x² / b), x in degrees; (a, b) per term.
const ACHROMATIC: [(f64, f64); 1] = [(1.0, 0.0047)];
const RED_GREEN: [(f64, f64); 1] = [(1.0, 0.0053)];
const BLUE_YELLOW: [(f64, f64); 2] = [(34.1, 0.04), (13.5, 0.025)];

/// The mean FLIP error of `a` to the reference `b`, in [0, 1]: 0 for no visible difference.
///
/// Both are `width` × `height` pictures as a display shows them: display-linear Rec. 709 RGB in [0, 1], after exposure
/// and tone map (values outside are clamped). `pixels_per_degree` says how large a pixel is to the eye, > 0.
///
/// # Panics
/// If a length is not `width · height`; compare the sizes first.
pub fn flip(a: &[Vec3], b: &[Vec3], width: usize, height: usize, pixels_per_degree: f64) -> f64 {
    assert!(a.len() == width * height && b.len() == a.len(), "pictures of different sizes");
    if a.is_empty() {
        return 0.0;
    }
    let size = Size { width, height };
    let [a, b] = [a, b].map(|pixels| Seen::new(pixels, size, pixels_per_degree));
    let max_color = max_color_difference();
    let errors: Vec<f64> = (0..width * height)
        .into_par_iter()
        .map(|i| {
            let color = redistribute(color_difference(a.color[i], b.color[i]), max_color);
            // Eq. 3 of FLIP 4.2, then its 4.3: features raise the colour difference.
            let edges = (a.edges[i] - b.edges[i]).abs();
            let points = (a.points[i] - b.points[i]).abs();
            let feature = libm::pow(edges.max(points) / std::f64::consts::SQRT_2, FEATURE_EXPONENT).min(1.0);
            libm::pow(color, 1.0 - feature)
        })
        .collect();
    // In order, so that the sum does not depend on threads.
    errors.iter().sum::<f64>() / errors.len() as f64
}

/// Width and height in pixels.
#[derive(Clone, Copy)]
struct Size {
    width: usize,
    height: usize,
}

/// A picture as the observer's two pipelines see it.
struct Seen {
    /// Filtered, in Hunt-adjusted L*a*b*.
    color: Vec<DVec3>,
    /// Strength of edges.
    edges: Vec<f64>,
    /// Strength of points.
    points: Vec<f64>,
}

impl Seen {
    pub(crate) fn new(pixels: &[Vec3], size: Size, pixels_per_degree: f64) -> Self {
        let opponent: Vec<DVec3> = pixels
            .par_iter()
            .map(|p| {
                let shown = Vec3::from_array(p.to_array().map(|c| if c > 0.0 { c.min(1.0) } else { 0.0 }));
                ycxcz_from_rgb(shown.as_dvec3())
            })
            .collect();
        let channel = |k: usize| -> Vec<f64> { opponent.iter().map(|c| c[k]).collect() };

        // The colour pipeline: filter by contrast sensitivity, then to a perceptually uniform space.
        let y = filter_by_sensitivity(&channel(0), size, &ACHROMATIC, pixels_per_degree);
        let cx = filter_by_sensitivity(&channel(1), size, &RED_GREEN, pixels_per_degree);
        let cz = filter_by_sensitivity(&channel(2), size, &BLUE_YELLOW, pixels_per_degree);
        let color = (0..pixels.len())
            .into_par_iter()
            .map(|i| {
                let rgb = rgb_from_ycxcz(DVec3::new(y[i], cx[i], cz[i]));
                hunt_from_rgb(rgb.clamp(DVec3::ZERO, DVec3::ONE))
            })
            .collect();

        // The feature pipeline: edges and points of the unfiltered achromatic channel, brought to [0, 1].
        let luminance: Vec<f64> = opponent.iter().map(|c| (c.x + 16.0) / 116.0).collect();
        let detectors = Detectors::new(pixels_per_degree);
        let edges = detectors.strength(&luminance, size, &detectors.edge);
        let points = detectors.strength(&luminance, size, &detectors.point);
        Self { color, edges, points }
    }
}

/// The channel convolved with the normalised sum of Gaussians that `terms` describe. A sum of two is not separable, its
/// terms are: each is convolved alone and weighted by its share of the sum.
fn filter_by_sensitivity(channel: &[f64], size: Size, terms: &[(f64, f64)], pixels_per_degree: f64) -> Vec<f64> {
    // One radius for all channels: three standard deviations of the widest term.
    let pi2 = std::f64::consts::PI * std::f64::consts::PI;
    let widest = BLUE_YELLOW[0].1;
    let radius = (3.0 * (widest / (2.0 * pi2)).sqrt() * pixels_per_degree).ceil() as i64;
    let kernels: Vec<(f64, Vec<f64>)> = terms
        .iter()
        .map(|&(a, b)| {
            let gauss = |x: i64| libm::exp(-pi2 * (x as f64 / pixels_per_degree) * (x as f64 / pixels_per_degree) / b);
            let kernel: Vec<f64> = (-radius..=radius).map(gauss).collect();
            let sum: f64 = kernel.iter().sum();
            let share = a * (std::f64::consts::PI / b).sqrt() * sum * sum;
            (share, kernel.iter().map(|k| k / sum).collect())
        })
        .collect();
    let whole: f64 = kernels.iter().map(|(share, _)| share).sum();
    let mut filtered = vec![0.0; channel.len()];
    for (share, kernel) in &kernels {
        let term = convolve(channel, size, kernel, kernel);
        filtered.iter_mut().zip(&term).for_each(|(f, t)| *f += share / whole * t);
    }
    filtered
}

/// The kernels that find features (FLIP 4.2): the first and second derivative of a Gaussian across, the Gaussian along.
struct Detectors {
    edge: Vec<f64>,
    point: Vec<f64>,
    along: Vec<f64>,
}

impl Detectors {
    pub(crate) fn new(pixels_per_degree: f64) -> Self {
        let deviation = 0.5 * FEATURE_WIDTH * pixels_per_degree;
        let radius = (3.0 * deviation).ceil() as i64;
        let kernel = |f: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let gauss = |x: f64| libm::exp(-x * x / (2.0 * deviation * deviation));
            (-radius..=radius).map(|x| f(x as f64) * gauss(x as f64)).collect()
        };
        let along = kernel(&|_| 1.0);
        let sum: f64 = along.iter().sum();
        Self {
            edge: balanced(kernel(&|x| -x)),
            point: balanced(kernel(&|x| x * x / (deviation * deviation) - 1.0)),
            along: along.iter().map(|k| k / sum).collect(),
        }
    }

    /// Length of the (horizontal, vertical) response at each pixel.
    fn strength(&self, channel: &[f64], size: Size, across: &[f64]) -> Vec<f64> {
        let horizontal = convolve(channel, size, across, &self.along);
        let vertical = convolve(channel, size, &self.along, across);
        horizontal.iter().zip(&vertical).map(|(x, y)| (x * x + y * y).sqrt()).collect()
    }
}

/// The kernel with its positive weights scaled to sum to 1 and its negative ones to −1.
fn balanced(kernel: Vec<f64>) -> Vec<f64> {
    let positive: f64 = kernel.iter().filter(|k| **k > 0.0).sum();
    let negative: f64 = -kernel.iter().filter(|k| **k < 0.0).sum::<f64>();
    kernel.into_iter().map(|k| if k > 0.0 { k / positive } else { k / negative }).collect()
}

/// The channel convolved with `horizontal` along rows, then `vertical` along columns; beyond the border its pixels go
/// on.
fn convolve(channel: &[f64], size: Size, horizontal: &[f64], vertical: &[f64]) -> Vec<f64> {
    let Size { width, height } = size;
    let clamped = |i: usize, k: usize, kernel: &[f64], n: usize| (i + k).saturating_sub(kernel.len() / 2).min(n - 1);
    let mut rows = vec![0.0; channel.len()];
    rows.par_chunks_mut(width).zip(channel.par_chunks(width)).for_each(|(out, row)| {
        for (x, out) in out.iter_mut().enumerate() {
            *out = horizontal.iter().enumerate().map(|(k, w)| w * row[clamped(x, k, horizontal, width)]).sum();
        }
    });
    let mut columns = vec![0.0; channel.len()];
    columns.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        for (k, weight) in vertical.iter().enumerate() {
            let from = clamped(y, k, vertical, height) * width;
            out.iter_mut().zip(&rows[from..from + width]).for_each(|(out, v)| *out += weight * v);
        }
    });
    columns
}

/// HyAB distance to the power q_c (FLIP 4.1): the lightness apart from the chroma, as suits large differences.
fn color_difference(a: DVec3, b: DVec3) -> f64 {
    let d = a - b;
    libm::pow(d.x.abs() + (d.y * d.y + d.z * d.z).sqrt(), COLOR_EXPONENT)
}

/// The largest colour difference that a display can show: green to blue (FLIP 4.1).
fn max_color_difference() -> f64 {
    color_difference(hunt_from_rgb(DVec3::Y), hunt_from_rgb(DVec3::Z))
}

/// Maps [0, `max`] to [0, 1]: differences under [`KNEE`] of the maximum get the range up to [`KNEE_VALUE`] (FLIP 4.1).
fn redistribute(difference: f64, max: f64) -> f64 {
    let knee = KNEE * max;
    if difference < knee {
        KNEE_VALUE / knee * difference
    } else {
        KNEE_VALUE + (difference - knee) / (max - knee) * (1.0 - KNEE_VALUE)
    }
}

/// XYZ from linear Rec. 709 RGB, white D65 (IEC 61966-2-1, derived from the primaries to seven digits).
const XYZ_FROM_RGB: DMat3 = DMat3::from_cols(
    DVec3::new(0.412_390_8, 0.212_639_0, 0.019_330_8),
    DVec3::new(0.357_584_3, 0.715_168_7, 0.119_194_8),
    DVec3::new(0.180_480_8, 0.072_192_3, 0.950_532_2),
);

/// XYZ over the white's, so that white is (1, 1, 1).
fn relative_xyz(rgb: DVec3) -> DVec3 {
    (XYZ_FROM_RGB * rgb) / (XYZ_FROM_RGB * DVec3::ONE)
}

/// The linear opponent space Y'CxCz (FLIP 4.1).
fn ycxcz_from_rgb(rgb: DVec3) -> DVec3 {
    let c = relative_xyz(rgb);
    DVec3::new(116.0 * c.y - 16.0, 500.0 * (c.x - c.y), 200.0 * (c.y - c.z))
}

fn rgb_from_ycxcz(c: DVec3) -> DVec3 {
    let y = (c.x + 16.0) / 116.0;
    let relative = DVec3::new(y + c.y / 500.0, y, y - c.z / 200.0);
    XYZ_FROM_RGB.inverse() * (relative * (XYZ_FROM_RGB * DVec3::ONE))
}

/// CIE L*a*b* with the Hunt effect: chroma counts less where it is dark (FLIP 4.1).
fn hunt_from_rgb(rgb: DVec3) -> DVec3 {
    const DELTA: f64 = 6.0 / 29.0;
    let f = |t: f64| {
        if t > DELTA * DELTA * DELTA { libm::cbrt(t) } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let c = relative_xyz(rgb);
    let (fx, fy, fz) = (f(c.x), f(c.y), f(c.z));
    let lightness = 116.0 * fy - 16.0;
    let chroma = 0.01 * lightness;
    DVec3::new(lightness, chroma * 500.0 * (fx - fy), chroma * 200.0 * (fy - fz))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_opponent_space_round_trips() {
        for rgb in [DVec3::ZERO, DVec3::ONE, DVec3::new(0.2, 0.7, 0.1), DVec3::new(0.9, 0.0, 0.4)] {
            assert!((rgb_from_ycxcz(ycxcz_from_rgb(rgb)) - rgb).abs().max_element() < 1e-12);
        }
    }

    /// A difference under 0 to the limit at both ends and at the knee.
    #[test]
    fn redistribution_keeps_the_ends_and_the_knee() {
        assert_eq!(redistribute(0.0, 40.0), 0.0);
        assert!((redistribute(16.0, 40.0) - 0.95).abs() < 1e-12);
        assert!((redistribute(40.0, 40.0) - 1.0).abs() < 1e-12);
    }

    /// Constant pictures: no filter and no feature matters, FLIP is the redistributed colour difference. Black to
    /// white:
    /// |ΔL| = 100.
    #[test]
    fn constant_pictures_differ_by_their_colour() {
        let value = flip(&[Vec3::ZERO; 64], &[Vec3::ONE; 64], 8, 8, FLIP_PIXELS_PER_DEGREE);
        let expected = redistribute(libm::pow(100.0, 0.7), max_color_difference());
        assert!((value - expected).abs() < 1e-9, "{value} {expected}");
        assert_eq!(flip(&[Vec3::splat(0.3); 64], &[Vec3::splat(0.3); 64], 8, 8, 67.0), 0.0);
    }

    /// What a display cannot show does not count.
    #[test]
    fn clamps_to_the_display() {
        assert_eq!(flip(&[Vec3::splat(1.5); 9], &[Vec3::splat(9.0); 9], 3, 3, 67.0), 0.0);
        assert_eq!(flip(&[Vec3::NAN; 9], &[Vec3::splat(-1.0); 9], 3, 3, 67.0), 0.0);
    }
}
