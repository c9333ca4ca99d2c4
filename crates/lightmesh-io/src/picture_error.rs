//! What can go wrong with a picture file.

use std::{io, path::PathBuf};

/// A picture that cannot be read, or a place to which none can be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// The operating system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The folder that should hold the file is not there.
    #[error("{}: the folder {} does not exist", path.display(), folder.display())]
    NoFolder {
        /// The file.
        path: PathBuf,
        /// The folder that is missing.
        folder: PathBuf,
    },
    /// A folder has the name that the file should get.
    #[error("{}: is a folder; name a file in it", path.display())]
    IsFolder {
        /// The folder.
        path: PathBuf,
    },
    /// The extension says neither PNG nor EXR.
    #[error("{}: pictures are .png or .exr by their extension", path.display())]
    UnknownExtension {
        /// The file.
        path: PathBuf,
    },
    /// The file's content is not what its extension says, is damaged, or is of a kind that is not read.
    #[error("{}: {what}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// What was found.
        what: String,
    },
}
