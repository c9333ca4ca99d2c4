//! Textures from afar: closed forms for what a pixel sees of a pattern, with every method.

use crate::common::*;
use glam::{Mat2, Vec2, Vec3};
use lightmesh::{
    AlphaMode, Camera, Filter, ImageData, Material, Method, Projection, Scene, SceneData, Texels, Texture, TextureRef,
    UvTransform, Wrap,
};

const METHODS: [Method; 6] =
    [Method::Standard, Method::MESH, Method::PAPER, Method::Hybrid, Method::UNBIASED, Method::Path];

/// A wall of 8 × 8 m at z = 0 that shows the pattern `texel` of 64 × 64 texels, `repeats` times in each direction.
fn wall(repeats: f32, texel: impl Fn(u32, u32) -> f32) -> SceneData {
    let texels = (0..64 * 64).map(|i| {
        let value = texel(i % 64, i / 64);
        [value, value, value, 1.0]
    });
    let image = ImageData { name: String::new(), width: 64, height: 64, texels: Texels::Rgba32F(texels.collect()) };
    let wrap = Wrap::Repeat;
    let texture = Texture { image: 0, wrap_s: wrap, wrap_t: wrap, filter: Filter::Bilinear };
    let transform = UvTransform { matrix: Mat2::from_diagonal(Vec2::splat(repeats)), offset: Vec2::new(0.3, 0.1) };
    let base_color_texture = Some(TextureRef { texture: 0, uv_set: 0, transform });
    let material = Material { base_color_texture, unlit: true, ..Material::default() };
    let mut data =
        SceneData { images: vec![image], textures: vec![texture], materials: vec![material], ..SceneData::default() };
    let c = |x: f32, y: f32| Vec3::new(x, y, 0.0);
    let mut mesh = quad([c(-4.0, -4.0), c(4.0, -4.0), c(4.0, 4.0), c(-4.0, 4.0)], 0);
    mesh.uvs[0] = vec![Vec2::new(0.0, 1.0), Vec2::ONE, Vec2::new(1.0, 0.0), Vec2::ZERO];
    place(&mut data, mesh);
    data
}

fn frontal(distance: f32) -> Camera {
    Camera::look_at(Vec3::new(0.1, 0.2, distance), Vec3::new(0.1, 0.2, 0.0), 0.5)
}

/// Black and white texels, hundreds to a pixel: every pixel is grey, with one sample and with four. Pinhole and
/// parallel rays.
#[test]
fn a_checkerboard_far_away_is_grey() {
    let scene = Scene::new(wall(40.0, |x, y| ((x + y) % 2) as f32)).expect("scene");
    let parallel = Camera { projection: Projection::Orthographic { xmag: 3.0, ymag: 2.0 }, ..frontal(10.0) };
    for camera in [frontal(8.0), parallel] {
        for method in METHODS {
            for spp in [1, 4] {
                let image = shoot(&scene, &camera, &options(method).with(|o| o.picture.spp = spp)).image;
                for pixel in &image.pixels {
                    assert!((pixel.x - 0.5).abs() < 1e-3, "{method:?}, {spp} samples: {}", pixel.x);
                }
            }
        }
    }
}

/// Root of the mean squared difference over the mean, and difference of the means over it.
fn error(image: &[Vec3], truth: &[Vec3]) -> (f32, f32) {
    let n = truth.len() as f32;
    let mean = truth.iter().map(|p| p.x).sum::<f32>() / n;
    let squares = image.iter().zip(truth).map(|(a, b)| (a.x - b.x) * (a.x - b.x)).sum::<f32>() / n;
    (squares.sqrt() / mean, image.iter().zip(truth).map(|(a, b)| a.x - b.x).sum::<f32>() / (n * mean))
}

/// Stripes of three pixels, frontal, slanted by perspective, and seen at a grazing angle along and across: the limit is
/// that of point samples (textures of MASK materials are looked up at points), of which 1024 are the truth. Where
/// stripes are narrower than a pixel, four samples have much less error than four point samples; where they are not,
/// little error: a lookup is a little wider than a box. Empirical: 0.059 (of points 0.023), 0.087 (0.041), 0.083
/// (0.184) and 0.088 (0.288) were found.
#[test]
fn four_samples_are_near_the_limit() {
    let along = Camera::look_at(Vec3::new(0.0, -6.0, 0.5), Vec3::ZERO, 0.5);
    let across = Camera::look_at(Vec3::new(-6.0, 0.0, 0.5), Vec3::ZERO, 0.5);
    let slanted = Camera::look_at(Vec3::new(4.0, 1.0, 6.0), Vec3::ZERO, 0.5);
    let filtered = wall(8.0, |x, _| (x / 16 % 2) as f32);
    let mut points = filtered.clone();
    points.materials[0].alpha_mode = AlphaMode::Mask { cutoff: 0.0 };
    let [filtered, points] = [filtered, points].map(|data| Scene::new(data).expect("scene"));
    for (camera, most, part) in [
        (frontal(7.37), 0.065, f32::INFINITY),
        (slanted, 0.095, f32::INFINITY),
        (along, 0.09, 0.55),
        (across, 0.095, 0.35),
    ] {
        let at =
            |scene, spp| shoot(scene, &camera, &options(Method::Standard).with(|o| o.picture.spp = spp)).image.pixels;
        let truth = at(&points, 1024);
        let (noise, bias) = error(&at(&filtered, 4), &truth);
        let (noise_of_points, _) = error(&at(&points, 4), &truth);
        assert!(noise < most && noise < part * noise_of_points, "{noise} {noise_of_points}");
        // A grazing view has an outline that four point samples miss too.
        assert!(bias.abs() < 0.016, "{bias}");
    }
}
