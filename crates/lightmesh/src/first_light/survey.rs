//! What a camera would see: a few hundred rays, before anything is rendered.

use glam::{Vec2, Vec3};

use super::studio;
use crate::api::measure;
use crate::geometry::Ray;
use crate::interaction::{SeenPlace, is_back_face};
use crate::light::emitters::luminance;
use crate::sampling::{Sampler, basis, sample_cosine_hemisphere};
use crate::{Camera, Error, LightMesh, Meter, Method, RenderOptions, Scene};

/// The light that a first picture gets beside the scene's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FirstLight {
    /// None: the scene's own light shows enough.
    Own,
    /// The environment of a studio.
    Studio,
    /// A lamp at the camera, where no environment can come in.
    Headlight,
}

/// What a camera sees, estimated from about 400 rays, the same ones for the same camera.
#[derive(Clone, Debug)]
pub struct Survey {
    /// The light that the view needs.
    pub wanted: FirstLight,
    /// Whether the scene has any light of its own that is not black: lamps, emission or an environment.
    pub has_own_light: bool,
    /// The part of the rays that meets a surface.
    pub seen: f32,
    /// The part of these that meets the back of a one-sided surface, as all do inside a solid.
    pub back_faces: f32,
    /// Whether light can come in from outside to what is seen.
    pub open: bool,
    pub(super) eye: Vec3,
    /// Unit: to the right, up and back.
    pub(super) axes: [Vec3; 3],
    /// The median distance of what is seen, metres.
    pub(super) distance: f32,
}

/// Camera rays.
const RAYS: u32 = 400;
/// Paths from each visible point to the sky, and their diffuse bounces.
const PATHS: u32 = 4;
const BOUNCES: u32 = 4;
/// The part of these paths, weighted by what they carry, that has to reach the sky. An opening of a thousandth of a
/// room's walls lets in about so much.
const OPEN: f32 = 1e-3;

/// The part of the visible points that lamps have to light, one way or another: a spot that shines on a mirror lights a
/// patch of a wall, and is meant to.
const LIT_BY_LAMPS: f32 = 0.005;
/// The same where only surfaces emit. Viewers take emission for paint that glows, and a model with a few such spots is
/// meant to be seen in light; a room lit by its emissive panel is lit everywhere.
const LIT_BY_EMISSION: f32 = 0.25;
/// Luminance that counts as lit on a white surface, cd/m². Where only surfaces emit, white paper in starlight, which
/// an emission of 1 reaches some ten times its own size away; files of other renderers have lamps without units.
const DARK_BY_LAMPS: f32 = 1e-6;
const DARK_BY_EMISSION: f32 = 1e-3;

/// Samples of the light at each visible point where only surfaces emit, or where one found nothing.
const SAMPLES: u32 = 64;

/// Visible points measured at a time, and lights above which one batch is all.
const BATCH: usize = 16;
const MANY_LIGHTS: usize = 4096;

impl Survey {
    /// Looks at `scene` through `camera`.
    ///
    /// # Errors
    /// As [`measure`]; none for a scene and a camera without errors.
    pub fn new(scene: &Scene, camera: &Camera) -> Result<Self, Error> {
        // Follow camera rays to what they see.
        let aspect = camera.aspect().clamp(0.05, 20.0);
        let height = (RAYS as f32 / aspect).sqrt().ceil();
        let (width, height) = ((height * aspect).ceil() as u32, height as u32);
        let film = camera.film_in(scene.data().origin, &scene.bounds(), width, height);
        let (mut places, mut distances) = (Vec::new(), Vec::new());
        let (mut hits, mut backs) = (0, 0);
        for pixel in 0..width * height {
            let mut sampler = Sampler::new(0, pixel, 0);
            let jitter = sampler.next_pair();
            let corner = Vec2::new((pixel % width) as f32, (pixel / width) as f32);
            let ray = film.ray(corner.x + jitter.x, corner.y + jitter.y);
            let Some(hit) = scene.bvh().closest(&ray) else { continue };
            (hits, backs) = (hits + 1, backs + u32::from(is_back_face(scene, &ray, &hit)));
            distances.push(hit.t * ray.direction.length());
            places.extend(SeenPlace::along(scene, ray, &mut sampler));
        }
        distances.sort_unstable_by(f32::total_cmp);

        // Estimate the light there, its own and what could come in.
        let m = &camera.world_from_camera.matrix3;
        let has_own_light = has_own_light(scene);
        let mut survey = Self {
            wanted: FirstLight::Own,
            has_own_light,
            seen: hits as f32 / (width * height) as f32,
            back_faces: backs as f32 / (hits as f32).max(1.0),
            open: is_open(scene, &places),
            eye: (camera.world_from_camera.translation - scene.data().origin).as_vec3(),
            axes: [(m.x_axis, Vec3::X), (m.y_axis, Vec3::Y), (m.z_axis, Vec3::Z)]
                .map(|(axis, fallback)| axis.as_vec3().normalize_or(fallback)),
            distance: distances.get(distances.len() / 2).copied().unwrap_or(1.0),
        };
        // Few samples find light that comes by way of a mirror, or through a small window: before a view is called dark,
        // there are more of them.
        let first_samples = if has_lamps(scene) { 1 } else { SAMPLES };
        let lit = has_own_light
            && (places.is_empty()
                || is_lit(scene, &places, first_samples)?
                || first_samples < SAMPLES && is_lit(scene, &places, SAMPLES)?);
        survey.wanted = match (lit, survey.open || places.is_empty()) {
            (true, _) => FirstLight::Own,
            (false, true) => FirstLight::Studio,
            (false, false) => FirstLight::Headlight,
        };
        Ok(survey)
    }
}

