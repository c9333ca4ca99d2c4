//! Exact where it matters: hybrid and unbiased light, error bounds, refined meshes.

use crate::common::*;
use glam::Vec3;
use lightmesh::metrics::difference;
use lightmesh::{Camera, Error, Image, Interpolation, LightMesh, Method, RenderOptions, Scene, Spacing, render};

/// The room with forty small lamps under its ceiling and a fence in it, whose pales are thinner than the mesh.
fn hall() -> Scene {
    let mut data = room();
    data.lights = (0..40)
        .map(|i| {
            let (x, z) = (0.45 * (i % 8) as f32 - 1.6, 0.7 * (i / 8) as f32 - 1.4);
            let color = Vec3::new(1.0, 1.0 + (i % 3) as f32, 2.0 - 0.2 * (i % 5) as f32);
            point_light(Vec3::new(x, 2.4 + 0.1 * (i % 4) as f32, z), color)
        })
        .collect();
    for i in 0..8 {
        let x = 0.3 * i as f32 - 1.1;
        place(&mut data, cuboid(Vec3::new(x, 0.0, 0.9), Vec3::new(x + 0.05, 0.8, 0.95), 1));
    }
    Scene::new(data).expect("scene")
}

/// From over the fence.
fn fence_camera() -> Camera {
    Camera::look_at(Vec3::new(-1.2, 1.2, 1.8), Vec3::new(0.0, 0.2, 0.4), 0.9)
}

fn relrmse(a: &Image, b: &Image) -> f64 {
    difference(&a.pixels, &b.pixels).relrmse
}

/// With exact light at every pixel as the truth: hybrid is several times better than the mean visibility of the same
/// mesh.
#[test]
fn hybrid_is_nearly_exact() {
    let scene = hall();
    let picture = |method| shoot(&scene, &room_camera(), &options(method));
    let (truth, mesh, hybrid) = (picture(Method::Standard), picture(Method::MESH), picture(Method::Hybrid));
    let [mesh_error, hybrid_error] = [&mesh, &hybrid].map(|frame| relrmse(&frame.image, &truth.image));
    assert!(hybrid_error < 0.02 && hybrid_error < 0.3 * mesh_error, "{hybrid_error}, mesh {mesh_error}");
    assert!(hybrid.stats.rays.shadow < truth.stats.rays.shadow);
    // What is left to chance is left to the seed.
    let other = shoot(&scene, &room_camera(), &RenderOptions { seed: 7, ..options(Method::Hybrid) });
    assert_ne!(other.image, hybrid.image);
}

/// Seeds that differ in their upper half alone, or have two equal halves, give other shadow rays too.
#[test]
fn both_halves_of_a_seed_choose_the_shadow_rays() {
    let scene = hall();
    for base in [options(Method::Hybrid), options(Method::with_error(0.05))] {
        let [zero, upper, both] = [0, 1 << 32, 0x1_0000_0001]
            .map(|seed| shoot(&scene, &room_camera(), &RenderOptions { seed, ..base.clone() }).image);
        assert!(zero != upper && zero != both && upper != both, "{:?}", base.method);
    }
}

/// Where the pictures of 64 seeds are independent estimates of the truth, the mean of each tile's light is off by z
/// standard errors with z nearly normal: the mean of z² over 48 tiles is 1 within 4 √(2/48) but once in 10,000, and
/// that of the whole picture's light is below 4².
#[test]
fn unbiased_light_has_no_bias() {
    const SEEDS: u64 = 64;
    let scene = hall();
    let truth = shoot(&scene, &room_camera(), &options(Method::Standard)).image;
    let mut mesh = LightMesh::new(&scene, &options(Method::UNBIASED)).expect("mesh");
    // 8 × 6 tiles, and all of them.
    let mut sums = [(0.0_f64, 0.0_f64); 49];
    let mut light = [0.0_f64; 49];
    for seed in 0..SEEDS {
        let options = options(Method::UNBIASED).with(|o| {
            o.seed = seed;
            o.method = Method::unbiased(4);
        });
        let image = render(&scene, &room_camera(), &options, &mut mesh, &()).expect("frame").image;
        let mut differences = [0.0; 49];
        for (i, (p, t)) in image.pixels.iter().zip(&truth.pixels).enumerate() {
            let d = f64::from((p - t).element_sum());
            differences[i % 64 / 8 + 8 * (i / 64 / 8)] += d;
            differences[48] += d;
            light[i % 64 / 8 + 8 * (i / 64 / 8)] += f64::from(t.element_sum()) / SEEDS as f64;
        }
        for (sum, d) in sums.iter_mut().zip(differences) {
            *sum = (sum.0 + d, sum.1 + d * d);
        }
    }
    let n = SEEDS as f64;
    // Where nothing is left to chance there is rounding: a part in 10⁵ of the light.
    let z2: [f64; 49] = std::array::from_fn(|i| {
        let ((sum, squares), rounding) = (sums[i], 1e-5 * light[i]);
        sum * sum / n / ((squares - sum * sum / n) / (n - 1.0)).max(rounding * rounding)
    });
    assert!(z2[48] < 16.0, "z² of the whole picture: {}", z2[48]);
    // The squares of Student's t with 63 degrees of freedom have a mean of 63/61.
    let mean = z2[..48].iter().sum::<f64>() / 48.0;
    assert!((mean - 63.0 / 61.0).abs() < 4.0 * (2.0_f64 / 48.0).sqrt(), "mean z² {mean}");
}

