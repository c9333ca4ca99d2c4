//! A picture in portions, for many processes or machines: the same picture, bit for bit, as [`crate::render()`] makes.
//!
//! A picture's samples are taken in waves, 65536 at most and always all of a pixel. A [`Portion`] is what some waves in a row bring. Whoever has
//! the scene, the camera and the options can take any portion, in any order and as often as it likes, and it is the same: first
//! [`prepare`], then [`render`](render()). Where lamps are in view, pixels on their outlines are sampled anew once all portions are there
//! ([`outlines`]). [`assemble`] makes the picture.
//!
//! What the light mesh lacks for a portion is filled on the way; [`crate::filling`] is how several processes share that work.

use std::ops::Range;
use std::time::Instant;

use super::waves::{plan_waves, render_portion_on};
use crate::api::new_film;
use crate::direct::LightingPlan;
use crate::film::{Film, RenderClock};
use crate::integrator::Lighting;
use crate::{Aov, Camera, Error, Frame, LightMesh, Method, Progress, RenderOptions, RenderStats, Scene};

/// How a picture is made, where that needs a look at all of it: how lights are asked so that the error keeps to its bound, where meshes are
/// finer. The same wherever it is found out.
#[derive(Clone, Debug)]
pub struct Prepared {
    pub(crate) plan: LightingPlan,
    /// Of the mesh that has been refined for it.
    preparation: u64,
    /// What it took; [`RenderStats::estimated_error`] is that of the picture.
    pub stats: RenderStats,
}

impl Prepared {
    /// Whether the mesh is still ready for the picture, and no other one.
    pub fn holds(&self, mesh: &LightMesh) -> bool {
        mesh.generation() == self.preparation
    }

    /// Refuses a mesh that is not ready for the picture.
    pub(crate) fn check(&self, mesh: &LightMesh) -> Result<(), Error> {
        if self.holds(mesh) {
            return Ok(());
        }
        Err(Error::IncompatibleMesh { what: "has been made ready for another picture since".into() })
    }
}

/// Which samples.
#[derive(Clone, Copy, Debug)]
pub enum PictureSamples<'a> {
    /// Those of every pixel.
    All,
    /// Those of the pixels on the outlines of lamps, which replace what these pixels had.
    Outlines(&'a Outlines),
}

/// The outlines of lamps in a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outlines {
    /// A byte per pixel, row by row: 1 a lamp was seen, 2 something else, 3 both.
    pub seen: Vec<u8>,
    /// How many waves their samples are.
    pub waves: u64,
}

/// Some waves of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Portion {
    /// Which.
    pub waves: Range<u64>,
    /// By pixel, in the order in which they are sampled (tiles of 32 × 32 pixels): the sums of its samples' red, green and blue, cd/m²,
    /// and of the layers' channels.
    pub values: Vec<f32>,
    /// By pixel, what was seen of lamps, as in [`crate::film::Film::copy_seen`]; empty where there are none.
    pub seen: Vec<u8>,
    /// Rays and seconds.
    pub stats: RenderStats,
}

/// How many waves the samples of a picture are.
///
/// # Errors
/// As [`RenderOptions::validate`].
pub fn wave_count(options: &RenderOptions) -> Result<u64, Error> {
    options.validate()?;
    let pixels = u64::from(options.picture.width) * u64::from(options.picture.height);
    let per_wave = crate::film::WAVE / u64::from(options.picture.spp);
    Ok(pixels.div_ceil(per_wave))
}

/// Makes ready for the portions of a picture; `mesh` stays so until it is made ready for another one.
///
/// # Errors
/// As [`crate::render()`]; [`Error::InvalidOption`] for what needs the whole picture at once: a time limit, and [`Aov::Points`].
pub fn prepare(
    scene: &Scene,
    camera: &Camera,
    options: &RenderOptions,
    mesh: &mut LightMesh,
    progress: &dyn Progress,
) -> Result<Prepared, Error> {
    check(options)?;
    let film = new_film(scene, camera, options);
    let mut watch = RenderClock::new(progress, None, Instant::now(), None);
    let (plan, stats) = match lighting(options, mesh)? {
        Some(lighting) => plan_waves(scene, &film, options, lighting, &mut watch)?,
        None => (LightingPlan::of(options), RenderStats::default()),
    };
    Ok(Prepared { plan, preparation: mesh.generation(), stats })
}

