//! The files that a render leaves.

use std::{
    io,
    path::{Path, PathBuf},
};

use anyhow::anyhow;
use lightmesh::Frame;
use lightmesh_io::{
    MeshFile,
    output::{Format, Metadata, Precision, StagedFile, write_exr, write_png},
    write_mesh_to,
};

use crate::{args::RenderArgs, exit::Failure, interrupt};

/// The output files for pictures, statistics and the mesh, checked before any work is done.
#[derive(Debug)]
pub(crate) struct Outputs {
    pictures: Vec<(PathBuf, Format)>,
    stats: Option<PathBuf>,
    mesh: Option<PathBuf>,
}

impl Outputs {
    /// Checks each extension, that no file is named twice, and that each can be created, the preview too.
    pub(crate) fn check(args: &RenderArgs) -> Result<Self, Failure> {
        let RenderArgs { output, stats, save_mesh, preview, .. } = args;
        let formats = output.iter().map(|path| Ok((path.clone(), Format::of(path).map_err(Failure::input)?)));
        let pictures = formats.collect::<Result<_, Failure>>()?;
        let outputs = Self { pictures, stats: stats.clone(), mesh: save_mesh.clone() };
        let all: Vec<&PathBuf> = output.iter().chain(stats).chain(save_mesh).chain(preview).collect();
        if let Some(path) = preview.as_deref().filter(|path| !matches!(Format::of(path), Ok(Format::Png))) {
            return Err(Failure::Input(anyhow!("{}: a preview is a .png file", path.display())));
        }
        for (i, path) in all.iter().enumerate() {
            if all[..i].contains(path) {
                return Err(Failure::Input(anyhow!("{}: named twice as an output", path.display())));
            }
            // Created and dropped: what can be found out about the place now should not cost a render.
            StagedFile::create(path).map_err(Failure::input)?;
        }
        Ok(outputs)
    }

    /// Returns whether any picture needs an exposure.
    pub(crate) fn has_png(&self) -> bool {
        self.pictures.iter().any(|(_, format)| *format == Format::Png)
    }

    /// Returns whether any picture can have layers.
    pub(crate) fn has_exr(&self) -> bool {
        self.pictures.iter().any(|(_, format)| *format == Format::Exr)
    }

    /// Writes every picture under a temporary name.
    pub(crate) fn stage_pictures(
        &self,
        frame: &Frame,
        ev: f32,
        precision: Precision,
        metadata: &Metadata,
    ) -> Result<Vec<StagedFile>, Failure> {
        self.pictures
            .iter()
            .map(|(path, format)| {
                stage(path, |file| match format {
                    Format::Png => write_png(file, &frame.image, ev, metadata),
                    Format::Exr => write_exr(file, &frame.image, &frame.layers, precision, metadata),
                })
            })
            .collect()
    }

    /// Writes the statistics, if they are wanted, under a temporary name.
    pub(crate) fn stage_stats(&self, json: &str) -> Result<Option<StagedFile>, Failure> {
        let write = |path| stage(path, |file| io::Write::write_all(file, json.as_bytes()));
        self.stats.as_deref().map(write).transpose()
    }

    /// Writes the mesh, if there is a file for it, under a temporary name.
    pub(crate) fn stage_mesh(&self, mesh: impl FnOnce() -> MeshFile) -> Result<Option<StagedFile>, Failure> {
        let write = |path| stage(path, |file| write_mesh_to(file, &mesh()));
        self.mesh.as_deref().map(write).transpose()
    }
}

/// Gives every staged file its name.
pub(crate) fn commit(files: impl IntoIterator<Item = StagedFile>) -> Result<(), Failure> {
    files.into_iter().try_for_each(|file| file.commit().map_err(Failure::work))
}

/// Creates a file under a temporary name and fills it; an unfinished one is removed, also by Ctrl-C.
pub(crate) fn stage(
    target: &Path,
    write: impl FnOnce(&mut StagedFile) -> io::Result<()>,
) -> Result<StagedFile, Failure> {
    let mut file = StagedFile::create(target).map_err(Failure::work)?;
    interrupt::remove_at_end(file.temporary().to_owned());
    write(&mut file).map_err(|error| Failure::Work(anyhow!(error).context(target.display().to_string())))?;
    Ok(file)
}
