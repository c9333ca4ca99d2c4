//! `--weight`.

use clap::ValueEnum;
use lightmesh::PointWeight;

/// `--weight`; the words are those of the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum WeightArg {
    /// All the same
    Constant,
    /// exp(-d²/(2(R/2)²)), d the distance from the surface point
    Gaussian,
    /// 1/d, d at least 0.1 spacings
    Inverse,
    /// Cosine of the angle to the surface's normal
    Cosine,
}

impl From<WeightArg> for PointWeight {
    fn from(weight: WeightArg) -> Self {
        match weight {
            WeightArg::Constant => Self::Constant,
            WeightArg::Gaussian => Self::Gaussian,
            WeightArg::Inverse => Self::Inverse,
            WeightArg::Cosine => Self::Cosine,
        }
    }
}

/// The word of the command line.
pub(crate) fn name(weight: PointWeight) -> &'static str {
    match weight {
        PointWeight::Constant => "constant",
        PointWeight::Gaussian => "gaussian",
        PointWeight::Inverse => "inverse",
        PointWeight::Cosine => "cosine",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_read_as_they_are_spelled() {
        for &arg in WeightArg::value_variants() {
            assert_eq!(WeightArg::from_str(name(arg.into()), false), Ok(arg));
        }
        for bad in ["", "gauss", "Constant", "1"] {
            assert!(WeightArg::from_str(bad, false).is_err(), "{bad}");
        }
    }
}
