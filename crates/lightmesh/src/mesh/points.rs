//! The points of one mesh: where they are, their states and their clearances. Values are kept by the fields, under the
//! same index.

use std::collections::HashSet;

use glam::Vec3;

use super::bricks::{Bricks, Slot};
use super::clearance::Clearance;
use super::lattice::{self, Coordinate, Focus, Levels};
use super::marks::{MarkedPoints, Marks};
use super::refinement::{NearFocus, RefinementLevel};
use super::stencil::{Interpolator, trilinear};
use crate::interaction::ShadingPoint;
use crate::world::FieldMemory;
use crate::{Error, MeshStats};

/// Where a mesh point is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Address {
    pub level: u32,
    pub coordinate: Coordinate,
}

/// The memory of points, bytes each.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Costs {
    /// A point's values in the field.
    pub kept: u64,
    /// A point's share of buffers while it is being filled.
    pub temporary: u64,
    /// The number of points that are being filled already.
    pub pending: usize,
}

impl Costs {
    /// Of points without buffers.
    pub(crate) fn kept(kept: u64) -> Self {
        Self { kept, temporary: 0, pending: 0 }
    }
}

/// Points of the lattices of all levels, filled as they are requested; their indices are one sequence.
#[derive(Debug)]
pub(crate) struct Points {
    /// The coarsest first.
    levels: Vec<RefinementLevel>,
    /// See [`Levels::base`].
    base: u32,
    focus: Option<Focus>,
    pub(crate) interpolator: Interpolator,
    /// By index of the filled point.
    addresses: Vec<Address>,
    clearances: Vec<Clearance>,
    /// By index of the probed point.
    probed: Vec<(Address, Clearance)>,
    /// Where the points inside solids are.
    invalid: Vec<Address>,
}

impl Points {
    /// No points yet.
    pub(crate) fn new(levels: Levels, interpolator: Interpolator) -> Self {
        let Levels { lattices, base, focus } = levels;
        // Each level before the base ends where the next one begins.
        let near_focus = |level: u32| {
            let focus = focus.filter(|_| level < base)?;
            Some(NearFocus { focus, radius: focus.radius(base - 1 - level) })
        };
        let numbered = lattices.into_iter().zip(0..);
        Self {
            levels: numbered.map(|(lattice, level)| RefinementLevel::new(lattice, near_focus(level))).collect(),
            base,
            focus,
            interpolator,
            addresses: Vec::new(),
            clearances: Vec::new(),
            probed: Vec::new(),
            invalid: Vec::new(),
        }
    }

    /// The same lattices without a point.
    pub(crate) fn without_points(&self) -> Self {
        let lattices = self.levels.iter().map(|level| level.lattice.clone()).collect();
        Self::new(Levels { lattices, base: self.base, focus: self.focus }, self.interpolator)
    }

    /// Returns the number of filled points, whose indices go from 0 up.
    pub(crate) fn len(&self) -> usize {
        self.addresses.len()
    }

    /// Returns a level; 0 is the coarsest.
    #[inline(always)]
    pub(crate) fn level(&self, level: u32) -> &RefinementLevel {
        &self.levels[level as usize]
    }

    /// Returns the level that surfaces read near the focus, where no picture refines them.
    pub(crate) fn base(&self) -> u32 {
        self.base
    }

    /// Where the mesh is fine.
    pub(crate) fn focus(&self) -> Option<Focus> {
        self.focus
    }

    /// Returns the level at which reading a surface at `p` begins: all points that it might read on coarser ones are
    /// refined.
    #[inline(always)]
    pub(crate) fn first_level(&self, p: Vec3) -> u32 {
        let Some(focus) = &self.focus else { return self.base };
        let distance = focus.distance(p);
        let mut level = self.base;
        // Corners of the cell of a position next to the surface are up to so far away along an axis.
        while level > 0 && distance + 1.75 * self.level(level - 1).lattice.spacing() >= focus.radius(self.base - level)
        {
            level -= 1;
        }
        level
    }

    /// Returns how many levels there may be.
    pub(crate) fn level_count(&self) -> u32 {
        self.levels.len() as u32
    }

    /// Returns the position of a point, metres.
    pub(crate) fn position_of(&self, address: Address) -> Vec3 {
        self.level(address.level).lattice.point(address.coordinate)
    }

    /// Returns the position of a filled point, metres.
    pub(crate) fn position(&self, index: usize) -> Vec3 {
        self.position_of(self.addresses[index])
    }

    /// Returns the positions of the filled points, metres, in the order in which they were filled.
    pub(crate) fn valid_positions(&self) -> impl Iterator<Item = Vec3> {
        self.addresses.iter().map(|&address| self.position_of(address))
    }

