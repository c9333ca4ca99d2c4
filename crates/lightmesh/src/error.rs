//! The errors of the core library.

/// An error of the core library. `lightmesh-io` has its own for files.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The scene description is inconsistent, or has values outside their range.
    #[error("{place}: {what}")]
    InvalidScene {
        /// Which object, by kind, index and name.
        place: String,
        /// What is wrong and what to check.
        what: String,
    },
    /// There is no surface to render.
    #[error("the scene has no surfaces: no triangle, sphere or shape that could be seen")]
    EmptyScene,
    /// An option is outside its range.
    #[error("{option}: {what}")]
    InvalidOption {
        /// The field of [`RenderOptions`](crate::RenderOptions), as the command line spells it.
        option: &'static str,
        /// The range and the value that was given.
        what: String,
    },
    /// A mesh that was made for other options or another picture.
    #[error("the mesh {what}")]
    IncompatibleMesh {
        /// What differs, with both values.
        what: String,
    },
    /// Bricks that a mesh does not have.
    #[error("bricks: {what}")]
    InvalidBricks {
        /// What is wrong and what to check.
        what: String,
    },
    /// Waves that a picture does not have.
    #[error("waves: {what}")]
    InvalidWaves {
        /// What is wrong and what to check.
        what: String,
    },
    /// Parts that do not make up a picture.
    #[error("portions: {what}")]
    InvalidParts {
        /// What is wrong and what to check.
        what: String,
    },
    /// Outlines of emitters that a picture does not have.
    #[error("outlines: {what}")]
    InvalidEmitterEdges {
        /// What is wrong and what to check.
        what: String,
    },
    /// A reflection whose light cannot be computed yet, or from what was given.
    #[error("reflections: {what}")]
    InvalidReflection {
        /// What is wrong and what to check.
        what: String,
    },
    /// A meter whose position or normal is no valid vector.
    #[error("meter {index}: {what}")]
    InvalidMeter {
        /// Its index in the list, from 0.
        index: usize,
        /// What is wrong and what to check.
        what: String,
    },
    /// A snapshot that a mesh cannot merge; the mesh has not changed.
    #[error("mesh contents: {place}: {what}")]
    InvalidContents {
        /// Which field, array and point.
        place: String,
        /// What is wrong and what to check.
        what: String,
    },
    /// The work would need more memory than allowed; nothing was allocated.
    #[error(
        "{what} would need {} of memory, {} more than the limit of {}; {advice}, or raise --max-memory",
        human_bytes(*.needed_bytes), human_bytes(.needed_bytes.saturating_sub(*.limit_bytes)), human_bytes(*.limit_bytes))]
    OutOfMemory {
        /// What the memory is for.
        what: &'static str,
        /// Bytes it would take.
        needed_bytes: u64,
        /// The limit in force, bytes.
        limit_bytes: u64,
        /// Which setting to change.
        advice: &'static str,
    },
    /// The caller asked to stop.
    #[error("cancelled")]
    Cancelled,
}

/// A byte count with a binary unit, as in messages: `1.2 GiB`.
pub fn human_bytes(bytes: u64) -> String {
    const UNITS: [&str; 7] = ["B", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"];
    let mut value = bytes as f64;
    let mut unit = 0;
    while value >= 1024.0 && unit + 1 < UNITS.len() {
        value /= 1024.0;
        unit += 1;
    }
    if unit == 0 { format!("{bytes} B") } else { format!("{value:.1} {}", UNITS[unit]) }
}
