//! A picture's file before it is believed: regular, of known length, with a header that its length can hold.

use std::fmt::Display;
use std::fs::{self, File};
use std::io::{self, BufReader};
use std::path::Path;

use crate::error::{Error, one_line};

/// The most pixels that are read, 16,384 × 16,384: a damaged header must not take the machine's memory.
pub(crate) const MAX_PIXELS: u64 = 1 << 28;
/// The most bytes of samples, in all layers and channels: four 32-bit channels of the most pixels.
const MAX_SAMPLE_BYTES: u64 = 16 * MAX_PIXELS;

/// A file that is open, its name and its length.
#[derive(Clone, Debug)]
pub(crate) struct PictureFile {
    /// The name for messages.
    pub(crate) name: String,
    /// Bytes.
    pub(crate) length: u64,
}

impl PictureFile {
    /// Opens a regular file: a pipe or a device could keep us waiting for ever.
    pub(crate) fn open(path: &Path) -> Result<(Self, BufReader<File>), Error> {
        let name = one_line(path.display());
        let unreadable = |cause| Error::Read { file: name.clone(), cause };
        let metadata = fs::metadata(path).map_err(unreadable)?;
        if !metadata.is_file() {
            return Err(Error::Picture { file: name, what: "is not a regular file".to_owned() });
        }
        let reader = BufReader::new(File::open(path).map_err(unreadable)?);
        Ok((Self { name, length: metadata.len() }, reader))
    }

    /// An [`Error::Picture`] about it.
    pub(crate) fn invalid(&self, what: impl Display) -> Error {
        Error::Picture { file: self.name.clone(), what: one_line(what) }
    }

    /// An [`Error::Read`] about it.
    pub(crate) fn unreadable(&self, cause: io::Error) -> Error {
        Error::Read { file: self.name.clone(), cause }
    }

    /// Refuses sizes beyond the limit.
    pub(crate) fn check_size(&self, width: u64, height: u64) -> Result<(), Error> {
        if width.saturating_mul(height) <= MAX_PIXELS {
            return Ok(());
        }
        Err(self.invalid(format_args!("its header says {width}x{height}; at most {MAX_PIXELS} pixels are read")))
    }

    /// Refuses `needed` bytes of samples if they are too many, or more than `expansion` times the file's length.
    pub(crate) fn check_samples(&self, needed: u64, expansion: u64) -> Result<(), Error> {
        let length = self.length;
        if needed > MAX_SAMPLE_BYTES {
            let what =
                format_args!("its header announces {needed} bytes of samples; at most {MAX_SAMPLE_BYTES} are read");
            return Err(self.invalid(what));
        }
        if needed > length.saturating_mul(expansion) {
            let what = format_args!(
                "its header announces {needed} bytes of samples, which its {length} bytes cannot hold; is it cut off?"
            );
            return Err(self.invalid(what));
        }
        Ok(())
    }
}
