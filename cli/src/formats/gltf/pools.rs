//! Primitives that share their vertices: what several primitives share stays shared, and is split once for all of them.

use super::document::{Document, Primitive, texcoord};
use super::file::GltfFile;
use super::surface::{TRIANGLES, is_surface};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Primitives of triangles with the same attributes and morph targets, but for the set of UVs that is written.
#[derive(Debug, Default)]
pub(super) struct VertexPool {
    /// Mesh and primitive of each.
    pub primitives: Vec<[usize; 2]>,
    /// The surface of each.
    pub surfaces: Vec<usize>,
    /// Accessors of all attributes and targets but that set, each once.
    pub accessors: Vec<usize>,
    /// The positions among them.
    pub positions: usize,
}

/// What an accessor is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    /// An attribute or a part of a morph target of this mesh and primitive.
    Vertices([usize; 2]),
    /// Its UVs of the set that is written.
    Uv([usize; 2]),
    /// Its indices.
    Indices([usize; 2]),
    /// Skins, animations, instances.
    Other,
}

/// The pools of a file. With `keep`, the old UVs of the set are an attribute like any other.
pub(super) fn pools(file: &GltfFile, set: u32, keep: bool) -> Vec<VertexPool> {
    let mut surface_of = HashMap::new();
    for (s, surface) in file.surfaces.iter().enumerate() {
        surface_of.extend(surface.users.iter().map(|user| (*user, s)));
    }
    let own = texcoord(set);
    let mut pools: Vec<VertexPool> = Vec::new();
    let mut pool_of: BTreeMap<Vec<(&str, usize)>, usize> = BTreeMap::new();
    for (at, primitive) in primitives(&file.document) {
        let Some(surface) = surface_of.get(&at).copied() else { continue };
        let attributes = primitive.attributes.iter().filter(|(name, _)| keep || **name != own);
        let all = attributes.chain(primitive.targets.iter().flatten());
        let key: Vec<(&str, usize)> = all.map(|(name, index)| (name.as_str(), *index)).collect();
        let place = *pool_of.entry(key).or_insert_with_key(|key| {
            let accessors: BTreeSet<usize> = key.iter().map(|(_, index)| *index).collect();
            let positions = primitive.attributes.get("POSITION").copied().unwrap_or(0);
            pools.push(VertexPool { accessors: accessors.into_iter().collect(), positions, ..VertexPool::default() });
            pools.len() - 1
        });
        pools[place].primitives.push(at);
        pools[place].surfaces.push(surface);
    }
    pools
}

/// Every primitive with its mesh and its number there.
pub(super) fn primitives(document: &Document) -> impl Iterator<Item = ([usize; 2], &Primitive)> {
    let meshes = document.meshes.iter().enumerate();
    meshes.flat_map(|(m, mesh)| mesh.primitives.iter().enumerate().map(move |(p, primitive)| ([m, p], primitive)))
}

/// What each accessor is used for. Of extensions only what this reader knows is seen.
pub(super) fn uses(document: &Document, set: u32, keep: bool) -> HashMap<usize, Vec<Use>> {
    let own = texcoord(set);
    let mut uses: HashMap<usize, Vec<Use>> = HashMap::new();
    let mut note = |index: usize, what: Use| uses.entry(index).or_default().push(what);
    for (at, primitive) in primitives(document) {
        // Points and lines keep their vertices as they are, and so does whoever shares an accessor with them.
        let is_split = is_surface(primitive.mode.unwrap_or(TRIANGLES));
        for (name, index) in &primitive.attributes {
            let what = if *name == own && !keep { Use::Uv(at) } else { Use::Vertices(at) };
            note(*index, if is_split { what } else { Use::Other });
        }
        for index in primitive.targets.iter().flat_map(BTreeMap::values) {
            note(*index, if is_split { Use::Vertices(at) } else { Use::Other });
        }
        if let Some(index) = primitive.indices {
            note(index, if is_split { Use::Indices(at) } else { Use::Other });
        }
    }
    let number = |value: &serde_json::Value| value.as_u64().and_then(|n| usize::try_from(n).ok());
    for skin in &document.skins {
        number(&skin["inverseBindMatrices"]).into_iter().for_each(|index| note(index, Use::Other));
    }
    for sampler in document.animations.iter().filter_map(|a| a["samplers"].as_array()).flatten() {
        [&sampler["input"], &sampler["output"]]
            .into_iter()
            .filter_map(number)
            .for_each(|index| note(index, Use::Other));
    }
    let instancing = document.nodes.iter().filter_map(|node| node.extensions.instancing.as_ref());
    instancing.flat_map(|i| i.attributes.values()).for_each(|index| note(*index, Use::Other));
    uses
}
