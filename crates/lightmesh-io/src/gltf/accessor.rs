//! Accessors: typed arrays in buffer views.

use super::buffer::Buffers;
use super::context::{Context, Place, place};
use super::json;
use crate::error::Error;

/// A component type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn from_gl(number: u32) -> Option<Self> {
        Some(match number {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}

/// Components per element. Matrices of small components are padded by columns; no attribute that we read is a matrix.
fn components(element_type: &str) -> Option<usize> {
    Some(match element_type {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        _ => return None,
    })
}

/// Elements at a fixed distance in a buffer view. Made only where the last one fits.
#[derive(Clone, Copy, Debug)]
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
}

impl<'a> Strided<'a> {
    /// The bytes of element `i`, which the maker has checked to be there.
    fn element(&self, i: usize, size: usize) -> &'a [u8] {
        &self.bytes[i * self.stride..][..size]
    }
}

/// Replacements of some elements.
#[derive(Debug)]
struct Sparse<'a> {
    /// Strictly increasing.
    indices: Vec<u32>,
    values: Strided<'a>,
}

/// A checked accessor.
#[derive(Debug)]
pub(super) struct Accessor<'a> {
    /// Number of elements.
    pub(super) count: usize,
    /// The type of a component.
    pub(super) component: Component,
    /// Components per element, 1 to 4.
    pub(super) components: usize,
    normalized: bool,
    /// `None`: zeros.
    base: Option<Strided<'a>>,
    sparse: Option<Sparse<'a>>,
}

impl<'a> Accessor<'a> {
    /// Checks accessor `index` against its buffer views, in 64-bit arithmetic and before anything is allocated.
    pub(super) fn open(
        context: &mut Context<'_>,
        buffers: &'a Buffers<'_>,
        index: usize,
        referrer: &str,
    ) -> Result<Self, Error> {
        let accessor = context.get(&buffers.document.accessors, "accessor", index, referrer)?;
        let place = place("accessor", index, None);

        // Element: what and how large.
        let Some(component) = Component::from_gl(accessor.component_type) else {
            let what = format!("componentType {} is none of glTF's (5120-5123, 5125, 5126)", accessor.component_type);
            return Err(context.invalid(place, what));
        };
        let Some(components) = components(&accessor.element_type) else {
            let what =
                format!("type {:?} is not read for {referrer}, only SCALAR, VEC2, VEC3, VEC4", accessor.element_type);
            return Err(context.invalid(place, what));
        };
        let size = components * component.bytes();

        // Count: indices are 32-bit, and what has no bytes in the file must still fit into memory.
        if accessor.count > u64::from(u32::MAX) {
            let what = format!("count {} is more than 32-bit indices can address", accessor.count);
            return Err(context.invalid(place, what));
        }
        let base = match accessor.buffer_view {
            Some(view) => {
                let span = Span { view, offset: accessor.byte_offset, count: accessor.count, size };
                Some(strided(context, buffers, place, span, Stride::OfView)?)
            }
            None => None,
        };
        let sparse = match &accessor.sparse {
            Some(sparse) => Some(open_sparse(context, buffers, place, accessor.count, sparse, size)?),
            None => None,
        };
        let normalized = accessor.normalized;
        Ok(Self { count: accessor.count as usize, component, components, normalized, base, sparse })
    }

    /// Returns whether components are integers that are not mapped to [0, 1] or [−1, 1].
    pub(super) fn is_plain_integer(&self) -> bool {
        self.component != Component::F32 && !self.normalized
    }

    /// Treats integers as normalised whatever the file says.
    pub(super) fn normalize(mut self) -> Self {
        self.normalized = true;
        self
    }

    /// Element `i` < `count` as floats; components beyond the element's own are zero.
    pub(super) fn float<const N: usize>(&self, i: usize) -> [f32; N] {
        let mut element = [0.0; N];
        if let Some(bytes) = self.element(i) {
            let size = self.component.bytes();
            for (value, bytes) in element.iter_mut().zip(bytes.chunks_exact(size)) {
                *value = self.component_value(bytes);
            }
        }
        element
    }

    /// Element `i` < `count` as an unsigned integer, for scalars of an unsigned type; else 0.
    pub(super) fn index(&self, i: usize) -> u32 {
        match (self.component, self.element(i)) {
            (_, None) => 0,
            (component, Some(bytes)) => unsigned(component, bytes),
        }
    }

