//! Storage: which points are filled, and where their values are.
//!
//! A dense table has one entry per brick of the lattice, a brick has one 32-bit slot per point, and a slot leads to the
//! point's values in one array that holds nothing else: an empty brick costs 4 bytes, one with a point 2 KiB, a filled
//! point its values.

use glam::UVec3;

/// The state of a mesh point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Slot {
    /// It has not been evaluated.
    Empty,
    /// It is inside a solid and has no values.
    Invalid,
    /// It has been evaluated; its values have this index.
    Filled(u32),
}

impl Slot {
    /// Filled indices stay below this.
    pub(super) const MAX_INDEX: u32 = u32::MAX - 1;
    const EMPTY: u32 = u32::MAX;
    const INVALID: u32 = u32::MAX - 1;

    #[inline(always)]
    fn unpack(bits: u32) -> Self {
        match bits {
            Self::EMPTY => Self::Empty,
            Self::INVALID => Self::Invalid,
            index => Self::Filled(index),
        }
    }

    /// Returns the slot as 32 bits.
    fn pack(self) -> u32 {
        match self {
            Self::Empty => Self::EMPTY,
            Self::Invalid => Self::INVALID,
            Self::Filled(index) => index,
        }
    }
}

/// The slots of one brick; `None` if none of its points has been evaluated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Brick<'a>(Option<&'a [u32; 512]>);

impl Brick<'_> {
    #[inline(always)]
    pub(super) fn slot(self, local: usize) -> Slot {
        self.0.map_or(Slot::Empty, |slots| Slot::unpack(slots[local]))
    }
}

/// The bricks of a mesh.
#[derive(Clone, Debug)]
pub(crate) struct Bricks {
    /// Index into `slots` by brick index, [`Bricks::NONE`] for a brick without slots.
    table: Vec<u32>,
    slots: Vec<[u32; 512]>,
}

impl Bricks {
    const NONE: u32 = u32::MAX;
    /// Memory of a table entry, its mark included, bytes.
    pub(super) const BYTES_PER_TABLE_ENTRY: u64 = 4 + 16;
    /// Memory of a brick with slots, its marks included, bytes.
    pub(super) const BYTES_PER_BRICK: u64 = 512 * 4 + 64;

    /// Empty bricks, with their numbers along x, y and z.
    pub(crate) fn new(bricks: UVec3) -> Self {
        Self { table: vec![Self::NONE; bricks.as_u64vec3().element_product() as usize], slots: Vec::new() }
    }

    /// Returns the slot of a point.
    #[inline(always)]
    pub(crate) fn slot(&self, brick: usize, local: usize) -> Slot {
        match self.table[brick] {
            Self::NONE => Slot::Empty,
            index => Slot::unpack(self.slots[index as usize][local]),
        }
    }

    /// Returns the slots of a brick.
    #[inline(always)]
    pub(super) fn brick(&self, brick: usize) -> Brick<'_> {
        match self.table[brick] {
            Self::NONE => Brick(None),
            index => Brick(Some(&self.slots[index as usize])),
        }
    }

    /// Returns whether a brick has slots.
    pub(crate) fn exists(&self, brick: usize) -> bool {
        self.table[brick] != Self::NONE
    }

    /// Sets a slot; a brick gets its slots on first use.
    pub(super) fn set(&mut self, brick: usize, local: usize, slot: Slot) {
        if self.table[brick] == Self::NONE {
            self.table[brick] = self.slots.len() as u32;
            self.slots.push([Slot::EMPTY; 512]);
        }
        self.slots[self.table[brick] as usize][local] = slot.pack();
    }

    /// Returns the memory, bytes.
    pub(crate) fn bytes(&self) -> u64 {
        self.table.len() as u64 * Self::BYTES_PER_TABLE_ENTRY + self.slots.len() as u64 * Self::BYTES_PER_BRICK
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slots_come_back_as_they_were_set() {
        let mut bricks = Bricks::new(UVec3::new(2, 3, 4));
        assert_eq!(bricks.slot(23, 511), Slot::Empty);
        bricks.set(23, 511, Slot::Filled(7));
        bricks.set(23, 0, Slot::Invalid);
        assert_eq!([511, 0, 1].map(|i| bricks.slot(23, i)), [Slot::Filled(7), Slot::Invalid, Slot::Empty]);
        assert!(bricks.exists(23) && !bricks.exists(22));
    }
}
