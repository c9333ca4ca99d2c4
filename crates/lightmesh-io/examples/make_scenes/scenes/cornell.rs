//! The Cornell box, life size.
//!
//! Dimensions (millimetres) are the published measurements: Cornell University Program of Computer Graphics, "Cornell
//! Box Data", 1998, <https://www.graphics.cornell.edu/online/box/data.html>. Two changes: the room is made rectangular,
//! 556 × 548.8 × 559.2, where the original's walls are some millimetres out of true; and a point light hangs under the
//! middle of the ceiling instead of the lamp. The colours are roundings of the measured spectra to linear RGB.

use super::document::{Camera, Document, PointLight};
use super::solids::prism;
use super::surface::{Surface, Vec3};

/// Width, height and depth of the room, mm.
const ROOM: Vec3 = [556.0, 548.8, 559.2];
/// The tops of the two blocks (x, z) in mm.
const SHORT_BLOCK: [[f64; 2]; 4] = [[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]];
const TALL_BLOCK: [[f64; 2]; 4] = [[423.0, 247.0], [265.0, 296.0], [314.0, 456.0], [472.0, 406.0]];
/// Their heights, mm.
const HEIGHTS: [f64; 2] = [165.0, 330.0];
/// How far the blocks reach below the floor, so that no two faces lie in one plane, mm.
const SUNK: f64 = 1.0;

/// Metres in our frame from the published one in mm: the room's middle at x = z = 0, the open side towards +Z.
fn place(p: Vec3) -> Vec3 {
    [1e-3 * (ROOM[0] / 2.0 - p[0]), 1e-3 * p[1], 1e-3 * (ROOM[2] / 2.0 - p[2])]
}

/// The scene.
pub(crate) fn cornell() -> Document {
    let [w, h, d] = ROOM;
    // Lens of 35 mm focal length over a film of 25 mm: 2 atan(12.5 / 35).
    let yfov = 2.0 * libm::atan(12.5 / 35.0);
    let camera = Camera { eye: place([278.0, 273.0, -800.0]), target: place([278.0, 273.0, 0.0]), yfov, aspect: 1.0 };
    let mut document = Document::new("cornell", camera);
    let white = document.lambert("white", [0.73, 0.72, 0.68], 1);
    let red = document.lambert("red", [0.57, 0.05, 0.04], 1);
    let green = document.lambert("green", [0.12, 0.4, 0.1], 1);

    // Corners run counter-clockwise as seen from inside.
    let wall = |corners: [Vec3; 4]| {
        let mut surface = Surface::default();
        surface.polygon(&corners.map(place));
        surface
    };
    let mut shell = wall([[0.0, 0.0, 0.0], [0.0, 0.0, d], [w, 0.0, d], [w, 0.0, 0.0]]);
    shell.append(&wall([[0.0, h, 0.0], [w, h, 0.0], [w, h, d], [0.0, h, d]]));
    shell.append(&wall([[0.0, 0.0, d], [0.0, h, d], [w, h, d], [w, 0.0, d]]));
    document.place("floor, ceiling and back wall", shell, white);
    document.place("left wall", wall([[w, 0.0, 0.0], [w, 0.0, d], [w, h, d], [w, h, 0.0]]), red);
    document.place("right wall", wall([[0.0, 0.0, 0.0], [0.0, h, 0.0], [0.0, h, d], [0.0, 0.0, d]]), green);

    // Turning about the vertical keeps the sense of the outlines.
    for (name, outline, height) in [("short block", SHORT_BLOCK, HEIGHTS[0]), ("tall block", TALL_BLOCK, HEIGHTS[1])] {
        let outline = outline.map(|[x, z]| {
            let p = place([x, 0.0, z]);
            [p[0], p[2]]
        });
        document.place(name, prism(&outline, -1e-3 * SUNK, 1e-3 * height), white);
    }
    document.light(PointLight { position: place([278.0, 470.0, 279.5]), color: [1.0, 0.85, 0.6], intensity: 8.0 });
    document
}