/// Takes the samples of some waves of a picture; what the mesh lacks for them is filled.
///
/// # Errors
/// As [`prepare`]; [`Error::IncompatibleMesh`] where the mesh has been made ready for another picture since,
/// [`Error::InvalidWaves`] for waves that the picture
/// does not have.
pub fn render(
    scene: &Scene,
    camera: &Camera,
    options: &RenderOptions,
    mesh: &mut LightMesh,
    (prepared, samples, waves): (&Prepared, PictureSamples<'_>, Range<u64>),
    progress: &dyn Progress,
) -> Result<Portion, Error> {
    prepared.check(mesh)?;
    let mut film = film_of(scene, camera, options, samples)?;
    check_waves(&film, &waves)?;
    let pixels = film.portion_pixels(waves.clone());
    film.begin_portion(waves.clone());
    let started = Instant::now();
    let lighting = lighting(options, mesh)?.map(|lighting| (lighting, prepared.plan));
    let mut watch = RenderClock::new(progress, None, started, None);
    let mut stats = render_portion_on(scene, &mut film, options, lighting, &mut watch)?;
    stats.seconds.render = started.elapsed().as_secs_f64();
    stats.estimated_error = prepared.stats.estimated_error;
    Ok(Portion { waves, values: film.copy_pixels(&pixels), seen: film.copy_seen(&pixels), stats })
}

/// The outlines of lamps in a picture of which all portions are there; `None` where no pixel has to be sampled anew.
///
/// # Errors
/// [`Error::InvalidPortions`] where portions are missing or twice, or not of this picture.
pub fn outlines(
    scene: &Scene,
    camera: &Camera,
    options: &RenderOptions,
    portions: &[Portion],
) -> Result<Option<Outlines>, Error> {
    check(options)?;
    let mut film = new_film(scene, camera, options);
    let sorted = in_order(&film, portions)?;
    if sorted.iter().all(|portion| portion.seen.is_empty()) {
        return Ok(None);
    }
    let mut seen = vec![0; film.pixel_count() as usize];
    for portion in sorted {
        let pixels = film.portion_pixels(portion.waves.clone());
        check_length("seen", portion.seen.len(), pixels.len())?;
        pixels.iter().zip(&portion.seen).for_each(|(&pixel, &saw)| seen[pixel as usize] = saw);
    }
    film.put_seen(&seen);
    let any = film.turn_to_outlines(u64::MAX);
    Ok(any.then(|| Outlines { seen, waves: film.wave_count() }))
}

/// The picture from all its portions and, where there are outlines, from all of theirs. Seconds and rays are sums over the portions.
///
/// # Errors
/// [`Error::InvalidPortions`] where portions are missing or twice, or not of this picture.
pub fn assemble(
    scene: &Scene,
    camera: &Camera,
    options: &RenderOptions,
    portions: &[Portion],
    outlines: Option<(&Outlines, &[Portion])>,
) -> Result<Frame, Error> {
    check(options)?;
    let mut film = new_film(scene, camera, options);
    let mut stats = RenderStats { spp: options.picture.spp, ..RenderStats::default() };
    put(&mut film, portions, &mut stats)?;
    if let Some((outlines, portions)) = outlines {
        turn_to(&mut film, outlines)?;
        put(&mut film, portions, &mut stats)?;
    }
    let (image, mut layers) = film.into_image();
    layers.retain(|layer| options.picture.aovs.contains(layer.aov));
    Ok(Frame { image, layers, stats })
}

/// An empty film with these samples to be taken.
pub(crate) fn film_of(
    scene: &Scene,
    camera: &Camera,
    options: &RenderOptions,
    samples: PictureSamples<'_>,
) -> Result<Film, Error> {
    check(options)?;
    let mut film = new_film(scene, camera, options);
    match samples {
        PictureSamples::All if scene.has_lamps() && options.method != Method::Path => film.watch_lamps(),
        PictureSamples::All => {}
        PictureSamples::Outlines(outlines) => turn_to(&mut film, outlines)?,
    }
    Ok(film)
}

/// Refuses waves that the film's samples do not have.
pub(crate) fn check_waves(film: &Film, waves: &Range<u64>) -> Result<(), Error> {
    let count = film.wave_count();
    if !waves.is_empty() && waves.end <= count {
        return Ok(());
    }
    let what = format!("there are no waves {} to {}: the picture has {count}", waves.start, waves.end);
    Err(Error::InvalidWaves { what })
}

/// Puts the portions of the film's pass on it, and their sums to the others'.
fn put(film: &mut Film, portions: &[Portion], stats: &mut RenderStats) -> Result<(), Error> {
    for portion in in_order(film, portions)? {
        let pixels = film.portion_pixels(portion.waves.clone());
        check_length("values", portion.values.len(), pixels.len() * film.channels())?;
        film.put_pixels(&pixels, &portion.values);
        stats.add(&portion.stats);
    }
    film.end_pass();
    Ok(())
}

/// The portions by wave, if each wave of the film's pass is there once.
fn in_order<'a>(film: &Film, portions: &'a [Portion]) -> Result<Vec<&'a Portion>, Error> {
    let mut sorted: Vec<&Portion> = portions.iter().collect();
    sorted.sort_by_key(|portion| portion.waves.start);
    let starts = sorted.iter().map(|portion| portion.waves.start).chain([film.wave_count()]);
    let ends = [0].into_iter().chain(sorted.iter().map(|portion| portion.waves.end));
    if let Some((end, start)) = ends.zip(starts).find(|(end, start)| end != start) {
        let what = format!("waves {} to {} are missing or there twice", end.min(start), end.max(start));
        return Err(Error::InvalidPortions { what });
    }
    Ok(sorted)
}