    /// The element's bytes; `None`: zeros.
    fn element(&self, i: usize) -> Option<&'a [u8]> {
        let size = self.components * self.component.bytes();
        if let Some(sparse) = &self.sparse
            && let Ok(at) = sparse.indices.binary_search(&(i as u32))
        {
            return Some(sparse.values.element(at, size));
        }
        self.base.map(|base| base.element(i, size))
    }

    /// Converts one component, by glTF 2.0, 3.6.2.2 "Accessor Data Types" and its table of normalised integers.
    fn component_value(&self, bytes: &[u8]) -> f32 {
        let (value, largest) = match (self.component, bytes) {
            (Component::I8, &[a]) => (f32::from(a as i8), 127.0),
            (Component::U8, &[a]) => (f32::from(a), 255.0),
            (Component::I16, &[a, b]) => (f32::from(i16::from_le_bytes([a, b])), 32767.0),
            (Component::U16, &[a, b]) => (f32::from(u16::from_le_bytes([a, b])), 65535.0),
            (Component::U32, &[a, b, c, d]) => (u32::from_le_bytes([a, b, c, d]) as f32, u32::MAX as f32),
            (Component::F32, &[a, b, c, d]) => return f32::from_le_bytes([a, b, c, d]),
            _ => return 0.0,
        };
        if self.normalized { (value / largest).max(-1.0) } else { value }
    }
}

/// An unsigned integer from little-endian bytes.
fn unsigned(component: Component, bytes: &[u8]) -> u32 {
    match (component, bytes) {
        (Component::U8, &[a]) => u32::from(a),
        (Component::U16, &[a, b]) => u32::from(u16::from_le_bytes([a, b])),
        (Component::U32, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]),
        _ => 0,
    }
}

/// The distance between elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stride {
    /// That of the buffer view, else tight.
    OfView,
    /// Tight whatever the view says: sparse indices and values.
    Tight,
}

/// Elements as the file describes them, not yet checked.
#[derive(Clone, Copy, Debug)]
struct Span {
    /// The buffer view.
    view: usize,
    /// Byte in it at which the first element begins.
    offset: u64,
    /// Number of elements.
    count: u64,
    /// Bytes of each.
    size: usize,
}

/// Checks that the elements lie in their view: offset + (count − 1) · stride + size must not pass its end.
fn strided<'a>(
    context: &Context<'_>,
    buffers: &'a Buffers<'_>,
    place: Place<'_>,
    Span { view, offset, count, size }: Span,
    stride: Stride,
) -> Result<Strided<'a>, Error> {
    let (bytes, view_stride) = buffers.view(context, view, place)?;
    let size = size as u64;
    let stride = match view_stride {
        Some(bytes) if bytes > 0 && stride == Stride::OfView => bytes,
        _ => size,
    };
    if stride < size {
        let what = format!("bufferView {view} has a byteStride of {stride}, less than an element's {size} bytes");
        return Err(context.invalid(place, what));
    }
    if count == 0 {
        return Ok(Strided { bytes: &[], stride: size as usize });
    }
    let end = (count - 1).checked_mul(stride).and_then(|n| n.checked_add(size)).and_then(|n| n.checked_add(offset));
    match end.filter(|&end| end <= bytes.len() as u64) {
        Some(end) => Ok(Strided { bytes: &bytes[offset as usize..end as usize], stride: stride as usize }),
        None => {
            let what = format!(
                "{count} elements of {size} bytes from byte {offset} do not fit into bufferView {view} \
                 of {} bytes; the file is damaged",
                bytes.len()
            );
            Err(context.invalid(place, what))
        }
    }
}

/// Checks the replacements: indices increase strictly and stay under `count`.
fn open_sparse<'a>(
    context: &mut Context<'_>,
    buffers: &'a Buffers<'_>,
    place: Place<'_>,
    count: u64,
    sparse: &json::Sparse,
    size: usize,
) -> Result<Sparse<'a>, Error> {
    let component = match Component::from_gl(sparse.indices.component_type) {
        Some(c @ (Component::U8 | Component::U16 | Component::U32)) => c,
        _ => {
            let what = format!("sparse.indices.componentType {} is no unsigned integer", sparse.indices.component_type);
            return Err(context.invalid(place, what));
        }
    };
    let width = component.bytes();
    let n = sparse.count;
    let (at, values) = (&sparse.indices, &sparse.values);
    let span = Span { view: at.buffer_view, offset: at.byte_offset, count: n, size: width };
    let raw = strided(context, buffers, place, span, Stride::Tight)?;
    let span = Span { view: values.buffer_view, offset: values.byte_offset, count: n, size };
    let values = strided(context, buffers, place, span, Stride::Tight)?;
    context.spend(place, n, 4)?;
    let indices: Vec<u32> = (0..n as usize).map(|i| unsigned(component, raw.element(i, width))).collect();
    let increasing = indices.windows(2).all(|pair| pair[0] < pair[1]);
    if !increasing || indices.last().is_some_and(|&last| u64::from(last) >= count) {
        let what = format!("sparse.indices do not increase strictly or pass the count of {count}; the file is damaged");
        return Err(context.invalid(place, what));
    }
    Ok(Sparse { indices, values })
}
