//! Vertex attributes and indices of one primitive.

use std::fmt::{self, Display};

use super::accessor::{Accessor, Component};
use super::buffer::Buffers;
use super::context::{Context, Place};
use crate::error::Error;

/// A primitive in a message.
#[derive(Clone, Copy, Debug)]
pub(super) struct PrimitivePlace<'a> {
    /// The mesh of the primitive.
    pub(super) mesh: Place<'a>,
    /// The index of the primitive in its mesh.
    pub(super) primitive: usize,
}

impl Display for PrimitivePlace<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, primitive {}", self.mesh, self.primitive)
    }
}

/// Opens the accessors of one primitive.
#[derive(Clone, Copy, Debug)]
pub(super) struct AttributeReader<'a> {
    /// The buffers with the bytes.
    pub(super) buffers: &'a Buffers<'a>,
    /// The primitive, for messages.
    pub(super) at: PrimitivePlace<'a>,
}

impl<'a> AttributeReader<'a> {
    /// Accessor `index`, which must have one of the numbers of `components`, and `count` elements if given.
    pub(super) fn open(
        &self,
        context: &mut Context<'_>,
        name: &str,
        index: usize,
        components: &[usize],
        count: Option<usize>,
    ) -> Result<Accessor<'a>, Error> {
        let referrer = format!("{}, {name}", self.at);
        let accessor = Accessor::open(context, self.buffers, index, &referrer)?;
        if !components.contains(&accessor.components) {
            let what = format!(
                "accessor {index} has {} components per element, which {name} cannot have",
                accessor.components
            );
            return Err(context.invalid(self.at, what));
        }
        match count {
            Some(count) if count != accessor.count => {
                let what = format!(
                    "accessor {index} of {name} has {} elements for {count} vertices; the file is damaged",
                    accessor.count
                );
                Err(context.invalid(self.at, what))
            }
            _ => Ok(accessor),
        }
    }

    /// The index list, checked; without an accessor every vertex once.
    pub(super) fn indices(
        &self,
        context: &mut Context<'_>,
        index: Option<usize>,
        vertex_count: usize,
    ) -> Result<Vec<u32>, Error> {
        let Some(index) = index else {
            context.spend(self.at, vertex_count as u64, 4)?;
            return Ok((0..vertex_count as u32).collect());
        };
        let accessor = self.open(context, "indices", index, &[1], None)?;
        if !(accessor.is_plain_integer()
            && matches!(accessor.component, Component::U8 | Component::U16 | Component::U32))
        {
            return Err(context.invalid(self.at, format!("accessor {index} of indices is not of unsigned integers")));
        }
        context.spend(self.at, accessor.count as u64, 4)?;
        let indices: Vec<u32> = (0..accessor.count).map(|i| accessor.index(i)).collect();
        match indices.iter().find(|&&i| i as usize >= vertex_count) {
            None => Ok(indices),
            Some(i) => {
                let what =
                    format!("index {i} is out of range: primitive has {vertex_count} vertices; the file is damaged");
                Err(context.invalid(self.at, what))
            }
        }
    }
}

/// The elements of the attributes that are kept, in order.
#[derive(Debug)]
pub(super) enum Vertices {
    All,
    /// Sorted; the vertex that is now i was `kept[i]`.
    Kept(Vec<u32>),
}

impl Vertices {
    /// Keeps all vertices, unless the triangles are too few to use them all: then those that they use, and the
    /// triangles are renumbered. So a primitive never takes more vertices than it has corners, whatever array it shares
    /// with others.
    pub(super) fn used_by(
        context: &mut Context<'_>,
        at: PrimitivePlace<'_>,
        triangles: &mut [[u32; 3]],
        vertex_count: usize,
    ) -> Result<Self, Error> {
        if triangles.len() * 3 >= vertex_count {
            return Ok(Self::All);
        }
        context.spend(at, triangles.len() as u64, 12)?;
        let mut kept: Vec<u32> = triangles.iter().flatten().copied().collect();
        kept.sort_unstable();
        kept.dedup();
        for corner in triangles.iter_mut().flatten() {
            // Every corner is in the list that was made of them.
            *corner = kept.binary_search(corner).unwrap_or_default() as u32;
        }
        Ok(Self::Kept(kept))
    }

    /// The vertex's number in the file.
    pub(super) fn original(&self, i: usize) -> usize {
        match self {
            Self::All => i,
            Self::Kept(kept) => kept[i] as usize,
        }
    }

    /// The kept elements of an attribute.
    pub(super) fn collect<T, const N: usize>(
        &self,
        context: &mut Context<'_>,
        at: PrimitivePlace<'_>,
        accessor: &Accessor<'_>,
        convert: impl Fn([f32; N]) -> T,
    ) -> Result<Vec<T>, Error> {
        let count = match self {
            Self::All => accessor.count,
            Self::Kept(kept) => kept.len(),
        };
        context.spend(at, count as u64, size_of::<T>() as u64)?;
        Ok((0..count).map(|i| convert(accessor.float(self.original(i)))).collect())
    }
}
