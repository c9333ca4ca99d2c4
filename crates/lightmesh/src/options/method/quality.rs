//! How good a picture is to be, in words.

use super::Method;

/// Three errors by name: a part of the picture's mean, as of [`Method::with_error`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// 10%: to see where the lamps should be.
    Preview,
    /// 5%.
    #[default]
    Normal,
    /// 2%: for a picture that is looked at for long.
    Final,
}

impl Quality {
    /// All of them, the coarsest first.
    pub const ALL: [Self; 3] = [Self::Preview, Self::Normal, Self::Final];

    /// The name of each, as both faces spell it, and one line about it.
    pub(in crate::options) const NAMES: [(&str, &str); 3] = [
        ("preview", "An error of 10% of the picture's mean, up to 16 samples per pixel, denoised if it can be"),
        ("normal", "5%"),
        ("final", "2%"),
    ];

    /// Returns the error that it stands for, relative to the picture's mean.
    pub fn error(self) -> f32 {
        match self {
            Self::Preview => 0.1,
            Self::Normal => 0.05,
            Self::Final => 0.02,
        }
    }

    /// Returns its name.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize].0
    }

    /// Returns the quality of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|quality| quality.name() == name)
    }

    /// Returns the quality of a method, where its error is that of one.
    pub fn of(method: Method) -> Option<Self> {
        Self::ALL.into_iter().find(|quality| method.error() == Some(quality.error()))
    }
}

/// Samples and short rays of a pixel, where nothing is said of them.
#[derive(Clone, Copy, Debug)]
pub(in crate::options) struct SamplesOfPixel {
    pub spp: u32,
    /// The most of a pixel with noise.
    pub most_spp: u32,
    pub near_rays: u32,
}

impl SamplesOfPixel {
    /// Returns those that go with a method and its error.
    pub(in crate::options) fn of(method: Method) -> Self {
        match method.error() {
            // Noise may be more than what other samples cost.
            Some(error) if error >= Quality::Preview.error() => Self { spp: 2, most_spp: 16, near_rays: 8 },
            _ => Self { spp: 4, most_spp: 64, near_rays: 16 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_errors_are_found_again() {
        for quality in Quality::ALL {
            assert_eq!(Quality::named(quality.name()), Some(quality));
            assert_eq!(Quality::of(Method::with_error(quality.error())), Some(quality));
        }
        assert_eq!((Quality::named("best"), Quality::of(Method::with_error(0.03))), (None, None));
    }
}
