//! The light mesh: illumination at points of a lattice in space, computed when a surface first asks for it.
//!
//! There are two: the direct field keeps visibility, the indirect one, coarser, keeps irradiance. A frame uses each in three
//! steps, each a plain parallel loop: demand ([`Reader::read`](crate::mesh::Reader::read) marks the points that hits read and that are still empty), fill
//! (evaluates them in brick order; [`DirectField::fill`], [`IndirectField::fill`]), and shade ([`Reader::read`](crate::mesh::Reader::read) interpolates).
//! Reading is asking: where nothing is empty, the first step already is the last. A point's value depends on the scene, the
//! settings and the point alone, so it does not matter who asked first.

mod prefill;
mod snapshot;

use glam::Vec3;
pub(crate) use snapshot::PointCursor;
pub use snapshot::{Cursor, DirectSnapshot, DirectValues, IndirectSnapshot, PointSnapshot, Snapshot};

use crate::direct::DirectField;
use crate::indirect::IndirectField;
use crate::mesh::{Interpolator, Lattice, Marks, PointRequests, requests};
use crate::{Error, MeshKey, MeshStats, RenderOptions, RenderStats, Scene, Spacing};

/// Lazily filled meshes of direct and indirect light. They belong to one scene and one [`MeshKey`], and serve up to the
/// bounces that they were made for; cameras, picture sizes and samples may change from frame to frame.
#[derive(Debug)]
pub struct LightMesh {
    /// All that its values depend on beside the scene.
    key: MeshKey,
    /// The bounces that it was made for.
    bounces: u32,
    /// How often it has been made ready for a picture.
    generation: u64,
    pub(crate) direct: DirectField,
    /// Where there are bounces, or emission that only gather rays find.
    pub(crate) indirect: Option<IndirectField>,
}

/// Marks of both meshes.
pub(crate) struct LightMarks {
    pub direct: Marks,
    pub indirect: Option<Marks>,
}

impl LightMesh {
    /// Empty meshes over the scene's box.
    ///
    /// # Errors
    /// [`Error::InvalidOption`] for a spacing out of range, [`Error::OutOfMemory`] if the tables of bricks alone would not
    /// fit into `options.limits.max_memory`.
    pub fn new(scene: &Scene, options: &RenderOptions) -> Result<Self, Error> {
        options.validate()?;
        let neighbourhood = Interpolator::of(options);
        let resolved = options.resolved();
        let lattices = |option, spacing: Spacing| {
            let bounds = scene.bounds();
            // A scene may be a single point of a user's shape: any spacing serves it.
            let spacing = spacing.metres(bounds.size().max_element().max(1e-20));
            let level = |l: u32, max_memory| {
                let spacing = spacing / (1 << l) as f32;
                Lattice::new(option, &bounds, spacing, neighbourhood.reach(), max_memory)
            };
            let mut levels = (0..=resolved.refinements)
                .map(|l| level(l, options.limits.max_memory))
                .collect::<Result<Vec<_>, _>>()?;
            // Density about the eye does without levels whose tables alone would take too much.
            let more = resolved.refinements + 1..=resolved.finer_levels;
            levels.extend(more.map_while(|l| level(l, options.limits.max_memory / 8).ok()));
            Ok::<_, Error>(levels)
        };
        let meshes = options.method.has_mesh();
        let wants_indirect = meshes && (options.transport.bounces > 0 || scene.has_gathered_emitters());
        let indirect = match wants_indirect {
            true => Some(lattices("indirect-spacing", resolved.indirect_spacing)?),
            false => None,
        };
        let direct = lattices("spacing", resolved.spacing)?;
        Ok(Self {
            key: MeshKey::of(options),
            bounces: options.transport.bounces,
            generation: 0,
            direct: DirectField::new(scene, direct, neighbourhood, options)?,
            indirect: indirect.map(|lattices| IndirectField::new(lattices, neighbourhood.of_indirect_light(), options)),
        })
    }

    /// All that its values depend on beside the scene.
    pub fn key(&self) -> &MeshKey {
        &self.key
    }

    /// Returns whether frames with these options can use this mesh.
    pub fn is_compatible(&self, options: &RenderOptions) -> bool {
        self.check_compatible(options).is_ok()
    }

    /// [`LightMesh::is_compatible`], as an error that names the first option that differs.
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

    /// Whether points lie all around a place: it is in the scene's box, but for rounding.
    pub(crate) fn reaches(&self, scene: &Scene, place: Vec3) -> bool {
        prefill::reaches(scene, self.direct.points().spacing(), place)
    }

    /// Notes its state in the numbers of a frame that had these options.
    pub(crate) fn report(&self, options: &RenderOptions, stats: &mut RenderStats) {
        if options.method.has_mesh() {
            stats.direct = self.stats();
            stats.indirect = self.indirect_stats();
            stats.truncated_light =
                self.indirect.as_ref().and_then(|field| field.truncated_light(options.transport.bounces));
        }
    }

    /// Points of the direct mesh evaluated so far, and their memory.
    pub fn stats(&self) -> MeshStats {
        self.direct.stats()
    }

    /// The same for the indirect mesh; all 0 where there is none.
    pub fn indirect_stats(&self) -> MeshStats {
        self.indirect.as_ref().map_or(MeshStats::default(), IndirectField::stats)
    }

    /// Makes ready for another picture: takes all refinement back; points that are filled stay so.
    pub(crate) fn reset_refinement(&mut self) {
        self.generation += 1;
        self.direct.points_mut().reset_refinement();
        if let Some(field) = &mut self.indirect {
            field.points_mut().reset_refinement();
        }
    }

    /// Which picture it is refined for; another number for each.
    pub(crate) fn generation(&self) -> u64 {
        self.generation
    }

    /// Whether it has indirect light.
    pub fn has_indirect(&self) -> bool {
        self.indirect.is_some()
    }

    /// How many levels the meshes may have: points of a finer one may become known as wanted when those of the coarser one are there.
    pub fn level_count(&self) -> u32 {
        let indirect = self.indirect.as_ref().map_or(0, |field| field.points().level_count());
        self.direct.points().level_count().max(indirect)
    }

    /// Empty marks for both meshes.
    pub(crate) fn marks(&self) -> LightMarks {
        LightMarks { direct: self.direct.marks(), indirect: self.indirect.as_ref().map(|field| field.points().marks()) }
    }
}

/// The marks of both meshes.
pub(crate) fn take_requests(mut marks: LightMarks) -> PointRequests {
    PointRequests {
        direct: requests::take(&mut marks.direct),
        indirect: marks.indirect.as_mut().map_or_else(Vec::new, requests::take),
    }
}
