//! The node hierarchy of one scene.

use glam::{Affine3A, DAffine3, DMat4, DQuat, DVec3, DVec4};

use super::context::{Context, place};
use super::json::{Document, Node};
use crate::error::{Error, one_line};

/// Something that a node carries, with the node's place in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    /// The node.
    pub(super) node: usize,
    /// Index of the mesh, light or camera.
    pub(super) index: usize,
    /// World space from the node's space.
    pub(super) world_from_node: Affine3A,
}

/// What the nodes of a scene carry, parents before children, siblings in the file's order.
#[derive(Debug, Default)]
pub(super) struct Visit {
    pub(super) meshes: Vec<Placed>,
    pub(super) lights: Vec<Placed>,
    pub(super) cameras: Vec<Placed>,
}

/// Walks the chosen scene. A node that is reached twice, by a cycle or from two parents, is an error.
pub(super) fn visit(context: &mut Context<'_>, document: &Document) -> Result<Visit, Error> {
    let (roots, from) = roots(context, document)?;
    let nodes = &document.nodes;
    let mut visit = Visit::default();
    let mut reached = vec![false; nodes.len()];
    // An explicit stack, because a file may be nested as deeply as it likes. Last in is first out, so push in reverse.
    let mut stack: Vec<(usize, Parent, DAffine3)> =
        roots.iter().rev().map(|&node| (node, Parent::Scene, DAffine3::IDENTITY)).collect();

    while let Some((index, parent, world_from_parent)) = stack.pop() {
        let node = match parent {
            Parent::Scene => context.get(nodes, "node", index, &from)?,
            Parent::Node(parent) => {
                context.get(nodes, "node", index, place("node", parent, nodes[parent].name.as_deref()))?
            }
        };
        let node_place = place("node", index, node.name.as_deref());
        if std::mem::replace(&mut reached[index], true) {
            let what = "is reached twice: it has two parents or is part of a cycle; a node may have one parent only";
            return Err(context.invalid(node_place, what));
        }

        // In double precision, so that deep hierarchies do not add up rounding errors.
        let world = world_from_parent * parent_from_node(context, index, node)?;
        let world_from_node = Affine3A::from_cols_array(&world.to_cols_array().map(|value| value as f32));
        if !world_from_node.is_finite() {
            return Err(context
                .invalid(node_place, "its transform leaves the range of 32-bit floats; check its parents' scales"));
        }

        let carried = [
            (node.mesh, &mut visit.meshes),
            (node.camera, &mut visit.cameras),
            (node.extensions.lights_punctual.as_ref().map(|l| l.light), &mut visit.lights),
        ];
        for (what, list) in carried {
            list.extend(what.map(|what| Placed { node: index, index: what, world_from_node }));
        }
        if node.skin.is_some() && node.mesh.is_some() {
            context.warnings.add(node_place, "skins are not read: the mesh is shown in its rest pose");
        }
        stack.extend(node.children.iter().rev().map(|&child| (child, Parent::Node(index), world)));
    }
    Ok(visit)
}

/// Where a node was reached from.
#[derive(Clone, Copy, Debug)]
enum Parent {
    Scene,
    Node(usize),
}

/// The root nodes to render and, for messages, where they are listed.
fn roots(context: &mut Context<'_>, document: &Document) -> Result<(Vec<usize>, String), Error> {
    if document.scenes.is_empty() && context.options.scene.is_none() {
        return Ok((parentless(context, document), "the file".to_owned()));
    }
    let index = match &context.options.scene {
        None => document.scene.unwrap_or(0),
        Some(wanted) => find_scene(context, document, wanted)?,
    };
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

/// The nodes that no node has as a child: what a file without scenes must mean.
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

/// The node's own transform: its matrix, or translation · rotation · scale.
fn parent_from_node(context: &mut Context<'_>, index: usize, node: &Node) -> Result<DAffine3, Error> {
    let node_place = place("node", index, node.name.as_deref());
    if let Some(matrix) = &node.matrix {
        let matrix = DMat4::from_cols_array(&matrix.map(f64::from));
        // Empirical: exporters that invert and multiply in f32 leave 1e-7 there; a projection has entries near 1.
        if (matrix.row(3) - DVec4::W).abs().max_element() > 1e-4 {
            return Err(
                context.invalid(node_place, "the last row of its matrix is not 0 0 0 1; projections are not allowed")
            );
        }
        return Ok(DAffine3::from_mat4(matrix));
    }
    let rotation = match node.rotation {
        None => DQuat::IDENTITY,
        Some(rotation) => {
            let quaternion = DVec4::from_array(rotation.map(f64::from));
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
    let vector = |value: Option<[f32; 3]>, default| value.map_or(default, |v| DVec3::from_array(v.map(f64::from)));
    Ok(DAffine3::from_scale_rotation_translation(
        vector(node.scale, DVec3::ONE),
        rotation,
        vector(node.translation, DVec3::ZERO),
    ))
}
