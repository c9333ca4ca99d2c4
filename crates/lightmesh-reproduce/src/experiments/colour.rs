//! Direct light only, one bounce, several: colour bleeding.

use lightmesh::{Image, Method, RenderOptions};

use crate::error::Error;
use crate::lab::Lab;
use crate::picture::{Rect, enlarged, figure, luminance};
use crate::report::{Claim, Section, Table, Verdict};
use crate::scenes::SceneName;

/// The part of the picture that is enlarged, in fractions of its size: the floor beside the coloured wall.
const PART: Rect<f32> = Rect { left: 0.12, top: 0.7, width: 0.2, height: 0.2 };

pub(super) fn run(lab: &mut Lab<'_>) -> Result<Section, Error> {
    let side: u32 = if lab.quick { 160 } else { 480 };
    let place = lab.place(SceneName::Cornell)?;
    let with = |method, bounces| {
        RenderOptions::default().with(|o| {
            o.method = method;
            o.picture.width = side;
            o.picture.height = side;
            o.picture.spp = 4;
            o.transport.bounces = bounces;
        })
    };

    // Render direct light, one bounce, several, and the paper's method.
    let ways = [
        ("direct light", with(Method::MESH, 0)),
        ("one bounce", with(Method::MESH, 1)),
        ("six bounces", with(Method::MESH, 6)),
        ("paper, one bounce", with(Method::PAPER, 1)),
    ];
    let mut shots = Vec::new();
    for (_, options) in &ways {
        shots.push(lab.shot(&place, options)?);
    }

    // Enlarge the floor beside the red wall, and measure how red it is.
    let part = PART.to_pixels((side, side));
    let times = if lab.quick { 4 } else { 2 };
    let parts: Vec<Image> = shots.iter().map(|shot| enlarged(&shot.image, part, times)).collect();
    let mut rows = Vec::new();
    let mut redness = Vec::new();
    for ((name, _), (shot, part)) in ways.iter().zip(shots.iter().zip(&parts)) {
        let sum: glam::Vec3 = part.pixels.iter().sum();
        redness.push(f64::from(sum.x / sum.y.max(1e-9)));
        let mean = shot.image.pixels.iter().map(|p| luminance(*p)).sum::<f64>() / f64::from(side * side);
        rows.push(vec![(*name).into(), shot.seconds().into(), mean.into(), redness[redness.len() - 1].into()]);
    }

    // Put the numbers into a table and the pictures beside each other.
    let columns = ["light", "seconds", "mean luminance, cd/m²", "red over green beside the red wall"];
    let caption = format!("{side} × {side}, 4 samples per pixel, default spacings.");
    let table = Table { caption, columns: columns.map(str::to_owned).to_vec(), rows };
    let named = |images: &mut dyn Iterator<Item = &Image>| -> Result<_, Error> {
        let pictures: Vec<_> = ways.iter().map(|(name, _)| *name).zip(images).collect();
        Ok(pictures.into_iter().map(|(name, image)| (name, image.clone())).collect::<Vec<_>>())
    };
    let whole = named(&mut shots.iter().map(|shot| &shot.image))?;
    let near = named(&mut parts.iter())?;
    let borrowed = |pictures: &[(&'static str, Image)], caption: &str| {
        let pictures: Vec<_> = pictures.iter().map(|(name, image)| (*name, image)).collect();
        figure(caption, &pictures)
    };
    let figures = vec![
        borrowed(&whole, "A box with a red and a green wall.")?,
        borrowed(&near, "The floor beside the red wall, enlarged: the wall's colour arrives with the first bounce.")?,
    ];

    // Judge the claim.
    let gain = redness[1] / redness[0];
    let claims = vec![Claim {
        claim: "Indirect light carries the colour of walls to what stands beside them.".into(),
        paper: None,
        ours: gain,
        unit: "×".into(),
        verdict: Verdict::of(gain > 1.05, gain > 1.0),
        note: "Red over green on the floor beside the red wall, with one bounce over direct light; holds above 1.05."
            .into(),
    }];
    Ok(Section { tables: vec![table], figures, claims, ..Section::default() })
}
