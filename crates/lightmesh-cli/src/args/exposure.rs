//! `--exposure`.

use lightmesh::Image;
use lightmesh_io::output::exposure_of;

/// The exposure of a PNG.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// Chosen from the picture.
    Auto,
    /// Luminance times 2 to this power.
    Ev(f32),
}

impl Exposure {
    /// The exposure of this picture, in EV.
    pub fn for_picture(self, picture: &Image) -> f32 {
        match self {
            Self::Auto => exposure_of(picture),
            Self::Ev(ev) => ev,
        }
    }
}

/// Parses a number between −64 and 64, or `auto`.
///
/// # Errors
/// What is expected, for any other text.
pub fn parse(text: &str) -> Result<Exposure, String> {
    if text == "auto" {
        return Ok(Exposure::Auto);
    }
    match text.parse().ok().filter(|ev: &f32| ev.abs() <= 64.0) {
        Some(ev) => Ok(Exposure::Ev(ev)),
        None => Err("the exposure is auto or a number of EV between -64 and 64".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn auto_or_ev() {
        assert_eq!(parse("auto"), Ok(Exposure::Auto));
        assert_eq!(parse("-6.5"), Ok(Exposure::Ev(-6.5)));
        for bad in ["", "bright", "nan", "inf", "100"] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }
}
