//! Errors of reading and writing files.

use std::fmt::Display;
use std::io;

use lightmesh::human_bytes;

/// An error of reading or writing a file.
///
/// Each message is one line that names the file, the place in it and what to check. Where another error is the cause,
/// its text is part of the message, so a chain printer has nothing to add.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system would not read a file.
    #[error("{file}: cannot be read: {cause}; check the path and its permissions")]
    Read {
        /// The file.
        file: String,
        /// What the operating system said.
        cause: io::Error,
    },
    /// Neither the name nor the content is of a kind that we read.
    #[error("{file}: {what}; lightmesh reads {readable}")]
    UnknownFormat {
        /// The file.
        file: String,
        /// What it looks like.
        what: String,
        /// The formats that can be read.
        readable: &'static str,
    },
    /// The container or its text cannot be parsed: cut off, or not of the format that its name says.
    #[error("{file}: {place}: {what}")]
    Syntax {
        /// The file.
        file: String,
        /// Chunk, byte offset or line.
        place: String,
        /// What is wrong and what to check.
        what: String,
    },
    /// The file parses but contradicts itself or holds values that no scene can have.
    #[error("{file}: {place}: {what}")]
    Invalid {
        /// The file.
        file: String,
        /// Which object, by kind, index and name.
        place: String,
        /// What is wrong and what to check.
        what: String,
    },
    /// A version of the format that we do not read.
    #[error(
        "{file}: {place}: version {version} is not read, only {readable}; \
         export the scene again with a current exporter"
    )]
    Version {
        /// The file.
        file: String,
        /// Where the version stands.
        place: &'static str,
        /// What it says.
        version: String,
        /// The versions that can be read.
        readable: &'static str,
    },
    /// The file cannot be understood without an extension that we do not read.
    #[error("{file}: extensionsRequired: {extension} is not read; {advice}")]
    RequiredExtension {
        /// The file.
        file: String,
        /// Its name.
        extension: String,
        /// How to convert the file.
        advice: String,
    },
    /// A reference to another file that is not followed.
    #[error("{file}: {place}: uri {uri:?} {what}")]
    Uri {
        /// The file.
        file: String,
        /// Which buffer or image.
        place: String,
        /// The reference, shortened.
        uri: String,
        /// Why it is refused and what to do.
        what: String,
    },
    /// A file that the scene refers to cannot be read.
    #[error("{file}: {place}: {target}: cannot be read: {cause}; is it beside the scene file?")]
    MissingFile {
        /// The scene file.
        file: String,
        /// Which buffer or image.
        place: String,
        /// The file that was looked for.
        target: String,
        /// What the operating system said.
        cause: io::Error,
    },
    /// A `data:` URI that is damaged.
    #[error("{file}: {place}: uri {uri:?} {what}")]
    DataUri {
        /// The scene file.
        file: String,
        /// Which buffer or image.
        place: String,
        /// The reference, shortened.
        uri: String,
        /// What is wrong with it.
        what: String,
    },
    /// An image cannot be decoded in the memory that is left.
    #[error("{file}: {place}: the image cannot be decoded: {what}; make it smaller or raise --max-memory")]
    Image {
        /// The scene file.
        file: String,
        /// Which image.
        place: String,
        /// What the decoder said.
        what: String,
    },
    /// Reading on would need more memory than allowed; it was not allocated.
    #[error(
        "{file}: {place}: needs {} more, {} is left of the limit of {}; check the file or raise --max-memory",
        human_bytes(*.needed_bytes), human_bytes(*.left_bytes), human_bytes(*.limit_bytes)
    )]
    OutOfMemory {
        /// The scene file.
        file: String,
        /// What the memory is for.
        place: String,
        /// Bytes it would take.
        needed_bytes: u64,
        /// Bytes left for it.
        left_bytes: u64,
        /// [`LoadOptions::max_memory`](crate::LoadOptions::max_memory).
        limit_bytes: u64,
    },
    /// The scene that was asked for is not in the file.
    #[error("{file}: scene {scene:?} is not in the file, which has {available}")]
    NoSuchScene {
        /// The file.
        file: String,
        /// The name or index that was asked for.
        scene: String,
        /// The scenes it has.
        available: String,
    },
    /// The file holds no surface.
    #[error("{file}: nothing to render: {what}")]
    Empty {
        /// The file.
        file: String,
        /// What is missing.
        what: String,
    },
    /// A picture's extension says neither PNG nor EXR.
    #[error("{file}: pictures are .png or .exr by their extension")]
    PictureFormat {
        /// The file.
        file: String,
    },
    /// An environment map's extension says neither Radiance nor EXR.
    #[error("{file}: environment maps are .hdr or .exr by their extension")]
    EnvironmentFormat {
        /// The file.
        file: String,
    },
    /// A picture's content is not what its extension says, is damaged, is too large or is of a kind that is not read.
    #[error("{file}: {what}")]
    Picture {
        /// The file.
        file: String,
        /// What was found.
        what: String,
    },
    /// A mesh file of another scene.
    #[error(
        "{file}: was made for another scene: geometry, materials, textures, lights or the number of light samples differ; \
         fill a mesh for this one"
    )]
    OtherScene {
        /// The file.
        file: String,
    },
    /// A mesh file of other settings.
    #[error("{file}: the mesh {what}")]
    OtherSettings {
        /// The file.
        file: String,
        /// What differs, with both values.
        what: String,
    },
    /// The contents of a mesh file do not fit the scene.
    #[error("{file}: {cause}")]
    Mesh {
        /// The file.
        file: String,
        /// What the mesh said.
        cause: lightmesh::Error,
    },
    /// The folder that should hold a file that is to be written is not there.
    #[error("{file}: the folder {folder} does not exist")]
    NoFolder {
        /// The file.
        file: String,
        /// The folder that is missing.
        folder: String,
    },
    /// A folder has the name that a file should get.
    #[error("{file}: is a folder; name a file in it")]
    IsFolder {
        /// The folder.
        file: String,
    },
    /// Two outputs are one file.
    #[error("{file}: named twice as an output{}", if .other == .file { String::new() } else { format!(": it is the same file as {other}") })]
    SameOutput {
        /// The second of them.
        file: String,
        /// The first.
        other: String,
    },
    /// Another process is writing the file.
    #[error("{file}: another program is writing it; wait until that has ended, or name another file")]
    InUse {
        /// The file.
        file: String,
    },
    /// The operating system would not write a file.
    #[error("{file}: cannot be written: {cause}")]
    Write {
        /// The file.
        file: String,
        /// What the operating system said.
        cause: io::Error,
    },
    /// The operating system would not write a file, and those before it could not be taken back.
    #[error("{file}: cannot be written: {cause}; {replaced} is already replaced")]
    PartlyWritten {
        /// The file.
        file: String,
        /// What the operating system said.
        cause: io::Error,
        /// The files that are new, separated by commas.
        replaced: String,
    },
}

/// `text` on one line of at most 300 characters: what comes from a file may hold anything.
pub(crate) fn one_line(text: impl Display) -> String {
    const LONGEST: usize = 300;
    let text = text.to_string();
    let mut line = String::with_capacity(text.len().min(2 * LONGEST));
    for (n, c) in text.chars().enumerate() {
        if n == LONGEST {
            line.push('…');
            break;
        }
        if c.is_control() { line.extend(c.escape_default()) } else { line.push(c) }
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_stay_on_one_line() {
        assert_eq!(one_line("a\nb\u{1b}"), "a\\nb\\u{1b}");
        assert_eq!(one_line("x".repeat(1000)).chars().count(), 301);
    }
}
