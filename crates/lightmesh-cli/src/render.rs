//! `lightmesh render`.

use std::time::{Duration, Instant};

use anyhow::{Context, anyhow};
use lightmesh::{Camera, Environment, LightMesh, Limits, Progress, RenderOptions, RenderStats, Scene, SceneData};
use lightmesh_denoise::{Error as DenoiseError, Places};
use lightmesh_io::{
    MeshFile, Provenance,
    output::{Metadata, Precision},
};

use crate::{
    SOFTWARE,
    args::{EmitterArgs, RenderArgs},
    camera_choice,
    denoise::{Denoise, no_noise_message},
    environment, error_report,
    exit::Failure,
    interrupt,
    outputs::{self, Outputs},
    preview::Preview,
    progress::Bar,
    settings,
    stats::{Stats, non_finite_message},
    terminal, threads,
};

/// Renders one picture into all its files.
pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
    let start = Instant::now();
    let warn = |message: &str| warn(args, message);

    // Refuse what can be refused before any work.
    let mut options = args.options()?;
    let surroundings = args.surroundings();
    let wants_layers = !options.picture.aovs.is_empty();
    let denoise = match args.denoise {
        true => prepare_denoise(&mut options, warn)?,
        // A preview is denoised where it can be.
        false if args.is_preview() => Denoise::prepare(&Places::of_process(), &mut options).unwrap_or_default(),
        false => None,
    };
    if args.chosen.get("size").is_some() {
        check_memory(args, &options, denoise.as_ref(), 0)?;
    }
    interrupt::listen();
    let outputs = Outputs::check(args, &surroundings)?;
    if wants_layers && !outputs.has_exr() {
        return Err(Failure::Input(anyhow!("--aov: layers need an .exr file to be written to; a .png has none")));
    }
    for (option, file) in [("mesh", &args.mesh), ("save-mesh", &args.save_mesh)] {
        if file.is_some() && !options.method.has_mesh() {
            return Err(Failure::Input(anyhow!("--{option}: --method {} has no light mesh", options.method)));
        }
    }

    // Start the threads, and work on them.
    let pool = threads::start(surroundings.threads, warn)?;
    pool.install(|| render(args, options, denoise.as_ref(), &surroundings.emitters, outputs, start))
}

