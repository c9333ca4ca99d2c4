//! Light from all sides, as a user asks for it.

use std::fmt;
use std::path::{Path, PathBuf};

use glam::Vec3;
use lightmesh_io::output::linear_from_srgb;

/// Light from all sides, as a user asks for it: a file, `R,G,B` (linear), `#rrggbb` (sRGB) or `black`.
#[derive(Clone, Debug, PartialEq)]
pub enum EnvironmentArg {
    /// A latitude-longitude map.
    File(PathBuf),
    /// One colour in every direction, linear.
    Color(Vec3),
}

pub(super) const EXPECTED: &str = "a .hdr or .exr file, R,G,B of linear numbers from 0 on, #rrggbb, or black";

impl EnvironmentArg {
    /// Parses a file name, `R,G,B`, `#rrggbb` or `black`; `None` for any other text.
    pub fn parse(text: &str) -> Option<Self> {
        let is_map = |e: &std::ffi::OsStr| e.eq_ignore_ascii_case("hdr") || e.eq_ignore_ascii_case("exr");
        if Path::new(text).extension().is_some_and(is_map) {
            return Some(Self::File(text.into()));
        }
        let black = (text == "black").then_some(Vec3::ZERO);
        black.or_else(|| hex(text)).or_else(|| triple(text)).map(Self::Color)
    }
}

impl fmt::Display for EnvironmentArg {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path) => write!(f, "{}", path.display()),
            Self::Color(c) => write!(f, "{},{},{}", c.x, c.y, c.z),
        }
    }
}

/// `#rrggbb`, sRGB.
fn hex(text: &str) -> Option<Vec3> {
    let digits = text.strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()))?;
    let [_, r, g, b] = u32::from_str_radix(digits, 16).ok()?.to_be_bytes();
    Some(Vec3::from_array([r, g, b].map(|c| linear_from_srgb(f32::from(c) / 255.0))))
}

/// `R,G,B`, linear.
fn triple(text: &str) -> Option<Vec3> {
    let number = |text: &str| text.trim().parse().ok().filter(|x: &f32| *x >= 0.0 && x.is_finite());
    let numbers: Option<Vec<f32>> = text.split(',').map(number).collect();
    <[f32; 3]>::try_from(numbers?).ok().map(Vec3::from_array)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_and_colours() {
        let parse = EnvironmentArg::parse;
        assert_eq!(parse("a/sky.HDR"), Some(EnvironmentArg::File("a/sky.HDR".into())));
        assert_eq!(parse("1,2.hdr"), Some(EnvironmentArg::File("1,2.hdr".into())));
        assert_eq!(parse("0.5, 1e3,0"), Some(EnvironmentArg::Color(Vec3::new(0.5, 1000.0, 0.0))));
        assert_eq!(parse("#ff0000"), Some(EnvironmentArg::Color(Vec3::X)));
        assert_eq!(parse("black"), Some(EnvironmentArg::Color(Vec3::ZERO)));
        let Some(EnvironmentArg::Color(grey)) = parse("#bcBCbc") else { panic!("a colour") };
        assert!((grey - 0.502_886).abs().max_element() < 1e-4, "{grey}");
        assert_eq!(parse(&EnvironmentArg::Color(grey).to_string()), Some(EnvironmentArg::Color(grey)));
        for bad in
            ["", "sky", "sky.png", "1", "1,2", "1,2,3,4", "1,-2,3", "nan,1,1", "inf,1,1", "#fff", "#ff00gg", "#+ff00f"]
        {
            assert_eq!(parse(bad), None, "{bad}");
        }
    }
}
