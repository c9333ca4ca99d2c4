//! `--falloff` and `--field-falloff`: φ3 and φ1 of the paper.

use lightmesh::Falloff;

/// Parses `r2` or `C+r`.
pub(crate) fn parse(text: &str) -> Result<Falloff, String> {
    if text == "r2" {
        return Ok(Falloff::InverseSquare);
    }
    let constant = text.strip_suffix("+r").and_then(|c| c.trim().parse().ok());
    match constant.filter(|c: &f32| *c >= 0.0 && c.is_finite()) {
        Some(constant) => Ok(Falloff::ConstantPlusDistance { constant }),
        None => Err("expected r2, or C+r with C in metres, 0 or more, as in 0.1+r".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn physical_or_the_papers() {
        assert_eq!(parse("r2"), Ok(Falloff::InverseSquare));
        assert_eq!(parse("0.1+r"), Ok(Falloff::ConstantPlusDistance { constant: 0.1 }));
        assert_eq!(parse("0+r"), Ok(Falloff::ConstantPlusDistance { constant: 0.0 }));
        for bad in ["", "r", "+r", "-1+r", "nan+r", "inf+r", "r+1", "r3"] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }
}
