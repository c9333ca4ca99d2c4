//! Rows of numbers as bytes.

use std::borrow::Cow;

use bytemuck::Pod;
use safetensors::Dtype;

/// A number of an array.
pub(super) trait Number: Pod + std::fmt::Debug {
    /// The name of the type in the header.
    const DTYPE: Dtype;

    /// Returns the number with its bytes in reverse order.
    fn swapped(self) -> Self;

    /// Returns whether it is a number at all, and not infinite.
    fn is_finite(self) -> bool;
}

macro_rules! number {
    ($($number:ident, $dtype:ident, $bits:ty, $is_finite:expr;)*) => {$(
        impl Number for $number {
            const DTYPE: Dtype = Dtype::$dtype;

            fn swapped(self) -> Self {
                bytemuck::cast(bytemuck::cast::<_, $bits>(self).swap_bytes())
            }

            fn is_finite(self) -> bool {
                $is_finite(self)
            }
        }
    )*};
}

number! {
    u8, U8, u8, |_| true;
    i32, I32, u32, |_| true;
    u32, U32, u32, |_| true;
    u64, U64, u64, |_| true;
    f32, F32, u32, f32::is_finite;
    f64, F64, u64, f64::is_finite;
}

/// An array that is to be written.
#[derive(Debug)]
pub(super) struct Tensor<'a> {
    pub name: String,
    pub dtype: Dtype,
    pub shape: Vec<usize>,
    pub bytes: Cow<'a, [u8]>,
}

impl<'a> Tensor<'a> {
    /// Makes an array of numbers that lie in a row.
    pub(super) fn new<N: Number>(name: String, shape: &[usize], numbers: Cow<'a, [N]>) -> Self {
        let bytes = match numbers {
            Cow::Borrowed(numbers) if cfg!(target_endian = "little") => Cow::Borrowed(bytemuck::cast_slice(numbers)),
            Cow::Borrowed(_) | Cow::Owned(_) => {
                let mut numbers = numbers.into_owned();
                to_little_endian(&mut numbers);
                Cow::Owned(bytemuck::cast_slice(&numbers).to_vec())
            }
        };
        Self { name, dtype: N::DTYPE, shape: shape.to_vec(), bytes }
    }
}

/// Converts the machine's order of bytes to the files', or back.
pub(super) fn to_little_endian<N: Number>(numbers: &mut [N]) {
    if cfg!(target_endian = "big") {
        numbers.iter_mut().for_each(|number| *number = number.swapped());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_turn_round() {
        assert_eq!(0x0102_0304_u32.swapped(), 0x0403_0201);
        assert_eq!(1.5_f32.swapped().swapped(), 1.5);
        assert_eq!(2.5_f64.swapped().to_bits(), 2.5_f64.to_bits().swap_bytes());
    }
}
