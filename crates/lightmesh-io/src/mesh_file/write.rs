//! Writing mesh files.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::Path;

use safetensors::tensor::TensorInfo;
use serde::Serialize;

use super::arrays::to_tensors;
use super::tensor::Tensor;
use super::{MeshFile, read};
use crate::error::{Error, one_line};
use crate::output::StagedFile;

/// The header: keys in the order of the alphabet, so that equal meshes are equal files.
#[derive(Debug, Serialize)]
struct Header<'a> {
    #[serde(rename = "__metadata__")]
    metadata: BTreeMap<&'a str, String>,
    #[serde(flatten)]
    tensors: BTreeMap<&'a str, TensorInfo>,
}

/// Writes a mesh file, whole or not at all: under a temporary name beside `path`, which it gets when it is complete.
///
/// # Errors
/// If the folder is missing or not writable, or `path` is a folder.
pub fn write_mesh(path: &Path, mesh: &MeshFile) -> Result<(), Error> {
    let mut file = StagedFile::create(path)?;
    write_mesh_to(&mut file, mesh).map_err(|cause| Error::Write { file: one_line(path.display()), cause })?;
    file.commit()
}

/// Writes a mesh file into memory.
pub fn mesh_to_bytes(mesh: &MeshFile) -> Vec<u8> {
    let mut bytes = Vec::new();
    // A vector takes whatever is written into it.
    let _ = write_mesh_to(&mut bytes, mesh);
    bytes
}

/// Writes a mesh file to a writer, such as an [`output::StagedFile`](crate::output::StagedFile).
///
/// # Errors
/// Those of `out`.
pub fn write_mesh_to(out: &mut dyn Write, mesh: &MeshFile) -> io::Result<()> {
    let mut tensors = to_tensors(&mesh.contents);
    // Numbers of more bytes first: then all of them are aligned.
    tensors.sort_by(|a, b| b.dtype.cmp(&a.dtype).then_with(|| a.name.cmp(&b.name)));
    let mut header = serde_json::to_vec(&header(mesh, &tensors)).map_err(io::Error::other)?;
    header.resize(header.len().next_multiple_of(8), b' ');
    out.write_all(&(header.len() as u64).to_le_bytes())?;
    out.write_all(&header)?;
    tensors.iter().try_for_each(|tensor| out.write_all(&tensor.bytes))
}

impl MeshFile {
    /// Returns the bytes of the arrays; the header of a file has a few thousand more.
    pub fn array_bytes(&self) -> u64 {
        to_tensors(&self.contents).iter().map(|tensor| tensor.bytes.len() as u64).sum()
    }
}

fn header<'a>(mesh: &MeshFile, tensors: &'a [Tensor<'_>]) -> Header<'a> {
    let mut infos = BTreeMap::new();
    let mut sums = BTreeMap::new();
    let mut begin = 0;
    for tensor in tensors {
        let end = begin + tensor.bytes.len();
        let info = TensorInfo { dtype: tensor.dtype, shape: tensor.shape.clone(), data_offsets: (begin, end) };
        infos.insert(tensor.name.as_str(), info);
        sums.insert(tensor.name.as_str(), crc32fast::hash(&tensor.bytes));
        begin = end;
    }
    let metadata = BTreeMap::from([
        ("format", read::FORMAT.to_owned()),
        ("version", read::VERSION.to_owned()),
        ("software", mesh.software.clone()),
        ("method", mesh.method.clone()),
        ("settings", mesh.settings.clone()),
        ("units", "metres; lux, RGB".to_owned()),
        ("scene", mesh.scene.to_string()),
        ("settings_fingerprint", mesh.settings_fingerprint.to_string()),
        // Names and numbers: they are always JSON.
        ("crc32", serde_json::to_string(&sums).unwrap_or_default()),
    ]);
    Header { metadata, tensors: infos }
}
