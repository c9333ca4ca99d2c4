//! Attenuation with distance.

use std::fmt;
use std::str::FromStr;

use super::Expected;

/// Attenuation with distance: φ1 and φ3 of the paper. Spelled `r2` or `C+r`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Falloff {
    /// r², physical.
    #[default]
    InverseSquare,
    /// The paper's Const + r; `constant` in metres, ≥ 0.
    ConstantPlusDistance {
        /// Metres.
        constant: f32,
    },
}

impl Falloff {
    pub(super) const EXPECTED: &'static str = "r2, or C+r with C in metres, 0 or more, as in 0.1+r";
}

impl FromStr for Falloff {
    type Err = Expected;

    fn from_str(text: &str) -> Result<Self, Expected> {
        if text == "r2" {
            return Ok(Self::InverseSquare);
        }
        let constant = text.strip_suffix("+r").and_then(|c| c.trim().parse().ok());
        let constant = constant.filter(|c: &f32| *c >= 0.0 && c.is_finite());
        constant.map(|constant| Self::ConstantPlusDistance { constant }).ok_or(Expected(Self::EXPECTED))
    }
}

impl fmt::Display for Falloff {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::InverseSquare => f.write_str("r2"),
            Self::ConstantPlusDistance { constant } => write!(f, "{constant}+r"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn physical_or_the_papers() {
        for (text, falloff) in [
            ("r2", Falloff::InverseSquare),
            ("0.1+r", Falloff::ConstantPlusDistance { constant: 0.1 }),
            ("0+r", Falloff::ConstantPlusDistance { constant: 0.0 }),
        ] {
            assert_eq!(text.parse(), Ok(falloff));
            assert_eq!(falloff.to_string(), text);
        }
        for bad in ["", "r", "+r", "-1+r", "nan+r", "inf+r", "r+1", "r3"] {
            assert!(bad.parse::<Falloff>().is_err(), "{bad}");
        }
    }
}
