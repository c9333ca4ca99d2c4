//! KHR_lights_punctual.

use std::f32::consts::FRAC_PI_2;

use glam::{DVec3, Vec3};
use lightmesh::Light;

use super::context::{Context, Place, place};
use super::json::{self, Document};
use super::node::Placed;
use super::normals::unit;
use crate::error::Error;
use crate::load_options::Units;

/// Luminous efficacy that Blender's exporter multiplies lamps by, lm/W.
const LUMENS_PER_WATT: f32 = 683.0;

/// Reads the scene's lights in the order of their nodes, relative to its origin.
pub(super) fn lights(
    context: &mut Context<'_>,
    document: &Document,
    placed: &[Placed],
    origin: DVec3,
) -> Result<Vec<Light>, Error> {
    let descriptions = document.extensions.lights_punctual.as_ref().map_or(&[][..], |l| &l.lights);
    context.spend("lights", placed.len() as u64, size_of::<Light>() as u64)?;
    let mut lights = Vec::with_capacity(placed.len());
    for placed in placed {
        let node_place = place("node", placed.node, document.nodes[placed.node].name.as_deref());
        let description = context.get(descriptions, "light", placed.index, node_place)?;
        lights.extend(light(context, node_place, placed, description, origin)?);
    }
    Ok(lights)
}

/// Reads one light; `None` if its direction is lost in a zero scale.
fn light(
    context: &mut Context<'_>,
    node_place: Place<'_>,
    placed: &Placed,
    light: &json::Light,
    origin: DVec3,
) -> Result<Option<Light>, Error> {
    // Check its colour and intensity, and convert the unit.
    let light_place = place("light", placed.index, light.name.as_deref());
    if !(light.intensity >= 0.0 && light.intensity.is_finite()) {
        let what = format!("intensity {} is negative or not finite; check the lamp's power", light.intensity);
        return Err(context.invalid(light_place, what));
    }
    let color = Vec3::from_array(light.color);
    if !(color.is_finite() && color.min_element() >= 0.0) {
        return Err(context.invalid(light_place, format!("color {:?} is negative or not finite", light.color)));
    }
    let divisor = match context.options.units {
        Units::Gltf => 1.0,
        Units::Blender => LUMENS_PER_WATT,
    };
    let strength = color * (light.intensity / divisor);
    if !strength.is_finite() {
        return Err(context.invalid(light_place, "color times intensity leaves the range of 32-bit floats"));
    }

    // Drop a range that is not positive, or infinite.
    let range = light.range.filter(|&range| {
        let usable = range > 0.0;
        if !usable {
            context.warnings.add(light_place, "its range is not positive: taken as infinite");
        }
        usable && range.is_finite()
    });

    // A light shines along its node's −Z; scale does not change it.
    let position = placed.position(origin);
    let direction = unit(-placed.world_from_node.matrix3.z_axis.as_vec3());
    Ok(match (light.kind, direction) {
        (json::LightKind::Point, _) => Some(Light::Point { position, intensity_cd: strength, range }),
        (_, None) => {
            context.warnings.add(node_place, "its scale is zero, so its light has no direction: the light is left out");
            None
        }
        (json::LightKind::Directional, Some(direction)) => {
            Some(Light::Directional { direction, illuminance_lux: strength })
        }
        (json::LightKind::Spot, Some(direction)) => {
            let (inner_cone_angle, outer_cone_angle) = cone(context, light_place, &light.spot);
            Some(Light::Spot { position, direction, intensity_cd: strength, range, inner_cone_angle, outer_cone_angle })
        }
    })
}

/// Returns the inner and outer half angle (radians) with 0 ≤ inner < outer ≤ π/2, mended where needed.
fn cone(context: &mut Context<'_>, place: Place<'_>, spot: &json::Spot) -> (f32, f32) {
    // Empirical: under a milliradian cos inner − cos outer drowns in f32 rounding even for inner = 0 (5·10⁻⁷ against
    // 6·10⁻⁸).
    const NARROWEST: f32 = 1e-3;
    // A hard edge is a ramp over the outermost hundredth. cos(0.99 a) − cos(a) ≈ a²/100, which f32 resolves from a =
    // 0.01 on.
    const HARD_EDGE: f32 = 0.99;
    let (inner, outer) = (spot.inner_cone_angle, spot.outer_cone_angle);
    let mended_outer = if outer.is_nan() { std::f32::consts::FRAC_PI_4 } else { outer.clamp(NARROWEST, FRAC_PI_2) };
    let widest_inner = if mended_outer < 0.01 { 0.0 } else { HARD_EDGE * mended_outer };
    let mended_inner = if inner > 0.0 { inner.min(widest_inner) } else { 0.0 };
    // Equal angles are what exporters write for a hard edge: no need to speak of it.
    if mended_outer != outer || inner < 0.0 || inner > mended_outer {
        context.warnings.add(place, "its cone angles are not 0 ≤ inner < outer ≤ π/2: they are clamped");
    }
    (mended_inner, mended_outer)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::budget::Budget;
    use crate::load_options::LoadOptions;

    #[test]
    fn every_cone_has_a_ramp_that_f32_resolves() {
        let options = LoadOptions::default();
        let mut context = Context::new("f", None, &options, Budget::new(0));
        for outer in [0.0, 1e-4, 1e-3, 5e-3, 0.01, 0.1, 1.0, 1.6, f32::INFINITY] {
            for inner in [-1.0, 0.0, 0.5 * outer, outer, 2.0 * outer] {
                let spot = json::Spot { inner_cone_angle: inner, outer_cone_angle: outer };
                let (inner, outer) = cone(&mut context, place("light", 0, None), &spot);
                assert!(0.0 <= inner && inner < outer && outer <= FRAC_PI_2);
                assert!(libm::cosf(inner) > libm::cosf(outer), "{inner} {outer}");
            }
        }
    }
}