/// Reads the scene, renders the picture and writes the files.
fn render(
    args: &RenderArgs,
    mut options: RenderOptions,
    denoise: Option<&Denoise>,
    emitters: &EmitterArgs,
    mut outputs: Outputs,
    start: Instant,
) -> Result<(), Failure> {
    let warn = |message: &str| warn(args, message);
    let bar = Bar::new(args.quiet, options.picture.time_limit);
    let max_memory = options.limits.max_memory;
    let has_size = args.chosen.get("size").is_some();

    // Read the environment and the mesh, which fail sooner, and the scene.
    let asked_for = environment::read(emitters, max_memory, warn).map_err(Failure::input)?;
    let known = args.mesh.as_deref().map(|path| Ok((path, lightmesh_io::read_mesh(path, max_memory)?)));
    let known = known.transpose().map_err(|error: lightmesh_io::Error| Failure::input(error))?;
    bar.spin("reading the scene");
    let load_options = args.load_options(max_memory);
    let loaded = lightmesh_io::load(&args.scene, &load_options).map_err(Failure::input);
    bar.clear();
    let loaded = loaded?;
    outputs.spare(&loaded.files)?;
    stop_if_interrupted()?;
    let load = start.elapsed();
    loaded.warnings.iter().for_each(|w| warn(w));

    // Build it.
    let build_start = Instant::now();
    bar.spin("building");
    let built = build(loaded.data, asked_for, emitters, &options.limits, args.camera.as_deref());
    bar.clear();
    let Built { scene, camera, warnings } =
        built.map_err(|failure| name_the_file(failure, &args.scene.display().to_string()))?;
    stop_if_interrupted()?;
    let build = build_start.elapsed();
    scene.warnings().iter().chain(&warnings).for_each(|w| warn(w));

    // Set up the picture and its light mesh, new or as the file has it.
    if !has_size {
        options.picture.height = camera_choice::height_for(&camera, options.picture.width);
    }
    let options = options.for_scene(&scene);
    check_memory(args, &options, denoise, scene.bytes())?;
    // Layers that only denoising needs are no setting of the picture.
    let kept = denoise.map_or(options.picture.aovs, Denoise::kept);
    let shown = options.clone().with(|o| o.picture.aovs = kept);
    let mut metadata = Metadata {
        software: SOFTWARE.to_owned(),
        method: options.method.to_string(),
        scene: args.scene.display().to_string(),
        settings: settings::json(&shown, emitters, load_options.units, &camera.name),
        seconds: 0.0,
        estimated_error: None,
        spp: options.picture.spp,
        denoised: None,
        camera,
    };
    let mut mesh = match known {
        None => LightMesh::for_cameras(&scene, &options, std::slice::from_ref(&metadata.camera))?,
        Some((path, file)) => file.into_mesh(path, &scene, &options).map_err(Failure::input)?,
    };

    // Render and take the noise out, with a preview if one is wanted.
    let mut render = |progress: &dyn Progress| {
        let mut frame = lightmesh::render(&scene, &metadata.camera, &options, &mut mesh, progress)?;
        let denoised = denoise.map(|denoise| {
            bar.spin("denoising");
            denoise.apply(&mut frame, &scene, &options, progress).map_err(|error| match error {
                DenoiseError::Cancelled => Failure::Interrupted,
                other => Failure::work(other),
            })
        });
        let denoised = denoised.transpose()?.flatten();
        if let (Some(viewer), Some(_)) = (progress.viewer(), &denoised) {
            viewer.show(frame.image.clone());
        }
        Ok::<_, Failure>((frame, denoised))
    };
    let frame = match &args.preview {
        None => render(&bar),
        Some(path) => {
            let next = outputs.take_preview().into();
            let preview = Preview { path: path.clone(), next, exposure: args.exposure, metadata: &metadata };
            preview.follow(&bar, warn, render)
        }
    };
    bar.clear();
    let (frame, denoised) = frame?;
    if denoise.is_some() && denoised.is_none() {
        warn(&no_noise_message(options.method));
    }
    metadata.denoised.clone_from(&denoised);
    (metadata.seconds, metadata.spp) = (frame.stats.seconds.render, frame.stats.spp);
    metadata.estimated_error = frame.stats.estimated_error;
    stop_if_interrupted()?;

    // Write every file under a temporary name, then give all of them theirs.
    let output_start = Instant::now();
    let ev = args.exposure.for_picture(&frame.image);
    let precision = if args.half { Precision::Half } else { Precision::Single };
    let pictures = outputs.stage_pictures(&frame, ev, precision, &metadata)?;
    let provenance = Provenance { software: SOFTWARE, method: &metadata.method, settings: &metadata.settings };
    let mesh_file = outputs.stage_mesh(|| MeshFile::new(&scene, &options, &mesh, provenance))?;
    let stats = Stats::new(metadata.scene, &scene, &options, &frame.stats).with_denoised(metadata.denoised.as_ref());
    let stats = stats.with_seconds(load, build, output_start.elapsed(), start.elapsed());
    let json = serde_json::to_string_pretty(&stats).context("statistics").map_err(Failure::Work)?;
    let stats_file = outputs.stage_stats(&(json + "\n"))?;
    stop_if_interrupted()?;
    outputs::commit(pictures.into_iter().chain(mesh_file).chain(stats_file))?;

    // Report the files, the time and the quality.
    if !args.quiet {
        let names: Vec<String> = args.output.iter().map(|path| path.display().to_string()).collect();
        let exposure = if outputs.has_png() { format!(", exposure {ev} EV") } else { String::new() };
        let denoising = denoised.map_or(String::new(), |denoised| format!(", {:.2} s denoising", denoised.seconds));
        if let Some(limit) = options.picture.time_limit {
            terminal::note(&samples_in_time(limit, &frame.stats));
        }
        if let (Some(bound), Some(estimate)) = (options.method.error(), &frame.stats.error_estimate) {
            error_report::lines(bound, estimate).iter().for_each(|line| terminal::note(line));
        }
        if let Some(note) = left_out(options.transport.bounces, frame.stats.truncated_light) {
            terminal::note(&note);
        }
        terminal::note(&format!(
            "{} in {:.2} s ({:.2} s of it rendering{denoising}){exposure}",
            names.join(", "),
            start.elapsed().as_secs_f64(),
            frame.stats.seconds.render
        ));
    }
    if let Some(message) = non_finite_message(&frame.stats, &frame.image) {
        return Err(Failure::Work(anyhow!(message)));
    }
    match (options.method.error(), &frame.stats.error_estimate) {
        (Some(bound), Some(estimate)) if args.strict && !error_report::is_kept(bound, estimate) => {
            Err(Failure::TooInexact(error_report::verdict(bound, estimate)))
        }
        _ => Ok(()),
    }
}

