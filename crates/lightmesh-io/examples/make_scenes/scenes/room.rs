//! A room of 10 × 4 × 8 m with columns, spheres and a torus knot, about 5,000 triangles like the paper's, under N
//! lights.

use super::document::{Camera, Document, PointLight};
use super::low_discrepancy::r3;
use super::solids::{TorusKnot, cuboid, lathe, sphere};
use super::surface::{Surface, Vec3};

/// Half the width and depth, and the height, metres.
const HALF_WIDTH: f64 = 5.0;
const HALF_DEPTH: f64 = 4.0;
const HEIGHT: f64 = 4.0;
/// How far things reach into what they stand on, so that no two faces lie in one plane, metres.
const SUNK: f64 = 0.01;
/// Where the columns stand (x, z).
const COLUMNS: [[f64; 2]; 5] = [[-3.3, 2.0], [-3.3, -0.5], [-3.3, -3.0], [-0.5, -3.0], [2.3, -3.0]];
/// Where the knot's drum stands (x, z).
const DRUM: [f64; 2] = [0.3, -0.6];
/// Luminous intensity of all lights together, candela.
const TOTAL_INTENSITY: f64 = 1800.0;
/// Smallest distance of a light from walls, floor, ceiling and columns' axes, metres.
const WALL_CLEARANCE: f64 = 0.4;
const COLUMN_CLEARANCE: f64 = 0.6;

/// The room with `count` point lights.
pub(crate) fn room(count: u32) -> Document {
    let camera = Camera { eye: [4.1, 1.75, 3.55], target: [-0.75, 1.3, -1.45], yfov: 0.84, aspect: 1.5 };
    let mut document = Document::new("room", camera);
    shell(&mut document);
    columns(&mut document);
    sculpture(&mut document);
    furniture(&mut document);
    for (position, color) in lights(count as usize) {
        document.light(PointLight {
            position,
            color,
            intensity: TOTAL_INTENSITY / (f64::from(count) * luminance(color)),
        });
    }
    document
}

/// Floor of square tiles, walls and ceiling; they face inward.
fn shell(document: &mut Document) {
    let (w, d, h) = (HALF_WIDTH, HALF_DEPTH, HEIGHT);
    let ivory = document.lambert("ivory tiles", [0.66, 0.61, 0.52], 1);
    let slate = document.lambert("slate tiles", [0.17, 0.18, 0.2], 1);
    let plaster = document.lambert("plaster", [0.77, 0.73, 0.66], 1);
    let sage = document.lambert("sage wall", [0.3, 0.41, 0.36], 1);
    let white = document.lambert("ceiling", [0.82, 0.81, 0.78], 1);

    let mut tiles = [Surface::default(), Surface::default()];
    for i in 0..10u8 {
        for j in 0..8u8 {
            let (x, z) = (f64::from(i) - w, f64::from(j) - d);
            tiles[usize::from((i + j) % 2)].polygon(&[
                [x, 0.0, z],
                [x, 0.0, z + 1.0],
                [x + 1.0, 0.0, z + 1.0],
                [x + 1.0, 0.0, z],
            ]);
        }
    }
    let [even, odd] = tiles;
    document.place_copies("floor", vec![(even, ivory), (odd, slate)], &[[0.0; 3]]);

    // A wall has a corner at every tile's, so that edges meet vertex to vertex. Corners run from the top of `from` to
    // that of `to` along the floor; seen from inside `from` is on the left.
    let wall = |from: [f64; 2], to: [f64; 2]| {
        let steps = ((to[0] - from[0]).abs() + (to[1] - from[1]).abs()) as u8;
        let mut corners = vec![[from[0], h, from[1]]];
        corners.extend((0..=steps).map(|i| {
            let t = f64::from(i) / f64::from(steps);
            [from[0] + t * (to[0] - from[0]), 0.0, from[1] + t * (to[1] - from[1])]
        }));
        corners.push([to[0], h, to[1]]);
        let mut surface = Surface::default();
        surface.polygon(&corners);
        surface
    };
    let mut light_walls = wall([-w, -d], [w, -d]);
    light_walls.append(&wall([w, -d], [w, d]));
    light_walls.append(&wall([w, d], [-w, d]));
    document.place("back, right and front wall", light_walls, plaster);
    document.place("left wall", wall([-w, d], [-w, -d]), sage);

    let mut ceiling = Surface::default();
    ceiling.polygon(&[[-w, h, -d], [w, h, -d], [w, h, d], [-w, h, d]]);
    document.place("ceiling", ceiling, white);
}

/// Five copies of one column from floor to ceiling, and the beams that they carry.
fn columns(document: &mut Document) {
    let stone = document.lambert("limestone", [0.74, 0.7, 0.62], 1);
    let walnut = document.lambert("walnut", [0.22, 0.125, 0.07], 1);

    // Plinth and abacus are boxes; between them base, shaft (a little thinner at the top) and capital. Each begins
    // inside the one below.
    let mut column = cuboid([0.0; 2], -SUNK, [0.62, 0.14 + SUNK, 0.62], 0.0);
    column.append(&lathe(
        &[
            [0.0, 0.13],
            [0.28, 0.13],
            [0.3, 0.19],
            [0.28, 0.25],
            [0.22, 0.27],
            [0.205, 1.5],
            [0.18, 3.28],
            [0.2, 3.33],
            [0.29, 3.47],
            [0.0, 3.47],
        ],
        18,
    ));
    column.append(&cuboid([0.0; 2], 3.46, [0.66, 0.14, 0.66], 0.0));
    document.place_copies("column", vec![(column, stone)], &COLUMNS.map(|[x, z]| [x, 0.0, z]));

    let [corner_x, corner_z] = COLUMNS[2];
    let mut beams = cuboid([corner_x, 0.0], 3.59, [0.4, 0.5, 2.0 * HALF_DEPTH + 0.1], 0.0);
    beams.append(&cuboid([0.0, corner_z], 3.57, [2.0 * HALF_WIDTH + 0.1, 0.5, 0.42], 0.0));
    document.place("beams", beams, walnut);
}

