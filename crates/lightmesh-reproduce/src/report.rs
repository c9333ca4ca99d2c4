//! Results: the data of the page and of its JSON.

use serde::{Deserialize, Serialize};

/// The results of one run of the experiments.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The program's version.
    pub version: String,
    /// The day on which it was put together, as in 2026-11-25 (UTC).
    pub date: String,
    /// Whether sizes were small: times mean little then.
    pub quick: bool,
    /// Threads that rendered.
    pub threads: usize,
    /// The experiments in the order of the page.
    pub sections: Vec<Section>,
}

/// The result of one experiment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Section {
    /// Its name in the registry.
    pub id: String,
    /// Its heading.
    pub title: String,
    /// Which part of the paper it repeats.
    pub paper: String,
    /// Paragraphs.
    pub text: Vec<String>,
    /// Measured numbers.
    pub tables: Vec<Table>,
    /// Pictures and plots.
    pub figures: Vec<Figure>,
    /// What the paper claims of it, and whether that holds.
    pub claims: Vec<Claim>,
}

/// A table of numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// What it shows and how it was measured.
    pub caption: String,
    /// Headings, with units.
    pub columns: Vec<String>,
    /// Rows, each with as many cells as there are headings.
    pub rows: Vec<Vec<Cell>>,
}

/// A cell of a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Cell {
    /// Nothing: it was not measured, or the paper does not say.
    Nothing(()),
    /// A count.
    Count(u64),
    /// A measured number.
    Number(f64),
    /// Words.
    Text(String),
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        if number.is_finite() { Self::Number(number) } else { Self::Nothing(()) }
    }
}

impl From<u64> for Cell {
    fn from(number: u64) -> Self {
        Self::Count(number)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl<T: Into<Self>> From<Option<T>> for Cell {
    fn from(cell: Option<T>) -> Self {
        cell.map_or(Self::Nothing(()), Into::into)
    }
}

/// Pictures beside each other, or a plot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// What it shows.
    pub caption: String,
    /// What is shown.
    pub panels: Vec<Panel>,
}

/// One picture or plot of a figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Panel {
    /// What tells it from the others; may be empty.
    pub label: String,
    /// A PNG or SVG, as a data URI.
    pub image: String,
}

/// A claim of the paper and what became of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// What the paper says, in our words.
    pub claim: String,
    /// The paper's number, where it has one.
    pub paper: Option<f64>,
    /// Ours, computed in this run.
    pub ours: f64,
    /// The unit of both; empty for ratios.
    pub unit: String,
    /// Computed from the run.
    pub verdict: Verdict,
    /// How it was judged.
    pub note: String,
}

/// Whether a claim holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Verdict {
    /// The paper is right.
    #[serde(rename = "holds")]
    Holds,
    /// The effect is there, but smaller, or only in part.
    #[serde(rename = "holds differently")]
    Differently,
    /// The effect is not there, or is the contrary.
    #[serde(rename = "does not hold")]
    Fails,
}

impl Verdict {
    /// Judges a claim: whether all of it is true, and whether a part of it is.
    pub(crate) fn of(whole: bool, part: bool) -> Self {
        match (whole, part) {
            (true, _) => Self::Holds,
            (false, true) => Self::Differently,
            (false, false) => Self::Fails,
        }
    }

    /// Returns the words for the page.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Differently => "holds differently",
            Self::Fails => "does not hold",
        }
    }
}

impl Report {
    /// Returns a copy without pictures and plots, only with their captions and labels.
    pub fn without_images(&self) -> Self {
        let mut report = self.clone();
        let panels =
            report.sections.iter_mut().flat_map(|section| &mut section.figures).flat_map(|figure| &mut figure.panels);
        panels.for_each(|panel| panel.image.clear());
        report
    }
}
