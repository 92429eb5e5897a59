//! The node hierarchy, flattened.

use super::document::{Document, place};
use crate::SceneError;
use crate::warn::Warnings;
use ::gltf::json::Node;
use glam::{DAffine3, DMat4, DQuat, DVec3, DVec4};

/// How far the last row of a matrix may be from 0 0 0 1.
const ROUNDING: f64 = 1e-5;

/// A node of the chosen scene.
pub(super) struct Placed<'a> {
    /// Its id in the file.
    pub(super) index: usize,
    /// The node.
    pub(super) node: &'a Node,
    /// Node to world.
    pub(super) world: DAffine3,
}

/// The nodes of the file's default scene, parents before children, in the file's order.
/// The whole hierarchy is checked to be a forest, also what the scene does not use.
pub(super) fn flatten<'a>(
    document: &Document<'a>,
    warnings: &mut Warnings,
) -> Result<Vec<Placed<'a>>, SceneError> {
    let nodes = &document.root.nodes;
    let roots = roots(document)?;
    let mut stack: Vec<(usize, DAffine3)> = chosen(document, roots, warnings)?
        .into_iter()
        .rev()
        .map(|root| (root, DAffine3::IDENTITY))
        .collect();
    let mut placed = Vec::new();
    while let Some((index, parent)) = stack.pop() {
        let Some(node) = nodes.get(index) else {
            continue;
        };
        let world = parent * local(document, index, node)?;
        if !world.is_finite() {
            let place = document.node_place(index);
            return Err(document.error(place, "its transform overflows"));
        }
        placed.push(Placed { index, node, world });
        let children = node.children.iter().flatten().rev();
        stack.extend(children.map(|child| (child.value(), world)));
    }
    Ok(placed)
}

/// Nodes without a parent, after a check that every node hangs under one of them, once.
fn roots(document: &Document) -> Result<Vec<usize>, SceneError> {
    let nodes = &document.root.nodes;
    let mut parent_of = vec![None; nodes.len()];
    for (parent, node) in nodes.iter().enumerate() {
        for child in node.children.iter().flatten() {
            let child = child.value();
            let slot = parent_of.get_mut(child);
            if let Some(other) = slot.and_then(|slot| slot.replace(parent)) {
                let message = format!(
                    "child of {} and of {}: nodes must form trees",
                    document.node_place(other),
                    document.node_place(parent)
                );
                return Err(document.error(document.node_place(child), message));
            }
        }
    }
    let is_root = |&index: &usize| parent_of.get(index) == Some(&None);
    let roots: Vec<usize> = (0..nodes.len()).filter(is_root).collect();
    // With one parent at most each, what no root reaches goes round in a circle.
    let mut is_reached = vec![false; nodes.len()];
    let mut stack = roots.clone();
    while let Some(index) = stack.pop() {
        if let Some(reached) = is_reached.get_mut(index) {
            *reached = true;
        }
        let children = nodes.get(index).and_then(|node| node.children.as_ref());
        stack.extend(children.into_iter().flatten().map(|child| child.value()));
    }
    match is_reached.iter().position(|&reached| !reached) {
        Some(index) => {
            let place = document.node_place(index);
            Err(document.error(place, "is its own ancestor: nodes must form trees"))
        }
        None => Ok(roots),
    }
}

/// The roots of the scene to read: the default one, else the first, else all.
fn chosen(
    document: &Document,
    roots: Vec<usize>,
    warnings: &mut Warnings,
) -> Result<Vec<usize>, SceneError> {
    let root = document.root;
    let index = root.scene.map_or(0, |scene| scene.value());
    let Some(scene) = root.scenes.get(index) else {
        warnings.add("scenes", "the file has no scene: all its nodes are read");
        return Ok(roots);
    };
    let place = place("scene", index, scene.name.as_deref());
    if root.scenes.len() > 1 {
        let message = format!(
            "one of {} scenes; the others are left out",
            root.scenes.len()
        );
        warnings.add(place.clone(), message);
    }
    let mut is_listed = vec![false; root.nodes.len()];
    for node in scene.nodes.iter().map(|node| node.value()) {
        let listed = is_listed.get_mut(node);
        let before = listed.is_none_or(|listed| std::mem::replace(listed, true));
        if before || roots.binary_search(&node).is_err() {
            let message = format!(
                "{} is listed twice or has a parent: a scene lists root nodes, once each",
                document.node_place(node)
            );
            return Err(document.error(place, message));
        }
    }
    Ok(scene.nodes.iter().map(|node| node.value()).collect())
}

/// Node to parent.
fn local(document: &Document, index: usize, node: &Node) -> Result<DAffine3, SceneError> {
    let wrong = |message: &str| document.error(document.node_place(index), message);
    if let Some(matrix) = node.matrix {
        let matrix = DMat4::from_cols_array(&matrix.map(f64::from));
        // Exporters round what they have computed: a last row of 0 0 0 1, but for a little.
        let last = matrix.row(3);
        if !matrix.is_finite() || !last.abs_diff_eq(DVec4::W, ROUNDING) {
            return Err(wrong("its matrix is not an affine transform"));
        }
        return Ok(DAffine3::from_mat4(matrix * (1.0 / last.w)));
    }
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let translation = node.translation.map_or(DVec3::ZERO, vector);
    let scale = node.scale.map_or(DVec3::ONE, vector);
    let rotation = node.rotation.unwrap_or_default().0.map(f64::from);
    let rotation = DQuat::from_array(rotation);
    // Exporters round quaternions to f32; any length but 0 has a direction.
    if !(rotation.length() > 0.0 && rotation.is_finite()) {
        return Err(wrong("its rotation is not a quaternion with a direction"));
    }
    let rotation = rotation.normalize();
    Ok(DAffine3::from_scale_rotation_translation(
        scale,
        rotation,
        translation,
    ))
}
