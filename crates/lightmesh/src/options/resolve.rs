//! What `auto`, and options that are not given, stand for: the one place that decides it.

use super::{Interpolation, RenderOptions, Spacing};

/// Options of the meshes with nothing left open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ResolvedMesh {
    /// Never [`Spacing::Auto`].
    pub spacing: Spacing,
    /// Never [`Spacing::Auto`].
    pub indirect_spacing: Spacing,
    /// Never [`Interpolation::Auto`].
    pub interpolation: Interpolation,
    /// How often meshes may be refined where their light is not good enough.
    pub refinements: u32,
    /// Levels of the meshes beyond the first, by the distance from the eye as well.
    pub finer_levels: u32,
}

impl RenderOptions {
    /// Levels beyond the first of meshes whose density falls with the distance: from near to far 8, 4, 2 and 1 points
    /// along an edge.
    const DISTANCE_LEVELS: u32 = 3;

    /// Returns the options of the meshes with nothing left open.
    pub(crate) fn resolved(&self) -> ResolvedMesh {
        let spacing = |spacing, auto| if spacing == Spacing::Auto { Spacing::Fraction(auto) } else { spacing };
        let refinements = self.mesh.refine.unwrap_or(0);
        ResolvedMesh {
            spacing: spacing(self.mesh.spacing, Spacing::AUTO),
            indirect_spacing: spacing(self.mesh.indirect_spacing, Spacing::AUTO_INDIRECT),
            interpolation: match self.mesh.interpolation {
                Interpolation::Auto if self.method.is_paper() => {
                    Interpolation::Sphere { radius: Interpolation::DEFAULT_RADIUS }
                }
                Interpolation::Auto => Interpolation::Trilinear,
                said => said,
            },
            refinements,
            finer_levels: refinements.max(if self.mesh.lod_distance.is_some() { Self::DISTANCE_LEVELS } else { 0 }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Method;

    #[test]
    fn auto_depends_on_the_method_and_its_error() {
        let resolved = |method| RenderOptions { method, ..RenderOptions::default() }.resolved();
        assert_eq!(resolved(Method::MESH).interpolation, Interpolation::Trilinear);
        assert_eq!(resolved(Method::PAPER).interpolation, Interpolation::Sphere { radius: 1.5 });
        let (free, bounded) = (resolved(Method::MESH), resolved(Method::with_error(0.05)));
        assert_eq!((free.spacing, free.indirect_spacing), (Spacing::Fraction(64.0), Spacing::Fraction(30.0)));
        assert_eq!((free, free.refinements), (bounded, 0));
        let near = RenderOptions::default().with(|o| o.mesh.lod_distance = Some(2.0)).resolved();
        assert_eq!((near.refinements, near.finer_levels), (0, 3));
    }
}
