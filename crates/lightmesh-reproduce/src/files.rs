//! The folder of a run: files are written whole or not at all.

use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use lightmesh_io::output::StagedFile;
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::report::{Report, Section};

/// The folder for results.
pub(crate) struct Folder(PathBuf);

/// The result of an experiment, and the kind of run that made it.
#[derive(Serialize, Deserialize)]
struct Kept {
    version: String,
    quick: bool,
    threads: usize,
    section: Section,
}

impl Folder {
    /// Opens the folder, and makes it if it does not exist.
    pub(crate) fn create(path: &Path) -> Result<Self, Error> {
        let experiments = path.join("experiments");
        fs::create_dir_all(&experiments).map_err(|cause| Error::Io { path: experiments, cause })?;
        Ok(Self(path.to_owned()))
    }

    fn experiment(&self, id: &str) -> PathBuf {
        self.0.join("experiments").join(format!("{id}.json"))
    }

    /// Reads the result of an experiment from an earlier run like this one. `None` if there is none, or if its file
    /// cannot be used.
    pub(crate) fn kept(&self, id: &str, run: &Report) -> Result<Option<Section>, Error> {
        let path = self.experiment(id);
        // A pipe could keep us waiting for ever.
        if fs::metadata(&path).is_ok_and(|there| !there.is_file()) {
            return Ok(None);
        }
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(cause) if cause.kind() == ErrorKind::NotFound => return Ok(None),
            Err(cause) => return Err(Error::Io { path, cause }),
        };
        let kept = serde_json::from_str::<Kept>(&text).ok();
        let same = |kept: &Kept| (kept.quick, kept.threads, &kept.version) == (run.quick, run.threads, &run.version);
        Ok(kept.filter(same).map(|kept| kept.section))
    }

    /// Writes the result of an experiment, for later runs.
    pub(crate) fn keep(&self, section: &Section, run: &Report) -> Result<(), Error> {
        let (version, section) = (run.version.clone(), section.clone());
        let kept = Kept { version, quick: run.quick, threads: run.threads, section };
        write(&self.experiment(&kept.section.id), &serde_json::to_string(&kept)?)
    }

    /// Writes a file of the folder.
    pub(crate) fn write(&self, name: &str, text: &str) -> Result<(), Error> {
        write(&self.0.join(name), text)
    }
}

fn write(path: &Path, text: &str) -> Result<(), Error> {
    let mut staged = StagedFile::create(path)?;
    staged.write_all(text.as_bytes()).map_err(|cause| Error::Io { path: path.to_owned(), cause })?;
    Ok(staged.commit()?)
}
