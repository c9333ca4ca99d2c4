//! The light mesh: illumination at points of a lattice in space, computed when a surface first reads it.
//!
//! There are two: the direct field keeps visibility, the indirect one, coarser, keeps irradiance. A frame uses each in
//! three steps, each a plain parallel loop: demand (readers mark the points that hits read and that are still empty),
//! fill ([`DirectField::fill`] and [`IndirectField::fill`] evaluate them in brick order), and shade (readers
//! interpolate). The reader of the first step is that of the last: where no point is empty, it shades at once. A
//! point's value depends on the scene, the settings and the point alone, and not on the surface that reads it first.

mod prefill;
mod snapshot;
mod views;

use glam::Vec3;
pub(crate) use snapshot::PointCursor;
pub use snapshot::{Cursor, DirectSnapshot, DirectValues, IndirectSnapshot, PointSnapshot, Snapshot};

use crate::direct::DirectField;
use crate::direct::encoding::refuse;
use crate::indirect::IndirectField;
use crate::mesh::{FinerLevels, Focus, Interpolator, Levels, Marks, PointRequests, Points, requests};
use crate::options::IndirectMesh;
use crate::world::FieldMemory;
use crate::{Camera, Error, MeshKey, MeshStats, RenderOptions, RenderStats, Scene, Spacing};

/// Meshes of direct and indirect light, filled as surfaces need their points. They belong to one scene and one
/// [`MeshKey`]. Cameras, picture sizes and sample counts may change from frame to frame, and so may the number of
/// bounces, up to that of the options they were made with.
#[derive(Debug)]
pub struct LightMesh {
    /// All that its values depend on beside the scene.
    key: MeshKey,
    /// The bounces that it was made for.
    bounces: u32,
    /// How often the refinement has been reset, once for each picture.
    generation: u64,
    pub(crate) direct: DirectField,
    /// `None` without bounces and without emission that only gather rays find.
    pub(crate) indirect: Option<IndirectField>,
}

/// Marks of both meshes.
pub(crate) struct LightMarks {
    pub direct: Marks,
    pub indirect: Option<Marks>,
}

impl LightMesh {
    /// Makes empty meshes of the same density in all of the scene's box.
    ///
    /// # Errors
    /// [`Error::InvalidOption`] for a spacing out of range, [`Error::OutOfMemory`] if the hierarchy of lights would not
    /// fit into `options.limits.max_memory`.
    pub fn new(scene: &Scene, options: &RenderOptions) -> Result<Self, Error> {
        Self::with_focus(scene, options, None)
    }

    /// Makes empty meshes for pictures by these cameras: where the spacing is [`Spacing::Auto`], it is a part of the
    /// room that they see, not of the scene's box, and grows with the distance to that room. What is around it changes
    /// nothing in it. Small pictures that are mostly empty, by the size in
    /// `options`, have larger spacings.
    ///
    /// # Errors
    /// As [`LightMesh::new`].
    pub fn for_cameras(scene: &Scene, options: &RenderOptions, cameras: &[Camera]) -> Result<Self, Error> {
        Self::with_focus(scene, options, views::focus(scene, options, cameras))
    }

    /// Makes empty meshes with the focus of another one ([`LightMesh::focus`]).
    ///
    /// # Errors
    /// As [`LightMesh::new`], and [`Error::InvalidContents`] for a focus that is no box.
    pub fn with_focus(scene: &Scene, options: &RenderOptions, focus: Option<Focus>) -> Result<Self, Error> {
        if let Some(focus) = focus.filter(|focus| !focus.is_valid()) {
            return refuse("focus", format!("{focus:?} is no box that a mesh can have"));
        }
        // Choose the lattices of a mesh.
        options.validate()?;
        let (interpolator, resolved) = (Interpolator::of(options), options.resolved());
        let finer = FinerLevels { needed: resolved.refinements, most: resolved.finer_levels };
        let levels = |option, asked: Spacing, resolved: Spacing| {
            let (bounds, reach) = (scene.bounds(), interpolator.reach());
            match focus.filter(|_| asked == Spacing::Auto) {
                Some(focus) => Levels::around(option, focus, &bounds, resolved.metres(focus.scale), reach, finer),
                // A scene may be a single point of a user's shape: any spacing will do.
                None => {
                    let longest = bounds.size().max_element().max(1e-20);
                    Levels::over(option, &bounds, resolved.metres(longest), reach, finer)
                }
            }
        };

        // Make the meshes that the method uses.
        let has_indirect =
            options.method.has_mesh() && (options.transport.bounces > 0 || scene.has_unsampled_emitters());
        let IndirectMesh { spacing, gather_rays } = options.indirect_mesh(scene.data().lights.len());
        let indirect = match has_indirect {
            true => Some(levels("indirect-spacing", options.mesh.indirect_spacing, spacing)?),
            false => None,
        };
        let spacing = match resolved.spacing {
            Spacing::Fraction(k) if options.mesh.spacing == Spacing::Auto && !options.method.is_paper() => {
                Spacing::Fraction(k * Spacing::auto_density(scene.lights().len()))
            }
            spacing => spacing,
        };
        let direct = levels("spacing", options.mesh.spacing, spacing)?;
        let [of_direct, of_indirect] = FieldMemory::pair(scene, options, focus.is_some());
        Ok(Self {
            key: MeshKey::of(options),
            bounces: options.transport.bounces,
            generation: 0,
            direct: DirectField::new(scene, direct, interpolator, options, of_direct)?,
            indirect: indirect.map(|levels| {
                let interpolator = interpolator.without_rules();
                IndirectField::new(scene, levels, interpolator, gather_rays, options, of_indirect)
            }),
        })
    }