/// The knot on its drum, and spheres about it.
fn sculpture(document: &mut Document) {
    let vermilion = document.lambert("vermilion", [0.72, 0.13, 0.06], 1);
    let basalt = document.lambert("basalt", [0.21, 0.2, 0.2], 1);
    let teal = document.lambert("teal", [0.06, 0.33, 0.34], 1);
    let mustard = document.lambert("mustard", [0.78, 0.5, 0.09], 1);
    let chalk = document.lambert("chalk", [0.8, 0.79, 0.76], 1);

    let knot = TorusKnot {
        center: [DRUM[0], 1.6, DRUM[1]],
        major_radius: 0.5,
        minor_radius: 0.22,
        tube_radius: 0.115,
        turns: [2.0, 3.0],
        steps: [90, 9],
    };
    document.place("knot", knot.surface(), vermilion);
    let drum = lathe(
        &[[0.0, -SUNK], [0.62, -SUNK], [0.62, 0.12], [0.46, 0.14], [0.42, 0.78], [0.5, 0.83], [0.5, 0.9], [0.0, 0.9]],
        24,
    );
    document.place_copies("drum", vec![(drum, basalt)], &[[DRUM[0], 0.0, DRUM[1]]]);
    document.place("large sphere", sphere([-1.45, 0.5 - SUNK, 0.75], 0.5, 5), teal);
    document.place("small sphere", sphere([1.75, 0.26 - SUNK, 0.55], 0.26, 4), mustard);
    document.place("sphere on the crates", sphere([2.2, 1.1 + 0.2 - SUNK, -1.75], 0.2, 4), chalk);
}

/// Crates, a bench, a table and three panels on the back wall.
fn furniture(document: &mut Document) {
    let oak = document.lambert("oak", [0.47, 0.3, 0.15], 1);
    let walnut = document.lambert("dark oak", [0.25, 0.15, 0.085], 1);
    let cobalt = document.lambert("cobalt", [0.05, 0.11, 0.42], 1);
    let ochre = document.lambert("ochre", [0.68, 0.38, 0.08], 1);
    let madder = document.lambert("madder", [0.5, 0.07, 0.09], 1);

    let mut crates = cuboid([2.3, -1.7], -SUNK, [0.9, 0.7 + SUNK, 0.7], 0.35);
    crates.append(&cuboid([2.22, -1.74], 0.7 - SUNK, [0.5, 0.4 + SUNK, 0.5], -0.2));
    crates.append(&cuboid([3.15, -1.2], -SUNK, [0.5, 0.45 + SUNK, 0.5], 0.9));
    document.place("crates", crates, oak);

    // A bench along the left wall: seat and three supports that end inside it.
    let mut bench = cuboid([-4.6, 0.75], 0.42, [0.45, 0.06, 2.4], 0.0);
    for z in [-0.2, 0.75, 1.7] {
        bench.append(&cuboid([-4.6, z], -SUNK, [0.35, 0.45, 0.08], 0.0));
    }
    document.place("bench", bench, walnut);

    // A low table before the left columns: its legs end inside the top.
    let mut table = cuboid([-1.9, -1.5], 0.55, [1.2, 0.05, 0.7], 0.25);
    let (sin, cos) = (libm::sin(0.25), libm::cos(0.25));
    for (x, z) in [(-0.52, -0.27), (0.52, -0.27), (-0.52, 0.27), (0.52, 0.27)] {
        let at = [-1.9 + cos * x + sin * z, -1.5 - sin * x + cos * z];
        table.append(&cuboid(at, -SUNK, [0.06, 0.57, 0.06], 0.25));
    }
    document.place("table", table, walnut);

    for (x, material, name) in
        [(-1.9, cobalt, "cobalt panel"), (0.9, ochre, "ochre panel"), (3.55, madder, "madder panel")]
    {
        let panel = cuboid([x, -HALF_DEPTH], 1.0, [1.1, 1.6, 0.08], 0.0);
        document.place(name, panel, material);
    }
}

/// Positions and colours of the first `count` lights: those of a room with fewer lights are among them.
///
/// They hang in the upper room, spread by a low-discrepancy sequence; a point too near to a column is skipped.
fn lights(count: usize) -> Vec<(Vec3, Vec3)> {
    // Warm and cool whites that together make nearly white light.
    const COLORS: [Vec3; 5] =
        [[1.0, 0.72, 0.42], [0.55, 0.76, 1.0], [1.0, 0.86, 0.68], [1.0, 0.55, 0.5], [0.62, 1.0, 0.86]];
    let spread = |t: f64, half: f64| (2.0 * t - 1.0) * (half - WALL_CLEARANCE);
    let hanging = (0..).map(|i| {
        let [a, b, c] = r3(i);
        [spread(a, HALF_WIDTH), 2.3 + (HEIGHT - 0.75 - 2.3) * c, spread(b, HALF_DEPTH)]
    });
    let free = hanging.filter(|&[x, _, z]: &Vec3| {
        let far = |[cx, cz]: [f64; 2]| (x - cx) * (x - cx) + (z - cz) * (z - cz) > COLUMN_CLEARANCE * COLUMN_CLEARANCE;
        COLUMNS.into_iter().all(far)
    });
    free.take(count).enumerate().map(|(i, position)| (position, COLORS[i % COLORS.len()])).collect()
}

/// Rec. 709 luminance of a linear colour.
fn luminance(color: Vec3) -> f64 {
    0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]
}
