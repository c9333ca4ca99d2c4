//! Figures 1-3: the edge of a shadow, by four ways to soften it.

use glam::{Affine3A, Vec3};
use lightmesh::{Camera, EmitterOptions, Image, Method};

use super::lights::papers;
use crate::error::Error;
use crate::lab::{Lab, Place, direct};
use crate::penumbra;
use crate::picture::{figure, luminance};
use crate::plot::{Line, Plot, SeriesLabelPosition};
use crate::report::{Claim, Section, Table, Verdict};
use crate::scenes;
use crate::scenes::{SceneName, light_of};

/// Radii of the spherical light, metres.
const RADII: [f32; 2] = [0.1, 0.25];

/// Points along the longest edge (8 m) of the meshes.
const POINTS: [f32; 2] = [40.0, 80.0];

/// Samples of the spherical light that gives the reference picture.
const SAMPLES: u32 = 256;

/// Fractions of the light without the sheet that count as full shadow and as no shadow.
const EDGE: (f64, f64) = (0.03, 0.97);

/// The profile: pixels across the edge of the sheet's shadow, on the floor.
const PIXELS: u32 = 480;
/// Half the width that they show, metres.
const HALF: f32 = 0.7;

pub(super) fn run(lab: &mut Lab<'_>) -> Result<Section, Error> {
    let size = if lab.quick { (240, 160) } else { (720, 480) };
    let place = lab.place(SceneName::Triangle)?;
    let soft = |radius| EmitterOptions { light_radius: radius, light_samples: SAMPLES };

    // Render the pictures: two meshes, reference [4], and a spherical light that is the truth.
    let mesh = lab.shot(&place, &direct(Method::MESH, size, POINTS[0]))?;
    let paper = lab.shot(&place, &papers(size, POINTS[0]))?;
    let mut pictures = Vec::new();
    for radius in RADII {
        let truth = lab.place_with(SceneName::Triangle, &soft(radius), None)?;
        pictures.push((format!("[4], radius {radius} m"), penumbra::picture(&place, size, radius)));
        let shot = lab.shot(&truth, &direct(Method::Standard, size, 40.0))?;
        pictures.push((format!("truth, radius {radius} m"), shot.image.clone()));
    }
    let mut shown: Vec<(&str, &Image)> = pictures.iter().map(|(label, image)| (label.as_str(), image)).collect();
    shown.insert(0, ("paper, 1/40", &paper.image));
    shown.insert(1, ("mesh, 1/40", &mesh.image));
    let shown = figure("A triangle over a floor under one light.", &shown)?;

    // Measure profiles across an edge of the shadow, as a part of the light without the sheet.
    let camera = edge_camera(&place);
    let strip = (PIXELS, 9);
    let bare = bare_floor(lab, &place, camera.clone())?;
    let open = lab.shot(&bare, &direct(Method::Standard, strip, 40.0))?;
    let part = |image: &Image| profile(image, &open.image);
    let mut lines = Vec::new();
    let point = lab.place_with(SceneName::Triangle, &EmitterOptions::default(), Some(camera.clone()))?;
    let hard = part(&lab.shot(&point, &direct(Method::Standard, strip, 40.0))?.image);
    let edge = edge_of(&hard);
    lines.push(("point light".to_owned(), hard));
    for radius in RADII {
        let truth = lab.place_with(SceneName::Triangle, &soft(radius), Some(camera.clone()))?;
        lines.push((format!("[4], {radius} m"), part(&penumbra::picture(&point, strip, radius))));
        lines.push((
            format!("truth, {radius} m"),
            part(&lab.shot(&truth, &direct(Method::Standard, strip, 40.0))?.image),
        ));
    }
    for points in POINTS {
        lines.push((format!("paper, 1/{points}"), part(&lab.shot(&point, &papers(strip, points))?.image)));
    }

    // Measure how far each profile is soft, and put that into a table and a plot.
    let reach = |profile: &[(f64, f64)]| widths(profile, edge);
    let rows = lines.iter().map(|(name, profile)| {
        let (inside, outside) = reach(profile);
        vec![name.as_str().into(), (100.0 * inside).into(), (100.0 * outside).into()]
    });
    let table = Table {
        caption: format!(
            "How far the edge of the shadow is soft, from where it would be under a point: to {:.0}% of the light inside the \
             shadow, to {:.0}% outside.",
            100.0 * EDGE.0,
            100.0 * EDGE.1
        ),
        columns: ["", "inside, cm", "outside, cm"].map(str::to_owned).to_vec(),
        rows: rows.collect(),
    };
    let ours = reach(&lines[1].1);
    let meshes = reach(&lines[5].1);
    let plot = Plot {
        caption: "Across an edge of the shadow on the floor.",
        x: "metres across the edge; shadow on the right",
        y: "part of the light that arrives",
        names: SeriesLabelPosition::UpperRight,
        logarithmic: false,
        lines: lines.iter().map(|(name, points)| Line { name: name.clone(), points: points.clone() }).collect(),
    };

    // Measure how deep the shadow of a sheet smaller than the mesh's cells is.
    let small = small_sheet(lab, &place)?;
    let bare_small = bare_floor(lab, &small, small.camera.clone())?;
    let square = (160, 160);
    let mut depths = Vec::new();
    for options in [direct(Method::Standard, square, 40.0), papers(square, POINTS[0])] {
        let with = lab.shot(&small, &options)?;
        let without = lab.shot(&bare_small, &direct(Method::Standard, square, 40.0))?;
        let parts =
            with.image.pixels.iter().zip(&without.image.pixels).map(|(a, b)| luminance(*a) / luminance(*b).max(1e-9));
        depths.push(1.0 - parts.fold(1.0, f64::min));
    }

    // Judge the claims.
    let claims = vec![
        Claim {
            claim: "The method of [4] blurs outward only.".into(),
            paper: Some(0.0),
            ours: 100.0 * ours.0,
            unit: "cm inside".into(),
            verdict: Verdict::of(ours.0 < 0.01 && ours.1 > 0.02, ours.1 > ours.0),
            note: format!(
                "Holds if less than 1 cm is soft inside and more than 2 outside, here {:.1}.",
                100.0 * ours.1
            ),
        },
        Claim {
            claim: "The light mesh blurs both ways.".into(),
            paper: None,
            ours: 100.0 * meshes.0,
            unit: "cm inside".into(),
            verdict: Verdict::of(meshes.0 > 0.02 && meshes.1 > 0.02, meshes.0 > 0.0),
            note: format!("1/40, paper's method; holds above 2 cm on both sides; outside {:.1}.", 100.0 * meshes.1),
        },
        Claim {
            claim: "Small objects cast almost no shadow.".into(),
            paper: None,
            ours: 100.0 * depths[1],
            unit: "% deep".into(),
            verdict: Verdict::of(depths[1] < 0.3 && depths[0] > 0.9, depths[1] < depths[0]),
            note: format!(
                "The darkest place under a sheet of a third of a cell; holds below 30% where exact shadow rays find {:.0}%.",
                100.0 * depths[0]
            ),
        },
    ];
    let text = vec![
        "Reference [4] of the paper is, by its description, Parker, Shirley and Smits, Single Sample Soft Shadows (1998): one shadow ray, and \
         an outer penumbra as wide as a spherical light would make it. The truth is that light in 256 samples. The mesh knows a point \
         light only: its penumbra is as wide as its cells."
            .to_owned(),
    ];
    Ok(Section { text, tables: vec![table], figures: vec![shown, plot.figure()?], claims, ..Section::default() })
}

