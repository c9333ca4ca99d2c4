//! Dividing the pieces of an emitter into strata: sets of pieces that lie together, face the same way and give about
//! the same flux.
//!
//! The pieces are halved again and again, as in a hierarchy of bounding volumes, across the longest axis of position and
//! normal together. Where a half ends depends on the pieces alone, not on the order in which they are listed.

use std::ops::Range;

use glam::Vec3;

/// Pieces whose normals have a mean that is shorter than this are divided further: a stratum is represented by one
/// point that faces one way. A hemisphere has 0.5.
const COHERENT: f32 = 0.7;

/// Steps of the search for the middle of the flux.
const STEPS: u32 = 20;

/// A piece of an emitter, as it is sorted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    /// Position, metres, and normal times a length; or a direction, and zero.
    pub at: [f32; 6],
    /// Luminous flux, in any unit.
    pub weight: f32,
    /// The piece.
    pub index: u32,
}

impl Item {
    /// A piece of a surface; a normal counts as much as the length `facing`.
    pub(super) fn of_surface(position: Vec3, normal: Vec3, facing: f32, weight: f32, index: u32) -> Self {
        let (p, n) = (position.to_array(), (normal * facing).to_array());
        Self { at: [p[0], p[1], p[2], n[0], n[1], n[2]], weight, index }
    }

    /// A piece of the sky.
    pub(super) fn of_sky(direction: Vec3, weight: f32, index: u32) -> Self {
        let [x, y, z] = direction.to_array();
        Self { at: [x, y, z, 0.0, 0.0, 0.0], weight, index }
    }
}

/// How many strata there are to be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Count {
    /// As many as this, if there are enough pieces.
    pub wanted: u32,
    /// As many as this where pieces face in different directions.
    pub most: u32,
    /// The length that normals were multiplied by; 0 where they do not count.
    pub facing: f32,
}

/// Sorts the pieces so that each stratum is a run of them, and returns the runs. There must be a piece.
pub(super) fn stratify(items: &mut [Item], count: Count) -> Vec<Range<u32>> {
    let mut strata = Vec::with_capacity(count.wanted as usize);
    divide(items, 0, count.wanted.max(1), count.most, count.facing, &mut strata);
    strata
}

fn divide(items: &mut [Item], first: u32, wanted: u32, most: u32, facing: f32, strata: &mut Vec<Range<u32>>) {
    let run = first..first + items.len() as u32;
    let wanted = if wanted == 1 && most > 1 && facing > 0.0 && !is_coherent(items, facing) { 2 } else { wanted };
    let Some((axis, middle)) = (wanted > 1).then(|| longest_axis(items)).flatten() else {
        strata.push(run);
        return;
    };
    // Put what is below the middle of the flux first.
    let share = (wanted / 2) as f32 / wanted as f32;
    let (threshold, part) = threshold(items, axis, middle, share);
    let mut half = 0;
    for i in 0..items.len() {
        if items[i].at[axis] <= threshold {
            items.swap(half, i);
            half += 1;
        }
    }
    // Pieces without flux, of triangles that hardly have an area, have no middle of it.
    if half == 0 || half == items.len() {
        strata.push(run);
        return;
    }
    // Give each half as many strata as its flux asks for.
    let left = ((wanted as f32 * part).round() as u32).clamp(1, wanted - 1);
    let most_left = ((most as f32 * part) as u32).clamp(left, most.max(left + 1) - 1);
    let (a, b) = items.split_at_mut(half);
    divide(a, first, left, most_left, facing, strata);
    divide(b, first + half as u32, wanted - left, most.saturating_sub(most_left), facing, strata);
}

/// Whether the pieces face about the same way.
fn is_coherent(items: &[Item], facing: f32) -> bool {
    let (mut mean, mut weight) = (Vec3::ZERO, 0.0);
    for item in items {
        mean += Vec3::from_slice(&item.at[3..]) * item.weight;
        weight += item.weight;
    }
    mean.length() >= COHERENT * facing * weight
}

/// Returns the axis along which the pieces reach furthest, and from where to where; `None` where all are in one place.
fn longest_axis(items: &[Item]) -> Option<(usize, [f32; 2])> {
    let (mut min, mut max) = ([f32::INFINITY; 6], [f32::NEG_INFINITY; 6]);
    for item in items {
        for axis in 0..6 {
            min[axis] = min[axis].min(item.at[axis]);
            max[axis] = max[axis].max(item.at[axis]);
        }
    }
    let mut longest = 0;
    for axis in 1..6 {
        if max[axis] - min[axis] > max[longest] - min[longest] {
            longest = axis;
        }
    }
    (max[longest] > min[longest]).then_some((longest, [min[longest], max[longest]]))
}

