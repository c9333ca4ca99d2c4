//! Pictures in parts: preparing, rendering some waves, and merging.

use std::ops::Range;
use std::time::Instant;

use super::waves::{WaveMethod, draw_waves, plan_waves};
use crate::api::{new_film, white_around};
use crate::direct::LightingPlan;
use crate::film::{Film, RenderClock, blacken_non_finite, cut_noise_below_black};
use crate::integrator::Lighting;
use crate::{Aov, Camera, Error, Frame, LightMesh, Method, Progress, RenderOptions, RenderStats, Scene};

/// What the waves of a picture have in common: how they are lit so that the error keeps to its bound, and where meshes
/// are finer. It is the same whichever process finds it out.
#[derive(Clone, Debug)]
pub struct Prepared {
    pub(crate) plan: LightingPlan,
    /// The generation of the mesh that has been refined for it.
    generation: u64,
    /// What preparing took; [`RenderStats::estimated_error`] is that of the picture.
    pub stats: RenderStats,
}

impl Prepared {
    /// Whether the mesh is still refined for this picture, and for no other one.
    pub fn holds(&self, mesh: &LightMesh) -> bool {
        mesh.generation() == self.generation
    }

    /// Refuses a mesh that is not ready for the picture.
    pub(crate) fn check(&self, mesh: &LightMesh) -> Result<(), Error> {
        if self.holds(mesh) {
            return Ok(());
        }
        Err(Error::IncompatibleMesh { what: "has been made ready for another picture since".into() })
    }
}

/// Which samples of a picture.
#[derive(Clone, Copy, Debug)]
pub enum PictureSamples<'a> {
    /// Those of every pixel.
    All,
    /// Those of the pixels on the edges of emitters, which replace what these pixels had.
    EmitterEdges(&'a EmitterEdges),
}

/// The pixels on edges of emitters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EmitterEdges {
    /// A byte per pixel, row by row: 1 an emitter was hit, 2 something else, 3 both.
    pub emitter_seen: Vec<u8>,
    /// How many waves their samples are.
    pub waves: u64,
}

/// Some waves of a picture to be rendered.
#[derive(Clone, Debug)]
pub struct WaveRequest<'a> {
    /// Made for this picture.
    pub prepared: &'a Prepared,
    /// The samples that the waves are counted in.
    pub samples: PictureSamples<'a>,
    /// Which waves; at least one.
    pub waves: Range<u64>,
}

/// What some waves of a picture have brought.
#[derive(Clone, Debug, PartialEq)]
pub struct PartialImage {
    /// Which waves.
    pub waves: Range<u64>,
    /// By pixel, in the order in which they are sampled (tiles of 32 × 32 pixels): the sums of its samples' red, green
    /// and blue, cd/m², and of the layers' channels.
    pub values: Vec<f32>,
    /// By pixel, as in [`EmitterEdges::emitter_seen`]; empty where there are no emitters.
    pub emitter_seen: Vec<u8>,
    /// Rays and seconds.
    pub stats: RenderStats,
}

impl WaveRequest<'_> {
    /// Makes an empty film whose pass are these waves.
    pub(super) fn film(&self, scene: &Scene, camera: &Camera, options: &RenderOptions) -> Result<Film, Error> {
        check(scene, options)?;
        let mut film = new_film(scene, camera, options);
        match self.samples {
            PictureSamples::All if scene.has_visible_emitters() && options.method != Method::Path => {
                film.watch_emitters()
            }
            PictureSamples::All => {}
            PictureSamples::EmitterEdges(edges) => turn_to(&mut film, edges)?,
        }
        let count = film.wave_count();
        if self.waves.is_empty() || self.waves.end > count {
            let Range { start, end } = self.waves;
            let what = format!("there are no waves {start} to {end}: the picture has {count}");
            return Err(Error::InvalidWaves { what });
        }
        film.begin_waves(self.waves.clone());
        Ok(film)
    }
}

