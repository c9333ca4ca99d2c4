//! `--method`.

use clap::ValueEnum;
use lightmesh::{Method, PaperScale};

/// How light is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum MethodArg {
    /// Light mesh, six-axis directional
    Mesh,
    /// Light mesh as the paper writes it: one scalar per channel, sphere neighbourhood
    Paper,
    /// Shadow ray to every light sample at every hit
    Standard,
    /// Light mesh by single lights, and shadow rays to those about which it disagrees
    Hybrid,
    /// Light mesh as control variate of light sampling (--rays): converges to the exact picture
    Unbiased,
    /// Path tracer, the reference
    Path,
}

impl From<MethodArg> for Method {
    fn from(arg: MethodArg) -> Self {
        match arg {
            MethodArg::Mesh => Self::Mesh,
            MethodArg::Paper => Self::Paper,
            MethodArg::Standard => Self::Standard,
            MethodArg::Hybrid => Self::Hybrid,
            MethodArg::Unbiased => Self::Unbiased,
            MethodArg::Path => Self::Path,
        }
    }
}

/// The word for a method.
pub fn name(method: Method) -> &'static str {
    match method {
        Method::Mesh => "mesh",
        Method::Paper => "paper",
        Method::Standard => "standard",
        Method::Hybrid => "hybrid",
        Method::Unbiased => "unbiased",
        Method::Path => "path",
    }
}

/// How the paper's mean is scaled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PaperScaleArg {
    /// Divide by the same sum without visibility: a mean visibility in [0, 1]
    Visibility,
    /// Formulas as printed, times one constant for the picture
    Constant,
}

impl From<PaperScaleArg> for PaperScale {
    fn from(arg: PaperScaleArg) -> Self {
        match arg {
            PaperScaleArg::Visibility => Self::Visibility,
            PaperScaleArg::Constant => Self::Constant,
        }
    }
}
