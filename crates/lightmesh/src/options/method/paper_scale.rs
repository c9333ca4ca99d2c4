//! How the paper's mean is scaled.

/// How Ĩ of the paper's method is scaled: (2) × (3) is an energy squared (docs/paper.md).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PaperScale {
    /// Divide sum (1) by the same sum without V_i, both over the neighbourhood: Ĩ is a mean visibility in [0, 1].
    /// Points inside solids are left out, and spheres stand 0.6 spacings off the surface: what is next to a point on a
    /// wall is mostly wall.
    #[default]
    Visibility,
    /// Formulas as printed, every point counting, in a sphere about the surface point itself, times one constant for
    /// the whole scene: one over the mean of Σ E_i / φ1, without V_i, over a regular grid of 8³ places in the scene's
    /// box and over the channels. Ĩ is then 1 on average where nothing is hidden.
    Constant,
}

impl PaperScale {
    /// The name of each, and one line about it.
    pub(in crate::options) const NAMES: [(&'static str, &'static str); 2] = [
        ("visibility", "Divide by the same sum without visibility: a mean visibility in [0, 1]"),
        ("constant", "Formulas as printed, times one constant for the picture"),
    ];

    /// Returns its name, as both faces spell it.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize].0
    }

    /// Returns the scale of that name.
    pub fn named(name: &str) -> Option<Self> {
        [Self::Visibility, Self::Constant].into_iter().find(|scale| scale.name() == name)
    }
}
