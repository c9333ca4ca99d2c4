//! A PLY file's header: which elements follow, with which properties, in which encoding.

use crate::error::{Error, one_line};

/// The encoding of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn parse(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Returns the size in a binary body, bytes.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// Returns whether it is an integer type.
    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

/// The values of a property: one, or a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Scalar(Scalar),
    List { count: Scalar, item: Scalar },
}

/// A property of an element.
#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
}

/// A run of `count` records of the same properties.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

impl Element {
    /// The fewest bytes that one record takes: in a text each value is a digit and what separates it from the next.
    fn least_bytes(&self, encoding: Encoding) -> u64 {
        let of = |property: &Property| match (encoding, property.kind) {
            (Encoding::Ascii, _) => 2,
            (_, Kind::Scalar(scalar) | Kind::List { count: scalar, .. }) => scalar.bytes() as u64,
        };
        self.properties.iter().map(of).sum()
    }
}

/// The header, and where the body starts.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Offset of the first byte after the header.
    pub(super) body: usize,
    /// Lines that the header has.
    pub(super) lines: usize,
}

/// Reads the header, and checks that the file is long enough for the records it announces.
pub(super) fn parse(file: &str, bytes: &[u8]) -> Result<Header, Error> {
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let (mut offset, mut number) = (0, 0);
    // Read line by line up to end_header.
    loop {
        // The next line; it ends with LF, or CR LF.
        let Some(length) = bytes[offset..].iter().position(|&b| b == b'\n') else {
            return Err(syntax(
                file,
                number + 1,
                "the header does not end: there is no end_header line; the file is cut off or no PLY",
            ));
        };
        let line = String::from_utf8_lossy(&bytes[offset..offset + length]);
        offset += length + 1;
        number += 1;

        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match words[..] {
            ["ply"] if number == 1 => {}
            _ if number == 1 => return Err(syntax(file, number, "does not begin with \"ply\"; the file is no PLY")),
            [] | ["comment" | "obj_info", ..] => {}
            ["format", name, version] => {
                encoding = match (name, version) {
                    ("ascii", "1.0") => Some(Encoding::Ascii),
                    ("binary_little_endian", "1.0") => Some(Encoding::LittleEndian),
                    ("binary_big_endian", "1.0") => Some(Encoding::BigEndian),
                    _ => return Err(syntax(file, number, format!("format {name} {version} is not read"))),
                }
            }
            ["element", name, count] => {
                let Ok(count) = count.parse() else {
                    return Err(syntax(file, number, format!("{count:?} is no count of elements")));
                };
                elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
            }
            ["property", ref rest @ ..] => {
                let property = match *rest {
                    ["list", count, item, name] => Scalar::parse(count)
                        .filter(|count| count.is_integer())
                        .zip(Scalar::parse(item))
                        .map(|(count, item)| Property { name: name.to_owned(), kind: Kind::List { count, item } }),
                    [scalar, name] => Scalar::parse(scalar)
                        .map(|scalar| Property { name: name.to_owned(), kind: Kind::Scalar(scalar) }),
                    _ => None,
                };
                match (property, elements.last_mut()) {
                    (Some(property), Some(element)) => element.properties.push(property),
                    (None, _) => return Err(syntax(file, number, format!("{:?} is no property", line.trim()))),
                    (_, None) => return Err(syntax(file, number, "a property without an element")),
                }
            }
            ["end_header"] => break,
            _ => return Err(syntax(file, number, format!("{:?} is no line of a header", line.trim()))),
        }
    }
    let Some(encoding) = encoding else {
        return Err(syntax(file, number, "the header has no format line"));
    };

    // The last value of a text needs no separator: hence the 1.
    let left = (bytes.len() - offset) as u64 + 1;
    let least = |element: &Element| element.count.saturating_mul(element.least_bytes(encoding));
    if elements.iter().fold(0, |sum: u64, element| sum.saturating_add(least(element))) > left {
        let announced: Vec<String> = elements.iter().map(|e| format!("{} {}", e.count, e.name)).collect();
        return Err(Error::Syntax {
            file: one_line(file),
            place: "header".into(),
            what: one_line(format_args!(
                "announces {}, more than the {} bytes after it can hold; the file is cut off",
                announced.join(", "),
                left - 1
            )),
        });
    }
    Ok(Header { encoding, elements, body: offset, lines: number })
}

fn syntax(file: &str, line: usize, what: impl std::fmt::Display) -> Error {
    Error::Syntax { file: one_line(file), place: format!("line {line}"), what: one_line(what) }
}
