//! Which meshes are drawn where: nodes of scenes, placed by their parents, and their instances.

use super::document::{Document, GltfNode};
use super::numbers::Numbers;
use crate::formats::error::FormatError;
use glam::{DMat3, DMat4, DQuat, DVec3};

/// A mesh at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Draw {
    /// The mesh, one that is there.
    pub mesh: usize,
    /// The node that draws it, if one does.
    pub node: Option<usize>,
    /// Where.
    pub place: DMat4,
    /// Whether the default scene draws it.
    pub is_seen: bool,
}

/// Every mesh as often as it is drawn: first what the default scene draws (the first scene where none is the default, all
/// nodes where there is none), then what other nodes draw, then meshes that nothing draws. Instances of
/// `EXT_mesh_gpu_instancing` are drawn one after another.
pub(super) fn draws(numbers: Numbers) -> Result<Vec<Draw>, FormatError> {
    let document = numbers.document;
    let mut seen = vec![false; document.nodes.len()];
    let scene = document.scene.and_then(|s| document.scenes.get(s)).or(document.scenes.first());
    let tops = roots(document);
    let first = placed(document, scene.map_or(&tops[..], |scene| &scene.nodes), &mut seen);
    let others = placed(document, &tops, &mut seen);
    let mut draws = Vec::new();
    for (nodes, is_seen) in [(first, true), (others, false)] {
        for (node, place) in nodes {
            let Some(mesh) = document.nodes[node].mesh.filter(|m| *m < document.meshes.len()) else { continue };
            for own in instances(numbers, &document.nodes[node])? {
                draws.push(Draw { mesh, node: Some(node), place: place * own, is_seen });
            }
        }
    }
    let undrawn = (0..document.meshes.len()).filter(|mesh| draws.iter().all(|draw| draw.mesh != *mesh));
    let undrawn: Vec<usize> = undrawn.collect();
    draws.extend(undrawn.into_iter().map(|mesh| Draw { mesh, node: None, place: DMat4::IDENTITY, is_seen: false }));
    Ok(draws)
}

/// Each node below `tops` that was not seen before, parents first, with its place in the world. A node that is its own
/// ancestor ends there.
fn placed(document: &Document, tops: &[usize], seen: &mut [bool]) -> Vec<(usize, DMat4)> {
    let mut stack: Vec<(usize, DMat4)> = tops.iter().rev().map(|node| (*node, DMat4::IDENTITY)).collect();
    let mut placed = Vec::new();
    while let Some((index, parent)) = stack.pop() {
        let Some(node) = document.nodes.get(index) else { continue };
        if core::mem::replace(&mut seen[index], true) {
            continue;
        }
        let place = parent * transform(node);
        stack.extend(node.children.iter().rev().map(|child| (*child, place)));
        placed.push((index, place));
    }
    placed
}

/// The nodes that are nobody's child.
fn roots(document: &Document) -> Vec<usize> {
    let mut is_child = vec![false; document.nodes.len()];
    for child in document.nodes.iter().flat_map(|node| &node.children) {
        if let Some(mark) = is_child.get_mut(*child) {
            *mark = true;
        }
    }
    (0..is_child.len()).filter(|i| !is_child[*i]).collect()
}

fn transform(node: &GltfNode) -> DMat4 {
    match node.matrix {
        Some(columns) => DMat4::from_cols_array(&columns),
        None => from_parts(
            node.translation.map_or(DVec3::ZERO, DVec3::from),
            DQuat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0])),
            node.scale.map_or(DVec3::ONE, DVec3::from),
        ),
    }
}

fn from_parts(translation: DVec3, rotation: DQuat, scale: DVec3) -> DMat4 {
    // Not normalised by glam: a quaternion of length 0 is no rotation.
    let rotation = if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
    DMat4::from_scale_rotation_translation(scale, rotation, translation)
}

/// Most instances of a node: beyond it the file is no mesh but a forest.
const MOST_INSTANCES: usize = 1 << 20;

/// Places of a node's instances, before its own; one where it has no more.
fn instances(numbers: Numbers, node: &GltfNode) -> Result<Vec<DMat4>, FormatError> {
    let Some(instancing) = &node.extensions.instancing else { return Ok(vec![DMat4::IDENTITY]) };
    let read = |name: &str, width: usize| {
        instancing.attributes.get(name).map(|index| numbers.values(*index, width)).transpose()
    };
    let (translations, rotations, scales) = (read("TRANSLATION", 3)?, read("ROTATION", 4)?, read("SCALE", 3)?);
    let counts = [(&translations, 3), (&rotations, 4), (&scales, 3)];
    let count = counts.iter().filter_map(|(list, width)| Some(list.as_ref()?.len() / width)).min();
    let Some(count) = count else { return Ok(vec![DMat4::IDENTITY]) };
    if count > MOST_INSTANCES {
        return Err(FormatError::whole(format!("{count} instances of a node; export fewer")));
    }
    let three = |list: &Option<Vec<f64>>, i: usize, other: DVec3| {
        list.as_ref().map_or(other, |list| DVec3::from_slice(&list[3 * i..]))
    };
    let one = |i: usize| {
        let rotation = rotations.as_ref().map_or(DQuat::IDENTITY, |list| DQuat::from_slice(&list[4 * i..]));
        from_parts(three(&translations, i, DVec3::ZERO), rotation, three(&scales, i, DVec3::ONE))
    };
    Ok((0..count).map(one).collect())
}

/// How large a place makes what is drawn there: the norm of its matrix without the shift, which no rotation changes.
pub(super) fn size(place: DMat4) -> f64 {
    DMat3::from_mat4(place).to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// How far a coordinate moves at the most where those before `place` each move by 1. 0 for what is beyond numbers.
pub(super) fn stretch(place: DMat4) -> f64 {
    let DMat3 { x_axis, y_axis, z_axis } = DMat3::from_mat4(place);
    let most = (x_axis.abs() + y_axis.abs() + z_axis.abs()).max_element();
    if most.is_finite() { most } else { 0.0 }
}
