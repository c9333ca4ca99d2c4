//! URIs of buffers and images: data in the file, or a file beside it.

use std::fmt::Display;
use std::io;

use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use super::context::{Context, Place};
use crate::beside::{self, OUTSIDE, Refusal};
use crate::error::{Error, one_line};

/// Base64 as exporters write it, with or without padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// The bytes that `uri` stands for, paid from the budget before they are read.
pub(super) fn fetch(context: &mut Context<'_>, place: Place<'_>, uri: &str) -> Result<Vec<u8>, Error> {
    match uri.get(..5).filter(|scheme| scheme.eq_ignore_ascii_case("data:")) {
        Some(_) => decode_data(context, place, uri),
        None => read_beside(context, place, uri),
    }
}

/// Notes that the document names a file, whether the scene uses it or not.
pub(super) fn note_file(context: &mut Context<'_>, uri: &str) {
    let is_data = uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"));
    if !is_data
        && !has_scheme(uri)
        && let Ok(relative) = String::from_utf8(percent_decode(uri))
    {
        context.files.extend(beside::path_of(context.folder, &relative, context.options.allow_outside));
    }
}

/// A URI that is not followed.
fn refuse(context: &Context<'_>, place: Place<'_>, uri: &str, what: &str) -> Error {
    Error::Uri { file: one_line(context.file), place: one_line(place), uri: shortened(uri), what: what.to_owned() }
}

/// The start of a URI, for messages.
fn shortened(uri: &str) -> String {
    let mut short: String = uri.chars().take(80).collect();
    if short.len() < uri.len() {
        short.push('…');
    }
    short
}

/// `data:[type][;base64],…` (RFC 2397).
fn decode_data(context: &mut Context<'_>, place: Place<'_>, uri: &str) -> Result<Vec<u8>, Error> {
    let damaged = |context: &Context<'_>, what: String| Error::DataUri {
        file: one_line(context.file),
        place: one_line(place),
        uri: shortened(uri),
        what,
    };
    let Some((head, body)) = uri.split_once(',') else {
        return Err(damaged(context, "has no comma before its data; the file is damaged".to_owned()));
    };
    context.spend(place, body.len() as u64, 1)?;
    if head.to_ascii_lowercase().ends_with(";base64") {
        BASE64.decode(body).map_err(|e| damaged(context, format!("is not valid base64: {e}")))
    } else {
        Ok(percent_decode(body))
    }
}

/// Replaces each `%XX` by its byte. A percent sign that starts no escape stays: exporters forget to encode it.
fn percent_decode(text: &str) -> Vec<u8> {
    let bytes = text.as_bytes();
    let hex = |b: Option<&u8>| b.and_then(|&b| char::from(b).to_digit(16));
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut index = 0;
    while index < bytes.len() {
        match (bytes[index], hex(bytes.get(index + 1)), hex(bytes.get(index + 2))) {
            (b'%', Some(high), Some(low)) => {
                decoded.push((high * 16 + low) as u8);
                index += 3;
            }
            (byte, ..) => {
                decoded.push(byte);
                index += 1;
            }
        }
    }
    decoded
}

/// Returns whether the URI begins with a scheme (RFC 3986: letter, then letters, digits, `+ - .`, then a colon). `C:`
/// is one too.
fn has_scheme(uri: &str) -> bool {
    uri.split_once(':').is_some_and(|(scheme, _)| {
        scheme.starts_with(|c: char| c.is_ascii_alphabetic())
            && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
    })
}

/// Reads the file at a relative path.
fn read_beside(context: &mut Context<'_>, place: Place<'_>, uri: &str) -> Result<Vec<u8>, Error> {
    // Decode the name of the file.
    if has_scheme(uri) {
        let what = "has a scheme, but only data: and files beside the scene are read; \
                    download the file and refer to it by a relative path";
        return Err(refuse(context, place, uri, what));
    }
    let Ok(relative) = String::from_utf8(percent_decode(uri)) else {
        return Err(refuse(context, place, uri, "is not UTF-8 after percent-decoding; rename the file"));
    };

    // Open the file, or say in the words of glTF why not.
    let missing = |context: &Context<'_>, target: &dyn Display, cause| Error::MissingFile {
        file: one_line(context.file),
        place: one_line(place),
        target: one_line(target),
        cause,
    };
    let beside = beside::open(context.folder, &relative, context.options.allow_outside).map_err(|why| {
        let what = match why {
            Refusal::NoFolder => "refers to another file, but the scene was not read from a folder",
            Refusal::NotAName => "is no file name; the file is damaged",
            Refusal::Outside => OUTSIDE,
            Refusal::NotAFile => {
                let cause = io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file");
                return missing(context, &relative, cause);
            }
            Refusal::Unreadable { target, cause } => return missing(context, &target.display(), cause),
        };
        refuse(context, place, uri, what)
    })?;

    // Pay for its bytes, and read them.
    context.spend(place, beside.length, 1)?;
    beside.read().map_err(|cause| missing(context, &relative, cause))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percent_escapes() {
        assert_eq!(percent_decode("a%20b%2Fc"), b"a b/c");
        assert_eq!(percent_decode("100%.png%4"), b"100%.png%4");
    }

    #[test]
    fn schemes() {
        for uri in ["http://x/y", "file:///etc/passwd", "C:/a.png", "HTTPS:x"] {
            assert!(has_scheme(uri), "{uri}");
        }
        for uri in ["a.png", "a/b:c.png", ":x", "1:x"] {
            assert!(!has_scheme(uri), "{uri}");
        }
    }
}