/// Sixteen times the rays, a quarter of the error.
#[test]
fn unbiased_light_converges() {
    let scene = hall();
    let truth = shoot(&scene, &room_camera(), &options(Method::Standard)).image;
    let error = |rays| {
        let options = options(Method::UNBIASED).with(|o| o.method = Method::unbiased(rays));
        relrmse(&shoot(&scene, &room_camera(), &options).image, &truth)
    };
    let (two, many) = (error(2), error(32));
    assert!(two > 3.5 * many, "{two} and {many}");
    // More rays than lights: each light has its own.
    assert_eq!(error(64), 0.0);
}

/// The same with bounces: what gather rays bring is unbiased too, so that methods meet where the mesh is fine.
#[test]
fn indirect_light_of_both_methods_is_that_of_the_mesh() {
    let scene = hall();
    let mean = |method| {
        let options = options(method).with(|o| o.transport.bounces = 2);
        let image = shoot(&scene, &room_camera(), &options).image;
        image.pixels.iter().map(|p| f64::from(p.element_sum())).sum::<f64>()
    };
    let mesh = mean(Method::MESH);
    for method in [Method::Hybrid, Method::UNBIASED] {
        assert!((mean(method) / mesh - 1.0).abs() < 0.03, "{method:?}: {} and {mesh}", mean(method));
    }
}

/// Indirect light too: the mean of pictures of many seeds is that of path tracing within the standard error of both,
/// though the points of the mesh are a metre apart and its own picture is several such errors off.
#[test]
fn unbiased_indirect_light_is_that_of_paths() {
    let scene = hall();
    let light = |method, spp, seed| {
        let options = options(method).with(|o| {
            o.transport.bounces = 3;
            o.picture.spp = spp;
            o.seed = seed;
            o.mesh.indirect_spacing = Spacing::Metres(1.0);
            o.mesh.gather_rays = Some(16);
        });
        let image = shoot(&scene, &room_camera(), &options).image;
        image.pixels.iter().map(|p| f64::from(p.element_sum())).sum::<f64>()
    };
    // Mean and squared standard error.
    let mean = |method, spp| {
        let lights: Vec<f64> = (0..16).map(|seed| light(method, spp, seed)).collect();
        let n = lights.len() as f64;
        let mean = lights.iter().sum::<f64>() / n;
        (mean, lights.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / (n - 1.0) / n)
    };
    let (paths, unbiased) = (mean(Method::Path, 16), mean(Method::UNBIASED, 2));
    let error = (paths.1 + unbiased.1).sqrt();
    assert!(error < 0.002 * paths.0, "{error} of {}", paths.0);
    // Student's t with some 30 degrees of freedom: beyond 4.5 once in 10,000.
    assert!((unbiased.0 - paths.0).abs() < 4.5 * error, "{unbiased:?} and {paths:?}");
    let mesh = light(Method::Hybrid, 2, 0);
    assert!((mesh - paths.0).abs() > 9.0 * error, "{mesh} and {paths:?}, within {error}");
}

/// True error at most 1.25 times the bound, and the estimate within half of the truth and of the bound; each bound
/// takes more rays than the last.
#[test]
fn error_bounds_are_kept() {
    let scene = hall();
    let camera = room_camera();
    let sized = |method| {
        options(method).with(|o| {
            o.picture.width = 160;
            o.picture.height = 120;
            o.picture.spp = 2;
        })
    };
    let truth = shoot(&scene, &camera, &sized(Method::Standard));
    let mut rays = 0;
    for bound in [0.1, 0.05, 0.02] {
        let options = sized(Method::MESH).with(|o| o.method = Method::with_error(bound));
        let frame = shoot(&scene, &camera, &options);
        let (error, estimate) = (relrmse(&frame.image, &truth.image), frame.stats.estimated_error.expect("estimate"));
        let bound = f64::from(bound);
        assert!(error <= 1.25 * bound, "{error} of {bound}");
        assert!(error / 1.5 <= estimate && estimate <= 1.5 * error.max(1.25 * bound), "{estimate} of {error}");
        assert!(frame.stats.rays.shadow >= rays);
        rays = frame.stats.rays.shadow;
    }
}

