//! The experiments of V. A. Debelov and I. M. Sevastyanov, "Original approach to simulation of soft shadows and diffuse
//! color bleeding in ray tracing" (GraphiCon 2001; *the paper*), run anew with the tracers of `lightmesh`.
//!
//! [`reproduce`] runs them one after the other, keeps what each has found, and writes a page that needs nothing else,
//! with its numbers beside it as JSON. Each claim of the paper is judged by numbers of the run.

#![forbid(unsafe_code)]

mod error;
mod experiments;
mod files;
mod lab;
mod page;
mod penumbra;
mod picture;
mod plot;
mod report;
mod scenes;
mod watcher;

use std::path::Path;

pub use error::Error;
pub use report::{Cell, Claim, Figure, Panel, Report, Section, Table, Verdict};
pub use watcher::Watcher;

use experiments::EXPERIMENTS;
use files::Folder;
use lab::Lab;

/// Options of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Small pictures: all of it within a minute, but times mean little.
    pub quick: bool,
    /// Run also those experiments again whose results are kept.
    pub force: bool,
    /// The experiments to run, by name; empty: all.
    pub only: Vec<String>,
}

/// The page's file in the folder, and that of its numbers.
pub const PAGE: &str = "index.html";
/// See [`PAGE`].
pub const NUMBERS: &str = "report.json";

/// The schema of [`NUMBERS`] (JSON Schema, 2020-12).
pub const SCHEMA: &str = include_str!("report.schema.json");

/// Names and titles of all experiments, in the order of the page.
pub fn experiments() -> impl Iterator<Item = (&'static str, &'static str)> {
    EXPERIMENTS.iter().map(|experiment| (experiment.id, experiment.title))
}

/// Runs the experiments and writes a folder: [`PAGE`], [`NUMBERS`], and `experiments/` with the result of each, so that
/// the next run can go on from there. A result of another size, version or number of threads is computed again.
///
/// # Errors
/// [`Error`]; experiments that were finished are kept.
pub fn reproduce(folder: &Path, options: &Options, watcher: &dyn Watcher) -> Result<Report, Error> {
    // Refuse unknown names before any work.
    if let Some(name) = options.only.iter().find(|name| EXPERIMENTS.iter().all(|e| e.id != name.as_str())) {
        let known = EXPERIMENTS.map(|e| e.id).join(", ");
        return Err(Error::Unknown { name: name.clone(), known });
    }

    // Set up the folder, the report and the lab.
    let folder = Folder::create(folder)?;
    let mut report = Report {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        date: jiff::Timestamp::now().strftime("%Y-%m-%d").to_string(),
        quick: options.quick,
        threads: rayon::current_num_threads(),
        sections: Vec::new(),
    };
    let mut lab = Lab::new(options.quick, watcher);

    // Run each wanted experiment, unless an earlier run left its result in the folder.
    let wanted: Vec<_> = EXPERIMENTS
        .iter()
        .filter(|e| options.only.is_empty() || options.only.iter().any(|name| name == e.id))
        .collect();
    for (done, experiment) in wanted.iter().enumerate() {
        watcher.begin(experiment.title, done, wanted.len());
        let kept = if options.force { None } else { folder.kept(experiment.id, &report)? };
        let section = match kept {
            Some(section) => section,
            None => {
                let section = Section {
                    id: experiment.id.to_owned(),
                    title: experiment.title.to_owned(),
                    paper: experiment.paper.to_owned(),
                    ..(experiment.run)(&mut lab)?
                };
                folder.keep(&section, &report)?;
                section
            }
        };
        report.sections.push(section);
    }

    // Write the numbers and the page.
    watcher.begin("writing the page", wanted.len(), wanted.len());
    folder.write(NUMBERS, &(serde_json::to_string_pretty(&report.without_images())? + "\n"))?;
    folder.write(PAGE, &page::html(&report))?;
    Ok(report)
}