/// Returns the corners of the sheet, which is the last instance.
fn sheet(place: &Place) -> [Vec3; 3] {
    let placed = place.data.instances.last().expect("the scene has a sheet");
    let mesh = &place.data.meshes[placed.mesh];
    let corner = |i: u32| placed.world_from_object.transform_point3(mesh.positions[i as usize]);
    mesh.triangles[0].map(corner)
}

/// Projects a point from the light onto the floor.
fn shadow(light: Vec3, point: Vec3) -> Vec3 {
    light + (point - light) * (light.y / (light.y - point.y))
}

/// Makes a camera under the sheet that looks straight down on the middle of a shadow's edge, its rows across that edge.
fn edge_camera(place: &Place) -> Camera {
    let light = light_of(&place.data);
    let [a, b, c] = sheet(place).map(|corner| shadow(light, corner));
    // Of the edges the one that runs most nearly along z.
    let edges = [(a, b), (b, c), (c, a)];
    let steepness = |(p, q): &(Vec3, Vec3)| ((q.z - p.z) / (q.x - p.x).abs().max(1e-6)).abs();
    let (p, q) = edges.into_iter().max_by(|a, b| steepness(a).total_cmp(&steepness(b))).unwrap_or((a, b));
    let middle = (p + q) * 0.5;
    let height = 0.3;
    // A strip is 9 pixels high.
    let half_height = HALF * 9.0 / PIXELS as f32;
    Camera::look_at(middle + Vec3::Y * height, middle, 2.0 * (half_height / height).atan())
}