/// Three lights: the honest answer is to trace them, and the picture is that of the standard tracer.
#[test]
fn few_lights_are_traced() {
    let scene = Scene::new(room()).expect("scene");
    let options = options(Method::MESH).with(|o| o.picture.spp = 2);
    let frame = shoot(&scene, &room_camera(), &options.clone().with(|o| o.method = Method::with_error(0.05)));
    let truth = shoot(&scene, &room_camera(), &RenderOptions { method: Method::Standard, ..options });
    assert_eq!(frame.image, truth.image);
    assert_eq!(frame.stats.estimated_error, Some(0.0));
}

/// Every level of refinement brings the light of each method nearer to the truth, and its points are counted.
#[test]
fn refined_meshes_are_better() {
    let scene = hall();
    let camera = fence_camera();
    let sized = |method| {
        options(method).with(|o| {
            o.picture.width = 128;
            o.picture.height = 96;
            o.mesh.interpolation = Interpolation::Trilinear;
        })
    };
    let truth = shoot(&scene, &camera, &sized(Method::Standard)).image;
    for (method, at_most) in [(Method::MESH, 0.9), (Method::PAPER, 0.95), (Method::unbiased(2), 0.95)] {
        let mut last = f64::INFINITY;
        for levels in 0..=2 {
            let options = sized(method).with(|o| o.mesh.refine = Some(levels));
            let frame = shoot(&scene, &camera, &options);
            let error = relrmse(&frame.image, &truth);
            assert!(error < at_most * last, "{method:?}, {levels}: {error} after {last}");
            assert_eq!(frame.stats.direct.points_refined > 0, levels > 0);
            last = error;
        }
    }
}

/// Where memory is short the worst cells win and the rest stays coarse.
#[test]
fn refinement_keeps_to_the_memory_limit() {
    let scene = hall();
    let camera = fence_camera();
    let options = options(Method::MESH).with(|o| o.mesh.refine = Some(3));
    let all = shoot(&scene, &camera, &options);
    // A point takes 192 B of values and some 50 B besides.
    let max_memory = scene.bytes() + 2 * (all.stats.direct.bytes - 150 * all.stats.direct.points_refined);
    let some = shoot(&scene, &camera, &options.with(|o| o.limits.max_memory = max_memory));
    let [all, some] = [all, some].map(|frame| frame.stats.direct.points_refined);
    assert!(0 < some && some < all, "{some} of {all}");
}

/// The second frame of a mesh is the first frame's picture, whatever camera came between, for everything that depends
/// on a pilot.
#[test]
fn what_came_before_does_not_matter() {
    let scene = hall();
    let elsewhere = Camera::look_at(Vec3::new(-1.5, 2.5, -1.5), Vec3::new(0.0, 0.5, 0.5), 1.0);
    let with = |method, refine| {
        options(method).with(|o| {
            o.mesh.refine = refine;
            o.transport.bounces = 1;
            o.picture.spp = 2;
        })
    };
    for options in [
        with(Method::Hybrid, None),
        with(Method::Hybrid, Some(1)),
        with(Method::UNBIASED, None),
        with(Method::UNBIASED, Some(1)),
        with(Method::MESH, Some(2)),
        with(Method::with_error(0.05), None),
    ] {
        let options = options.with(|o| o.mesh.gather_rays = Some(32));
        let first = shoot(&scene, &room_camera(), &options).image;
        let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
        render(&scene, &elsewhere, &options, &mut mesh, &()).expect("frame");
        let second = render(&scene, &room_camera(), &options, &mut mesh, &()).expect("frame").image;
        assert_eq!(first, second, "{options:?}");
    }
}

#[test]
fn options_that_do_not_go_together_are_refused() {
    let refused = |options: RenderOptions, word: &str| match options.validate() {
        Err(Error::InvalidOption { option, .. }) => assert_eq!(option, word),
        other => panic!("{other:?}"),
    };
    refused(options(Method::MESH).with(|o| o.method = Method::with_error(0.0)), "error");
    refused(options(Method::UNBIASED).with(|o| o.method = Method::unbiased(0)), "rays");
    refused(options(Method::MESH).with(|o| o.mesh.refine = Some(5)), "refine");
    refused(options(Method::Standard).with(|o| o.mesh.refine = Some(1)), "refine");
    refused(options(Method::PAPER).with(|o| o.mesh.refine = Some(1)), "interpolation");
    let sphere = Interpolation::Sphere { radius: 1.5 };
    refused(options(Method::Hybrid).with(|o| o.mesh.interpolation = sphere), "interpolation");
    refused(
        options(Method::MESH).with(|o| {
            o.mesh.interpolation = Interpolation::Nearest;
            o.mesh.refine = Some(1);
        }),
        "interpolation",
    );
    assert!(options(Method::Hybrid).with(|o| o.mesh.spacing = Spacing::Auto).validate().is_ok());
}
