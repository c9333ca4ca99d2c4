//! A room by day: sun and sky come in through a window, beside a panel under the ceiling and a lamp of frosted glass.
//!
//! The file has the sun; the sky is an environment that the command line adds.

use super::document::{Camera, Document, Sun};
use super::solids::{cuboid, lathe, sphere};
use super::surface::{Surface, Vec3, add_scaled};

/// Half the room's width and depth, and its height, metres.
const HALF: [f64; 2] = [2.5, 2.0];
const HEIGHT: f64 = 2.7;
/// Of walls, floor and ceiling.
const THICKNESS: f64 = 0.25;
/// The window in the wall at +x: its ends along z, and its sill and head.
const WINDOW_Z: [f64; 2] = [-0.9, 0.9];
const WINDOW_Y: [f64; 2] = [0.9, 2.2];

/// A box from one corner to the opposite one.
fn block(min: Vec3, max: Vec3) -> Surface {
    let middle = [0.5 * (min[0] + max[0]), 0.5 * (min[2] + max[2])];
    cuboid(middle, min[1], [max[0] - min[0], max[1] - min[1], max[2] - min[2]], 0.0)
}

fn joined(parts: &[Surface]) -> Surface {
    parts.iter().fold(Surface::default(), |mut all, part| {
        all.append(part);
        all
    })
}

/// The scene.
pub(crate) fn window() -> Document {
    let camera = Camera { eye: [-2.2, 1.5, 1.75], target: [0.9, 0.95, -0.7], yfov: 0.95, aspect: 1.5 };
    let mut document = Document::new("window", camera);
    let white = document.lambert("white", [0.8, 0.79, 0.76], 1);
    let clay = document.lambert("clay", [0.55, 0.28, 0.18], 1);
    let oak = document.lambert("oak", [0.42, 0.27, 0.15], 1);
    let wool = document.lambert("wool", [0.12, 0.22, 0.33], 1);
    let glass = document.glass("glass");
    // 0.36 m² · π · 2500 cd/m² = 2830 lm, and 4π 0.12² m² · π · 1500 cd/m² = 850 lm.
    let panel = document.emitter("panel", [1.0, 0.93, 0.84], 2500.0);
    let frosted = document.emitter("frosted glass", [1.0, 0.78, 0.55], 1500.0);
    shell(&mut document, [white, clay, oak]);

    // A pane without thickness, in the middle of the wall.
    let (x, [y0, y1], [z0, z1]) = (HALF[0] + 0.5 * THICKNESS, WINDOW_Y, WINDOW_Z);
    let mut pane = Surface::default();
    pane.polygon(&[[x, y0, z1], [x, y0, z0], [x, y1, z0], [x, y1, z1]]);
    document.place("pane", pane, glass);

    // Lamps: a panel 2 cm below the ceiling that shines downwards, and a globe on a pole.
    let (y, [x0, x1], [z0, z1]) = (HEIGHT - 0.02, [-1.1, -0.5], [-0.3, 0.3]);
    let mut sheet = Surface::default();
    sheet.polygon(&[[x0, y, z0], [x1, y, z0], [x1, y, z1], [x0, y, z1]]);
    document.place("panel", sheet, panel);
    let lamp = [-0.4, 1.35, -1.6];
    document.place("globe", sphere(lamp, 0.12, 4), frosted);
    let pole = lathe(&[[0.0, 0.0], [0.14, 0.0], [0.14, 0.02], [0.012, 0.03], [0.012, 1.22], [0.0, 1.22]], 16);
    document.place_copies("pole", vec![(pole, oak)], &[[lamp[0], 0.0, lamp[2]]]);

    // A table with a bowl and a ball, a rug, a sideboard and a picture above it.
    let (top, foot): (Vec3, Vec3) = ([0.7, 0.76, -0.6], [0.06, 0.72, 0.06]);
    let leg = |x: f64, z: f64| {
        let min = [top[0] + x - 0.5 * foot[0], 0.0, top[2] + z - 0.5 * foot[2]];
        block(min, add_scaled(min, foot, 1.0))
    };
    let legs = [leg(-0.65, -0.3), leg(0.65, -0.3), leg(0.65, 0.3), leg(-0.65, 0.3)];
    let board = block([top[0] - 0.75, 0.72, top[2] - 0.4], [top[0] + 0.75, top[1], top[2] + 0.4]);
    document.place("table", joined(&[joined(&legs), board]), oak);
    let bowl = [[0.0, 0.0], [0.08, 0.0], [0.17, 0.1], [0.16, 0.105], [0.07, 0.015], [0.0, 0.015]];
    document.place_copies("bowl", vec![(lathe(&bowl, 32), white)], &[[top[0] - 0.25, top[1], top[2]]]);
    document.place("ball", sphere([top[0] + 0.35, top[1] + 0.11, top[2] + 0.1], 0.11, 8), clay);
    document.place("rug", block([-0.6, 0.0, -0.3], [1.6, 0.012, 1.3]), wool);
    let sideboard = block([-2.2, 0.0, -HALF[1] + 0.02], [-0.8, 0.55, -HALF[1] + 0.45]);
    document.place("sideboard", sideboard, oak);
    document.place("picture", block([-1.9, 1.1, -HALF[1]], [-1.1, 1.8, -HALF[1] + 0.03]), wool);

    document.sun(Sun { direction: [-0.72, -0.62, -0.3], color: [1.0, 0.92, 0.8], illuminance: 60_000.0 });
    document
}

/// Walls with a window, floor and ceiling. `materials`: of walls and ceiling, of the back wall, and of the floor.
fn shell(document: &mut Document, [white, clay, oak]: [usize; 3]) {
    let ([w, d], t) = (HALF, THICKNESS);
    let (ow, od) = (w + t, d + t);
    let ([y0, y1], [z0, z1]) = (WINDOW_Y, WINDOW_Z);
    let walls = [
        block([-ow, 0.0, -od], [-w, HEIGHT, od]),
        block([-w, 0.0, d], [w, HEIGHT, od]),
        block([w, 0.0, -od], [ow, y0, od]),
        block([w, y1, -od], [ow, HEIGHT, od]),
        block([w, y0, -od], [ow, y1, z0]),
        block([w, y0, z1], [ow, y1, od]),
        block([-ow, HEIGHT, -od], [ow, HEIGHT + t, od]),
    ];
    document.place("walls and ceiling", joined(&walls), white);
    document.place("back wall", block([-w, 0.0, -od], [w, HEIGHT, -d]), clay);
    document.place("floor", block([-ow, -t, -od], [ow, 0.0, od]), oak);
}
