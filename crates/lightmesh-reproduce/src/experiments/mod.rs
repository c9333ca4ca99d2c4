//! The experiments, in the order of the page.

mod colour;
mod density;
mod future;
mod lights;
mod missing_corners;
mod neighbourhoods;
mod resolutions;
mod soft_shadows;
mod today;

use crate::error::Error;
use crate::lab::Lab;
use crate::report::Section;

/// An experiment: inputs, runs, checks and plots are in its function.
pub(crate) struct Experiment {
    /// Its name on the command line and in links.
    pub(crate) id: &'static str,
    pub(crate) title: &'static str,
    /// Which part of the paper it repeats.
    pub(crate) paper: &'static str,
    pub(crate) run: fn(&mut Lab<'_>) -> Result<Section, Error>,
}

/// All experiments.
pub(crate) const EXPERIMENTS: [Experiment; 9] = [
    Experiment {
        id: "lights",
        title: "Standard and modified tracing, by the number of lights",
        paper: "Table 1: about 5,000 triangles, no antialiasing.",
        run: lights::run,
    },
    Experiment {
        id: "resolutions",
        title: "By resolution",
        paper: "Table 2, and the growth of the mesh with the picture's size.",
        run: resolutions::run,
    },
    Experiment {
        id: "density",
        title: "By the density of the mesh",
        paper: "The speed-up where density is halved, and what it costs.",
        run: density::run,
    },
    Experiment {
        id: "soft-shadows",
        title: "Soft shadows",
        paper: "Figures 1-3: a triangle over a floor, one light; beside the method of the paper's reference [4].",
        run: soft_shadows::run,
    },
    Experiment {
        id: "neighbourhoods",
        title: "Neighbourhoods",
        paper: "Figures 4-9: the nearest point at three densities, spheres of two radii.",
        run: neighbourhoods::run,
    },
    Experiment {
        id: "missing-corners",
        title: "Effects of missing corners",
        paper: "Figures 10-11: trilinear reading, and what counts where a corner of the cell cannot be used.",
        run: missing_corners::run,
    },
    Experiment {
        id: "colour",
        title: "Colour bleeding",
        paper: "Section on indirect light; the paper could print no colour.",
        run: colour::run,
    },
    Experiment {
        id: "future",
        title: "What the paper named as future work",
        paper: "Other weights, adaptive meshes, parallel machines.",
        run: future::run,
    },
    Experiment {
        id: "today",
        title: "Where the paper stands today",
        paper: "Its scalar field beside what came after it.",
        run: today::run,
    },
];
