//! The node hierarchy of one scene.

use std::fmt::Display;

use glam::{Affine3A, DAffine3, DMat4, DQuat, DVec3, DVec4, Vec3};

use super::context::{Context, place};
use super::json::{Document, Node};
use crate::error::{Error, one_line};
use crate::world_origin::relative;

/// Something that a node carries, with the node's place in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    /// The node.
    pub(super) node: usize,
    /// Index of the mesh, light or camera.
    pub(super) index: usize,
    /// The file's coordinates from the node's space.
    pub(super) world_from_node: DAffine3,
}

impl Placed {
    /// Where the node's origin is.
    pub(super) fn place(&self) -> DVec3 {
        self.world_from_node.translation
    }

    /// Returns where the node's origin is, relative to a scene's.
    pub(super) fn position(&self, origin: DVec3) -> Vec3 {
        relative(self.place(), origin)
    }

    /// Returns the transform to coordinates relative to a scene's origin, from a mesh that was moved by −`shift`.
    pub(super) fn shifted_to(&self, shift: DVec3, origin: DVec3) -> Affine3A {
        let mut world = self.world_from_node;
        if shift != DVec3::ZERO {
            world.translation = world.transform_point3(shift);
        }
        world.translation -= origin;
        rounded(&world)
    }
}

/// In single precision.
fn rounded(transform: &DAffine3) -> Affine3A {
    Affine3A::from_cols_array(&transform.to_cols_array().map(|value| value as f32))
}

/// The meshes, lights and cameras on the nodes of a scene, parents before children, siblings in the file's order.
#[derive(Debug, Default)]
pub(super) struct Visit {
    /// The scene that was chosen; `None` in a file without scenes.
    pub(super) scene: Option<usize>,
    pub(super) meshes: Vec<Placed>,
    pub(super) lights: Vec<Placed>,
    pub(super) cameras: Vec<Placed>,
}

/// Walks the chosen scene. A node that is reached twice, by a cycle or from two parents, is an error.
pub(super) fn visit(context: &mut Context<'_>, document: &Document) -> Result<Visit, Error> {
    // Find the roots, and pay for the lists.
    let scene = chosen_scene(context, document)?;
    let (roots, from) = roots(context, document, scene)?;
    let nodes = &document.nodes;
    // A list that grows lives up to three times: see `json::parsed_bytes`.
    let carried = nodes.iter().map(|n| [n.mesh, n.camera, light_of(n)].into_iter().flatten().count() as u64).sum();
    context.spend("nodes", carried, 3 * size_of::<Placed>() as u64)?;
    context.spend("nodes", nodes.len() as u64, 3 * size_of::<(usize, DAffine3)>() as u64 + 1)?;

    // Walk from parents to children.
    let mut visit = Visit { scene, ..Visit::default() };
    let mut reached = vec![false; nodes.len()];
    // An explicit stack, because a file may be nested as deeply as it likes. Last in is first out, so push in reverse.
    // Nodes are marked when pushed: then the stack is never longer than the list of nodes.
    let mut stack = Vec::new();
    for &root in roots.iter().rev() {
        mark(context, nodes, &mut reached, root, &from)?;
        stack.push((root, DAffine3::IDENTITY));
    }
    while let Some((index, world_from_parent)) = stack.pop() {
        let node = &nodes[index];
        let node_place = place("node", index, node.name.as_deref());

        // In double precision, so that deep hierarchies do not add up rounding errors.
        let world = world_from_parent * parent_from_node(context, index, node)?;
        if !rounded(&world).is_finite() {
            return Err(context
                .invalid(node_place, "its transform leaves the range of 32-bit floats; check its parents' scales"));
        }

        let carried =
            [(node.mesh, &mut visit.meshes), (node.camera, &mut visit.cameras), (light_of(node), &mut visit.lights)];
        for (what, list) in carried {
            list.extend(what.map(|what| Placed { node: index, index: what, world_from_node: world }));
        }
        if node.skin.is_some() && node.mesh.is_some() {
            context.warnings.add(node_place, "skins are not read: the mesh is shown in its rest pose");
        }
        for &child in node.children.iter().rev() {
            mark(context, nodes, &mut reached, child, node_place)?;
            stack.push((child, world));
        }
    }
    Ok(visit)
}

/// Returns the index of the light on a node.
fn light_of(node: &Node) -> Option<usize> {
    node.extensions.lights_punctual.as_ref().map(|light| light.light)
}

