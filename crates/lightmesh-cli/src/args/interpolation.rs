//! `--interpolation`.

use lightmesh::Interpolation;

/// Parses `auto`, `trilinear`, `sphere`, `sphere:R` or `nearest`.
pub(crate) fn parse(text: &str) -> Result<Interpolation, String> {
    match text {
        "auto" => return Ok(Interpolation::Auto),
        "trilinear" => return Ok(Interpolation::Trilinear),
        "nearest" => return Ok(Interpolation::Nearest),
        "sphere" => return Ok(Interpolation::Sphere { radius: Interpolation::DEFAULT_RADIUS }),
        _ => {}
    }
    let radius = text.strip_prefix("sphere:").and_then(|r| r.parse().ok());
    match radius.filter(|r: &f32| *r > 0.0 && *r <= 16.0) {
        Some(radius) => Ok(Interpolation::Sphere { radius }),
        None => {
            Err("expected auto, trilinear, nearest, sphere or sphere:R with R above 0 and at most 16 spacings"
                .to_owned())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn auto_or_one_of_the_three_neighbourhoods() {
        assert_eq!(parse("auto"), Ok(Interpolation::Auto));
        assert_eq!(parse("trilinear"), Ok(Interpolation::Trilinear));
        assert_eq!(parse("nearest"), Ok(Interpolation::Nearest));
        assert_eq!(parse("sphere"), Ok(Interpolation::Sphere { radius: 1.5 }));
        assert_eq!(parse("sphere:2.25"), Ok(Interpolation::Sphere { radius: 2.25 }));
        for bad in ["", "cubic", "sphere:", "sphere:0", "sphere:-1", "sphere:17", "sphere:nan", "Sphere"] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }
}
