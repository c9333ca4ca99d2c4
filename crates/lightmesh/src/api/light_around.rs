//! How bright it is about a camera, as a photographer measures it who holds a meter in the light instead of pointing it
//! at the picture: what is in the picture, dark wood or white paint, does not count, and neighbouring views have nearly
//! the same answer.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::measure;
use crate::geometry::Ray;
use crate::interaction::SeenPlace;
use crate::light::emitters::luminance;
use crate::sampling::Sampler;
use crate::{Camera, Error, LightMesh, Meter, Method, Projection, RenderOptions, Scene};

/// A grid of directions with equal solid angles: columns round +Y, rows in its height. Within the picture it is as many
/// times finer along both, a power of two, as give it [`IN_PICTURE`] directions, but no more than [`FINEST`] times.
const COLUMNS: u32 = 24;
const ROWS: u32 = 12;
const IN_PICTURE: f32 = 64.0;
const FINEST: u32 = 32;
/// Light is measured at fewer places where there are more lamps than [`LIGHTS`], at most so many at each of all places,
/// and nowhere where that would leave less than [`LEAST`] places.
const LIGHTS: usize = 128;
const LEAST: usize = 16;
/// Samples of the light at each place, with few lamps; and how many where fewer have more noise than a part of all light.
const FEW_SAMPLES: usize = 2;
const SAMPLES: usize = 16;
const MOST_NOISE: f32 = 0.06;
/// Places whose indirect light is taken together. This and the noise are judgements.
const NEIGHBOURS: usize = 24;
/// Shadow rays for direct light, at most.
const MOST_RAYS: usize = 1 << 20;
/// The mean that the surfaces of a model have in the studio, as a part of its white, and how many stops the
/// light may be from that before it decides: all sides of a model have one exposure, but a room that only a window
/// lights is not dark.
const STUDIO: f64 = 0.5;
const KEEP: f64 = 1.0;

/// A direction in which the camera could look, with what it sees there.
struct Look {
    weight: f64,
    place: SeenPlace,
}

/// Returns the luminance that a white surface has in the light about the camera, cd/m²: a mean over what is seen from
/// there. `None` where nothing lit is seen, or with more than some thousand lamps.
///
/// Directions count by (1 + cos)/2 of their angle to that in which the camera looks, not by the lens: between two halves
/// of the sphere a turn by 10° exchanges 4.4% (sin 10° / 4). They are fixed in the world, so that a turn meets the same
/// places. Light counts by its root: dark rooms beyond a door and the spot next to a lamp both count, but not alone.
pub(crate) fn white_around(scene: &Scene, camera: &Camera) -> Result<Option<f32>, Error> {
    let lights = scene.data().lights.len();
    let looks = looks(scene, camera);
    let most = if lights > LIGHTS { looks.len() * LIGHTS / lights } else { looks.len() };
    if looks.is_empty() || most < LEAST.min(looks.len()) {
        return Ok(scene.white_cd_m2().map(|white| white * STUDIO as f32));
    }

    // Measure the light there.
    let chosen: Vec<&Look> = (0..most).map(|i| &looks[i * looks.len() / most]).collect();
    let meters: Vec<Meter> =
        chosen.iter().map(|look| Meter { position: look.place.point, normal: look.place.n }).collect();
    let with = |method, spp, bounces| {
        let options = RenderOptions::default().with(|o| {
            (o.method, o.picture.spp, o.transport.bounces) = (method, spp, bounces);
        });
        let mut mesh = LightMesh::new(scene, &options)?;
        measure(scene, &meters, &options, &mut mesh, &())
    };
    let samples = |most: usize| (2 * LIGHTS / lights.max(1)).clamp(1, most) as u32;
    let mut paths = with(Method::Path, samples(FEW_SAMPLES), 2)?;
    // The root of a noisy value is too small in the mean: lamps that are not seen must not make it so. All of them have
    // their ray, if that is affordable, and indirect light has more samples if it is noisy.
    let affordable = scene.lights().len() * meters.len() <= MOST_RAYS;
    let direct = if affordable { with(Method::Standard, 1, 0)?.direct } else { std::mem::take(&mut paths.direct) };
    let (mut indirect, noise) = smoothed(&meters, &paths.indirect);
    let light: f32 = direct.iter().chain(&indirect).map(|e| e.element_sum()).sum();
    if noise > MOST_NOISE * light && samples(SAMPLES) > samples(FEW_SAMPLES) {
        (indirect, _) = smoothed(&meters, &with(Method::Path, samples(SAMPLES), 2)?.indirect);
    }

    // Take the mean of the roots.
    let mut sum = (0.0, 0.0);
    for (look, (direct, indirect)) in chosen.iter().zip(direct.iter().zip(&indirect)) {
        let white = f64::from(luminance(*direct + *indirect) / PI);
        if white.is_finite() {
            sum = (sum.0 + look.weight * white.max(0.0).sqrt(), sum.1 + look.weight);
        }
    }
    if sum.0 <= 0.0 {
        return Ok(scene.white_cd_m2().map(|white| white * STUDIO as f32));
    }
    let mean = 2.0 * libm::log2(sum.0 / sum.1);

    // In the studio stay near its white.
    let mean = scene.white_cd_m2().map_or(mean, |white| {
        let usual = libm::log2(STUDIO * f64::from(white));
        usual + beyond(mean - usual, KEEP)
    });
    Ok(Some(libm::exp2(mean) as f32).filter(|white| *white > 0.0 && white.is_finite()))
}

