//! Random numbers without a state: hashes of seeds, positions and counters.

use glam::{IVec3, UVec3, Vec3};

/// 1 / golden ratio in units of 2⁻³²: its multiples are spread evenly.
pub(crate) const INV_GOLDEN: u32 = 2_654_435_769;

/// PCG's output hash of 32 bits (Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 2020, section 4).
pub(crate) fn hash(x: u32) -> u32 {
    let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Folds the user's seed to 32 bits, both halves of which count.
pub(crate) fn fold_seed(seed: u64) -> u32 {
    let (low, high) = (seed as u32, (seed >> 32) as u32);
    hash(low ^ hash(high))
}

/// The seed of a position, the same for every seed of the user.
pub(crate) fn seed_of_position(p: Vec3) -> u32 {
    let [x, y, z] = p.to_array().map(f32::to_bits);
    hash(hash(hash(x) ^ y) ^ z)
}

/// The seed of a coordinate of the mesh's lattice.
pub(crate) fn seed_of_coordinate(seed: u64, c: IVec3) -> u32 {
    seed_of_numbers(seed, c.as_uvec3())
}

fn seed_of_numbers(seed: u64, c: UVec3) -> u32 {
    hash(hash(hash(fold_seed(seed) ^ c.x) ^ c.y) ^ c.z)
}

/// The seed of a surface point.
pub(crate) fn seed_of_surface(seed: u64, p: Vec3) -> u32 {
    seed_of_numbers(seed, UVec3::from_array(p.to_array().map(f32::to_bits)))
}

/// 32 random bits as a number in [0, 1): the upper 24, as many as a float holds exactly.
#[inline(always)]
pub(crate) fn unit_f32(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / (1 << 24) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_floats_reach_from_zero_to_just_below_one() {
        assert_eq!([0, 255, 256, 1 << 31].map(unit_f32), [0.0, 0.0, 2.0_f32.powi(-24), 0.5]);
        assert_eq!(unit_f32(u32::MAX), 1.0_f32.next_down());
    }

    /// Swapped and equal halves are where a fold that only combines them by XOR would collide.
    #[test]
    fn both_halves_of_a_seed_count() {
        let seeds = [0, 1, 1 << 32, 0x1_0000_0001, 2, 0x2_0000_0000, 0x2_0000_0002, u64::MAX];
        let folded: std::collections::HashSet<u32> = seeds.into_iter().map(fold_seed).collect();
        assert_eq!(folded.len(), seeds.len());
    }
}
