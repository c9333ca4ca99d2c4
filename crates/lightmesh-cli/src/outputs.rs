//! The files that a render leaves.

use std::{
    io,
    path::{Path, PathBuf},
};

use anyhow::anyhow;
use lightmesh::Frame;
use lightmesh_io::{
    Error, MeshFile,
    output::{Batch, Format, Metadata, Precision, StagedFile, claim, is_same_file, write_exr, write_png},
    write_mesh_to,
};

use crate::{
    args::{EnvironmentArg, RenderArgs, Surroundings},
    exit::Failure,
    interrupt,
};

/// The output files for pictures, statistics and the mesh, checked before any work is done. They are ours from then on:
/// no other process can begin to write them.
#[derive(Debug)]
pub(crate) struct Outputs {
    /// What is replaced or removed, by option.
    names: Vec<(&'static str, PathBuf)>,
    formats: Vec<Format>,
    pictures: Vec<StagedFile>,
    stats: Option<StagedFile>,
    mesh: Option<StagedFile>,
    preview: Option<StagedFile>,
}

impl Outputs {
    /// Checks each extension, that no file is named twice or is read, and that each can be created, the preview too.
    pub(crate) fn check(args: &RenderArgs, surroundings: &Surroundings) -> Result<Self, Failure> {
        let RenderArgs { output, stats, save_mesh, preview, .. } = args;
        // Check what the names say.
        let formats = output.iter().map(|path| Format::of(path).map_err(Failure::input)).collect::<Result<_, _>>()?;
        if let Some(path) = preview.as_deref().filter(|path| !matches!(Format::of(path), Ok(Format::Png))) {
            return Err(Failure::Input(anyhow!("{}: a preview is a .png file", path.display())));
        }

        // Check that they spare what is read.
        let pictures = output.iter().map(|path| ("--output", path));
        let others = [("--stats", stats), ("--save-mesh", save_mesh), ("--preview", preview)];
        let others = others.into_iter().filter_map(|(option, path)| Some((option, path.as_ref()?)));
        let names: Vec<_> = pictures.chain(others).map(|(option, path)| (option, path.clone())).collect();
        let mut inputs: Vec<(&str, &Path)> = vec![("the scene", &args.scene)];
        inputs.extend(args.mesh.as_deref().map(|mesh| ("the light mesh of --mesh,", mesh)));
        if let Some(EnvironmentArg::File(map)) = &surroundings.emitters.environment {
            inputs.push(("the environment map", map));
        }
        inputs.iter().try_for_each(|(what, input)| refuse_replacing(&names, what, input))?;

        // Make all of them, empty: what can be found out about the place now should not cost a render.
        let paths: Vec<PathBuf> = names.iter().map(|(_, path)| path.clone()).collect();
        let files = claim(&paths).map_err(|error| match error {
            Error::InUse { .. } => Failure::work(error),
            error => Failure::input(error),
        })?;
        let leftovers: Vec<_> = files
            .iter()
            .zip(&names)
            .flat_map(|(file, (option, _))| file.leftovers().into_iter().map(|path| (*option, path)))
            .collect();
        inputs.iter().try_for_each(|(what, input)| refuse_replacing(&leftovers, what, input))?;
        files.iter().for_each(remove_at_end);
        let mut files = files.into_iter();
        let pictures = files.by_ref().take(output.len()).collect();
        let mut if_named = |path: &Option<PathBuf>| path.as_ref().and_then(|_| files.next());
        let (stats, mesh, preview) = (if_named(stats), if_named(save_mesh), if_named(preview));
        let names = names.into_iter().chain(leftovers).collect();
        Ok(Self { names, formats, pictures, stats, mesh, preview })
    }

    /// Checks that no output would take the place of a file that the scene names.
    pub(crate) fn spare(&self, files_of_the_scene: &[PathBuf]) -> Result<(), Failure> {
        files_of_the_scene.iter().try_for_each(|file| refuse_replacing(&self.names, "a file of the scene,", file))
    }

    /// Returns whether any picture needs an exposure.
    pub(crate) fn has_png(&self) -> bool {
        self.formats.contains(&Format::Png)
    }

    /// Returns whether any picture can have layers.
    pub(crate) fn has_exr(&self) -> bool {
        self.formats.contains(&Format::Exr)
    }

    /// Returns the file of the preview.
    pub(crate) fn take_preview(&mut self) -> Option<StagedFile> {
        self.preview.take()
    }

    /// Writes every picture under its temporary name.
    pub(crate) fn stage_pictures(
        &mut self,
        frame: &Frame,
        ev: f32,
        precision: Precision,
        metadata: &Metadata,
    ) -> Result<Vec<StagedFile>, Failure> {
        let files = std::mem::take(&mut self.pictures).into_iter().zip(&self.formats);
        files
            .map(|(file, format)| {
                fill(file, |file| match format {
                    Format::Png => write_png(file, &frame.image, ev, metadata),
                    Format::Exr => write_exr(file, &frame.image, &frame.layers, precision, metadata),
                })
            })
            .collect()
    }

    /// Writes the statistics, if they are wanted, under their temporary name.
    pub(crate) fn stage_stats(&mut self, json: &str) -> Result<Option<StagedFile>, Failure> {
        let file = self.stats.take();
        file.map(|file| fill(file, |file| io::Write::write_all(file, json.as_bytes()))).transpose()
    }

    /// Writes the mesh, if there is a file for it, under its temporary name.
    pub(crate) fn stage_mesh(&mut self, mesh: impl FnOnce() -> MeshFile) -> Result<Option<StagedFile>, Failure> {
        self.mesh.take().map(|file| fill(file, |file| write_mesh_to(file, &mesh()))).transpose()
    }
}

/// Refuses outputs that are the file `input`, however they are spelled.
fn refuse_replacing(names: &[(&str, PathBuf)], what: &str, input: &Path) -> Result<(), Failure> {
    match names.iter().find(|(_, path)| is_same_file(path, input)) {
        None => Ok(()),
        Some((option, path)) => Err(Failure::Input(anyhow!(
            "{}: {option} would replace {what} {}; name another file",
            path.display(),
            input.display()
        ))),
    }
}

/// Fills a file under its temporary name; an unfinished one is removed, also by Ctrl-C.
pub(crate) fn fill(
    file: StagedFile,
    write: impl FnOnce(&mut StagedFile) -> io::Result<()>,
) -> Result<StagedFile, Failure> {
    let mut file = file.renewed().map_err(Failure::work)?;
    remove_at_end(&file);
    write(&mut file).map_err(|cause| Failure::work(file.error(cause)))?;
    Ok(file)
}

/// Gives every file its name: all, or none.
pub(crate) fn commit(files: impl IntoIterator<Item = StagedFile>) -> Result<(), Failure> {
    let files: Vec<StagedFile> = files.into_iter().collect();
    let temporaries: Vec<PathBuf> = files.iter().filter_map(|file| Some(file.temporary()?.to_owned())).collect();
    let batch = Batch::complete(files).map_err(Failure::work)?;
    interrupt::undisturbed(&temporaries, || batch.commit()).map_err(Failure::work)
}

/// Has the temporary removed where the program is ended.
pub(crate) fn remove_at_end(file: &StagedFile) {
    if let Some(temporary) = file.temporary() {
        interrupt::remove_at_end(temporary.to_owned());
    }
}
