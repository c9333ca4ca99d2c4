//! Formats of picture files.

use std::path::Path;

use crate::error::{Error, one_line};

/// A picture file's format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 8-bit sRGB.
    Png,
    /// Linear floating point.
    Exr,
}

impl Format {
    /// The format that the extension names, in either case.
    ///
    /// # Errors
    /// [`Error::PictureFormat`] for any other or none.
    pub fn of(path: &Path) -> Result<Self, Error> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        match extension.as_str() {
            "png" => Ok(Self::Png),
            "exr" => Ok(Self::Exr),
            _ => Err(Error::PictureFormat { file: one_line(path.display()) }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_decides_in_either_case() {
        assert_eq!(Format::of(Path::new("a/b.PNG")).unwrap(), Format::Png);
        assert_eq!(Format::of(Path::new("b.c.exr")).unwrap(), Format::Exr);
        for name in ["b", "b.jpg", ".png", "exr", ""] {
            let message = Format::of(Path::new(name)).unwrap_err().to_string();
            assert!(message.starts_with(name) && message.contains(".exr"), "{message}");
        }
    }
}
