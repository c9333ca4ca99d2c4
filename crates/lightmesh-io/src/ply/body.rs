//! The numbers of a PLY file's body, whatever their encoding.

use super::header::{Encoding, Header, Scalar};
use crate::error::{Error, one_line};

/// Reads one number after the other.
#[derive(Debug)]
pub(super) struct Body<'a> {
    file: &'a str,
    encoding: Encoding,
    bytes: &'a [u8],
    /// Next byte, from the start of the file.
    offset: usize,
    /// Current line of a text.
    line: usize,
}

impl<'a> Body<'a> {
    /// At the first byte after the header.
    pub(super) fn new(file: &'a str, bytes: &'a [u8], header: &Header) -> Self {
        Self { file, encoding: header.encoding, bytes, offset: header.body, line: header.lines + 1 }
    }

    /// Bytes not yet read.
    pub(super) fn left(&self) -> usize {
        self.bytes.len() - self.offset
    }

    /// Returns the current position, for messages.
    pub(super) fn place(&self) -> String {
        match self.encoding {
            Encoding::Ascii => format!("line {}", self.line),
            _ => format!("byte {}", self.offset),
        }
    }

    /// The next number. Every type fits f64 without loss.
    pub(super) fn number(&mut self, scalar: Scalar) -> Result<f64, Error> {
        match self.encoding {
            Encoding::Ascii => self.text(),
            Encoding::LittleEndian => self.binary(scalar, false),
            Encoding::BigEndian => self.binary(scalar, true),
        }
    }

    /// The next number as a count or an index: whole, and 0 or more.
    pub(super) fn whole(&mut self, scalar: Scalar) -> Result<u64, Error> {
        let start = self.place();
        let value = self.number(scalar)?;
        if value >= 0.0 && value <= f64::from(u32::MAX) && value == value.trunc() {
            return Ok(value as u64);
        }
        // A text's number may stand some lines further down.
        let place = if self.encoding == Encoding::Ascii { self.place() } else { start };
        let what = format!("{value} is no index or count: it must be a whole number, 0 or more; the file is damaged");
        Err(Error::Invalid { file: one_line(self.file), place, what })
    }

    /// Passes over `count` numbers.
    pub(super) fn skip(&mut self, scalar: Scalar, count: u64) -> Result<(), Error> {
        match self.encoding {
            Encoding::Ascii => (0..count).try_for_each(|_| self.text().map(drop)),
            _ => {
                let bytes = count.saturating_mul(scalar.bytes() as u64);
                if bytes > self.left() as u64 {
                    return Err(self.cut_off());
                }
                self.offset += bytes as usize;
                Ok(())
            }
        }
    }

    /// The file ends here and should not.
    pub(super) fn cut_off(&self) -> Error {
        let what = "the file ends before the last element that the header announces; it is cut off".into();
        Error::Syntax { file: one_line(self.file), place: self.place(), what }
    }

    fn text(&mut self) -> Result<f64, Error> {
        let rest = &self.bytes[self.offset..];
        let blank = rest.iter().take_while(|b| b.is_ascii_whitespace());
        let start = blank.fold(0, |n, &b| {
            self.line += usize::from(b == b'\n');
            n + 1
        });
        let length = rest[start..].iter().position(|b| b.is_ascii_whitespace()).unwrap_or(rest.len() - start);
        self.offset += start + length;
        if length == 0 {
            return Err(self.cut_off());
        }
        let word = String::from_utf8_lossy(&rest[start..start + length]);
        word.parse().map_err(|_| Error::Syntax {
            file: one_line(self.file),
            place: self.place(),
            what: one_line(format_args!("{word:?} is no number")),
        })
    }

    fn binary(&mut self, scalar: Scalar, big_endian: bool) -> Result<f64, Error> {
        let length = scalar.bytes();
        if self.left() < length {
            return Err(self.cut_off());
        }
        let mut raw = [0; 8];
        raw[..length].copy_from_slice(&self.bytes[self.offset..self.offset + length]);
        self.offset += length;
        if big_endian {
            raw[..length].reverse();
        }
        let [a, b, c, d, ..] = raw;
        Ok(match scalar {
            Scalar::I8 => f64::from(a as i8),
            Scalar::U8 => f64::from(a),
            Scalar::I16 => f64::from(i16::from_le_bytes([a, b])),
            Scalar::U16 => f64::from(u16::from_le_bytes([a, b])),
            Scalar::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Scalar::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Scalar::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Scalar::F64 => f64::from_le_bytes(raw),
        })
    }
}
