//! Points that somebody wants, as plain numbers: what marks are between processes.

use super::bricks::Slot;
use super::marks::Marks;
use super::points::Points;
use crate::Error;

/// Points of one brick of a mesh. Point (i, j, k) of the lattice is in brick (i / 8, j / 8, k / 8), which has the index a + bx (b + by c) for
/// (a, b, c) in a lattice of bx × by × bz bricks, at place (i mod 8) + 8 (j mod 8) + 64 (k mod 8).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct BrickMask {
    /// How often the spacing has been halved.
    pub level: u32,
    /// Which brick of the level's lattice.
    pub brick: u32,
    /// A bit per place: bit p mod 64 of word p / 64.
    pub mask: [u64; 8],
}

impl BrickMask {
    /// How many points there are.
    pub fn len(&self) -> u32 {
        self.mask.iter().map(|word| word.count_ones()).sum()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.mask == [0; 8]
    }
}

/// Points of both meshes, each brick once, by level and brick.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PointRequests {
    /// Of the mesh of direct light.
    pub direct: Vec<BrickMask>,
    /// Of the mesh of indirect light.
    pub indirect: Vec<BrickMask>,
}

impl PointRequests {
    /// Whether nothing is wanted.
    pub fn is_empty(&self) -> bool {
        self.direct.is_empty() && self.indirect.is_empty()
    }

    /// How many points there are, of both meshes.
    pub fn len(&self) -> u64 {
        self.direct.iter().chain(&self.indirect).map(|brick| u64::from(brick.len())).sum()
    }

    /// Adds what somebody else wants.
    pub fn merge(&mut self, other: &Self) {
        join(&mut self.direct, &other.direct);
        join(&mut self.indirect, &other.indirect);
    }

    /// Takes away what somebody already has.
    pub fn remove(&mut self, other: &Self) {
        remove(&mut self.direct, &other.direct);
        remove(&mut self.indirect, &other.indirect);
    }
}

/// Takes points away from bricks.
fn remove(bricks: &mut Vec<BrickMask>, others: &[BrickMask]) {
    bricks.retain_mut(|brick| {
        let other = others.binary_search_by_key(&(brick.level, brick.brick), |other| (other.level, other.brick));
        if let Ok(i) = other {
            brick.mask.iter_mut().zip(others[i].mask).for_each(|(places, known)| *places &= !known);
        }
        !brick.is_empty()
    });
}

/// Adds bricks to others, each of which then is there once, in order.
fn join(bricks: &mut Vec<BrickMask>, others: &[BrickMask]) {
    bricks.extend_from_slice(others);
    bricks.sort_unstable_by_key(|brick| (brick.level, brick.brick));
    bricks.dedup_by(|next, first| {
        let same = (next.level, next.brick) == (first.level, first.brick);
        if same {
            first.mask.iter_mut().zip(next.mask).for_each(|(places, more)| *places |= more);
        }
        same
    });
}

/// The marks, which are cleared.
pub(crate) fn take(marks: &mut Marks) -> Vec<BrickMask> {
    let levels = (0..).zip(marks.levels());
    let bricks = levels.flat_map(|(level, marks)| {
        marks.take_words().into_iter().map(move |(brick, places)| BrickMask {
            level,
            brick: brick as u32,
            mask: places,
        })
    });
    bricks.collect()
}

/// Marks those of the points that are empty.
///
/// # Errors
/// [`Error::InvalidBricks`] for bricks that the mesh does not have.
pub(crate) fn mark(points: &Points, bricks: &[BrickMask], marks: &Marks) -> Result<(), Error> {
    each(points, bricks, |level, brick, local, slot| {
        if slot == Slot::Empty {
            marks.set(level, brick, local);
        }
    })
}

/// Hands out level, brick and place of each point, and its slot.
///
/// # Errors
/// As [`mark`].
pub(crate) fn each(
    points: &Points,
    bricks: &[BrickMask],
    mut take: impl FnMut(u32, usize, usize, Slot),
) -> Result<(), Error> {
    for &BrickMask { level, brick, mask: places } in bricks {
        let known = (level < points.level_count()).then(|| points.level(level));
        let Some(known) = known.filter(|known| (brick as usize) < known.lattice.brick_count()) else {
            let what = format!("the mesh has no brick {brick} on level {level}: it is of another mesh");
            return Err(Error::InvalidBricks { what });
        };
        let slots = known.bricks.brick(brick as usize);
        let set = (0..512).filter(|place| places[place / 64] >> (place % 64) & 1 != 0);
        set.for_each(|place| take(level, brick as usize, place, slots.at(place)));
    }
    Ok(())
}
