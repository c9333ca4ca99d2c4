//! A triangle over a floor under one light: the figure with which the paper shows soft shadows.

use super::document::{Camera, Document, PointLight};
use super::surface::Surface;

/// The scene.
pub(crate) fn triangle() -> Document {
    let camera = Camera { eye: [1.5, 3.3, 2.9], target: [-0.1, 0.3, -0.05], yfov: 0.6, aspect: 1.5 };
    let mut document = Document::new("triangle", camera);
    let paper = document.lambert("floor", [0.74, 0.72, 0.68], 1);
    let red = document.lambert("triangle", [0.66, 0.13, 0.09], 2);

    let mut floor = Surface::default();
    floor.polygon(&[[-4.0, 0.0, -4.0], [-4.0, 0.0, 4.0], [4.0, 0.0, 4.0], [4.0, 0.0, -4.0]]);
    document.place("floor", floor, paper);
    let mut sheet = Surface::default();
    sheet.polygon(&[[-0.9, 0.7, 0.6], [0.9, 0.7, 0.35], [-0.1, 1.1, -0.9]]);
    document.place("triangle", sheet, red);
    document.light(PointLight { position: [0.5, 3.0, 0.3], color: [1.0, 0.96, 0.9], intensity: 60.0 });
    document
}