/// Returns a place on the axis with about this share of the flux at or below it, and the share: at least one piece and
/// not all of them, if there is flux.
fn threshold(items: &[Item], axis: usize, [min, max]: [f32; 2], share: f32) -> (f32, f32) {
    let weight_to =
        |t: f32| -> f64 { items.iter().filter(|item| item.at[axis] <= t).map(|item| f64::from(item.weight)).sum() };
    let whole = weight_to(max);
    let wanted = whole * f64::from(share);
    let (mut low, mut high) = (min, max);
    for _ in 0..STEPS {
        let t = 0.5 * (low + high);
        if weight_to(t) <= wanted { low = t } else { high = t }
    }
    // Of the two sides of the step, the nearer one.
    let part = |t: f32| weight_to(t) / whole.max(f64::MIN_POSITIVE);
    let (below, above) = (part(low), part(high));
    let t = if high < max && f64::from(share) - below > above - f64::from(share) { high } else { low };
    (t, part(t) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 32 × 32 pieces.
    fn square() -> Vec<Item> {
        (0..1024)
            .map(|i| Item::of_surface(Vec3::new((i % 32) as f32, 0.0, (i / 32) as f32), Vec3::Y, 20.0, 1.0, i))
            .collect()
    }

    fn extent(items: &[Item]) -> f32 {
        let (axis, [min, max]) = longest_axis(items).unwrap_or((0, [0.0; 2]));
        assert!(axis < 6);
        max - min
    }

    /// 64 strata of a square are squares of 4 × 4.
    #[test]
    fn strata_are_compact_and_alike() {
        let mut items = square();
        let strata = stratify(&mut items, Count { wanted: 64, most: 64, facing: 20.0 });
        assert_eq!(strata.len(), 64);
        for run in strata {
            assert_eq!((run.len(), extent(&items[run.start as usize..run.end as usize])), (16, 3.0));
        }
    }

    /// In another order the pieces make the same strata.
    #[test]
    fn the_order_of_the_pieces_does_not_matter() {
        let (mut a, mut b) = (square(), square());
        b.reverse();
        b.swap(3, 700);
        let count = Count { wanted: 37, most: 37, facing: 20.0 };
        let sets = |items: &mut Vec<Item>| -> Vec<Vec<u32>> {
            let strata = stratify(items, count);
            let set = |run: Range<u32>| {
                let mut set: Vec<u32> = items[run.start as usize..run.end as usize].iter().map(|i| i.index).collect();
                set.sort_unstable();
                set
            };
            strata.into_iter().map(set).collect()
        };
        assert_eq!(sets(&mut a), sets(&mut b));
    }

    /// The two sides of a thin box are never one stratum; nor are opposite sides of
    /// small cubes in a row, whose strata may have two neighbouring sides.
    #[test]
    fn pieces_that_face_apart_are_kept_apart() {
        let mut items = square();
        items.extend(square().iter().map(|item| {
            let mut below = *item;
            (below.at[1], below.at[4]) = (-0.01, -20.0);
            below
        }));
        for run in stratify(&mut items, Count { wanted: 2, most: 2, facing: 20.0 }) {
            let items = &items[run.start as usize..run.end as usize];
            assert!(items.iter().all(|item| item.at[4] == items[0].at[4]));
        }
        let sides = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z];
        let side = |i: u32| {
            let n = sides[i as usize % 6];
            Item::of_surface(Vec3::X * (i / 6 * 10) as f32 + 0.1 * n, n, 5.0, 1.0, i)
        };
        let mut cubes: Vec<Item> = (0..120).map(side).collect();
        let strata = stratify(&mut cubes, Count { wanted: 8, most: 400, facing: 5.0 });
        for run in strata {
            let items = &cubes[run.start as usize..run.end as usize];
            let normal = |item: &Item| Vec3::from_slice(&item.at[3..]);
            assert!(items.iter().all(|item| normal(item).dot(normal(&items[0])) > -1.0), "opposite sides");
        }
    }

    /// Whatever their flux, no stratum is without pieces.
    #[test]
    fn pieces_without_flux_make_no_empty_stratum() {
        for weight in [0.0, f32::MIN_POSITIVE, 1e-45, f32::MAX, f32::INFINITY, f32::NAN] {
            // Nine places, and two between which there is no other number: the middle rounds to the upper one.
            for place in [|i| i as f32, |i| 1.0 + f32::EPSILON * (1 + i % 2) as f32] {
                let item = |i| Item::of_surface(Vec3::X * place(i), Vec3::Y, 1.0, weight, i);
                let mut items: Vec<Item> = (0..9).map(item).collect();
                let strata = stratify(&mut items, Count { wanted: 4, most: 8, facing: 1.0 });
                assert!(strata.iter().all(|run| !run.is_empty()), "{weight}: {strata:?}");
                assert_eq!(strata.iter().map(|run| run.len()).sum::<usize>(), 9);
            }
        }
    }

    /// Items at one place cannot be divided; there are then fewer strata.
    #[test]
    fn one_place_is_one_stratum() {
        let mut items: Vec<Item> = (0..9).map(|i| Item::of_sky(Vec3::Y, 1.0, i)).collect();
        let strata = stratify(&mut items, Count { wanted: 4, most: 4, facing: 0.0 });
        assert_eq!((strata.len(), strata[0].clone()), (1, 0..9));
    }
}
