//! The points of contents: copied, checked and taken in.

use std::collections::HashSet;

use glam::UVec3;

use super::check::{check_length, refuse};
use super::{PointCursor, PointSnapshot};
use crate::Error;
use crate::mesh::{Address, BrickMask, Clearance, LatticeShape, Points, Slot, lattice, requests};

impl Points {
    /// How many there are.
    pub(crate) fn cursor(&self) -> PointCursor {
        PointCursor { valid: self.len(), invalid: self.invalid_addresses().len() }
    }

    /// Those since `counts`.
    pub(crate) fn snapshot_since(&self, counts: PointCursor) -> PointSnapshot {
        let plain = |&Address { level, coordinate: c }: &Address| [level, c.x, c.y, c.z];
        let first = counts.valid.min(self.len());
        let invalid = self.invalid_addresses();
        PointSnapshot {
            lattices: self.shapes().collect(),
            addresses: (first..self.len()).map(|i| plain(&self.address(i))).collect(),
            clearances: (first..self.len()).map(|i| self.clearance(i as u32).sides()).collect(),
            invalid: invalid[counts.invalid.min(invalid.len())..].iter().map(plain).collect(),
        }
    }

    /// Those of some bricks that are not empty, in order, and the indices of those that give light.
    pub(super) fn snapshot_of(&self, bricks: &[BrickMask]) -> Result<(PointSnapshot, Vec<u32>), Error> {
        let mut contents = PointSnapshot { lattices: self.shapes().collect(), ..PointSnapshot::default() };
        let mut indices = Vec::new();
        requests::each(self, bricks, |level, brick, local, slot| {
            let c = self.level(level).lattice.coordinate(brick, local);
            let address = [level, c.x, c.y, c.z];
            match slot {
                Slot::Empty => {}
                Slot::Invalid => contents.invalid.push(address),
                Slot::Filled(index) => {
                    contents.addresses.push(address);
                    contents.clearances.push(self.clearance(index).sides());
                    indices.push(index);
                }
            }
        })?;
        Ok((contents, indices))
    }

    fn shapes(&self) -> impl Iterator<Item = LatticeShape> {
        (0..self.level_count()).map(|level| self.level(level).lattice.shape())
    }

    /// Refuses points of other lattices, and such as lie on none.
    pub(super) fn check(&self, contents: &PointSnapshot, field: &str) -> Result<(), Error> {
        let own: Vec<LatticeShape> = self.shapes().collect();
        if contents.lattices.len() != own.len() {
            let what =
                format!("there are {}; this mesh has {}: refine or graded differ", contents.lattices.len(), own.len());
            return refuse(format!("{field} lattices"), what);
        }
        for (level, (given, own)) in contents.lattices.iter().zip(&own).enumerate() {
            // Bits: a NaN is no lattice of ours either.
            if given != own {
                let what = format!(
                    "is {:?} points of {} m from {:?}; this mesh has {:?} of {} m from {:?}",
                    given.size, given.spacing, given.origin, own.size, own.spacing, own.origin
                );
                return refuse(format!("{field} lattice, level {level}"), what);
            }
        }
        check_length(&format!("{field} clearances"), contents.clearances.len(), &[contents.addresses.len()])?;
        for (array, addresses) in [("addresses", &contents.addresses), ("invalid points", &contents.invalid)] {
            let lies_on_none = |&[level, i, j, k]: &[u32; 4]| {
                own.get(level as usize)
                    .is_none_or(|lattice| [i, j, k].iter().zip(lattice.size).any(|(&c, size)| c >= size))
            };
            if let Some(i) = addresses.iter().position(lies_on_none) {
                let [level, x, y, z] = addresses[i];
                let what = format!("({x}, {y}, {z}) of level {level} is not on the lattice");
                return refuse(format!("{field} {array}, point {i}"), what);
            }
        }
        Ok(())
    }

    /// How many of some points are not known here, and how many bricks they need. They lie on the lattices.
    pub(super) fn news(&self, contents: &PointSnapshot) -> (usize, u64) {
        let (mut new, mut bricks) = (0, HashSet::new());
        for &address in contents.addresses.iter().chain(&contents.invalid) {
            let Address { level, coordinate } = from_plain(address);
            let (brick, local) = lattice::split(coordinate);
            let level_bricks = &self.level(level).bricks;
            let brick = self.level(level).lattice.brick_index(brick);
            if level_bricks.slot(brick, local) == Slot::Empty {
                new += 1;
                if !level_bricks.exists(brick) {
                    bricks.insert((level, brick));
                }
            }
        }
        (new, bricks.len() as u64)
    }

    /// Adds those that are not known; `take` gets the place in `contents` of each that gives light.
    pub(super) fn merge(&mut self, contents: &PointSnapshot, mut take: impl FnMut(usize)) {
        let is_new =
            |points: &Self, address: Address| points.level(address.level).slot(address.coordinate) == Slot::Empty;
        for (i, (&address, &sides)) in contents.addresses.iter().zip(&contents.clearances).enumerate() {
            let address = from_plain(address);
            if is_new(self, address) {
                self.insert((address, Some(Clearance::from_sides(sides))));
                take(i);
            }
        }
        for &address in &contents.invalid {
            let address = from_plain(address);
            if is_new(self, address) {
                self.insert((address, None));
            }
        }
    }
}

fn from_plain([level, x, y, z]: [u32; 4]) -> Address {
    Address { level, coordinate: UVec3::new(x, y, z) }
}
