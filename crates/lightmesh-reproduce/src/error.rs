//! Errors.

use std::path::PathBuf;

/// Why the experiments stopped.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A render was refused, or cancelled.
    #[error(transparent)]
    Render(#[from] lightmesh::Error),
    /// A file was not read or written.
    #[error(transparent)]
    File(#[from] lightmesh_io::Error),
    /// The folder was not made, or a kept experiment not read.
    #[error("{}: {cause}", path.display())]
    Io {
        /// Which file or folder.
        path: PathBuf,
        /// What the system says.
        cause: std::io::Error,
    },
    /// A plot was not drawn.
    #[error("plot: {0}")]
    Plot(String),
    /// No such experiment.
    #[error("there is no experiment \"{name}\"; there are {known}")]
    Unknown {
        /// What was asked for.
        name: String,
        /// What there is.
        known: String,
    },
    /// Threads could not be started.
    #[error("threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// Numbers did not become JSON.
    #[error("JSON: {0}")]
    Json(#[from] serde_json::Error),
}

impl Error {
    /// Returns whether the user stopped the work.
    pub fn is_cancelled(&self) -> bool {
        matches!(self, Self::Render(lightmesh::Error::Cancelled))
    }
}
