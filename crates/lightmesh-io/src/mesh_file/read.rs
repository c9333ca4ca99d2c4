//! Reads mesh files. Everything in them is checked before it is used, and memory is counted before it is allocated.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::Path;

use safetensors::tensor::{Metadata, TensorInfo};

use super::MeshFile;
use super::arrays::read_contents;
use super::tensor::{Number, to_little_endian};
use crate::budget::Budget;
use crate::error::{Error, one_line};

/// The format and version that the header must have.
pub(super) const FORMAT: &str = "lightmesh mesh";
pub(super) const VERSION: &str = "2";

/// The longest header that is read, bytes: ours have a few thousand.
const LONGEST_HEADER: u64 = 1 << 20;

/// Reads a mesh file into at most `max_memory` bytes.
///
/// # Errors
/// [`Error::Read`]; [`Error::Syntax`] and [`Error::Invalid`] for a file that is not a mesh file, cut off or damaged, or
/// has numbers that are not finite;
/// [`Error::OutOfMemory`] before an allocation that would exceed the limit.
pub fn read_mesh(path: &Path, max_memory: u64) -> Result<MeshFile, Error> {
    let name = one_line(path.display());
    let unreadable = |cause| Error::Read { file: name.clone(), cause };
    let metadata = fs::metadata(path).map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(unreadable(io::Error::new(io::ErrorKind::InvalidInput, "not a regular file")));
    }
    let mut file = BufReader::new(File::open(path).map_err(unreadable)?);
    read(&name, &mut file, metadata.len(), max_memory)
}

/// Reads a mesh file that is in memory; `name` names it in messages.
///
/// # Errors
/// As [`read_mesh`].
pub fn mesh_from_bytes(name: &str, bytes: &[u8], max_memory: u64) -> Result<MeshFile, Error> {
    read(&one_line(name), &mut Cursor::new(bytes), bytes.len() as u64, max_memory)
}

/// A file that can be read at any position.
trait Source: Read + Seek {}

impl<T: Read + Seek> Source for T {}

fn read(name: &str, source: &mut dyn Source, length: u64, max_memory: u64) -> Result<MeshFile, Error> {
    let syntax =
        |place: &str, what: String| Error::Syntax { file: name.into(), place: place.into(), what: one_line(what) };
    let unreadable = |cause| Error::Read { file: name.into(), cause };
    let foreign = "is this a mesh file that lightmesh has written?";

    // Read the length of the header, then the header, and check that the arrays end where the file does.
    let mut word = [0; 8];
    if length < 8 {
        return Err(syntax("header", format!("the file has {length} bytes; {foreign}")));
    }
    source.read_exact(&mut word).map_err(unreadable)?;
    let header_length = u64::from_le_bytes(word);
    if header_length > LONGEST_HEADER {
        return Err(syntax("header", format!("would be {header_length} bytes long; {foreign}")));
    }
    let begin = 8 + header_length;
    if begin > length {
        return Err(syntax("header", format!("ends at byte {begin}, the file at {length}: it is cut off")));
    }
    let mut budget = Budget::new(max_memory);
    budget.take(name, "header", header_length, 1)?;
    let mut header = vec![0; header_length as usize];
    source.read_exact(&mut header).map_err(unreadable)?;
    let header: Metadata =
        serde_json::from_slice(&header).map_err(|error| syntax("header", format!("{error}; {foreign}")))?;
    let said = |key: &str| header.metadata().as_ref().and_then(|said| said.get(key)).map(String::as_str);
    if said("format") != Some(FORMAT) {
        return Err(syntax("header", format!("does not say that its format is {FORMAT:?}; {foreign}")));
    }
    let version = said("version").unwrap_or_default();
    if version != VERSION {
        let what =
            format!("version {version:?} is not read, only {VERSION:?}; write the file anew with this lightmesh");
        return Err(syntax("header", what));
    }
    let end = begin.checked_add(header.data_len() as u64);
    if end != Some(length) {
        let end = end.map_or("beyond all files".to_owned(), |end| format!("at byte {end}"));
        return Err(syntax("arrays", format!("end {end}, the file at {length}: it is cut off or damaged")));
    }

    // Read the texts, then the arrays.
    let text = |key: &str| {
        let missing = || syntax("header", format!("{key:?} is missing"));
        said(key).map(str::to_owned).ok_or_else(missing)
    };
    let fingerprint = |key: &str| {
        let text = text(key)?;
        text.parse().map_err(|_| syntax("header", format!("{key:?} is not a fingerprint")))
    };
    let sums: BTreeMap<String, u32> = serde_json::from_str(&text("crc32")?)
        .map_err(|error| syntax("header", format!("\"crc32\" is not a list of checksums: {error}")))?;
    let (scene, settings_fingerprint) = (fingerprint("scene")?, fingerprint("settings_fingerprint")?);
    let (software, method, settings) = (text("software")?, text("method")?, text("settings")?);
    let mut arrays = ArrayReader { file: name, source, begin, header: &header, sums, budget };
    let contents = read_contents(&mut arrays)?;
    Ok(MeshFile { scene, settings_fingerprint, software, method, settings, contents })
}

/// The shape that an array must have; `None` stands for any number.
#[derive(Clone, Debug)]
pub(super) struct Shape(Vec<Option<usize>>);

impl Shape {
    /// A shape of these numbers.
    pub(super) fn of<const N: usize>(numbers: [usize; N]) -> Self {
        Self(Vec::new()).and(numbers)
    }

    /// A shape of any `count` numbers.
    pub(super) fn any(count: usize) -> Self {
        Self(Vec::new()).and_any(count)
    }

