//! EXT_lights_image_based.

use glam::{Quat, Vec3, Vec4};
use lightmesh::{Environment, ImageData, Texels};

use super::buffer::Buffers;
use super::context::{Context, Place, place};
use super::cube_map::{CubeMap, sample_map};
use super::image::decode_radiance;
use super::irradiance::Irradiance;
use super::json::ImageBasedLight;
use crate::error::{Error, one_line};

/// Columns of a map made of nine coefficients, which show nothing finer than 60°.
const SMOOTH_WIDTH: u32 = 64;

/// Reads the environment of the chosen scene: from the sharpest level of its cube map, else from the coefficients of
/// its irradiance. A texel of 1 with an intensity of 1 is 1 cd/m².
pub(super) fn environment(
    context: &mut Context<'_>,
    buffers: &Buffers<'_>,
    scene: Option<usize>,
) -> Result<Option<Environment>, Error> {
    // Which light, if any.
    let document = buffers.document;
    let Some((index, scene)) = scene.and_then(|index| Some((index, document.scenes.get(index)?))) else {
        return Ok(None);
    };
    let Some(reference) = &scene.extensions.lights_image_based else { return Ok(None) };
    let lights = document.extensions.lights_image_based.as_ref().map_or(&[][..], |l| &l.lights);
    let scene_place = place("scene", index, scene.name.as_deref());
    let light = context.get(lights, "image-based light", reference.light, scene_place)?;
    let light_place = place("image-based light", reference.light, light.name.as_deref());
    if !(light.intensity >= 0.0 && light.intensity.is_finite()) {
        return Err(context.invalid(light_place, format!("intensity {} is negative or not finite", light.intensity)));
    }
    if let Some(i) = light.irradiance_coefficients.iter().position(|c| !Vec3::from_array(*c).is_finite()) {
        return Err(context.invalid(light_place, format!("its irradianceCoefficients, the {}th: not finite", i + 1)));
    }

    // Its map: the cube, or what the coefficients say.
    let (width, texels) = match cube_map(context, buffers, light_place, light)? {
        Some(cube) => {
            pay(context, light_place, cube.width())?;
            (cube.width(), cube.to_latitude_longitude())
        }
        None => {
            let Ok(coefficients) = <[[f32; 3]; 9]>::try_from(&*light.irradiance_coefficients) else {
                let what = "neither its specularImages nor nine irradianceCoefficients can be read: it is left out";
                context.warnings.add(light_place, what);
                return Ok(None);
            };
            context.warnings.add(
                light_place,
                "its specularImages cannot be read: irradianceCoefficients take their place, blurred",
            );
            let irradiance = Irradiance(coefficients.map(Vec3::from_array));
            pay(context, light_place, SMOOTH_WIDTH)?;
            (SMOOTH_WIDTH, sample_map(SMOOTH_WIDTH, 1, |direction| irradiance.radiance(direction)))
        }
    };
    let name = one_line(light.name.as_deref().unwrap_or_default());
    let map = ImageData { name, width, height: width / 2, texels: Texels::Rgba32F(texels.into()) };
    Ok(Some(Environment {
        map: Some(map),
        radiance: Vec3::splat(light.intensity),
        world_from_map: rotation(context, light_place, light),
    }))
}

/// Pays for a map that is this wide, and for its copy behind a shared pointer.
fn pay(context: &mut Context<'_>, light: Place<'_>, width: u32) -> Result<(), Error> {
    context.spend(light, u64::from(width) * u64::from(width / 2), 2 * size_of::<[f32; 4]>() as u64)
}

/// The sharpest level; `None`, with a warning unless there is no level at all, where a face is missing or of another
/// shape.
fn cube_map(
    context: &mut Context<'_>,
    buffers: &Buffers<'_>,
    light_place: Place<'_>,
    light: &ImageBasedLight,
) -> Result<Option<CubeMap>, Error> {
    let Some(level) = light.specular_images.first() else { return Ok(None) };
    let Ok(indices) = <[usize; 6]>::try_from(&**level) else {
        context.warnings.add(light_place, "the first level of its specularImages has not six faces");
        return Ok(None);
    };
    let mut faces = Vec::with_capacity(6);
    for index in indices {
        let Some(face) = decode_radiance(context, buffers, index, light_place)? else { return Ok(None) };
        faces.push(face);
    }
    let cube = <[_; 6]>::try_from(faces).ok().and_then(CubeMap::new);
    if cube.is_none() {
        context.warnings.add(light_place, "its specularImages are not squares of one size");
    }
    Ok(cube)
}

/// Turns the map's directions into the world's: "the rotation of the IBL environment".
fn rotation(context: &mut Context<'_>, light_place: Place<'_>, light: &ImageBasedLight) -> Quat {
    let quaternion = light.rotation.map_or(Vec4::W, Vec4::from_array);
    match quaternion.try_normalize() {
        Some(unit) => Quat::from_vec4(unit),
        None => {
            context.warnings.add(light_place, "its rotation is no quaternion (zero length): taken as no rotation");
            Quat::IDENTITY
        }
    }
}