/// Notes that a node was reached, once.
fn mark(
    context: &Context<'_>,
    nodes: &[Node],
    reached: &mut [bool],
    index: usize,
    referrer: impl Display,
) -> Result<(), Error> {
    let node = context.get(nodes, "node", index, referrer)?;
    if std::mem::replace(&mut reached[index], true) {
        let what = "is reached twice: it has two parents or is part of a cycle; a node may have one parent only";
        return Err(context.invalid(place("node", index, node.name.as_deref()), what));
    }
    Ok(())
}

/// The scene that the options or the file choose; `None` in a file without scenes.
fn chosen_scene(context: &Context<'_>, document: &Document) -> Result<Option<usize>, Error> {
    match &context.options.scene {
        None if document.scenes.is_empty() => Ok(None),
        None => Ok(Some(document.scene.unwrap_or(0))),
        Some(wanted) => find_scene(context, document, wanted).map(Some),
    }
}

/// The root nodes to render and, for messages, where they are listed.
fn roots(context: &mut Context<'_>, document: &Document, scene: Option<usize>) -> Result<(Vec<usize>, String), Error> {
    let Some(index) = scene else { return Ok((parentless(context, document), "the file".to_owned())) };
    let scene = context.get(&document.scenes, "scene", index, "scene")?;
    Ok((scene.nodes.clone(), place("scene", index, scene.name.as_deref()).to_string()))
}

/// A scene by name, else by index.
fn find_scene(context: &Context<'_>, document: &Document, wanted: &str) -> Result<usize, Error> {
    let scenes = &document.scenes;
    let by_name = || scenes.iter().position(|scene| scene.name.as_deref() == Some(wanted));
    let by_index = || wanted.parse().ok().filter(|&index: &usize| index < scenes.len());
    by_name().or_else(by_index).ok_or_else(|| {
        const SHOWN: usize = 8;
        let names =
            scenes.iter().enumerate().take(SHOWN).map(|(i, s)| place("scene", i, s.name.as_deref()).to_string());
        let mut available = names.collect::<Vec<_>>().join(", ");
        match scenes.len() {
            0 => available.push_str("no scenes"),
            n if n > SHOWN => available.push_str(", …"),
            _ => {}
        }
        Error::NoSuchScene { file: one_line(context.file), scene: one_line(wanted), available: one_line(available) }
    })
}

/// Returns the nodes that no node has as a child: the roots of a file without scenes.
fn parentless(context: &mut Context<'_>, document: &Document) -> Vec<usize> {
    context.warnings.add("scenes", "the file has no scene: all its root nodes are rendered");
    let mut is_root = vec![true; document.nodes.len()];
    for &child in document.nodes.iter().flat_map(|node| &node.children) {
        if let Some(root) = is_root.get_mut(child) {
            *root = false;
        }
    }
    (0..is_root.len()).filter(|&node| is_root[node]).collect()
}

/// Returns the node's own transform: its matrix, or translation · rotation · scale.
fn parent_from_node(context: &mut Context<'_>, index: usize, node: &Node) -> Result<DAffine3, Error> {
    let node_place = place("node", index, node.name.as_deref());
    if let Some(matrix) = &node.matrix {
        let matrix = DMat4::from_cols_array(matrix);
        // Empirical: exporters that invert and multiply in f32 leave 1e-7 there; a projection has entries near 1.
        if (matrix.row(3) - DVec4::W).abs().max_element() > 1e-4 {
            return Err(
                context.invalid(node_place, "the last row of its matrix is not 0 0 0 1; projections are not allowed")
            );
        }
        return Ok(DAffine3::from_mat4(matrix));
    }

    // Compose the transform of its parts; a quaternion need not have unit length.
    let rotation = match &node.rotation {
        None => DQuat::IDENTITY,
        Some(rotation) => {
            let quaternion = DVec4::from_array(**rotation);
            match quaternion.try_normalize() {
                Some(unit) => DQuat::from_vec4(unit),
                None => {
                    context
                        .warnings
                        .add(node_place, "its rotation is no quaternion (zero length): taken as no rotation");
                    DQuat::IDENTITY
                }
            }
        }
    };
    Ok(DAffine3::from_scale_rotation_translation(
        node.scale.map_or(DVec3::ONE, |scale| DVec3::from_array(scale.map(f64::from))),
        rotation,
        node.translation.as_ref().map_or(DVec3::ZERO, |translation| DVec3::from_array(**translation)),
    ))
}
