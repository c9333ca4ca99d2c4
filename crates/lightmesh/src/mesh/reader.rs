//! Reading the mesh: which points a surface point asks for, with what weight, and which of them it cannot see.

mod occlusion;

use glam::{UVec3, Vec3, Vec4};
pub(crate) use occlusion::choose;

use super::bricks::Slot;
use super::clearance::{self, Clearance, FreeEdges, blocked, boxed_in, component, distances, free_edges};
use super::corners::{ByCorner, ONES, corner, set_bits};
use super::lattice::Coordinate;
use super::marks::Marks;
use super::missing_corners::read_with;
use super::points::{Address, Points};
use super::read_result::{CornerVisibility, ReadResult, VisibleCorners};
use super::refinement::RefinementLevel;
use super::stencil::{Interpolator, Stencil, heights_above, nearest, sphere, trilinear};
use crate::interaction::ShadingPoint;
use crate::world::Scene;

/// Reads points vertex by vertex. It keeps what it knows of the last cell: neighbouring pixels mostly share it.
#[derive(Debug)]
pub(crate) struct Reader<'a> {
    scene: &'a Scene,
    points: &'a Points,
    /// Which level this reads.
    at: u32,
    level: &'a RefinementLevel,
    cell: Coordinate,
    slots: [Slot; 8],
    /// Which corners the next level takes over, a bit each; no longer where only the sum counts, as points must not depend on it.
    refined: u8,
    /// Which of the slots are filled and which are empty, a bit each, and which of those have been marked.
    filled: u8,
    empty: u8,
    marked: u8,
    clearances: [Clearance; 8],
    free_edges: FreeEdges,
    boxed_in: u8,
    /// The sides that any corner has a surface on.
    blocked: u8,
    /// The clearances by side, and for which sides they are known.
    distances: [ByCorner; 6],
    known: u8,
    /// The last set of corners that was wanted, and whether it is in one piece.
    whole: (u8, bool),
    /// The last plane that was judged, for which corners, and whether the cell is clear before it ([`Self::is_clear`]).
    plane: (Vec3, f32, u8),
    clear: bool,
    sight: CornerVisibility,
    visits: u64,
    visibility_rays: u64,
    /// Of the last vertex: the corners that it wanted to read but cannot, and whether the next level was read too.
    missing: u8,
    blended: bool,
    /// Whether something stands before the last vertex' plane in its cell; known where sight is unchecked.
    near_occluder: bool,
    /// Reads the next level.
    finer: Option<Box<Self>>,
}

/// Usable corners with less than this part of the weight are looked at one by one. Empirical: a half catches both sides of a gap
/// between a box and a wall (a test's furnace); looking always is the same there and shoots more rays.
const MINORITY: f32 = 0.5;

impl<'a> Reader<'a> {
    pub(crate) fn new(scene: &'a Scene, points: &'a Points, sight: CornerVisibility) -> Self {
        Self::of_level(scene, points, 0, sight)
    }

    /// Reads a level, where the level before lets it.
    pub(super) fn of_level(scene: &'a Scene, points: &'a Points, at: u32, sight: CornerVisibility) -> Self {
        Self {
            scene,
            points,
            at,
            level: points.level(at),
            cell: UVec3::MAX,
            slots: [Slot::Empty; 8],
            refined: 0,
            filled: 0,
            empty: 0,
            marked: 0,
            clearances: [Clearance::default(); 8],
            free_edges: [0; 3],
            boxed_in: 0,
            blocked: 0,
            distances: [[Vec4::ZERO; 2]; 6],
            known: 0,
            whole: (0, true),
            plane: (Vec3::ZERO, 0.0, 0),
            clear: false,
            sight,
            visits: 0,
            visibility_rays: 0,
            missing: 0,
            blended: false,
            near_occluder: false,
            finer: None,
        }
    }

    /// Whether vertices read the corners of their cells.
    #[inline(always)]
    pub(crate) fn reads_cells(&self) -> bool {
        self.points.neighbourhood == Interpolator::Trilinear
    }

