//! How mesh points are combined.

use std::fmt;
use std::str::FromStr;

use super::Expected;

/// The neighbourhood D_y of formula (3g). Spelled `auto`, `trilinear`, `trilinear:RULE`, `sphere`, `sphere:R` or
/// `nearest`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Interpolation {
    /// Trilinear; for [`Method::Paper`](crate::Method::Paper) a sphere of 1.5 spacings.
    #[default]
    Auto,
    /// The eight corners of the cell half a spacing off the surface, trilinear weights; corners that are behind the
    /// surface, inside solids or hidden are left out, and the weights of the rest are normalised.
    Trilinear,
    /// The eight corners of the cell that the surface point itself is in, trilinear weights, and a rule for those that
    /// are missing (figs. 10-11 of the paper). What stands between a corner and the surface is not asked. It is for the
    /// direct light of [`Method::Paper`](crate::Method::Paper), and of [`Method::Mesh`](crate::Method::Mesh) without a
    /// bound on its error; indirect light is read as by [`Self::Trilinear`].
    TrilinearWith(MissingCorners),
    /// Every mesh point within `radius` spacings, weighted as [`MeshOptions::weight`](crate::MeshOptions::weight) says
    /// (figs. 7-9).
    Sphere {
        /// In spacings, > 0.
        radius: f32,
    },
    /// The nearest mesh point (figs. 4-6).
    Nearest,
}

/// What a corner counts as that is behind the surface's plane or, except with [`Method::Paper`](crate::Method::Paper),
/// inside a solid: figs. 10-11 of the paper. Ĩ is what the other corners say, s the part of the trilinear weight that
/// they have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MissingCorners {
    /// Visibility 0: s Ĩ. Edges are dark.
    Zero,
    /// Its weight goes to the corner nearest to the surface point, among those that are there.
    Nearest,
    /// Its weight goes to the corner at the other end of the cell's edge along the axis in which the normal is longest;
    /// where that is missing, too, as with [`Self::Nearest`].
    Mirror,
    /// Visibility 1: s Ĩ + (1 − s). Edges are bright.
    One,
}

impl MissingCorners {
    /// Each rule and its name.
    const NAMES: [(&'static str, Self); 4] =
        [("zero", Self::Zero), ("nearest", Self::Nearest), ("mirror", Self::Mirror), ("one", Self::One)];

    fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, rule)| *rule == self).map_or("", |(name, _)| name)
    }
}

impl Interpolation {
    /// Radius of the sphere where none is said, in spacings.
    pub const DEFAULT_RADIUS: f32 = 1.5;

    pub(super) const EXPECTED: &'static str = "auto, trilinear, trilinear:zero, trilinear:nearest, trilinear:mirror, \
                                               trilinear:one, nearest, sphere, or sphere:R with R above 0 and at most 16 \
                                               spacings";
}

impl FromStr for Interpolation {
    type Err = Expected;

    fn from_str(text: &str) -> Result<Self, Expected> {
        let interpolation = match text {
            "auto" => Some(Self::Auto),
            "trilinear" => Some(Self::Trilinear),
            "nearest" => Some(Self::Nearest),
            "sphere" => Some(Self::Sphere { radius: Self::DEFAULT_RADIUS }),
            _ => match text.split_once(':') {
                Some(("trilinear", rule)) => MissingCorners::NAMES
                    .iter()
                    .find(|(name, _)| *name == rule)
                    .map(|&(_, rule)| Self::TrilinearWith(rule)),
                Some(("sphere", radius)) => {
                    let radius = radius.parse().ok().filter(|r: &f32| *r > 0.0 && *r <= 16.0);
                    radius.map(|radius| Self::Sphere { radius })
                }
                _ => None,
            },
        };
        interpolation.ok_or(Expected(Self::EXPECTED))
    }
}

impl fmt::Display for Interpolation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Trilinear => f.write_str("trilinear"),
            Self::TrilinearWith(rule) => write!(f, "trilinear:{}", rule.name()),
            Self::Sphere { radius } => write!(f, "sphere:{radius}"),
            Self::Nearest => f.write_str("nearest"),
        }
    }
}

/// Weights of the mesh points in a sphere: φ4 of formula (3g) for direct light and φ5 of (6) for indirect light. Means
/// are over weights: Ĩ(y) = Σ φ(x_i, y) DirectLight(x_i) / Σ φ(x_i, y). The paper has 1; others are among its future
/// work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PointWeight {
    /// 1.
    #[default]
    Constant,
    /// exp(−d² / (2 (R/2)²)), d the distance of the point from the surface point and R the sphere's radius: e⁻² at its
    /// edge.
    Gaussian,
    /// 1 / max(d, 0.1), d in spacings.
    Inverse,
    /// n·(x − y) / |x − y|, n the geometric normal: points straight above count, those along the surface hardly.
    Cosine,
}

impl PointWeight {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Constant, Self::Gaussian, Self::Inverse, Self::Cosine];

    /// The name of each, in the order of [`Self::ALL`], and one line about it.
    pub(super) const NAMES: [(&'static str, &'static str); 4] = [
        ("constant", "All the same"),
        ("gaussian", "exp(-d²/(2(R/2)²)), d the distance from the surface point"),
        ("inverse", "1/d, d at least 0.1 spacings"),
        ("cosine", "Cosine of the angle to the surface's normal"),
    ];

    /// Returns its name, as both faces spell it.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize].0
    }

    /// Returns the weight of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|weight| weight.name() == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolations_are_read_as_they_are_spelled() {
        let rules = MissingCorners::NAMES.map(|(_, rule)| Interpolation::TrilinearWith(rule));
        let others = [
            Interpolation::Auto,
            Interpolation::Trilinear,
            Interpolation::Nearest,
            Interpolation::Sphere { radius: 2.25 },
        ];
        for interpolation in rules.into_iter().chain(others) {
            assert_eq!(interpolation.to_string().parse(), Ok(interpolation));
        }
        assert_eq!("sphere".parse(), Ok(Interpolation::Sphere { radius: 1.5 }));
        for bad in [
            "",
            "cubic",
            "sphere:",
            "sphere:0",
            "sphere:-1",
            "sphere:17",
            "sphere:nan",
            "Sphere",
            "trilinear:",
            "trilinear:two",
            "trilinear:Zero",
            "trilinear:1",
            "nearest:zero",
        ] {
            assert!(bad.parse::<Interpolation>().is_err(), "{bad}");
        }
    }

    #[test]
    fn weights_are_found_again() {
        for weight in PointWeight::ALL {
            assert_eq!(PointWeight::named(weight.name()), Some(weight));
        }
        assert_eq!(PointWeight::named("gauss"), None);
    }
}