/// Counts the waves of a picture's samples.
///
/// # Errors
/// As [`RenderOptions::validate`].
pub fn wave_count(options: &RenderOptions) -> Result<u64, Error> {
    options.validate()?;
    let pixels = u64::from(options.picture.width) * u64::from(options.picture.height);
    let per_wave = crate::film::WAVE / u64::from(options.picture.spp);
    Ok(pixels.div_ceil(per_wave))
}

/// Prepares for the waves of a picture; `mesh` stays refined for it until another picture is prepared or rendered.
///
/// # Errors
/// As [`crate::render()`]; [`Error::InvalidOption`] for what needs the whole picture at once: a time limit, and
/// [`Aov::Points`].
pub fn prepare(
    scene: &Scene,
    camera: &Camera,
    options: &RenderOptions,
    mesh: &mut LightMesh,
    progress: &dyn Progress,
) -> Result<Prepared, Error> {
    check(scene, options)?;
    let film = new_film(scene, camera, options);
    let mut clock = RenderClock::new(progress, None, Instant::now(), None);
    let (plan, stats) = match lighting(options, mesh)? {
        Some(lighting) => plan_waves(scene, &film, options, lighting, &mut clock)?,
        None => (LightingPlan::of(options), RenderStats::default()),
    };
    Ok(Prepared { plan, generation: mesh.generation(), stats })
}

/// Takes the samples of some waves of a picture; what the mesh lacks for them is filled.
///
/// # Errors
/// As [`prepare`]; [`Error::IncompatibleMesh`] where the mesh has been made ready for another picture since, and for
/// waves that the picture does not have.
pub fn render_waves(
    scene: &Scene,
    camera: &Camera,
    options: &RenderOptions,
    mesh: &mut LightMesh,
    request: WaveRequest<'_>,
    progress: &dyn Progress,
) -> Result<PartialImage, Error> {
    // Make a film whose pass are the waves.
    request.prepared.check(mesh)?;
    let mut film = request.film(scene, camera, options)?;
    let WaveRequest { prepared, waves, .. } = request;
    let pixels = film.wave_pixels(waves.clone());

    // Draw them.
    let started = Instant::now();
    let method = match lighting(options, mesh)? {
        Some(lighting) => WaveMethod::Lit { lighting, plan: prepared.plan },
        None => WaveMethod::Paths,
    };
    let mut clock = RenderClock::new(progress, None, started, None);
    let mut stats = draw_waves(scene, &mut film, options, method, &mut clock)?;

    // Copy their pixels.
    stats.seconds.render = started.elapsed().as_secs_f64();
    stats.estimated_error = prepared.stats.estimated_error;
    stats.error_estimate = prepared.stats.error_estimate;
    Ok(PartialImage { waves, values: film.copy_pixels(&pixels), emitter_seen: film.copy_seen(&pixels), stats })
}

/// Finds the pixels on edges of emitters, from all waves of a picture. Returns `None` where no pixel has to be sampled
/// anew.
///
/// # Errors
/// [`Error::InvalidParts`] where waves are missing or twice, or not of this picture.
pub fn find_emitter_edges(
    scene: &Scene,
    camera: &Camera,
    options: &RenderOptions,
    parts: &[PartialImage],
) -> Result<Option<EmitterEdges>, Error> {
    check(scene, options)?;
    let mut film = new_film(scene, camera, options);
    let sorted = in_order(&film, parts)?;
    if sorted.iter().all(|part| part.emitter_seen.is_empty()) {
        return Ok(None);
    }

    // Put together what the samples of each pixel met.
    let mut emitter_seen = vec![0; film.pixel_count() as usize];
    for part in sorted {
        let pixels = film.wave_pixels(part.waves.clone());
        check_length("seen", part.emitter_seen.len(), pixels.len())?;
        pixels.iter().zip(&part.emitter_seen).for_each(|(&pixel, &seen)| emitter_seen[pixel as usize] = seen);
    }
    film.set_seen(&emitter_seen);

    // Count the waves of the pixels on edges.
    let any = film.begin_emitter_edges(u64::MAX);
    Ok(any.then(|| EmitterEdges { emitter_seen, waves: film.wave_count() }))
}

