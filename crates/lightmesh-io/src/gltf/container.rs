//! The GLB container: a 12-byte header, then chunks.

use crate::error::{Error, one_line};

/// The two parts of a glTF file that lie in the file itself.
#[derive(Debug, PartialEq)]
pub(super) struct Container<'a> {
    /// JSON text.
    pub(super) json: &'a [u8],
    /// The binary chunk, which buffer 0 may use.
    pub(super) binary: Option<&'a [u8]>,
}

const JSON_CHUNK: u32 = u32::from_le_bytes(*b"JSON");
const BINARY_CHUNK: u32 = u32::from_le_bytes(*b"BIN\0");

/// Splits a .glb into its chunks, or takes the whole of a .gltf as JSON; the first bytes decide, not the file's name.
pub(super) fn split<'a>(file: &str, bytes: &'a [u8]) -> Result<Container<'a>, Error> {
    let syntax = |place: String, what: String| Error::Syntax { file: one_line(file), place, what: one_line(what) };
    if bytes.is_empty() {
        return Err(syntax("byte 0".into(), "the file is empty; was it written completely?".into()));
    }

    // Text: skip a byte order mark and white space, then expect an object.
    if !bytes.starts_with(b"glTF") {
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        return match text.iter().find(|b| !b.is_ascii_whitespace()) {
            Some(b'{') => Ok(Container { json: text, binary: None }),
            _ => Err(syntax(
                "byte 0".into(),
                "this is not a glTF file: it begins neither with the magic \"glTF\" nor with a JSON object".into(),
            )),
        };
    }

    // Header: magic, version, length of the whole file.
    let word = |offset: usize| -> Option<u32> {
        let bytes = bytes.get(offset..offset.checked_add(4)?)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?))
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        let what = format!("the GLB header is cut off: {} of 12 bytes; the file is incomplete", bytes.len());
        return Err(syntax("byte 0".into(), what));
    };
    if version != 2 {
        return Err(Error::Version {
            file: one_line(file),
            place: "GLB header",
            version: version.to_string(),
            readable: "GLB version 2",
        });
    }
    let Some(body) = bytes.get(..length as usize).filter(|b| b.len() >= 12) else {
        let what = format!("says {length} bytes, the file has {}; it is incomplete or damaged", bytes.len());
        return Err(syntax("GLB header".into(), what));
    };

    // Chunks: length, kind, data. The first is JSON, BIN may follow, others are for extensions.
    let (mut json, mut binary) = (None, None);
    let mut offset = 12;
    let mut index = 0;
    while offset < body.len() {
        let place = || format!("GLB chunk {index} at byte {offset}");
        let (Some(chunk_length), Some(kind)) = (word(offset), word(offset + 4)) else {
            return Err(syntax(place(), "its header is cut off; the file is incomplete or damaged".into()));
        };
        let start = offset + 8;
        let end = start as u64 + u64::from(chunk_length);
        let Some(data) = usize::try_from(end).ok().and_then(|end| body.get(start..end)) else {
            let left = body.len().saturating_sub(start);
            let what = format!("says {chunk_length} bytes, {left} are left; the file is incomplete or damaged");
            return Err(syntax(place(), what));
        };
        match (index, kind) {
            // Padding should be spaces, but some exporters write zeros.
            (0, JSON_CHUNK) => json = Some(without_trailing_zeros(data)),
            (0, _) => return Err(syntax(place(), "the first chunk is not JSON; the file is damaged".into())),
            (_, BINARY_CHUNK) if binary.is_none() => binary = Some(data),
            _ => {}
        }
        offset = start + data.len();
        index += 1;
    }
    match json {
        Some(json) => Ok(Container { json, binary }),
        None => Err(syntax("GLB header".into(), "no chunk follows; the file is incomplete".into())),
    }
}

fn without_trailing_zeros(bytes: &[u8]) -> &[u8] {
    let end = bytes.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
    &bytes[..end]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(json: &[u8], binary: &[u8]) -> Vec<u8> {
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend(((28 + json.len() + binary.len()) as u32).to_le_bytes());
        for (kind, data) in [(JSON_CHUNK, json), (BINARY_CHUNK, binary)] {
            bytes.extend((data.len() as u32).to_le_bytes());
            bytes.extend(kind.to_le_bytes());
            bytes.extend(data);
        }
        bytes
    }

    #[test]
    fn finds_both_chunks_and_no_cut_goes_unnoticed() {
        let whole = glb(b"{ }{", b"0123");
        assert_eq!(split("f", &whole).unwrap(), Container { json: b"{ }{", binary: Some(b"0123") });
        for cut in 0..whole.len() {
            assert!(split("f", &whole[..cut]).is_err(), "{cut} bytes");
        }
    }

    #[test]
    fn json_may_be_padded_with_zeros() {
        assert_eq!(split("f", &glb(b"{}\0\0", b"")).unwrap().json, b"{}");
    }

    #[test]
    fn a_chunk_longer_than_the_file_is_refused() {
        let mut bytes = glb(b"{}  ", b"0123");
        bytes[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(split("f", &bytes).unwrap_err().to_string().contains("chunk 0 at byte 12"));
    }

    #[test]
    fn text_may_have_a_byte_order_mark() {
        assert_eq!(split("f", b"\xef\xbb\xbf {}").unwrap().json, b" {}");
        assert!(split("f", b"\x89PNG").is_err());
    }
}
