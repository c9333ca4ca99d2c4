//! Reading one level of a mesh, and the finer ones where they take over from it.

use glam::Vec3;

use super::super::bricks::Slot;
use super::super::corners::{ONES, corner, corners_of};
use super::super::lattice::Coordinate;
use super::super::marks::Marks;
use super::super::missing_corners::read_with;
use super::super::points::{Address, Points};
use super::super::read_result::{CornerVisibility, Needs, ReadResult, Sight, VisibleCorners};
use super::super::refinement::RefinementLevel;
use super::super::stencil::{Interpolator, Stencil, nearest, sphere, trilinear};
use super::cell_cache::CellCache;
use crate::interaction::ShadingPoint;
use crate::world::Scene;

/// Reads the points of one level, vertex by vertex, and those of the next level where that takes over.
#[derive(Debug)]
pub(super) struct LevelReader<'a> {
    pub(super) scene: &'a Scene,
    points: &'a Points,
    pub(super) level_index: u32,
    pub(super) level: &'a RefinementLevel,
    pub(super) visibility: CornerVisibility,
    needs: Needs,
    /// The cell of the last vertex.
    pub(super) cell: CellCache,
    /// Cells entered so far.
    visits: u64,
    pub(super) visibility_rays: u64,
    /// The corners that the last vertex should read but cannot, a bit each.
    missing: u8,
    /// Whether the last vertex read the next level, too.
    blended: bool,
    /// Whether something stands before the last vertex' plane in its cell; set only where visibility is deferred.
    near_occluder: bool,
    /// Reads the next level.
    finer: Option<Box<Self>>,
}

/// Usable corners with less than this part of the weight get a ray each. Empirical: in a corner of two walls those outside
/// may have three quarters, and with a half a closed box filled 5768 points outside it.
const MINORITY: f32 = 0.76;

impl<'a> LevelReader<'a> {
    /// Reads a level, where the level before lets it.
    pub(super) fn new(scene: &'a Scene, points: &'a Points, level_index: u32, sight: Sight) -> Self {
        Self {
            scene,
            points,
            level_index,
            level: points.level(level_index),
            visibility: sight.visibility,
            needs: sight.needs,
            cell: CellCache::new(),
            visits: 0,
            visibility_rays: 0,
            missing: 0,
            blended: false,
            near_occluder: false,
            finer: None,
        }
    }

    /// Returns how many rays have been traced so far to find out which points vertices see.
    pub(super) fn visibility_rays(&self) -> u64 {
        self.visibility_rays + self.finer.as_ref().map_or(0, |finer| finer.visibility_rays())
    }

    /// Visits (index, φ4) of every point of D_y, if all of them have been evaluated. Those that are still empty are
    /// marked instead: marks are bits that are only ever set, so neither the order nor the thread matters.
    #[inline(always)]
    pub(super) fn read(
        &mut self,
        vertex: &ShadingPoint,
        marks: &Marks,
        mut visit_point: impl FnMut(u32, f32),
    ) -> ReadResult {
        // The eight corners of a cell have readers of their own.
        let points = self.points;
        if points.interpolator == Interpolator::Trilinear {
            return self.read_cell(vertex, marks, visit_point);
        }
        if let Interpolator::TrilinearWith(rule) = points.interpolator {
            let mark = |coordinate| points.mark(Address { level: self.level_index, coordinate }, marks);
            return read_with(self.level, rule, vertex, mark, visit_point);
        }

        // Visit what is filled, and mark what is empty.
        let (mut any, mut empty) = (false, false);
        let mut visit = |coordinate: Coordinate, weight: f32| {
            let slot = self.level.slot(coordinate);
            match slot {
                Slot::Filled(index) if weight > 0.0 => {
                    any = true;
                    visit_point(index, weight);
                }
                Slot::Filled(_) | Slot::Invalid => {}
                Slot::Empty | Slot::Probed(_) => {
                    points.mark(Address { level: self.level_index, coordinate }, marks);
                    empty = true;
                }
            }
            slot
        };
        match points.interpolator {
            Interpolator::Sphere(stencil) => sphere(&self.level.lattice, vertex, stencil, visit),
            _ => nearest(&self.level.lattice, vertex, |coordinate| visit(coordinate, 1.0)),
        }

        // One empty point is enough to wait for.
        match (empty, any) {
            (true, _) => ReadResult::Pending,
            (false, true) => ReadResult::Value,
            (false, false) => ReadResult::Unavailable,
        }
    }