    /// Rays shot so far to find out which points vertices see.
    pub(crate) fn visibility_rays(&self) -> u64 {
        self.visibility_rays + self.finer.as_ref().map_or(0, |finer| finer.visibility_rays())
    }

    /// Hands out (index, φ4) of every point of D_y, if all of them have been evaluated. Those that are still empty are
    /// marked instead: marks are bits that are only ever set, so neither the order nor the thread matters.
    #[inline(always)]
    pub(crate) fn read(&mut self, vertex: &ShadingPoint, marks: &Marks, mut take: impl FnMut(u32, f32)) -> ReadResult {
        let points = self.points;
        if points.neighbourhood == Interpolator::Trilinear {
            return self.read_cell(vertex, marks, take);
        }
        if let Interpolator::TrilinearWith(rule) = points.neighbourhood {
            let mark = |coordinate| points.mark(Address { level: self.at, coordinate }, marks);
            return read_with(self.level, rule, vertex, mark, take);
        }
        let (mut any, mut empty) = (false, false);
        let mut visit = |coordinate: Coordinate, weight: f32| {
            let slot = self.level.slot(coordinate);
            match slot {
                Slot::Filled(index) if weight > 0.0 => {
                    any = true;
                    take(index, weight);
                }
                Slot::Filled(_) | Slot::Invalid => {}
                Slot::Empty => {
                    points.mark(Address { level: self.at, coordinate }, marks);
                    empty = true;
                }
            }
            slot
        };
        match points.neighbourhood {
            Interpolator::Sphere(ball) => sphere(&self.level.lattice, vertex, ball, visit),
            _ => nearest(&self.level.lattice, vertex, |coordinate| visit(coordinate, 1.0)),
        }
        match (empty, any) {
            (true, _) => ReadResult::Pending,
            (false, true) => ReadResult::Value,
            (false, false) => ReadResult::Unavailable,
        }
    }

    /// [`Self::read`] for the corners of the vertex' cell.
    #[inline(always)]
    fn read_cell(&mut self, vertex: &ShadingPoint, marks: &Marks, mut take: impl FnMut(u32, f32)) -> ReadResult {
        let seen = match self.corners(vertex, marks) {
            Ok(seen) => seen,
            Err(outcome) => return outcome,
        };
        if seen.refined > 0.0 {
            return self.blend(&seen, 1.0, vertex, marks, &mut take);
        }
        for k in set_bits(seen.mask) {
            take(self.index(k), seen.weights[k / 4][k % 4]);
        }
        ReadResult::Value
    }

    /// Hands out what is seen on this level and on the finer ones that take over from it (see [`RefinementLevel`]); their weights
    /// have the sum `share`.
    #[cold]
    fn blend(
        &mut self,
        seen: &VisibleCorners,
        share: f32,
        vertex: &ShadingPoint,
        marks: &Marks,
        take: &mut dyn FnMut(u32, f32),
    ) -> ReadResult {
        let own: f32 = seen.weights.iter().map(|w| w.element_sum()).sum();
        let scale = share / (own + seen.refined);
        for k in set_bits(seen.mask) {
            take(self.index(k), scale * seen.weights[k / 4][k % 4]);
        }
        if seen.refined == 0.0 {
            return ReadResult::Value;
        }
        let (scene, points, next, sight) = (self.scene, self.points, self.at + 1, self.sight);
        self.blended = true;
        let finer = self.finer.get_or_insert_with(|| Box::new(Self::of_level(scene, points, next, sight)));
        match finer.corners(vertex, marks) {
            Ok(finest) => finer.blend(&finest, scale * seen.refined, vertex, marks, take),
            Err(ReadResult::Unavailable) if seen.mask != 0 => ReadResult::Value,
            Err(outcome) => outcome,
        }
    }