    /// Appends these numbers.
    pub(super) fn and<const N: usize>(mut self, numbers: [usize; N]) -> Self {
        self.0.extend(numbers.map(Some));
        self
    }

    /// Appends any `count` numbers.
    pub(super) fn and_any(mut self, count: usize) -> Self {
        self.0.extend(std::iter::repeat_n(None, count));
        self
    }

    fn fits(&self, shape: &[usize]) -> bool {
        self.0.len() == shape.len()
            && self.0.iter().zip(shape).all(|(wanted, given)| wanted.is_none_or(|n| n == *given))
    }
}

impl std::fmt::Display for Shape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let numbers = self.0.iter().map(|number| number.map_or("any".to_owned(), |number| number.to_string()));
        write!(f, "[{}]", numbers.collect::<Vec<_>>().join(", "))
    }
}

/// Reads arrays by name.
pub(super) struct ArrayReader<'a> {
    file: &'a str,
    source: &'a mut dyn Source,
    /// Where the arrays begin, bytes.
    begin: u64,
    header: &'a Metadata,
    sums: BTreeMap<String, u32>,
    budget: Budget,
}

impl ArrayReader<'_> {
    /// The error for an array that is wrong.
    pub(super) fn invalid(&self, name: &str, what: impl std::fmt::Display) -> Error {
        Error::Invalid { file: self.file.into(), place: name.into(), what: one_line(what) }
    }

    /// Returns whether the file has the array.
    pub(super) fn has(&self, name: &str) -> bool {
        self.header.info(name).is_some()
    }

    /// Converts a number of a shape to 32 bits.
    pub(super) fn small(&self, name: &str, number: usize) -> Result<u32, Error> {
        u32::try_from(number).map_err(|_| self.invalid(name, format!("has {number} in its shape, which is too many")))
    }

    /// Reads an array that must have this shape. Returns its numbers and its own shape.
    pub(super) fn read<N: Number>(&mut self, name: &str, wanted: &Shape) -> Result<(Vec<N>, Vec<usize>), Error> {
        let TensorInfo { shape, .. } = self.info::<N>(name, wanted)?;
        let numbers = self.read_into(name, shape.iter().product())?;
        Ok((numbers, shape))
    }

    /// Reads an array of rows, which must be `rows` if that is given. Returns the rows and their number.
    pub(super) fn read_rows<N: Number, const W: usize>(
        &mut self,
        name: &str,
        rows: Option<usize>,
    ) -> Result<(Vec<[N; W]>, usize), Error>
    where
        [N; W]: bytemuck::Pod,
    {
        let wanted = rows.map_or(Shape::any(1), |rows| Shape::of([rows])).and([W]);
        let TensorInfo { shape, .. } = self.info::<N>(name, &wanted)?;
        let mut rows = self.take::<[N; W]>(name, shape[0])?;
        self.fill(name, rows.as_flattened_mut())?;
        Ok((rows, shape[0]))
    }

    /// Finds an array in the header, and checks its type and shape.
    fn info<N: Number>(&self, name: &str, wanted: &Shape) -> Result<TensorInfo, Error> {
        let Some(info) = self.header.info(name) else {
            return Err(self.invalid(name, "the array is missing"));
        };
        if info.dtype != N::DTYPE || !wanted.fits(&info.shape) {
            let TensorInfo { dtype, shape, .. } = info;
            return Err(self.invalid(name, format!("is {dtype} {shape:?}, not {} {wanted}", N::DTYPE)));
        }
        Ok(info.clone())
    }

    fn read_into<N: Number>(&mut self, name: &str, count: usize) -> Result<Vec<N>, Error> {
        let mut numbers = self.take(name, count)?;
        self.fill(name, &mut numbers)?;
        Ok(numbers)
    }

    /// Allocates zeros, which are paid for first.
    fn take<T: bytemuck::Zeroable + Clone>(&mut self, name: &str, count: usize) -> Result<Vec<T>, Error> {
        self.budget.take(self.file, name, count as u64, size_of::<T>() as u64)?;
        Ok(vec![T::zeroed(); count])
    }

    /// Reads an array into memory that is there, compares its checksum, and refuses numbers that are not finite: no mesh
    /// has any, and one of them spreads over a picture.
    fn fill<N: Number>(&mut self, name: &str, numbers: &mut [N]) -> Result<(), Error> {
        let unreadable = |cause| Error::Read { file: self.file.into(), cause };
        let offset = self.header.info(name).map_or(0, |info| info.data_offsets.0 as u64);
        self.source.seek(SeekFrom::Start(self.begin + offset)).map_err(unreadable)?;
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(numbers);
        self.source.read_exact(bytes).map_err(unreadable)?;
        if self.sums.get(name) != Some(&crc32fast::hash(bytes)) {
            return Err(self.invalid(name, "is damaged: its checksum is another"));
        }
        to_little_endian(numbers);
        match numbers.iter().position(|number| !number.is_finite()) {
            Some(i) => {
                Err(self
                    .invalid(name, format_args!("number {:?} is {:?}, not finite", self.place(name, i), numbers[i])))
            }
            None => Ok(()),
        }
    }

    /// Returns the indices of an array's number along its axes.
    fn place(&self, name: &str, number: usize) -> Vec<usize> {
        let shape = self.header.info(name).map_or(&[][..], |info| &info.shape);
        let mut left = number;
        let mut indices: Vec<usize> = shape
            .iter()
            .rev()
            .map(|&length| {
                let index = left % length.max(1);
                left /= length.max(1);
                index
            })
            .collect();
        indices.reverse();
        indices
    }
}
