//! Bits of masks.

/// The indices of the set bits, ascending. No bit from `END` on may be set; the compiler sees that all indices are
/// below it.
#[inline(always)]
pub(crate) fn set_bits<const END: usize>(mask: impl Into<u64>) -> impl Iterator<Item = usize> + Clone {
    let mut mask = mask.into();
    std::iter::from_fn(move || {
        let i = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (i < END).then_some(i)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn set_bits_ascend() {
        assert_eq!(set_bits::<64>(1_u64 << 63 | 0b1010_0001).collect::<Vec<_>>(), [0, 5, 7, 63]);
        assert_eq!(set_bits::<16>(0x8001_u32).collect::<Vec<_>>(), [0, 15]);
        assert_eq!(set_bits::<8>(u8::MAX).collect::<Vec<_>>(), [0, 1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(set_bits::<8>(0_u8).count(), 0);
    }
}