    /// The corners of the vertex' cell that it sees; otherwise what became of the read. Which cell it is, [`Self::visits`] tells.
    #[inline(always)]
    pub(crate) fn corners(&mut self, vertex: &ShadingPoint, marks: &Marks) -> Result<VisibleCorners, ReadResult> {
        let stencil = trilinear(&self.level.lattice, vertex);
        (self.missing, self.blended) = (0, false);
        if stencil.cell != self.cell {
            self.enter(stencil.cell);
        }
        let read = stencil.read & !self.refined;
        let refined = stencil.sum(stencil.read & self.refined);
        let empty = read & self.empty;
        if empty != 0 {
            for k in set_bits(empty & !self.marked) {
                self.points.mark(Address { level: self.at, coordinate: corner(self.cell, k) }, marks);
            }
            self.marked |= empty;
            return Err(ReadResult::Pending);
        }
        let usable = read & self.filled;
        if usable == 0 {
            return if refined > 0.0 { Ok(VisibleCorners::nothing(refined)) } else { Err(ReadResult::Unavailable) };
        }
        if matches!(self.sight, CornerVisibility::Deferred { .. }) {
            self.near_occluder = !self.is_clear(vertex, &stencil, usable);
            let mask = if is_minority(&stencil, read, usable) { self.trace_each(vertex, usable) } else { usable };
            return self.visible(mask, &stencil, read, refined);
        }
        if self.whole.0 != usable {
            self.whole = (usable, component(&self.free_edges, usable) == usable);
        }
        let parted = if is_minority(&stencil, read, usable) {
            usable
        } else if self.is_clear(vertex, &stencil, u8::MAX) {
            self.boxed_in & usable
        } else {
            self.occluded(vertex, &stencil) & usable
        };
        let mask =
            if self.whole.1 && parted == 0 { usable } else { self.trace_occlusion(vertex, &stencil, usable, parted) };
        self.visible(mask, &stencil, read, refined)
    }

    /// What a vertex sees that wanted to read some corners and sees those of `mask`.
    #[inline(always)]
    fn visible(&mut self, mask: u8, stencil: &Stencil, read: u8, refined: f32) -> Result<VisibleCorners, ReadResult> {
        if mask == 0 {
            return if refined > 0.0 { Ok(VisibleCorners::nothing(refined)) } else { Err(ReadResult::Unavailable) };
        }
        let [lower, upper] = stencil.weights;
        let weights = [lower * ONES[mask as usize & 15], upper * ONES[mask as usize >> 4]];
        self.missing = read & !mask;
        Ok(VisibleCorners { mask, weights, refined })
    }

    /// How many cells have been entered: as long as it stays, the corners are the same points.
    #[inline(always)]
    pub(crate) fn visits(&self) -> u64 {
        self.visits
    }

    /// A mean direction, of any length, from the vertex that was read last to the corners that it wanted to read but cannot, on all
    /// levels that it read: they are inside solids or hidden from it. Zero where there are none.
    #[inline(always)]
    pub(crate) fn towards_missing(&self, vertex: &ShadingPoint) -> Vec3 {
        if self.missing == 0 && !self.blended { Vec3::ZERO } else { self.sum_of_missing(vertex) }
    }

    /// Whether something stands before the plane of the vertex that was read last, in the cells that it read. Known where sight is
    /// unchecked.
    pub(crate) fn has_near_occluder(&self) -> bool {
        self.near_occluder || self.finer.as_ref().is_some_and(|finer| self.blended && finer.has_near_occluder())
    }

    fn sum_of_missing(&self, vertex: &ShadingPoint) -> Vec3 {
        let lattice = &self.level.lattice;
        let to_corner = |k| (lattice.point(corner(self.cell, k)) - vertex.position) * lattice.inv_spacing();
        let own: Vec3 = set_bits(self.missing).map(to_corner).sum();
        let finer = self.finer.as_ref().filter(|_| self.blended);
        own + finer.map_or(Vec3::ZERO, |finer| finer.towards_missing(vertex))
    }

    /// The index of corner k, which is filled.
    #[inline(always)]
    pub(crate) fn index(&self, k: usize) -> u32 {
        match self.slots[k] {
            Slot::Filled(index) => index,
            Slot::Empty | Slot::Invalid => unreachable!("corners that are read are filled"),
        }
    }

