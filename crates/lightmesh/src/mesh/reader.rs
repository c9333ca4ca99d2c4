//! Reading the mesh: which points a surface point reads, with what weight, and which of them are hidden from it.

mod cached;
mod cell_cache;
mod level_reader;
mod occlusion;

pub(crate) use cached::CachedReader;
use glam::Vec3;
use level_reader::LevelReader;
pub(crate) use occlusion::choose;

use super::marks::Marks;
use super::points::Points;
use super::read_result::{CornerVisibility, Needs, ReadResult, Sight, VisibleCorners};
use super::stencil::Interpolator;
use crate::interaction::ShadingPoint;
use crate::world::Scene;

/// Reads the points of a mesh, vertex by vertex: on the level that the vertex' distance from the mesh's focus asks for,
/// and on finer ones where these take over.
#[derive(Debug)]
pub(crate) struct Reader<'a> {
    scene: &'a Scene,
    points: &'a Points,
    sight: Sight,
    /// Begins at the level of the last vertex.
    level: LevelReader<'a>,
    /// Those that begin at other levels.
    others: Vec<LevelReader<'a>>,
    /// How often vertices have changed between them.
    changes: u64,
}

impl Points {
    /// Returns a reader for one thread.
    pub(crate) fn reader<'a>(&'a self, scene: &'a Scene, visibility: CornerVisibility) -> Reader<'a> {
        self.reader_with(scene, Sight { visibility, needs: Needs::Values })
    }

    /// Returns a reader of which corners there are, whether they have values or not.
    pub(crate) fn corner_reader<'a>(&'a self, scene: &'a Scene, visibility: CornerVisibility) -> Reader<'a> {
        self.reader_with(scene, Sight { visibility, needs: Needs::Corners })
    }

    fn reader_with<'a>(&'a self, scene: &'a Scene, sight: Sight) -> Reader<'a> {
        let level = LevelReader::new(scene, self, self.base(), sight);
        Reader { scene, points: self, sight, level, others: Vec::new(), changes: 0 }
    }

    /// Marks the points that vertices read and that are empty, also those that are hidden from the vertices.
    pub(crate) fn demand(&self, scene: &Scene, vertices: &[ShadingPoint], marks: &Marks, visibility: CornerVisibility) {
        let mut reader =
            self.reader(scene, CornerVisibility::Deferred { finer: visibility != CornerVisibility::Stochastic });
        vertices.iter().for_each(|vertex| {
            reader.read(vertex, marks, |_, _| {});
        });
    }
}

impl<'a> Reader<'a> {
    /// Returns whether vertices read the corners of their cells.
    #[inline(always)]
    pub(crate) fn reads_cells(&self) -> bool {
        self.points.interpolator == Interpolator::Trilinear
    }

    /// Returns how many rays have been traced so far to find out which points vertices see.
    pub(crate) fn visibility_rays(&self) -> u64 {
        self.others.iter().map(LevelReader::visibility_rays).sum::<u64>() + self.level.visibility_rays()
    }

    /// Visits (index, φ4) of every point of D_y, if all of them have been evaluated. Those that are still empty are
    /// marked instead: marks are bits that are only ever set, so neither the order nor the thread matters.
    #[inline(always)]
    pub(crate) fn read(&mut self, vertex: &ShadingPoint, marks: &Marks, visit: impl FnMut(u32, f32)) -> ReadResult {
        self.enter_level(vertex);
        self.level.read(vertex, marks, visit)
    }

    /// Returns the corners of the vertex' cell that are visible from it. [`Self::visits`] tells whether it is another
    /// cell than the last vertex'.
    ///
    /// # Errors
    /// [`ReadResult::Unavailable`] or [`ReadResult::Pending`].
    #[inline(always)]
    pub(crate) fn corners(&mut self, vertex: &ShadingPoint, marks: &Marks) -> Result<VisibleCorners, ReadResult> {
        self.enter_level(vertex);
        self.level.corners(vertex, marks)
    }

    /// Returns how many cells have been entered: as long as the number stays, the corners are the same points.
    #[inline(always)]
    pub(crate) fn visits(&self) -> u64 {
        (self.changes << 40) + self.level.visits()
    }

    /// Returns a mean direction, of any length, from the vertex that was read last to the corners that it should read
    /// but cannot, on all levels that it read: they are inside solids or hidden from it. Zero where there are none.
    #[inline(always)]
    pub(crate) fn towards_missing(&self, vertex: &ShadingPoint) -> Vec3 {
        self.level.towards_missing(vertex)
    }

    /// Returns whether something stands before the plane of the vertex that was read last, in the cells that it read.
    /// Computed only where visibility is deferred.
    pub(crate) fn has_near_occluder(&self) -> bool {
        self.level.has_near_occluder()
    }

    /// Returns the index of corner k, which is filled.
    #[inline(always)]
    pub(crate) fn index(&self, k: usize) -> u32 {
        self.level.index(k)
    }

    /// Changes to the reader that begins at the level of a vertex.
    #[inline(always)]
    fn enter_level(&mut self, vertex: &ShadingPoint) {
        let level = self.points.first_level(vertex.position);
        if level != self.level.level_index {
            self.change_level(level);
        }
    }

    #[cold]
    fn change_level(&mut self, level: u32) {
        self.changes += 1;
        let known = self.others.iter_mut().find(|other| other.level_index == level);
        match known {
            Some(other) => std::mem::swap(other, &mut self.level),
            None => {
                let new = LevelReader::new(self.scene, self.points, level, self.sight);
                self.others.push(std::mem::replace(&mut self.level, new));
            }
        }
    }
}
