//! Storage: which points are filled, and where their values are.
//!
//! A hash table has an entry per brick that has points, a brick has one 32-bit slot per point, and a slot leads to the
//! point's values in one array that holds nothing else: an empty brick costs nothing, one with a point 2 KiB, a filled
//! point its values.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use super::lattice::BrickKey;

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

/// Hashes keys of bricks: neighbours differ in few bits, which the product spreads over all.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct KeyHasher(u64);

impl Hasher for KeyHasher {
    fn finish(&self) -> u64 {
        self.0 ^ self.0 >> 32
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_u64(u64::from(byte)));
    }

    fn write_u32(&mut self, x: u32) {
        self.write_u64(u64::from(x));
    }

    #[inline(always)]
    fn write_u64(&mut self, x: u64) {
        // 2⁶⁴ / golden ratio, odd.
        self.0 = (self.0.rotate_left(5) ^ x).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
}

/// A table by brick; its order is never used.
pub(super) type ByBrick<K, V> = HashMap<K, V, BuildHasherDefault<KeyHasher>>;

/// The bricks of a level.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bricks {
    /// Index into `slots` by brick.
    table: ByBrick<BrickKey, u32>,
    slots: Vec<[u32; 512]>,
}

impl Bricks {
    /// Memory of a brick with slots, its marks and its entries in tables included, bytes.
    pub(super) const BYTES_PER_BRICK: u64 = 512 * 4 + 64 + 128;

    /// Returns the slot of a point.
    #[inline(always)]
    pub(crate) fn slot(&self, brick: BrickKey, local: usize) -> Slot {
        self.brick(brick).slot(local)
    }

    /// Returns the slots of a brick.
    #[inline(always)]
    pub(super) fn brick(&self, brick: BrickKey) -> Brick<'_> {
        Brick(self.table.get(&brick).map(|&index| &self.slots[index as usize]))
    }

    /// Returns whether a brick has slots.
    pub(crate) fn exists(&self, brick: BrickKey) -> bool {
        self.table.contains_key(&brick)
    }

    /// Sets a slot; a brick gets its slots on first use.
    pub(super) fn set(&mut self, brick: BrickKey, local: usize, slot: Slot) {
        let Self { table, slots } = self;
        let index = *table.entry(brick).or_insert_with(|| {
            slots.push([Slot::EMPTY; 512]);
            slots.len() as u32 - 1
        });
        slots[index as usize][local] = slot.pack();
    }

    /// Returns the memory, bytes.
    pub(crate) fn bytes(&self) -> u64 {
        self.slots.len() as u64 * Self::BYTES_PER_BRICK
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slots_come_back_as_they_were_set() {
        let mut bricks = Bricks::default();
        assert_eq!(bricks.slot(23, 511), Slot::Empty);
        bricks.set(23, 511, Slot::Filled(7));
        bricks.set(23, 0, Slot::Invalid);
        assert_eq!([511, 0, 1].map(|i| bricks.slot(23, i)), [Slot::Filled(7), Slot::Invalid, Slot::Empty]);
        assert!(bricks.exists(23) && !bricks.exists(22));
    }
}