/// Builds the place without its sheet, with another camera.
fn bare_floor(lab: &Lab<'_>, place: &Place, camera: Camera) -> Result<Place, Error> {
    let mut data = place.data.clone();
    data.instances.pop();
    lab.made_up(format!("bare floor {camera:?}"), data, camera)
}

/// Builds the place with a sheet a third of a cell large, and a camera on its shadow.
fn small_sheet(lab: &Lab<'_>, place: &Place) -> Result<Place, Error> {
    let (mut data, _) = scenes::read(SceneName::Triangle)?;
    let corners = sheet(place);
    let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
    let scale = 8.0 / POINTS[0] / 3.0 / corners[0].distance(corners[1]);
    if let Some(placed) = data.instances.last_mut() {
        let to_middle = Affine3A::from_translation(middle) * Affine3A::from_scale(Vec3::splat(scale));
        placed.world_from_object = to_middle * Affine3A::from_translation(-middle) * placed.world_from_object;
    }
    let below = shadow(light_of(&data), middle);
    let camera = Camera::look_at(below + Vec3::Y * 0.4, below, 0.6);
    lab.made_up("small sheet".to_owned(), data, camera)
}

/// Returns the fraction of the light that arrives along the middle row, with the distance from its middle, metres.
fn profile(image: &Image, open: &Image) -> Vec<(f64, f64)> {
    let row = (image.height / 2 * image.width) as usize;
    let pairs = image.pixels[row..].iter().zip(&open.pixels[row..]).take(image.width as usize);
    let place = |i: usize| f64::from(HALF) * (2.0 * (i as f64 + 0.5) / f64::from(image.width) - 1.0);
    pairs.enumerate().map(|(i, (a, b))| (place(i), luminance(*a) / luminance(*b).max(1e-9))).collect()
}

/// Returns where a hard shadow begins, metres.
fn edge_of(profile: &[(f64, f64)]) -> f64 {
    profile
        .windows(2)
        .find(|pair| (pair[0].1 > 0.5) != (pair[1].1 > 0.5))
        .map_or(0.0, |pair| 0.5 * (pair[0].0 + pair[1].0))
}

/// Measures how far a profile is soft: inside the shadow of a point light, and outside it, metres.
fn widths(profile: &[(f64, f64)], edge: f64) -> (f64, f64) {
    let right_is_dark = profile.last().map_or(0.0, |p| p.1) < profile.first().map_or(0.0, |p| p.1);
    let sign = if right_is_dark { 1.0 } else { -1.0 };
    let (mut inside, mut outside) = (0.0_f64, 0.0_f64);
    for &(x, part) in profile {
        let deep = sign * (x - edge);
        if part > EDGE.0 {
            inside = inside.max(deep);
        }
        if part < EDGE.1 {
            outside = outside.max(-deep);
        }
    }
    (inside, outside)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_are_measured_from_the_edge() {
        // Light to −0.1, shadow from 0.2, linear between.
        let ramp = |x: f64| ((0.2 - x) / 0.3).clamp(0.0, 1.0);
        let profile: Vec<_> = (-500..=500).map(|i| f64::from(i) * 1e-3).map(|x| (x, ramp(x))).collect();
        let (inside, outside) = widths(&profile, 0.0);
        assert!((inside - (0.2 - 0.3 * EDGE.0)).abs() < 2e-3 && (outside - (0.1 - 0.3 * (1.0 - EDGE.1))).abs() < 2e-3);
        let hard: Vec<_> = profile.iter().map(|&(x, _)| (x, if x < 0.05 { 1.0 } else { 0.0 })).collect();
        assert!((edge_of(&hard) - 0.05).abs() < 1e-3);
    }
}