    /// Returns the positions of the points inside solids, metres.
    pub(crate) fn invalid_positions(&self) -> impl Iterator<Item = Vec3> {
        self.invalid.iter().map(|&address| self.position_of(address))
    }

    /// Returns the addresses of the points inside solids.
    pub(crate) fn invalid_addresses(&self) -> &[Address] {
        &self.invalid
    }

    /// Returns the distance between neighbours on the base, metres.
    pub(crate) fn spacing(&self) -> f32 {
        self.level(self.base).lattice.spacing()
    }

    /// Returns the address of a filled point.
    pub(crate) fn address(&self, index: usize) -> Address {
        self.addresses[index]
    }

    /// Returns the clearance of a filled point.
    pub(crate) fn clearance(&self, index: u32) -> Clearance {
        self.clearances[index as usize]
    }

    /// Returns the clearance of a point, if it is known; one to which nothing is near otherwise.
    #[inline(always)]
    pub(super) fn clearance_of(&self, slot: Slot) -> Clearance {
        match slot {
            Slot::Filled(index) => self.clearance(index),
            Slot::Probed(index) => self.probed[index as usize].1,
            Slot::Empty | Slot::Invalid => Clearance::default(),
        }
    }

    /// Returns the address of a probed point.
    pub(crate) fn probed_address(&self, index: u32) -> Address {
        self.probed[index as usize].0
    }

    /// Returns the slot of a point.
    pub(crate) fn slot(&self, address: Address) -> Slot {
        self.level(address.level).slot(address.coordinate)
    }

    /// Returns a number by which positions can be sorted so that those of a cell, and cells of a brick, follow each other.
    pub(crate) fn place(&self, p: Vec3) -> u64 {
        let level = self.first_level(p);
        let (brick, local) = lattice::split(self.level(level).lattice.cell(p).0);
        (brick << 9 | local as u64) ^ u64::from(level) << 60
    }

    /// Marks a point.
    pub(crate) fn mark(&self, address: Address, marks: &Marks) {
        let (brick, local) = lattice::split(address.coordinate);
        marks.set(address.level, brick, local);
    }

    /// Returns the index of a point that readers know by its packed slot, if it has got its values since.
    pub(crate) fn filled(&self, packed: u32) -> u32 {
        match Slot::unpack(packed) {
            Slot::Probed(index) => self.slot(self.probed_address(index)).pack(),
            _ => packed,
        }
    }

    /// Returns where a vertex reads: the finest level that gives it half of its light or more, and the cell there.
    pub(crate) fn cell(&self, vertex: &ShadingPoint) -> (u32, Coordinate) {
        let mut level_index = self.first_level(vertex.position);
        loop {
            let level = self.level(level_index);
            let stencil = trilinear(&level.lattice, vertex);
            let refined = level.refined(stencil.cell) & stencil.read;
            if 2.0 * stencil.sum(refined) < stencil.sum(stencil.read) || level_index + 1 == self.level_count() {
                return (level_index, stencil.cell);
            }
            level_index += 1;
        }
    }

    /// Returns the distance between neighbours on the level that a vertex reads, metres.
    pub(crate) fn spacing_at(&self, vertex: &ShadingPoint) -> f32 {
        self.level(self.cell(vertex).0).lattice.spacing()
    }

    /// Lets the next level take over in a cell. There must be one.
    pub(crate) fn refine(&mut self, level: u32, cell: Coordinate) {
        self.levels[level as usize].refine(cell);
    }

    /// Lets each level take over from the one before in a sphere about the eye: from the first nearer than `metres`,
    /// from each that follows nearer than half as much. Ends where the cells that `surface_points` have in the spheres
    /// would be more than `max_cells`.
    pub(crate) fn refine_by_distance(&mut self, eye: Vec3, metres: f32, surface_points: &[Vec3], max_cells: u64) {
        // From level to level, count the cells in the sphere before it is refined.
        let (mut cells, mut radius) = (0, metres);
        for level in self.base as usize..self.levels.len() - 1 {
            let lattice = &self.levels[level].lattice;
            let near = surface_points.iter().filter(|p| p.distance_squared(eye) < radius * radius);
            cells += near.map(|&p| lattice.cell(p).0.to_array()).collect::<HashSet<_>>().len() as u64;
            if cells > max_cells {
                return;
            }
            self.levels[level].refine_near(eye, radius);
            radius *= 0.5;
        }
    }

    /// Takes all refinement back; points that are filled stay so.
    pub(crate) fn reset_refinement(&mut self) {
        self.levels.iter_mut().for_each(RefinementLevel::reset_refinement);
    }

