//! An environment map as a file, and a scene that it lights.

use glam::{Quat, Vec3};
use lightmesh::{Environment, Texels};
use lightmesh_io::EnvironmentMap;

use super::{MEMORY, outcome, scratch};
use crate::exercise::{Depth, exercise};
use crate::memory::within;
use crate::seeds::scene_bytes;

pub(crate) fn run(input: &[u8], depth: Depth) -> String {
    let name = if input.starts_with(b"#?") { "input.hdr" } else { "input.exr" };
    let path = scratch::write(name, input);
    match within(MEMORY, || lightmesh_io::read_environment(&path, MEMORY)) {
        Err(error) => outcome::of_error(name, &error),
        Ok(EnvironmentMap { map, warnings }) => {
            let Texels::Rgba32F(texels) = &map.texels else { panic!("environment maps are floats") };
            assert_eq!(texels.len() as u64, u64::from(map.width) * u64::from(map.height));
            assert!(texels.as_flattened().iter().all(|x| x.is_finite() && *x >= 0.0), "a texel is no radiance");
            let words = warnings.iter().map(|warning| outcome::without_numbers(warning)).collect::<Vec<_>>().join("; ");
            if depth >= Depth::Build {
                let mut scene = scene_bytes::small_scene();
                let environment = Environment { map: Some(map), radiance: Vec3::ONE, world_from_map: Quat::IDENTITY };
                scene.environment = Some(environment);
                exercise(scene, depth);
            }
            format!("map: {words}")
        }
    }
}
