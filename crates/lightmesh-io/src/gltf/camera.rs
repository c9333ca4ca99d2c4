//! Cameras.

use lightmesh::{Camera, Projection};

use super::context::{Context, Place, place};
use super::json::{self, Document};
use super::node::Placed;
use crate::error::Error;

/// The scene's cameras in the order of the file's `cameras`, those that share one in the order of their nodes. Each has its
/// node's name, or else its own.
pub(super) fn cameras(context: &mut Context<'_>, document: &Document, placed: &[Placed]) -> Result<Vec<Camera>, Error> {
    let mut order: Vec<&Placed> = placed.iter().collect();
    order.sort_by_key(|placed| (placed.index, placed.node));
    context.spend("cameras", placed.len() as u64, size_of::<Camera>() as u64)?;
    let mut cameras = Vec::with_capacity(placed.len());
    for placed in order {
        let node = &document.nodes[placed.node];
        let node_place = place("node", placed.node, node.name.as_deref());
        let camera = context.get(&document.cameras, "camera", placed.index, node_place)?;
        let projection = projection(context, place("camera", placed.index, camera.name.as_deref()), camera)?;
        let name = [&node.name, &camera.name].into_iter().flatten().find(|name| !name.is_empty());
        let name = name.cloned().unwrap_or_default();
        context.spend(node_place, name.len() as u64, 1)?;
        cameras.push(Camera { name, world_from_camera: placed.world_from_node, projection });
    }
    Ok(cameras)
}

fn projection(context: &mut Context<'_>, place: Place<'_>, camera: &json::Camera) -> Result<Projection, Error> {
    match (&camera.perspective, &camera.orthographic) {
        (Some(lens), _) => {
            if !(lens.yfov > 0.0 && lens.yfov < std::f32::consts::PI) {
                return Err(context.invalid(place, format!("yfov {} is not between 0 and π radians", lens.yfov)));
            }
            let aspect = lens.aspect_ratio.filter(|aspect| *aspect > 0.0 && aspect.is_finite());
            if aspect != lens.aspect_ratio {
                context.warnings.add(place, "its aspectRatio is not positive: ignored");
            }
            Ok(Projection::Perspective { yfov: lens.yfov, aspect })
        }
        (None, Some(lens)) => {
            let usable = |mag: f32| mag != 0.0 && mag.is_finite();
            if !(usable(lens.xmag) && usable(lens.ymag)) {
                let what = format!("xmag {} and ymag {} must be finite and not zero", lens.xmag, lens.ymag);
                return Err(context.invalid(place, what));
            }
            // A negative magnification would mirror the picture, which no viewer does.
            Ok(Projection::Orthographic { xmag: lens.xmag.abs(), ymag: lens.ymag.abs() })
        }
        (None, None) => Err(context.invalid(place, "has neither a perspective nor an orthographic lens")),
    }
}
