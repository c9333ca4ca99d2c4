//! A point sequence that fills the unit cube evenly, so that the first N points are spread well for every N.

/// Point `i` of the R3 sequence (M. Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018):
/// the fractional parts of `1/2 + (i + 1) / gᵏ`, k = 1, 2, 3, where g is the positive root of g⁴ = g + 1.
pub(crate) fn r3(i: u32) -> [f64; 3] {
    const G: f64 = 1.220_744_084_605_759_6;
    let n = f64::from(i) + 1.0;
    [1.0 / G, 1.0 / (G * G), 1.0 / (G * G * G)].map(|step| (0.5 + n * step) % 1.0)
}
