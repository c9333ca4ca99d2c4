//! `--interpolation`.

use lightmesh::{Interpolation, MissingCorners};

/// The rules that `trilinear:RULE` may name.
const RULES: [(&str, MissingCorners); 4] = [
    ("zero", MissingCorners::Zero),
    ("nearest", MissingCorners::Nearest),
    ("mirror", MissingCorners::Mirror),
    ("one", MissingCorners::One),
];

/// Parses `auto`, `trilinear`, `trilinear:RULE`, `sphere`, `sphere:R` or `nearest`.
pub(crate) fn parse(text: &str) -> Result<Interpolation, String> {
    match text {
        "auto" => return Ok(Interpolation::Auto),
        "trilinear" => return Ok(Interpolation::Trilinear),
        "nearest" => return Ok(Interpolation::Nearest),
        "sphere" => return Ok(Interpolation::Sphere { radius: Interpolation::DEFAULT_RADIUS }),
        _ => {}
    }
    if let Some(name) = text.strip_prefix("trilinear:") {
        let rule = RULES.iter().find(|(rule, _)| *rule == name);
        return rule
            .map(|&(_, rule)| Interpolation::TrilinearWith(rule))
            .ok_or_else(|| "expected trilinear:zero, trilinear:nearest, trilinear:mirror or trilinear:one".to_owned());
    }
    let radius = text.strip_prefix("sphere:").and_then(|r| r.parse().ok());
    match radius.filter(|r: &f32| *r > 0.0 && *r <= 16.0) {
        Some(radius) => Ok(Interpolation::Sphere { radius }),
        None => {
            Err("expected auto, trilinear, trilinear:RULE, nearest, sphere or sphere:R with R above 0 and at most 16 \
                 spacings"
                .to_owned())
        }
    }
}

/// Spells an interpolation as [`parse`] reads it.
pub(crate) fn spell(interpolation: Interpolation) -> String {
    match interpolation {
        Interpolation::Auto => "auto".to_owned(),
        Interpolation::Trilinear => "trilinear".to_owned(),
        Interpolation::TrilinearWith(rule) => {
            let name = RULES.iter().find(|(_, of)| *of == rule).map_or("", |(name, _)| name);
            format!("trilinear:{name}")
        }
        Interpolation::Sphere { radius } => format!("sphere:{radius}"),
        Interpolation::Nearest => "nearest".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_read_as_they_are_spelled() {
        for (name, rule) in RULES {
            let text = format!("trilinear:{name}");
            assert_eq!(parse(&text), Ok(Interpolation::TrilinearWith(rule)));
            assert_eq!(spell(Interpolation::TrilinearWith(rule)), text);
        }
        for bad in ["trilinear:", "trilinear:two", "trilinear:Zero", "trilinear:1", "nearest:zero"] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }

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