/// Says a warning, if any are wanted.
fn warn(args: &RenderArgs, message: &str) {
    if !args.quiet {
        terminal::warning(message);
    }
}

/// Loads the denoiser before there is work that would be lost without it; warns if the method makes no noise.
fn prepare_denoise(options: &mut RenderOptions, warn: impl Fn(&str)) -> Result<Option<Denoise>, Failure> {
    let denoise = Denoise::prepare(&Places::of_process(), options).map_err(Failure::input)?;
    if denoise.is_none() {
        warn(&no_noise_message(options.method));
    }
    Ok(denoise)
}

/// Refuses a picture that memory does not hold, with what looks at it and what takes its noise out, beside the
/// `scene_bytes` of its scene.
fn check_memory(
    args: &RenderArgs,
    options: &RenderOptions,
    denoise: Option<&Denoise>,
    scene_bytes: u64,
) -> Result<(), Failure> {
    match args.preview {
        Some(_) => options.check_viewed_picture_memory()?,
        None => options.check_picture_memory()?,
    }
    denoise.map_or(Ok(()), |denoise| denoise.check_memory(options, scene_bytes)).map_err(Failure::input)
}

/// Describes how many samples a time limit allowed.
fn samples_in_time(limit: Duration, stats: &RenderStats) -> String {
    let seconds = limit.as_secs_f64();
    match stats.time_limit_reached {
        true => format!("{} sample(s) per pixel in the limit of {seconds} s", stats.spp),
        false => format!("all {} sample(s) per pixel, before the limit of {seconds} s", stats.spp),
    }
}

/// Describes the light that more bounces would add; `None` if nothing is known of it.
fn left_out(bounces: u32, part: Option<f64>) -> Option<String> {
    let part = part.filter(|_| bounces > 0)?;
    Some(format!("{bounces} bounce(s) leave out about {:.1}% of the light", 100.0 * part))
}

/// A scene that can be rendered, and from where.
struct Built {
    scene: Scene,
    camera: Camera,
    warnings: Vec<String>,
}

/// Chooses the camera, lights the scene as asked or if nothing does, and builds it.
fn build(
    mut data: SceneData,
    asked_for: Option<Environment>,
    emitters: &EmitterArgs,
    limits: &Limits,
    wanted: Option<&str>,
) -> Result<Built, Failure> {
    let (camera, warning) = camera_choice::choose(&data, wanted).map_err(Failure::Input)?;
    let mut warnings: Vec<String> = warning.into_iter().collect();
    environment::apply(&mut data, asked_for, emitters);
    let scene = Scene::within(data, &emitters.options, limits)?;
    let lit = environment::add_first_light(scene, &camera, emitters)?;
    warnings.extend(lit.warnings);
    Ok(Built { scene: lit.scene, camera, warnings })
}

/// Says which file bad input is about; the core does not know it.
fn name_the_file(failure: Failure, scene: &str) -> Failure {
    match failure {
        Failure::Input(error) => Failure::Input(error.context(scene.to_owned())),
        other => other,
    }
}

/// Ends here after Ctrl-C.
fn stop_if_interrupted() -> Result<(), Failure> {
    if interrupt::pressed() { Err(Failure::Interrupted) } else { Ok(()) }
}