    /// Returns where the meshes are fine; `None` where they have the same density everywhere.
    pub fn focus(&self) -> Option<Focus> {
        let indirect = self.indirect.as_ref().and_then(|field| field.points().focus());
        self.direct.points().focus().or(indirect)
    }

    /// Returns all that its values depend on beside the scene, its focus and the bounces.
    pub fn key(&self) -> &MeshKey {
        &self.key
    }

    /// Returns whether frames with these options can use this mesh.
    pub fn is_compatible(&self, options: &RenderOptions) -> bool {
        self.check_compatible(options).is_ok()
    }

    /// Refuses options with which frames cannot use this mesh.
    ///
    /// # Errors
    /// [`Error::IncompatibleMesh`] names the first option that differs.
    pub(crate) fn check_compatible(&self, options: &RenderOptions) -> Result<(), Error> {
        let asked = MeshKey::of(options);
        let direct = || self.key.direct_difference(&asked);
        let indirect = || self.indirect.as_ref().and_then(|_| self.key.indirect_difference(&asked));
        if let Some(difference) = direct().or_else(indirect) {
            return Err(Error::IncompatibleMesh { what: difference.to_string() });
        }
        let (own, bounces) = (self.bounces, options.transport.bounces);
        // A mesh without bounces may have indirect light, if it is only emission.
        let enough = if self.indirect.is_some() { bounces <= own } else { bounces == 0 };
        if enough {
            return Ok(());
        }
        let own = if self.indirect.is_some() { own } else { 0 };
        Err(Error::IncompatibleMesh { what: format!("was made with bounces {own}, and the options ask for {bounces}") })
    }

    /// Returns whether points lie all around a position: it is in the scene's box, but for rounding.
    pub(crate) fn covers(&self, scene: &Scene, position: Vec3) -> bool {
        prefill::covers(scene, self.direct.points().spacing(), position)
    }

    /// Writes its state into the statistics of a frame with these options.
    pub(crate) fn report(&self, options: &RenderOptions, stats: &mut RenderStats) {
        if options.method.has_mesh() {
            stats.direct = self.stats();
            stats.indirect = self.indirect_stats();
            let of_points = || self.indirect.as_ref()?.truncated_light(options.transport.bounces);
            stats.truncated_light = stats.truncated_light.or_else(of_points);
        }
    }

    /// Returns the number of points of the direct mesh evaluated so far, and their memory.
    pub fn stats(&self) -> MeshStats {
        self.direct.stats()
    }

    /// Returns the same for the indirect mesh; all 0 where there is none.
    pub fn indirect_stats(&self) -> MeshStats {
        self.indirect.as_ref().map_or(MeshStats::default(), IndirectField::stats)
    }

    /// Prepares for another picture: takes all refinement back. Points that are filled stay so.
    pub(crate) fn reset_refinement(&mut self) {
        self.generation += 1;
        self.direct.points_mut().reset_refinement();
        if let Some(field) = &mut self.indirect {
            field.points_mut().reset_refinement();
        }
    }

    /// Returns a number that is another one for each picture: refinement belongs to one of them.
    pub(crate) fn generation(&self) -> u64 {
        self.generation
    }

    /// Returns whether it has indirect light.
    pub fn has_indirect(&self) -> bool {
        self.indirect.is_some()
    }

    /// Returns how many levels a surface may read at one place. Which points of a finer level a picture needs may only be found
    /// when those of the coarser one have been evaluated.
    pub fn level_count(&self) -> u32 {
        // A surface between levels reads both.
        let levels = |points: &Points| points.level_count() - points.base() + u32::from(points.focus().is_some());
        let indirect = self.indirect.as_ref().map_or(0, |field| levels(field.points()));
        levels(self.direct.points()).max(indirect)
    }

    /// Returns empty marks for both meshes.
    pub(crate) fn marks(&self) -> LightMarks {
        LightMarks { direct: Marks::default(), indirect: self.indirect.as_ref().map(|_| Marks::default()) }
    }
}

/// Returns the marked points of both meshes.
pub(crate) fn take_requests(mut marks: LightMarks) -> PointRequests {
    PointRequests {
        direct: requests::take(&mut marks.direct),
        indirect: marks.indirect.as_mut().map_or_else(Vec::new, requests::take),
    }
}
