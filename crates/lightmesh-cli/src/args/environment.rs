//! `--environment`.

use std::path::{Path, PathBuf};

use glam::Vec3;
use lightmesh_io::output::linear_from_srgb;

/// Light from all sides as the command line asks for it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum EnvironmentArg {
    /// A latitude-longitude map.
    File(PathBuf),
    /// One colour in every direction, linear.
    Color(Vec3),
}

/// Parses a file name, `R,G,B` or `#rrggbb`.
pub(crate) fn parse(text: &str) -> Result<EnvironmentArg, String> {
    let is_map = |e: &std::ffi::OsStr| e.eq_ignore_ascii_case("hdr") || e.eq_ignore_ascii_case("exr");
    if Path::new(text).extension().is_some_and(is_map) {
        return Ok(EnvironmentArg::File(text.into()));
    }
    hex(text)
        .or_else(|| triple(text))
        .map(EnvironmentArg::Color)
        .ok_or_else(|| "expected a .hdr or .exr file, R,G,B of linear numbers from 0 on, or #rrggbb".to_owned())
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
        assert_eq!(parse("a/sky.HDR"), Ok(EnvironmentArg::File("a/sky.HDR".into())));
        assert_eq!(parse("1,2.hdr"), Ok(EnvironmentArg::File("1,2.hdr".into())));
        assert_eq!(parse("0.5, 1e3,0"), Ok(EnvironmentArg::Color(Vec3::new(0.5, 1000.0, 0.0))));
        assert_eq!(parse("#ff0000"), Ok(EnvironmentArg::Color(Vec3::X)));
        let Ok(EnvironmentArg::Color(grey)) = parse("#bcBCbc") else { panic!("a colour") };
        assert!((grey - 0.502_886).abs().max_element() < 1e-4, "{grey}");
        for bad in
            ["", "sky", "sky.png", "1", "1,2", "1,2,3,4", "1,-2,3", "nan,1,1", "inf,1,1", "#fff", "#ff00gg", "#+ff00f"]
        {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }
}