    /// [`Self::read`] for the corners of the vertex' cell.
    #[inline(always)]
    fn read_cell(&mut self, vertex: &ShadingPoint, marks: &Marks, mut visit: impl FnMut(u32, f32)) -> ReadResult {
        let visible = match self.corners(vertex, marks) {
            Ok(visible) => visible,
            Err(outcome) => return outcome,
        };
        if visible.refined > 0.0 {
            return self.blend(&visible, 1.0, vertex, marks, &mut visit);
        }
        for k in corners_of(visible.mask) {
            visit(self.index(k), visible.weights[k / 4][k % 4]);
        }
        ReadResult::Value
    }

    /// Visits the visible corners of this level and those of the finer ones that take over from it (see
    /// [`RefinementLevel`]), with weights of the sum `share`.
    #[cold]
    fn blend(
        &mut self,
        visible: &VisibleCorners,
        share: f32,
        vertex: &ShadingPoint,
        marks: &Marks,
        visit: &mut dyn FnMut(u32, f32),
    ) -> ReadResult {
        // Visit the corners of this level.
        let own: f32 = visible.weights.iter().map(|w| w.element_sum()).sum();
        let scale = share / (own + visible.refined);
        for k in corners_of(visible.mask) {
            visit(self.index(k), scale * visible.weights[k / 4][k % 4]);
        }
        if visible.refined == 0.0 {
            return ReadResult::Value;
        }

        // The next level gets the rest of the weight.
        let (scene, points, next) = (self.scene, self.points, self.level_index + 1);
        let sight = Sight { visibility: self.visibility, needs: self.needs };
        self.blended = true;
        let finer = self.finer.get_or_insert_with(|| Box::new(Self::new(scene, points, next, sight)));
        match finer.corners(vertex, marks) {
            Ok(finest) => finer.blend(&finest, scale * visible.refined, vertex, marks, visit),
            Err(ReadResult::Unavailable) if visible.mask != 0 => ReadResult::Value,
            Err(outcome) => outcome,
        }
    }

    /// Returns the corners of the vertex' cell that are visible from it. [`Self::visits`] tells whether it is another
    /// cell than the last vertex'.
    ///
    /// # Errors
    /// [`ReadResult::Unavailable`] or [`ReadResult::Pending`].
    #[inline(always)]
    pub(super) fn corners(&mut self, vertex: &ShadingPoint, marks: &Marks) -> Result<VisibleCorners, ReadResult> {
        // Look up the cell, unless it is the last vertex'.
        let stencil = trilinear(&self.level.lattice, vertex);
        // Nothing of the last vertex stays: a cell whose corners are all refined is left early.
        (self.missing, self.blended, self.near_occluder) = (0, false, false);
        if stencil.cell != self.cell.coordinate {
            self.enter(stencil.cell);
        }

        // Mark the corners that are empty.
        let read = stencil.read & !self.cell.refined;
        let refined = stencil.sum(stencil.read & self.cell.refined);
        let empty = read & self.cell.empty;
        if empty != 0 {
            self.mark(empty, marks);
            return Err(ReadResult::Pending);
        }
        let usable = read & self.cell.known;
        if usable == 0 {
            return if refined > 0.0 { Ok(VisibleCorners::nothing(refined)) } else { Err(ReadResult::Unavailable) };
        }

        // Where visibility is deferred, take all usable corners, unless they are few.
        if matches!(self.visibility, CornerVisibility::Deferred { .. }) {
            self.near_occluder = !self.cell.is_clear(vertex, &stencil, usable);
            let mask = if is_minority(&stencil, read, usable) { self.trace_each(vertex, usable) } else { usable };
            return self.visible(mask, &stencil, read, refined, marks);
        }

        // Otherwise find the corners that may be hidden, and trace rays only if there are any or the cell is divided.
        let is_connected = self.cell.is_connected(usable);
        let occluded = if is_minority(&stencil, read, usable) {
            usable
        } else if self.cell.is_clear(vertex, &stencil, u8::MAX) {
            self.cell.boxed_in & usable
        } else {
            self.cell.occluded(&self.level.lattice, vertex, &stencil) & usable
        };
        let mask = match is_connected && occluded == 0 {
            true => usable,
            false => self.trace_occlusion(vertex, &stencil, usable, occluded),
        };
        self.visible(mask, &stencil, read, refined, marks)
    }

