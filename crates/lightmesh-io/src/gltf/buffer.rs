//! Buffers and views into them.

use std::borrow::Cow;
use std::fmt::Display;

use super::context::{Context, place};
use super::json::Document;
use super::uri;
use crate::error::Error;

/// The bytes of all buffers. One that has neither a URI nor the binary chunk is an error only where it is used: it may be the
/// fallback of a compression extension.
#[derive(Debug)]
pub(super) struct Buffers<'a> {
    buffers: Vec<Option<Cow<'a, [u8]>>>,
}

impl<'a> Buffers<'a> {
    /// Decodes and reads the buffers; `binary` is the GLB's own.
    pub(super) fn open(
        context: &mut Context<'_>,
        document: &Document,
        binary: Option<&'a [u8]>,
    ) -> Result<Self, Error> {
        let mut buffers = Vec::with_capacity(document.buffers.len());
        for (index, buffer) in document.buffers.iter().enumerate() {
            let place = place("buffer", index, buffer.name.as_deref());
            let bytes = match (&buffer.uri, index, binary) {
                (Some(uri), ..) => Some(Cow::Owned(uri::fetch(context, place, uri)?)),
                (None, 0, Some(binary)) => Some(Cow::Borrowed(binary)),
                _ => None,
            };
            if let Some(bytes) = &bytes
                && buffer.byte_length > bytes.len() as u64
            {
                let what = format!(
                    "byteLength is {}, but there are {} bytes; the file is incomplete",
                    buffer.byte_length,
                    bytes.len()
                );
                return Err(context.invalid(place, what));
            }
            buffers.push(bytes);
        }
        Ok(Self { buffers })
    }

    /// The bytes of a buffer view and its stride; `referrer` is named in errors.
    pub(super) fn view(
        &self,
        context: &Context<'_>,
        document: &Document,
        index: usize,
        referrer: impl Display,
    ) -> Result<(&[u8], Option<u64>), Error> {
        let view = context.get(&document.buffer_views, "bufferView", index, referrer)?;
        let view_place = place("bufferView", index, None);
        let buffer = context.get(&document.buffers, "buffer", view.buffer, view_place)?;
        let Some(bytes) = self.buffers[view.buffer].as_deref() else {
            let what =
                "has neither a uri nor a binary chunk; the file is incomplete or was saved with the wrong extension";
            return Err(context.invalid(place("buffer", view.buffer, buffer.name.as_deref()), what));
        };
        let range = view.byte_offset.checked_add(view.byte_length).filter(|&end| end <= buffer.byte_length);
        let slice = range.and_then(|end| bytes.get(view.byte_offset as usize..end as usize));
        match slice {
            Some(slice) => Ok((slice, view.byte_stride)),
            None => {
                let what = format!(
                    "{} bytes from byte {} do not fit into buffer {} of {} bytes; the file is damaged",
                    view.byte_length, view.byte_offset, view.buffer, buffer.byte_length
                );
                Err(context.invalid(view_place, what))
            }
        }
    }
}
