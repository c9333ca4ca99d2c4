//! Numbers that a careless reader trips over.

use fastrand::Rng;

/// Single-precision numbers: the ends of the range, what is no number, and numbers whose products overflow or vanish.
const FLOATS: [f32; 24] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    1e-45,
    1.2e-38,
    1e-30,
    1e-20,
    1e-10,
    1e-6,
    1e6,
    1.7e7,
    1e10,
    1.8e19,
    1.9e19,
    1e30,
    3e38,
    f32::MAX,
    f32::MIN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    -1e25,
];

/// Whole numbers at the ends of the types' ranges.
const WHOLE: [u64; 20] = [
    0,
    1,
    2,
    3,
    4,
    7,
    127,
    128,
    255,
    256,
    32_767,
    65_535,
    65_536,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_fffe,
    0xffff_ffff,
    0x1_0000_0000,
    i64::MAX as u64,
    u64::MAX,
];

/// Numbers as text: also what parsers differ about.
const TEXTS: [&str; 30] = [
    "0",
    "-0",
    "-1",
    "1",
    "2",
    "3",
    "1e38",
    "3.5e38",
    "-1e39",
    "1e-46",
    "1e308",
    "1e309",
    "-1e999",
    "1e-999",
    "nan",
    "NaN",
    "inf",
    "-inf",
    "Infinity",
    "0x10",
    "1.",
    ".5",
    "+1",
    "1e",
    "4294967295",
    "4294967296",
    "-2147483649",
    "18446744073709551615",
    "18446744073709551616",
    "99999999999999999999999999999999999999999",
];

/// A float, every fourth time any bits at all.
pub(super) fn float(rng: &mut Rng) -> f32 {
    match rng.u8(0..8) {
        0 => f32::from_bits(rng.u32(..)),
        1 => rng.f32() * 2.0 - 1.0,
        _ => FLOATS[rng.usize(0..FLOATS.len())],
    }
}

/// The same in double precision, and what overflows single precision.
pub(super) fn double(rng: &mut Rng) -> f64 {
    match rng.u8(0..8) {
        0 => f64::from_bits(rng.u64(..)),
        1 => f64::MAX,
        2 => 1e39,
        _ => f64::from(float(rng)),
    }
}

/// A whole number: at an end of a range, small, or any.
pub(super) fn whole(rng: &mut Rng) -> u64 {
    match rng.u8(0..8) {
        0 => rng.u64(..),
        1 => u64::from(rng.u32(..)),
        2 | 3 => rng.u64(0..12),
        _ => WHOLE[rng.usize(0..WHOLE.len())],
    }
}

/// A number as text.
pub(super) fn text(rng: &mut Rng) -> String {
    match rng.u8(0..8) {
        0 => whole(rng).to_string(),
        1 => float(rng).to_string(),
        2 => format!("{:e}", float(rng)),
        3 => rng.i32(-3..20).to_string(),
        _ => TEXTS[rng.usize(0..TEXTS.len())].to_owned(),
    }
}
