//! A hash of 128 bits over a stream of 64-bit words: two lanes, each a chain of the finaliser of SplitMix64 (Steele,
//! Lea and Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014; constants of Stafford's variant 13),
//! which every word enters in another way. Not cryptographic.

use std::fmt;

use super::Fingerprint;

const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Hashes words one after the other.
#[derive(Debug)]
pub(crate) struct Digest {
    lanes: [u64; 2],
}

impl Digest {
    /// Begins the digest of things of a kind.
    pub(crate) fn new(kind: &str) -> Self {
        let mut digest = Self { lanes: [0, GOLDEN] };
        digest.text(kind);
        digest
    }

    /// Adds a number.
    #[inline(always)]
    pub(super) fn number(&mut self, word: u64) {
        let [a, b] = self.lanes;
        self.lanes = [mix((a ^ word).wrapping_add(GOLDEN)), mix(b.wrapping_add(word.wrapping_mul(GOLDEN)))];
    }

    /// Adds some numbers, but not how many they are; 0 and −0 differ.
    pub(super) fn floats(&mut self, numbers: impl IntoIterator<Item = f32>) {
        self.halves(numbers.into_iter().map(f32::to_bits));
    }

    /// Adds 32-bit words, two by two; a last one has 0 beside it.
    pub(super) fn halves(&mut self, words: impl IntoIterator<Item = u32>) {
        let mut words = words.into_iter();
        while let Some(low) = words.next() {
            let high = words.next().unwrap_or(0);
            self.number(u64::from(high) << 32 | u64::from(low));
        }
    }

    /// Adds a list of such numbers, and its length.
    pub(super) fn list<const N: usize>(&mut self, items: impl ExactSizeIterator<Item = [f32; N]>) {
        self.number(items.len() as u64);
        self.floats(items.flatten());
    }

    /// Adds a text and its length.
    pub(super) fn text(&mut self, text: &str) {
        self.number(text.len() as u64);
        for chunk in text.as_bytes().chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.number(u64::from_le_bytes(word));
        }
    }

    pub(super) fn finish(self) -> Fingerprint {
        let [a, b] = self.lanes;
        Fingerprint(u128::from(a) << 64 | u128::from(b))
    }
}

/// Adds the text of `Debug`, piece by piece.
impl fmt::Write for Digest {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.text(text);
        Ok(())
    }
}

#[inline(always)]
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    /// Words that differ in one bit, lists that are cut elsewhere, zeros of all lengths: no two are alike.
    #[test]
    fn near_misses_are_told_apart() {
        let mut seen = HashSet::new();
        let mut see = |words: &[u64]| {
            let mut digest = Digest::new("test");
            words.iter().for_each(|&word| digest.number(word));
            assert!(seen.insert(digest.finish()), "{words:?}");
        };
        for n in 0..20 {
            see(&vec![0; n]);
        }
        for bit in 0..64 {
            see(&[1 << bit, 7]);
            see(&[7, 1 << bit, 0]);
        }
        let of = |pieces: &[&str]| {
            let mut digest = Digest::new("test");
            pieces.iter().for_each(|piece| digest.text(piece));
            digest.finish()
        };
        assert_ne!(of(&["ab", "c"]), of(&["a", "bc"]));
        assert_ne!(of(&["a"]), of(&["a\0"]));
    }
}