    /// Returns the marked points in brick order; clears the marks.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if they would not fit; nothing has been allocated.
    pub(crate) fn take_marked(
        &self,
        marks: &mut Marks,
        costs: Costs,
        memory: &FieldMemory,
    ) -> Result<Vec<Address>, Error> {
        // List the marked points of all levels.
        let MarkedPoints { points, new_bricks } = marks.take(|level| &self.level(level).bricks);
        self.reserve_memory(points.len(), new_bricks, costs, memory)?;
        let address = |(level, brick, local)| Address { level, coordinate: lattice::coordinate(brick, local) };
        Ok(points.into_iter().map(address).collect())
    }

    /// Reserves the memory of a number of new points, some of them in new bricks, or refuses them if they would not fit.
    pub(crate) fn reserve_memory(
        &self,
        new: usize,
        new_bricks: u64,
        costs: Costs,
        memory: &FieldMemory,
    ) -> Result<(), Error> {
        // Sum what is kept and what buffers need.
        let points = (self.len() + self.probed.len() + new) as u64;
        // A growing vector may hold twice its contents for a moment.
        let bytes = 2 * (costs.kept + Self::BYTES_PER_POINT);
        let temporary = ((costs.pending + new) as u64).saturating_mul(costs.temporary);
        let needed = (self.brick_bytes() + new_bricks * Bricks::BYTES_PER_BRICK)
            .saturating_add(points.saturating_mul(bytes))
            .saturating_add(temporary);
        // Indices have 32 bits.
        let needed = if points >= u64::from(Slot::MAX_INDEX) { u64::MAX } else { needed };
        memory.reserve(needed, "choose a larger --spacing or --indirect-spacing")
    }

    /// Memory of a point without its values and its slot, bytes.
    pub(crate) const BYTES_PER_POINT: u64 = (size_of::<Address>() + size_of::<Clearance>()) as u64;

    /// Returns the memory of all bricks.
    fn brick_bytes(&self) -> u64 {
        self.levels.iter().map(|level| level.bricks.bytes()).sum()
    }

    /// Stores a point; one with a clearance is valid and gets the next index, one without is inside a solid.
    pub(crate) fn insert(&mut self, address: Address, clearance: Option<Clearance>) {
        let slot = match clearance {
            Some(clearance) => {
                self.addresses.push(address);
                self.clearances.push(clearance);
                Slot::Filled(self.addresses.len() as u32 - 1)
            }
            None => {
                self.invalid.push(address);
                Slot::Invalid
            }
        };
        self.levels[address.level as usize].set(address.coordinate, slot);
    }

    /// Stores a point that has been probed, without values; one without a clearance is inside a solid.
    pub(crate) fn insert_probed(&mut self, address: Address, clearance: Option<Clearance>) {
        let Some(clearance) = clearance else { return self.insert(address, None) };
        self.probed.push((address, clearance));
        self.levels[address.level as usize].set(address.coordinate, Slot::Probed(self.probed.len() as u32 - 1));
    }

    /// Gives a point the next index, if it has been probed and has none: its values must follow.
    pub(crate) fn promote(&mut self, address: Address) {
        if let Slot::Probed(index) = self.slot(address) {
            self.insert(address, Some(self.probed[index as usize].1));
        }
    }

    /// Removes the points from index `first` on: they are empty again.
    pub(crate) fn truncate(&mut self, first: usize) {
        for address in self.addresses.drain(first..) {
            self.levels[address.level as usize].set(address.coordinate, Slot::Empty);
        }
        self.clearances.truncate(first);
    }

    /// Returns the number of points so far, and the memory of them and of `value_bytes` of values.
    pub(crate) fn stats(&self, value_bytes: u64) -> MeshStats {
        // Those of the base, and of coarser levels where these end before the scene does.
        let (mut total, mut level) = (0, self.base);
        loop {
            let lattice = &self.level(level).lattice;
            total += lattice.point_count();
            if lattice.has_all_of_scene() || level == 0 {
                break;
            }
            level -= 1;
        }
        let refined = self.addresses.iter().chain(&self.invalid).filter(|address| address.level > self.base).count();
        MeshStats {
            spacing_m: f64::from(self.spacing()),
            points_used: (self.len() + self.invalid.len()) as u64,
            points_refined: refined as u64,
            points_total: total,
            points_invalid: self.invalid.len() as u64,
            bytes: self.brick_bytes() + (self.len() + self.probed.len()) as u64 * Self::BYTES_PER_POINT + value_bytes,
        }
    }
}