/// Whether there is any light that is not black.
fn has_own_light(scene: &Scene) -> bool {
    let data = scene.data();
    let emits = |m: usize| !data.materials[m].unlit && studio::shown(data, &data.materials[m]) > 0.0;
    has_lamps(scene) || studio::used_materials(data).into_iter().any(emits)
}

/// Whether there are lamps or an environment, and not all black.
fn has_lamps(scene: &Scene) -> bool {
    scene.emitters().environment.is_some() || scene.data().lights.iter().any(|light| light.color().max_element() > 0.0)
}

/// Whether enough of what is seen is lit. Random batches are measured until that is certain, so that lit scenes, and
/// with many lights all scenes, take little time.
fn is_lit(scene: &Scene, places: &[SeenPlace], samples: u32) -> Result<bool, Error> {
    let (part, dark) =
        if has_lamps(scene) { (LIT_BY_LAMPS, DARK_BY_LAMPS) } else { (LIT_BY_EMISSION, DARK_BY_EMISSION) };
    let options = RenderOptions::default().with(|o| {
        o.method = Method::Path;
        o.picture.spp = samples;
        o.transport.bounces = 2;
    });
    let mut mesh = LightMesh::new(scene, &options)?;
    let count = if scene.data().lights.len() > MANY_LIGHTS { BATCH.min(places.len()) } else { places.len() };
    let needed = ((part * count as f32).ceil() as usize).max(1);
    // A stride without a common divisor visits all places, and each batch is spread over the picture.
    let stride = (1..).map(|i| places.len() * 38 / 100 + i).find(|&s| gcd(s, places.len()) == 1).unwrap_or(1);
    let order: Vec<usize> = (0..count).map(|i| i * stride % places.len()).collect();
    let mut lit = 0;
    for (done, batch) in order.chunks(BATCH).enumerate() {
        let meters: Vec<Meter> =
            batch.iter().map(|&i| Meter { position: places[i].point, normal: places[i].n }).collect();
        let measured = measure(scene, &meters, &options, &mut mesh, &())?;
        let light = measured.direct.iter().zip(&measured.indirect).map(|(d, i)| luminance(*d + *i));
        lit += light.filter(|e| *e > dark * std::f32::consts::PI).count();
        let left = count - ((done + 1) * BATCH).min(count);
        if lit >= needed || lit + left < needed {
            break;
        }
    }
    Ok(lit >= needed)
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Whether paths from what is seen reach the sky.
fn is_open(scene: &Scene, places: &[SeenPlace]) -> bool {
    let mut reached = 0.0;
    let enough = OPEN * (places.len() as u32 * PATHS) as f32;
    for (i, place) in places.iter().enumerate() {
        for branch in 0..PATHS {
            let mut sampler = Sampler::new(1, i as u32, branch);
            let (mut point, mut n, mut weight) = (place.point, place.n, 1.0);
            for _ in 0..=BOUNCES {
                let (x, y) = basis(n);
                let local = sample_cosine_hemisphere(sampler.next_pair());
                let ray = Ray::new(point, x * local.x + y * local.y + n * local.z);
                if scene.bvh().closest(&ray).is_none() {
                    reached += weight;
                    break;
                }
                let Some(next) = SeenPlace::along(scene, ray, &mut sampler) else { break };
                (point, n, weight) = (next.point, next.n, weight * next.albedo);
            }
            if reached > enough {
                return true;
            }
        }
    }
    false
}
