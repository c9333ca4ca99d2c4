//! The state of one reading: the file's name, the options, the budget, the warnings.

use std::fmt::{self, Display};
use std::path::{Path, PathBuf};

use crate::budget::Budget;
use crate::error::{Error, one_line};
use crate::load_options::LoadOptions;
use crate::warnings::Warnings;

/// The state of one reading.
#[derive(Debug)]
pub(super) struct Context<'a> {
    /// The scene file, for messages.
    pub(super) file: &'a str,
    /// The folder that URIs are relative to; `None` if the file may have no URIs.
    pub(super) folder: Option<&'a Path>,
    pub(super) options: &'a LoadOptions,
    pub(super) budget: Budget,
    pub(super) warnings: Warnings,
    /// The files that the scene names.
    pub(super) files: Vec<PathBuf>,
}

impl<'a> Context<'a> {
    pub(super) fn new(file: &'a str, folder: Option<&'a Path>, options: &'a LoadOptions, budget: Budget) -> Self {
        Self { file, folder, options, budget, warnings: Warnings::default(), files: Vec::new() }
    }

    /// An [`Error::Invalid`] at `place`.
    pub(super) fn invalid(&self, place: impl Display, what: impl Display) -> Error {
        Error::Invalid { file: one_line(self.file), place: one_line(place), what: one_line(what) }
    }

    /// Pays for `count` items of `item_bytes` that are about to be allocated.
    pub(super) fn spend(&mut self, place: impl Display, count: u64, item_bytes: u64) -> Result<(), Error> {
        self.budget.take(self.file, place, count, item_bytes)
    }

    /// `list[index]`, or an error that says who refers to what.
    pub(super) fn get<'l, T>(
        &self,
        list: &'l [T],
        kind: &'static str,
        index: usize,
        referrer: impl Display,
    ) -> Result<&'l T, Error> {
        list.get(index).ok_or_else(|| {
            let what = format_args!("refers to {kind} {index}, but the file has {}; the file is damaged", list.len());
            Error::Invalid { file: one_line(self.file), place: one_line(referrer), what: one_line(what) }
        })
    }
}

/// An object of the file in a message: kind, index and name, as in `node 3 "lamp"`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place<'a> {
    kind: &'static str,
    index: usize,
    name: Option<&'a str>,
}

/// A [`SurfaceInteraction`].
pub(super) fn place<'a>(kind: &'static str, index: usize, name: Option<&'a str>) -> Place<'a> {
    Place { kind, index, name }
}

impl Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.kind, self.index)?;
        match self.name {
            // A long name must not push the message itself off the line.
            Some(name) if name.chars().nth(60).is_some() => {
                write!(f, " {:?}…", name.chars().take(60).collect::<String>())
            }
            Some(name) if !name.is_empty() => write!(f, " {name:?}"),
            _ => Ok(()),
        }
    }
}
