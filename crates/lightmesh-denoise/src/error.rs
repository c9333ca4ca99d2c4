//! Errors.

use std::path::PathBuf;

use lightmesh::human_bytes;

/// How to get the library, for messages.
const HOW_TO_GET: &str = "install it with `pip install pyoidn` or as a package of the system (openimagedenoise), or set \
                          LIGHTMESH_OIDN to its file or folder";

/// What denoising can fail at.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No place has the library.
    #[error("Open Image Denoise was not found: tried {}; {HOW_TO_GET}", tried.join(", "))]
    NotFound {
        /// Each place that was looked at, and what was wrong with it where something was.
        tried: Vec<String>,
    },
    /// The file or folder that the user names is not the library.
    #[error("LIGHTMESH_OIDN: {}: {what}; it must name the library of Open Image Denoise 2 or its \
             folder, which `pip install pyoidn` or a package of the system brings", path.display())]
    Named {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// The library was loaded and answers with an error.
    #[error("Open Image Denoise failed: {what}")]
    Library {
        /// What it says.
        what: String,
    },
    /// The progress asked for an end.
    #[error("cancelled")]
    Cancelled,
    /// An image does not have three values for each pixel.
    #[error("{image}: {width} x {height} pixels have {expected} values, not {found}")]
    Size {
        /// Which image.
        image: &'static str,
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Three for each pixel.
        expected: u64,
        /// What it has.
        found: u64,
    },
    /// The picture lacks layers that denoising reads.
    #[error("the picture lacks the layer(s) {}, which denoising reads", missing.join(", "))]
    MissingLayers {
        /// Their names.
        missing: Vec<&'static str>,
    },
    /// The work takes more memory than is allowed.
    #[error(
        "denoising a picture of this size takes {}, and the limit is {}: choose a smaller --size or raise --max-memory",
        human_bytes(*needed_bytes),
        human_bytes(*limit_bytes)
    )]
    OutOfMemory {
        /// What it takes.
        needed_bytes: u64,
        /// What is allowed.
        limit_bytes: u64,
    },
}