    /// Whether nothing stands between the vertex' plane and some corners of the cell, as far as they see along the axes. Asked of all
    /// eight, nothing can part any vertex on that plane from a corner: [`Self::occluded`] then is what [`Self::boxed_in`] is.
    /// Planes are told apart by their normal and their height in 1/256 of the spacing, and judged by the upper end of that step.
    #[inline(always)]
    fn is_clear(&mut self, vertex: &ShadingPoint, stencil: &Stencil, corners: u8) -> bool {
        // The offset keeps walls on and half-way between lattice planes, the most of them, off the edges of steps.
        let step = (stencil.heights[0].x * 256.0 + 0.382).ceil();
        if self.plane != (vertex.ng, step, corners) {
            // Of the step, not of the vertex: the answer must not depend on which of them comes first.
            let heights = heights_above(vertex.ng, step * (1.0 / 256.0));
            self.plane = (vertex.ng, step, corners);
            self.clear = set_bits(self.blocked).all(|side| {
                clearance::before_plane(side, vertex.ng, &heights, &self.distances_to(side)) & corners == 0
            });
        }
        self.clear
    }

    /// The corners that may have something between them and the vertex.
    #[inline(never)]
    fn occluded(&mut self, vertex: &ShadingPoint, stencil: &Stencil) -> u8 {
        let lattice = &self.level.lattice;
        let place = (vertex.position - lattice.point(self.cell)) * lattice.inv_spacing();
        let mut parted = self.boxed_in;
        for axis in 0..3 {
            for upper in [false, true] {
                let d = place[axis] - f32::from(u8::from(upper));
                if self.blocked >> (2 * axis + usize::from(d < 0.0)) & 1 != 0 {
                    let room = |side| self.distances_to(side);
                    parted |= clearance::occluded(axis, upper, d, vertex.ng[axis], &stencil.heights, room);
                }
            }
        }
        parted
    }

    /// The corners' clearances towards a side.
    #[inline(always)]
    fn distances_to(&mut self, side: usize) -> ByCorner {
        if self.known >> side & 1 == 0 {
            self.known |= 1 << side;
            self.distances[side] = distances(&self.clearances, side);
        }
        self.distances[side]
    }

    /// Looks up the corners of another cell.
    fn enter(&mut self, cell: Coordinate) {
        self.cell = cell;
        self.visits += 1;
        self.slots = self.level.slots(cell);
        let last = self.at + 1 == self.points.level_count();
        let coarse = matches!(self.sight, CornerVisibility::Stochastic | CornerVisibility::Deferred { finer: false });
        self.refined = if last || coarse { 0 } else { self.level.refined(cell) };
        let mask = |is: fn(Slot) -> bool| (0..8).map(|k| u8::from(is(self.slots[k])) << k).sum();
        self.filled = mask(|slot| matches!(slot, Slot::Filled(_)));
        self.empty = mask(|slot| slot == Slot::Empty);
        self.marked = 0;
        self.known = 0;
        self.plane.0 = Vec3::ZERO;
        self.clearances = self.slots.map(|slot| match slot {
            Slot::Filled(index) => self.points.clearance(index),
            Slot::Empty | Slot::Invalid => Clearance::default(),
        });
        self.blocked = blocked(&self.clearances, self.filled);
        if matches!(self.sight, CornerVisibility::Deferred { .. }) {
            return;
        }
        self.free_edges = free_edges(&self.clearances);
        self.boxed_in = boxed_in(&self.clearances);
        self.whole = (0, true);
    }
}

/// Whether the usable corners are but the lesser part of what the vertex wants to read, the rest being inside solids. What
/// lies across the edge of a wall or a solid then may be hidden though no wall crosses an edge of the cell.
#[inline(always)]
fn is_minority(stencil: &Stencil, read: u8, usable: u8) -> bool {
    read != usable && stencil.sum(usable) < MINORITY * stencil.sum(read)
}