/// Returns the mean of the values at the nearest places of each place: few paths find light that comes through a small
/// window, and indirect light is even. And the sum of the standard errors of these means, of the sum of the channels.
fn smoothed(places: &[Meter], values: &[Vec3]) -> (Vec<Vec3>, f32) {
    let mut noise = 0.0;
    let mut near: Vec<(f32, usize)> = Vec::new();
    let mean = |place: &Meter| {
        near.clear();
        near.extend(places.iter().map(|other| other.position.distance_squared(place.position)).zip(0..));
        let count = NEIGHBOURS.min(near.len());
        near.select_nth_unstable_by(count - 1, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        // In their own order, so that the sum does not depend on how they were selected.
        near[..count].sort_unstable_by_key(|&(_, i)| i);
        let near = || near[..count].iter().map(|&(_, i)| values[i]);
        let mean = near().sum::<Vec3>() / count as f32;
        let squares: f32 = near().map(|value| (value - mean).element_sum().powi(2)).sum();
        noise += squares.sqrt() / count as f32;
        mean
    };
    let means = places.iter().map(mean).collect();
    (means, noise)
}

/// What is left of `x` beyond ±`keep`.
fn beyond(x: f64, keep: f64) -> f64 {
    (x.abs() - keep).max(0.0).copysign(x)
}

/// Looks out from the camera: evenly all round, and closer within the picture, where a model may be that is far away.
/// Weights are those of one set of directions (the balance heuristic), each in proportion to the solid angle that it
/// stands for.
fn looks(scene: &Scene, camera: &Camera) -> Vec<Look> {
    let m = &camera.world_from_camera.matrix3;
    let axes = [(m.x_axis, Vec3::X), (m.y_axis, Vec3::Y), (m.z_axis, Vec3::Z)]
        .map(|(axis, fallback)| axis.as_vec3().normalize_or(fallback));
    let eye = (camera.world_from_camera.translation - scene.data().origin).as_vec3();
    let mut looks = Vec::new();
    let mut look = |ray: Ray, density: f32, index: u32| {
        let direction = ray.direction.normalize();
        let place = SeenPlace::along(scene, ray, &mut Sampler::new(2, index, 0));
        let near = 0.5 * (1.0 - axes[2].dot(direction)).max(0.0);
        let weight = f64::from(near / density);
        looks.extend(place.map(|place| Look { weight, place }));
    };

    // Lenses of parallel rays, and narrow ones, see too little of a grid of directions.
    let tan = match camera.projection {
        Projection::Perspective { yfov, .. } => libm::tanf(0.5 * yfov),
        Projection::Orthographic { .. } => 0.0,
    };
    let half = Vec2::new(tan * camera.aspect(), tan);
    let solid_angle = 4.0 * half.x * half.y / (1.0 + half.length_squared());
    let coarse = (COLUMNS * ROWS) as f32 / (4.0 * PI);
    let finer = (0..).map(|i| 1 << i).find(|&n: &u32| n > FINEST || coarse * (n * n) as f32 * solid_angle > IN_PICTURE);
    let Some(finer) = finer.filter(|&n| n <= FINEST) else {
        let side = IN_PICTURE.sqrt() as u32;
        let film = camera.film_in(scene.data().origin, &scene.bounds(), side, side);
        (0..side * side).for_each(|i| look(film.ray((i % side) as f32 + 0.5, (i / side) as f32 + 0.5), 1.0, i));
        return looks;
    };

    // Both grids are fixed in the world.
    for (times, is_fine) in [(1, false), (finer, true)] {
        let (columns, rows) = (COLUMNS * times, ROWS * times);
        for i in 0..columns * rows {
            let phi = 2.0 * PI * ((i % columns) as f32 + 0.5) / columns as f32;
            let height = 2.0 * ((i / columns) as f32 + 0.5) / rows as f32 - 1.0;
            let r = (1.0 - height * height).sqrt();
            let direction = Vec3::new(r * libm::cosf(phi), height, r * libm::sinf(phi));
            let [x, y, z] = axes.map(|axis| axis.dot(direction));
            let inside = z < 0.0 && x.abs() < -z * half.x && y.abs() < -z * half.y;
            if inside || !is_fine {
                let density = if inside { 1.0 + (finer * finer) as f32 } else { 1.0 };
                look(Ray::new(eye, direction), density, 2 * i + u32::from(is_fine));
            }
        }
    }
    looks
}