    /// Returns the corners of `mask`, for a vertex that should read those of `read`; marks those without values.
    #[inline(always)]
    fn visible(
        &mut self,
        mask: u8,
        stencil: &Stencil,
        read: u8,
        refined: f32,
        marks: &Marks,
    ) -> Result<VisibleCorners, ReadResult> {
        if mask == 0 {
            return if refined > 0.0 { Ok(VisibleCorners::nothing(refined)) } else { Err(ReadResult::Unavailable) };
        }
        let unvalued = mask & self.cell.unvalued;
        if unvalued != 0 && self.needs == Needs::Values {
            self.mark(unvalued, marks);
            return Err(ReadResult::Pending);
        }
        let [lower, upper] = stencil.weights;
        let weights = [lower * ONES[mask as usize & 15], upper * ONES[mask as usize >> 4]];
        self.missing = read & !mask;
        Ok(VisibleCorners { mask, weights, refined })
    }

    /// Marks corners that have not been marked.
    fn mark(&mut self, corners: u8, marks: &Marks) {
        for k in corners_of(corners & !self.cell.marked) {
            let coordinate = corner(self.cell.coordinate, k);
            self.points.mark(Address { level: self.level_index, coordinate }, marks);
        }
        self.cell.marked |= corners;
    }

    /// Returns how many cells have been entered: as long as the number stays, the corners are the same points.
    #[inline(always)]
    pub(super) fn visits(&self) -> u64 {
        self.visits
    }

    /// Returns a mean direction, of any length, from the vertex that was read last to the corners that it should read
    /// but cannot, on all levels that it read: they are inside solids or hidden from it. Zero where there are none.
    #[inline(always)]
    pub(super) fn towards_missing(&self, vertex: &ShadingPoint) -> Vec3 {
        if self.missing == 0 && !self.blended { Vec3::ZERO } else { self.sum_of_missing(vertex) }
    }

    /// Returns whether something stands before the plane of the vertex that was read last, in the cells that it read.
    /// Computed only where visibility is deferred.
    pub(super) fn has_near_occluder(&self) -> bool {
        self.near_occluder || self.finer.as_ref().is_some_and(|finer| self.blended && finer.has_near_occluder())
    }

    /// Returns the sum of the vectors from a vertex to the corners that it cannot read, in spacings.
    fn sum_of_missing(&self, vertex: &ShadingPoint) -> Vec3 {
        let lattice = &self.level.lattice;
        let to_corner = |k| (lattice.point(corner(self.cell.coordinate, k)) - vertex.position) * lattice.inv_spacing();
        let own: Vec3 = corners_of(self.missing).map(to_corner).sum();
        let finer = self.finer.as_ref().filter(|_| self.blended);
        own + finer.map_or(Vec3::ZERO, |finer| finer.towards_missing(vertex))
    }

    /// Returns the index of corner k, which is filled.
    #[inline(always)]
    pub(super) fn index(&self, k: usize) -> u32 {
        self.cell.index(k)
    }

    /// Looks up the corners of another cell.
    fn enter(&mut self, coordinate: Coordinate) {
        self.visits += 1;
        self.cell.enter(self.points, self.level, coordinate);
        // Where only the sum counts, a picture's refinement plays no part: points must not depend on it.
        let is_last = self.level_index + 1 == self.points.level_count();
        let is_coarse =
            matches!(self.visibility, CornerVisibility::Stochastic | CornerVisibility::Deferred { finer: false });
        self.cell.refined = match (is_last, is_coarse) {
            (true, _) => 0,
            (false, true) => self.level.refined_near_focus(coordinate),
            (false, false) => self.level.refined(coordinate),
        };
        if !matches!(self.visibility, CornerVisibility::Deferred { .. }) {
            self.cell.find_free_edges();
        }
    }
}

/// Returns whether the usable corners are but the lesser part of those that the vertex should read, the rest being
/// inside solids. What lies across the edge of a wall or a solid then may be hidden though no wall crosses an edge of
/// the cell.
#[inline(always)]
fn is_minority(stencil: &Stencil, read: u8, usable: u8) -> bool {
    read != usable && stencil.sum(usable) < MINORITY * stencil.sum(read)
}
