//! Fingerprints: they tell whether a stored light mesh belongs to a scene and its settings.

mod digest;
mod scene;

use std::fmt;
use std::str::FromStr;

use digest::Digest;

use crate::options::PointKind;
use crate::{Falloff, Interpolation, MeshKey, MissingCorners, PaperScale, PointWeight, RenderOptions, Scene, Spacing};

/// Increased whenever mesh points get other values, so that meshes of older versions are not mistaken for this one's.
const VALUES_VERSION: u64 = 1;

/// 128 bits that tell scenes, or settings, from each other: the same on every machine and in every run. They are not
/// cryptographic.
///
/// Written as 32 hexadecimal digits; [`FromStr`] reads them back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Fingerprint(pub u128);

impl Fingerprint {
    /// Returns the fingerprint of everything in a scene that light depends on: surfaces and their transforms,
    /// materials, textures, lights, the environment, and how emitters become light samples; not of cameras and names.
    /// Of a user-defined shape it has the box and the `Debug` text. It takes about a second for two gigabytes of
    /// vertices and texels.
    pub fn of_scene(scene: &Scene) -> Self {
        scene::fingerprint(scene)
    }

    /// Returns the fingerprint of a text that describes something else.
    pub fn of_text(text: &str) -> Self {
        let mut digest = Digest::new("text");
        digest.text(text);
        digest.finish()
    }

    /// Returns the fingerprint of the settings that values of mesh points depend on, their [`MeshKey`]. `hybrid` and
    /// `unbiased` have the same points. The number of bounces is not part of it; [`Snapshot`](crate::Snapshot) tells
    /// it.
    pub fn of_settings(options: &RenderOptions) -> Self {
        Self::of_key(&MeshKey::of(options))
    }

    /// Returns the fingerprint of a mesh's key.
    pub fn of_key(key: &MeshKey) -> Self {
        let mut digest = Digest::new("lightmesh settings");
        // What direct values are, and how light attenuates in them.
        digest.number(VALUES_VERSION);
        digest.number(match key.kind {
            PointKind::SixAxis => 0,
            PointKind::ByLight => 1,
            PointKind::Scalar { .. } => 2,
        });
        digest.number(u64::from(key.error_bound));
        add_falloff(&mut digest, key.falloff);
        if let PointKind::Scalar { field_falloff, scale } = key.kind {
            add_falloff(&mut digest, field_falloff);
            digest.number(match scale {
                PaperScale::Visibility => 0,
                PaperScale::Constant => 1,
            });
        }
        // Where points are, and how they are combined.
        add_spacing(&mut digest, key.spacing);
        add_spacing(&mut digest, key.indirect_spacing);
        match key.interpolation {
            Interpolation::Auto | Interpolation::Trilinear => digest.number(0),
            Interpolation::TrilinearWith(rule) => {
                digest.number(1);
                digest.number(match rule {
                    MissingCorners::Zero => 0,
                    MissingCorners::Nearest => 1,
                    MissingCorners::Mirror => 2,
                    MissingCorners::One => 3,
                });
            }
            Interpolation::Sphere { radius } => {
                digest.number(2);
                digest.floats([radius]);
            }
            Interpolation::Nearest => digest.number(3),
        }
        digest.number(match key.weight {
            PointWeight::Constant => 0,
            PointWeight::Gaussian => 1,
            PointWeight::Inverse => 2,
            PointWeight::Cosine => 3,
        });
        // How indirect values are gathered.
        digest.number(u64::from(key.finer_levels));
        digest.floats([key.light_error]);
        digest.number(u64::from(key.gather_rays.unwrap_or(RenderOptions::GATHER_RAYS)));
        digest.number(u64::from(key.depth));
        digest.number(key.seed);
        digest.finish()
    }
}

fn add_falloff(digest: &mut Digest, falloff: Falloff) {
    match falloff {
        Falloff::InverseSquare => digest.number(0),
        Falloff::ConstantPlusDistance { constant } => {
            digest.number(1);
            digest.floats([constant]);
        }
    }
}

pub(crate) fn add_spacing(digest: &mut Digest, spacing: Spacing) {
    let (kind, x) = match spacing {
        Spacing::Auto => (0, 0.0),
        Spacing::Fraction(k) => (1, k),
        Spacing::Metres(h) => (2, h),
    };
    digest.number(kind);
    digest.floats([x]);
}

impl fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

impl FromStr for Fingerprint {
    type Err = std::num::ParseIntError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        u128::from_str_radix(text, 16).map(Self)
    }
}

#[cfg(test)]
mod tests;
