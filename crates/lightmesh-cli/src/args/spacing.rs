//! `--spacing`.

use lightmesh::Spacing;

/// Parses metres, `1/K` or `auto`.
pub(crate) fn parse(text: &str) -> Result<Spacing, String> {
    let positive = |text: &str| text.trim().parse().ok().filter(|x: &f32| *x > 0.0 && x.is_finite());
    let spacing = if text == "auto" {
        Some(Spacing::Auto)
    } else if let Some(k) = text.strip_prefix("1/") {
        positive(k).map(Spacing::Fraction)
    } else {
        positive(text).map(Spacing::Metres)
    };
    spacing.ok_or_else(|| "the spacing is metres above 0, 1/K of the scene's longest edge, or auto".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metres_fractions_and_auto() {
        assert_eq!(parse("0.25"), Ok(Spacing::Metres(0.25)));
        assert_eq!(parse("1e-9"), Ok(Spacing::Metres(1e-9)));
        assert_eq!(parse("1/80"), Ok(Spacing::Fraction(80.0)));
        assert_eq!(parse("auto"), Ok(Spacing::Auto));
        for bad in ["", "-1", "0", "1/0", "1/-4", "2/80", "nan", "inf", "1/nan", "1e-60", "5m"] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }
}