fn check_length(what: &str, length: usize, expected: usize) -> Result<(), Error> {
    if length == expected {
        return Ok(());
    }
    let what = format!("{what} has {length} numbers, not {expected}: it is of another picture");
    Err(Error::InvalidPortions { what })
}

/// Turns to the pixels on outlines.
fn turn_to(film: &mut Film, outlines: &Outlines) -> Result<(), Error> {
    check_length("seen", outlines.seen.len(), film.pixel_count() as usize)?;
    film.put_seen(&outlines.seen);
    if film.turn_to_outlines(u64::MAX) {
        return Ok(());
    }
    Err(Error::InvalidOutlines { what: "no pixel of this picture is on one".into() })
}

/// Refuses what portions cannot have.
fn check(options: &RenderOptions) -> Result<(), Error> {
    options.validate()?;
    options.check_picture_memory()?;
    if options.picture.time_limit.is_some() {
        let what = "portions have no common clock; choose --spp or --error";
        return Err(Error::InvalidOption { option: "time-limit", what: what.into() });
    }
    if options.picture.aovs.contains(Aov::Points) {
        let what = "points shows the whole mesh, of which portions fill parts; render it in one piece";
        return Err(Error::InvalidOption { option: "aov", what: what.into() });
    }
    Ok(())
}

/// Where light comes from; `None`: from paths.
fn lighting<'a>(options: &RenderOptions, mesh: &'a mut LightMesh) -> Result<Option<Lighting<'a>>, Error> {
    match options.method {
        Method::Path => Ok(None),
        Method::Standard => Ok(Some(Lighting::Exact)),
        Method::Mesh { .. } | Method::Paper { .. } | Method::Hybrid | Method::Unbiased { .. } => {
            mesh.check_compatible(options)?;
            Ok(Some(Lighting::Mesh(mesh)))
        }
    }
}
