//! The points of a snapshot: copied, checked and merged.

use std::collections::HashSet;

use glam::IVec3;

use super::{PointCursor, PointSnapshot};
use crate::Error;
use crate::direct::encoding::{check_length, refuse};
use crate::mesh::{Address, BrickMask, Clearance, LatticeShape, Points, Slot, lattice, requests};

impl Points {
    /// Returns how many points there are.
    pub(crate) fn cursor(&self) -> PointCursor {
        PointCursor { valid: self.len(), invalid: self.invalid_addresses().len() }
    }

    /// Copies the points since `cursor`.
    pub(crate) fn snapshot_since(&self, cursor: PointCursor) -> PointSnapshot {
        let plain = |&Address { level, coordinate: c }: &Address| [level as i32, c.x, c.y, c.z];
        let first = cursor.valid.min(self.len());
        let invalid = self.invalid_addresses();
        PointSnapshot {
            lattices: self.shapes().collect(),
            addresses: (first..self.len()).map(|i| plain(&self.address(i))).collect(),
            clearances: (first..self.len()).map(|i| self.clearance(i as u32).sides()).collect(),
            invalid: invalid[cursor.invalid.min(invalid.len())..].iter().map(plain).collect(),
        }
    }

    /// Copies the points of some bricks that are not empty, in order; also returns the indices of the valid ones.
    pub(super) fn snapshot_of(&self, bricks: &[BrickMask]) -> Result<(PointSnapshot, Vec<u32>), Error> {
        let mut snapshot = PointSnapshot { lattices: self.shapes().collect(), ..PointSnapshot::default() };
        let mut indices = Vec::new();
        requests::for_each_point(self, bricks, |level, brick, local, slot| {
            let c = lattice::coordinate(brick, local);
            let address = [level as i32, c.x, c.y, c.z];
            match slot {
                Slot::Empty => {}
                Slot::Invalid => snapshot.invalid.push(address),
                Slot::Filled(index) => {
                    snapshot.addresses.push(address);
                    snapshot.clearances.push(self.clearance(index).sides());
                    indices.push(index);
                }
            }
        })?;
        Ok((snapshot, indices))
    }

    /// Returns the lattice of each level.
    fn shapes(&self) -> impl Iterator<Item = LatticeShape> {
        (0..self.level_count()).map(|level| self.level(level).lattice.shape())
    }

    /// Refuses points of other lattices, and points outside the lattices.
    pub(super) fn check(&self, snapshot: &PointSnapshot, field: &str) -> Result<(), Error> {
        // Compare the lattices.
        let own: Vec<LatticeShape> = self.shapes().collect();
        if snapshot.lattices.len() != own.len() {
            let what =
                format!("there are {}; this mesh has {}: refine or graded differ", snapshot.lattices.len(), own.len());
            return refuse(format!("{field} lattices"), what);
        }
        for (level, (given, own)) in snapshot.lattices.iter().zip(&own).enumerate() {
            // A NaN differs, too.
            if given != own {
                let what = format!(
                    "is {:?} points of {} m from {:?}; this mesh has {:?} of {} m from {:?}",
                    given.size, given.spacing, given.origin, own.size, own.spacing, own.origin
                );
                return refuse(format!("{field} lattice, level {level}"), what);
            }
        }

        // Check the arrays of points.
        check_length(&format!("{field} clearances"), snapshot.clearances.len(), &[snapshot.addresses.len()])?;
        for (array, addresses) in [("addresses", &snapshot.addresses), ("invalid points", &snapshot.invalid)] {
            let is_outside = |&[level, i, j, k]: &[i32; 4]| {
                let level = u32::try_from(level).ok().filter(|&level| level < self.level_count());
                level.is_none_or(|level| !self.level(level).lattice.contains(IVec3::new(i, j, k)))
            };
            if let Some(i) = addresses.iter().position(is_outside) {
                let [level, x, y, z] = addresses[i];
                let what = format!("({x}, {y}, {z}) of level {level} is not on the lattice");
                return refuse(format!("{field} {array}, point {i}"), what);
            }
        }
        Ok(())
    }

    /// Returns how many of the points are new here, and how many new bricks they need. They lie on the lattices.
    pub(super) fn count_new(&self, snapshot: &PointSnapshot) -> (usize, u64) {
        // Count the empty slots, and the bricks that have none yet.
        let (mut new, mut bricks) = (0, HashSet::new());
        for &address in snapshot.addresses.iter().chain(&snapshot.invalid) {
            let Address { level, coordinate } = from_plain(address);
            let (brick, local) = lattice::split(coordinate);
            let level_bricks = &self.level(level).bricks;
            if level_bricks.slot(brick, local) == Slot::Empty {
                new += 1;
                if !level_bricks.exists(brick) {
                    bricks.insert((level, brick));
                }
            }
        }
        (new, bricks.len() as u64)
    }

    /// Adds the points that are new; `push` gets the index in `snapshot` of each that is valid.
    pub(super) fn merge(&mut self, snapshot: &PointSnapshot, mut push: impl FnMut(usize)) {
        // Valid points first: their order is that of their values.
        let is_new =
            |points: &Self, address: Address| points.level(address.level).slot(address.coordinate) == Slot::Empty;
        for (i, (&address, &sides)) in snapshot.addresses.iter().zip(&snapshot.clearances).enumerate() {
            let address = from_plain(address);
            if is_new(self, address) {
                self.insert(address, Some(Clearance::from_sides(sides)));
                push(i);
            }
        }

        // Then those inside solids.
        for &address in &snapshot.invalid {
            let address = from_plain(address);
            if is_new(self, address) {
                self.insert(address, None);
            }
        }
    }
}

/// Returns the address that these numbers are.
fn from_plain([level, x, y, z]: [i32; 4]) -> Address {
    Address { level: level as u32, coordinate: IVec3::new(x, y, z) }
}
