//! Punctual lights and the environment.

use glam::Vec3;

use super::images::{BRIGHTEST, check_texel_count};
use super::invalid;
use super::surfaces::{FARTHEST, is_within_reach};
use crate::Error;
use crate::scene::environment::Environment;
use crate::scene::light::Light;
use crate::scene::texture::Texels;

/// The largest intensity of a punctual light, cd or lux: the sun has 3·10²⁷ cd.
const MOST_INTENSE: f32 = 1e30;

pub(super) fn check_light(index: usize, light: &Light) -> Result<(), Error> {
    let object = || format!("light {index}");
    let color = light.color();
    if !(color.is_finite() && color.min_element() >= 0.0) {
        return invalid(object(), format!("intensity {color} is negative or not finite"));
    }
    if color.max_element() > MOST_INTENSE {
        return invalid(object(), format!("intensity {color} is above {MOST_INTENSE:e}"));
    }
    // Check position, direction, range and cone.
    let (position, direction, range) = match *light {
        Light::Point { position, range, .. } => (position, Vec3::X, range),
        Light::Spot { position, direction, range, .. } => (position, direction, range),
        Light::Directional { direction, .. } => (Vec3::ZERO, direction, None),
    };
    let unit = (direction.length() - 1.0).abs() < 1e-3;
    if !position.is_finite() || !unit {
        return invalid(object(), "its position is not finite or its direction is not of unit length");
    }
    if !is_within_reach(position, position) {
        return invalid(object(), format!("its position {position} is beyond {FARTHEST:e} m"));
    }
    if range.is_some_and(|r| r.is_nan() || r <= 0.0) {
        return invalid(object(), "its range must be above 0");
    }
    if let Light::Spot { inner_cone_angle, outer_cone_angle, .. } = *light
        && !(inner_cone_angle >= 0.0
            && inner_cone_angle < outer_cone_angle
            && outer_cone_angle <= std::f32::consts::FRAC_PI_2 + 1e-4)
    {
        let what =
            format!("cone angles {inner_cone_angle} and {outer_cone_angle} must satisfy 0 ≤ inner < outer ≤ π/2");
        return invalid(object(), what);
    }
    Ok(())
}

pub(super) fn check_environment(environment: &Environment) -> Result<(), Error> {
    let object = || "environment".to_owned();
    let Environment { map, radiance, world_from_map } = environment;
    if !(radiance.min_element() >= 0.0 && radiance.max_element() <= BRIGHTEST) {
        return invalid(
            object(),
            format!("its radiance {:?} is negative, not finite or above {BRIGHTEST:e} cd/m²", radiance.to_array()),
        );
    }
    // Check the rotation, then the map's texels.
    let is_rotation = (world_from_map.length_squared() - 1.0).abs() < 1e-3;
    if !is_rotation {
        return invalid(object(), "its rotation is not a quaternion of unit length");
    }
    let Some(map) = map else { return Ok(()) };
    check_texel_count(map, object)?;
    if let Texels::Rgba32F(texels) = &map.texels {
        let fits = |&c: &f32| (0.0..=BRIGHTEST).contains(&c) && c * radiance.max_element() <= BRIGHTEST;
        if let Some(i) = texels.iter().position(|texel| !texel[..3].iter().all(fits)) {
            let (column, row, texel) = (i % map.width as usize, i / map.width as usize, texels[i]);
            let what = format!(
                "texel ({column}, {row}) of its map, {:?}, is negative, not finite or above {BRIGHTEST:e} cd/m²",
                &texel[..3]
            );
            return invalid(object(), what);
        }
    }
    Ok(())
}
