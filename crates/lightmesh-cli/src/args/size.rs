//! `--size`.

/// Width and height of a picture, pixels, each at least 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

/// Parses `WIDTHxHEIGHT`.
pub(crate) fn parse(text: &str) -> Result<Size, String> {
    let side = |text: &str| text.parse().ok().filter(|&n: &u32| n > 0);
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some((side(w)?, side(h)?)));
    let (width, height) = sides.ok_or("expected WIDTHxHEIGHT, whole pixels above 0, as in 1280x720")?;
    Ok(Size { width, height })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_numbers_above_zero() {
        assert_eq!(parse("640x360"), Ok(Size { width: 640, height: 360 }));
        assert_eq!(parse("1X1"), Ok(Size { width: 1, height: 1 }));
        for bad in ["", "640", "0x10", "10x0", "-4x4", "4x4x4", "x", "1.5x2", "5000000000x1"] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }
}