/// Merges all waves of a picture and, where there are emitter edges, all waves of theirs. Seconds and rays are sums
/// over the parts.
///
/// # Errors
/// [`Error::InvalidParts`] where waves are missing or twice, or not of this picture.
pub fn merge_images(
    scene: &Scene,
    camera: &Camera,
    options: &RenderOptions,
    parts: &[PartialImage],
    edges: Option<(&EmitterEdges, &[PartialImage])>,
) -> Result<Frame, Error> {
    check(scene, options)?;
    let mut film = new_film(scene, camera, options);
    let mut stats = RenderStats { spp: options.picture.spp, ..RenderStats::default() };
    merge_pass(&mut film, parts, &mut stats)?;
    if let Some((edges, parts)) = edges {
        turn_to(&mut film, edges)?;
        merge_pass(&mut film, parts, &mut stats)?;
    }
    film.set_white(white_around(scene, camera)?);
    let (mut image, mut layers) = film.into_image();
    layers.retain(|layer| options.picture.aovs.contains(layer.aov));
    stats.non_finite_pixels = blacken_non_finite(&mut image, &mut layers);
    cut_noise_below_black(&mut image, options.method);
    Ok(Frame { image, layers, stats })
}

/// Puts all waves of the film's pass on it, and adds their rays and seconds.
fn merge_pass(film: &mut Film, parts: &[PartialImage], stats: &mut RenderStats) -> Result<(), Error> {
    for part in in_order(film, parts)? {
        let pixels = film.wave_pixels(part.waves.clone());
        check_length("values", part.values.len(), pixels.len() * film.channels())?;
        film.set_pixels(&pixels, &part.values);
        stats.add(&part.stats);
    }
    film.end_pass();
    Ok(())
}

/// Sorts the parts by wave, if each wave of the film's pass is there once.
fn in_order<'a>(film: &Film, parts: &'a [PartialImage]) -> Result<Vec<&'a PartialImage>, Error> {
    let mut sorted: Vec<&PartialImage> = parts.iter().collect();
    sorted.sort_by_key(|part| part.waves.start);
    let starts = sorted.iter().map(|part| part.waves.start).chain([film.wave_count()]);
    let ends = [0].into_iter().chain(sorted.iter().map(|part| part.waves.end));
    if let Some((end, start)) = ends.zip(starts).find(|(end, start)| end != start) {
        let what = format!("waves {} to {} are missing or there twice", end.min(start), end.max(start));
        return Err(Error::InvalidParts { what });
    }
    Ok(sorted)
}

fn check_length(what: &str, length: usize, expected: usize) -> Result<(), Error> {
    if length == expected {
        return Ok(());
    }
    let what = format!("{what} has {length} numbers, not {expected}: it is of another picture");
    Err(Error::InvalidParts { what })
}

/// Turns to the pixels on emitter edges.
fn turn_to(film: &mut Film, edges: &EmitterEdges) -> Result<(), Error> {
    check_length("seen", edges.emitter_seen.len(), film.pixel_count() as usize)?;
    film.set_seen(&edges.emitter_seen);
    if film.begin_emitter_edges(u64::MAX) {
        return Ok(());
    }
    Err(Error::InvalidEmitterEdges { what: "no pixel of this picture is on one".into() })
}

/// Refuses options that need the whole picture at once.
fn check(scene: &Scene, options: &RenderOptions) -> Result<(), Error> {
    options.validate()?;
    options.check_film_memory(false, scene.has_unlit(), scene.bytes())?;
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

/// Chooses where the light of surfaces comes from; `None` for path tracing.
fn lighting<'a>(options: &RenderOptions, mesh: &'a mut LightMesh) -> Result<Option<Lighting<'a>>, Error> {
    match options.method {
        Method::Path => Ok(None),
        Method::Standard => Ok(Some(Lighting::Exact)),
        Method::Auto { .. } | Method::Mesh { .. } | Method::Paper { .. } | Method::Hybrid | Method::Unbiased { .. } => {
            mesh.check_compatible(options)?;
            Ok(Some(Lighting::from_mesh(mesh)))
        }
    }
}
