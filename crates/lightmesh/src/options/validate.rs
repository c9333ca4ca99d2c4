//! The checks of options: each against its range in the table, and those of several together.

use super::{Interpolation, PointWeight, RenderOptions, schema};
use crate::Error;

impl RenderOptions {
    /// Checks every option against its range, and those that do not go together.
    ///
    /// # Errors
    /// [`Error::InvalidOption`] names the first option outside its range.
    pub fn validate(&self) -> Result<(), Error> {
        let bad = |option, what: &str| Err(Error::InvalidOption { option, what: what.into() });
        schema::RENDER.iter().try_for_each(|entry| entry.check(self))?;
        let interpolation = self.resolved().interpolation;

        // Finer levels are for meshes that are read trilinear.
        let refined = self.mesh.refine.is_some_and(|times| times > 0).then_some("refine");
        if let Some(option) = refined.or(self.mesh.lod_distance.map(|_| "lod-distance")) {
            if !self.method.has_mesh() {
                return bad(option, "is for methods that have a mesh");
            }
            if interpolation != Interpolation::Trilinear {
                return bad("interpolation", "must be trilinear, without a rule, where meshes are refined");
            }
        }

        // Weights are for spheres, and single lights are not read from them.
        if self.mesh.weight != PointWeight::Constant && !matches!(interpolation, Interpolation::Sphere { .. }) {
            return bad("weight", "is for points in a sphere: choose the interpolation sphere:R");
        }
        if self.method.knows_lights()
            && matches!(interpolation, Interpolation::Sphere { .. } | Interpolation::TrilinearWith(_))
        {
            return bad(
                "interpolation",
                "single lights (the methods hybrid and unbiased, and an error bound) are read trilinear, without a \
                 rule, or nearest",
            );
        }

        // Layers that show the mesh need one.
        match self.picture.aovs.iter().find(|aov| !aov.is_known_to(self.method)) {
            Some(aov) => Err(Error::InvalidOption {
                option: "aov",
                what: format!("{} shows the light mesh, which the methods standard and path do not have", aov.name()),
            }),
            None => Ok(()),
        }
    }
}
