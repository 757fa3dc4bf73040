//! A glTF's JSON with a new set of UVs: accessors that grow or change, and the bytes that they need.
//!
//! Nothing else of the tree is touched. An accessor that only the edited primitives use keeps its number, its name and its
//! extras; one that somebody else uses too is left alone, and the primitives get one of their own. Where no vertex is split,
//! the UVs alone are new.

use super::document::{Sparse, texcoord};
use super::file::GltfFile;
use super::numbers::{ComponentType, Numbers};
use super::overwrite::{Overwrite, over};
use super::pools::{Use, VertexPool, pools, uses};
use super::records::{INDICES, Member, NewView, VERTICES, records};
use super::split::{Split, split};
use super::surface::TRIANGLES;
use crate::formats::error::FormatError;
use glam::DVec2;
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, HashMap};

/// What a file becomes.
pub(super) struct Edited {
    pub tree: Value,
    /// Views that accessors name by numbers behind those of the file.
    pub views: Vec<NewView>,
    /// UVs that are written over the old ones.
    pub over: Vec<Overwrite>,
    /// Vertices that seams added, and primitives whose strips or fans became lists.
    pub copies: usize,
    /// See `copies`.
    pub listed: usize,
}

/// Gives every surface its UVs as set number `set`, origin at the top left. `corner_uv` has one a corner of the mesh. With
/// `moved`, the UVs that the set has become that set.
pub(super) fn with_uvs(
    file: &GltfFile,
    corner_uv: &[DVec2],
    set: u32,
    moved: Option<u32>,
) -> Result<Edited, FormatError> {
    let keep = moved.is_some();
    let made = Edited { tree: file.container.tree.clone(), views: Vec::new(), over: Vec::new(), copies: 0, listed: 0 };
    let mut edit = TreeEdit { file, set, moved, uses: uses(&file.document, set, keep), made };
    for pool in pools(file, set, keep) {
        edit.pool(&pool, corner_uv)?;
    }
    Ok(edit.made)
}

/// Refuses what cannot be split: attributes that are not there for every vertex. It is known before any work.
pub(super) fn check(file: &GltfFile, set: u32) -> Result<(), FormatError> {
    let numbers = file.numbers();
    for pool in pools(file, set, false) {
        let [m, p] = pool.primitives[0];
        let count = numbers.count(pool.positions)?;
        let own = |[m, p]: &[usize; 2]| file.document.meshes[*m].primitives[*p].attributes.get(&texcoord(set));
        pool.primitives.iter().filter_map(own).try_for_each(|index| numbers.count(*index).map(drop))?;
        for index in pool.accessors {
            numbers.layout(index)?;
            if let Some(sparse) = &file.document.accessors[index].sparse {
                numbers.sparse(sparse, index)?;
            }
            let given = numbers.count(index)?;
            if given != count {
                let text =
                    format!("accessor {index} has {given} items for the {count} vertices of mesh {m}, primitive {p}");
                return Err(FormatError::whole(text + "; export it again"));
            }
        }
    }
    Ok(())
}

struct TreeEdit<'a> {
    file: &'a GltfFile,
    set: u32,
    moved: Option<u32>,
    uses: HashMap<usize, Vec<Use>>,
    made: Edited,
}

impl<'a> TreeEdit<'a> {
    fn pool(&mut self, pool: &VertexPool, corner_uv: &[DVec2]) -> Result<(), FormatError> {
        let numbers = self.file.numbers();
        let count = numbers.count(pool.positions)?;
        let mut of_surface: Vec<usize> = pool.surfaces.clone();
        of_surface.sort_unstable();
        of_surface.dedup();
        let surfaces: Vec<_> = of_surface.iter().map(|s| &self.file.surfaces[*s]).collect();
        let split = split(count, &surfaces, corner_uv);
        self.made.copies += split.copies.len();

        let old_uv = self.old_uv(pool);
        let uv = self.place_of_uv(old_uv, count + split.copies.len());
        let becomes = match split.copies.is_empty() {
            true => BTreeMap::new(),
            false => pool.accessors.iter().map(|index| (*index, self.place_of(*index, pool))).collect(),
        };
        let uv_is_written = self.vertices(numbers, &becomes, old_uv.filter(|old| *old == uv), &split, count)?;
        let over = old_uv.filter(|_| split.copies.is_empty()).and_then(|old| over(self.file, old, &split.uv));
        if let Some(over) = over {
            let accessor = &self.file.document.accessors[uv];
            self.point_at(uv, accessor.buffer_view.unwrap_or(0), accessor.byte_offset);
            self.made.over.push(over);
        } else if !uv_is_written {
            let bytes = split.uv.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
            self.point(uv, NewView { bytes, stride: None, target: VERTICES }, 0);
        }
        let mut lists = HashMap::new();
        for (at, surface) in pool.primitives.iter().zip(&pool.surfaces) {
            let s = of_surface.binary_search(surface).unwrap_or(0);
            let [m, p] = *at;
            let is_list = self.file.document.meshes[m].primitives[p].indices.is_some();
            // Without indices all vertices are drawn, and now there are more.
            let drawn = (!is_list && !split.copies.is_empty()).then(|| &self.file.surfaces[*surface].triangles);
            let indices = split.triangles[s].as_ref().or(drawn).map(|triangles| {
                let place = lists.entry(s).or_insert_with(|| self.indices(*at, *surface, pool, triangles));
                *place
            });
            self.primitive(*at, &becomes, uv, indices);
        }
        Ok(())
    }

    /// The accessor of the pool's old UVs, where all have the same and nobody else uses it.
    fn old_uv(&self, pool: &VertexPool) -> Option<usize> {
        if self.moved.is_some() {
            return None;
        }
        let of = |[m, p]: [usize; 2]| {
            let attributes = &self.file.document.meshes[m].primitives[p].attributes;
            attributes.get(&texcoord(self.set)).copied()
        };
        let old = of(pool.primitives[0])?;
        let own = |what: &Use| matches!(what, Use::Uv(at) if pool.primitives.contains(at));
        self.uses[&old].iter().all(own).then_some(old)
    }

    /// The accessor of the new UVs, without bytes yet.
    fn place_of_uv(&mut self, old: Option<usize>, count: usize) -> usize {
        let mut kept = old.map(|old| self.accessor(old).clone()).unwrap_or_default();
        for key in ["bufferView", "byteOffset", "normalized", "min", "max", "sparse"] {
            kept.shift_remove(key);
        }
        kept.insert("componentType".into(), json!(5126));
        kept.insert("count".into(), json!(count));
        kept.insert("type".into(), json!("VEC2"));
        match old {
            Some(old) => {
                *self.accessor(old) = kept;
                old
            }
            None => self.push_accessor(kept),
        }
    }

    /// The accessor that takes the place of `index`: itself, where only the pool's primitives use it as vertices.
    fn place_of(&mut self, index: usize, pool: &VertexPool) -> usize {
        let own = |what: &Use| matches!(what, Use::Vertices(at) if pool.primitives.contains(at));
        if self.uses[&index].iter().all(own) {
            return index;
        }
        let copy = self.accessor(index).clone();
        self.push_accessor(copy)
    }

    fn accessor(&mut self, index: usize) -> &mut Map<String, Value> {
        self.made.tree["accessors"][index].as_object_mut().expect("an accessor was read here")
    }

    fn push_accessor(&mut self, accessor: Map<String, Value>) -> usize {
        let all = self.made.tree["accessors"].as_array_mut().expect("accessors were read here");
        all.push(Value::Object(accessor));
        all.len() - 1
    }

    /// Writes the vertices of the accessors that have copies. Says whether the UVs were written among them: they are where
    /// they lay between others.
    fn vertices(
        &mut self,
        numbers: Numbers<'a>,
        becomes: &BTreeMap<usize, usize>,
        uv: Option<usize>,
        split: &Split,
        count: usize,
    ) -> Result<bool, FormatError> {
        let document = &self.file.document;
        let mut members = Vec::new();
        for (accessor, becomes) in becomes {
            let layout = numbers.layout(*accessor)?;
            self.accessor(*becomes).insert("count".into(), json!(count + split.copies.len()));
            if let Some(sparse) = &document.accessors[*accessor].sparse {
                self.sparse(numbers, *accessor, *becomes, sparse, split, count)?;
            }
            if let Some(view) = document.accessors[*accessor].buffer_view {
                members.push(Member { accessor: *accessor, becomes: *becomes, view, layout });
            }
        }
        let floats = |index: &usize| {
            let a = &document.accessors[*index];
            a.component_type == 5126 && a.shape == "VEC2" && a.sparse.is_none() && a.count == count
        };
        if let Some(uv) = uv.filter(|uv| floats(uv) && !becomes.is_empty())
            && let Some(view) = document.accessors[uv].buffer_view
        {
            members.push(Member { accessor: uv, becomes: uv, view, layout: numbers.layout(uv)? });
        }
        let mut is_written = false;
        for record in records(members) {
            let mut view = record.view(count, &split.copies);
            let is_alone = record.members.len() == 1;
            if let Some(member) = record.members.iter().find(|m| Some(m.accessor) == uv) {
                if is_alone {
                    continue;
                }
                let (stride, offset) = (view.stride.unwrap_or(8), record.offset(member));
                for (item, uv) in view.bytes.chunks_exact_mut(stride).zip(&split.uv) {
                    item[offset..offset + 4].copy_from_slice(&uv[0].to_le_bytes());
                    item[offset + 4..offset + 8].copy_from_slice(&uv[1].to_le_bytes());
                }
                is_written = true;
            }
            let number = self.push_view(view);
            for member in &record.members {
                self.point_at(member.becomes, number, record.offset(member));
            }
        }
        Ok(is_written)
    }

    /// The items that a sparse accessor has of its own, and those of the copies.
    fn sparse(
        &mut self,
        numbers: Numbers,
        accessor: usize,
        becomes: usize,
        sparse: &Sparse,
        split: &Split,
        count: usize,
    ) -> Result<(), FormatError> {
        let (mut places, bytes) = numbers.sparse(sparse, accessor)?;
        let size = bytes.len() / places.len().max(1);
        let mut values = bytes.to_vec();
        let item_of: HashMap<u32, usize> = places.iter().enumerate().map(|(i, place)| (*place, i)).collect();
        for (i, vertex) in split.copies.iter().enumerate() {
            if let Some(item) = item_of.get(vertex) {
                places.push((count + i) as u32);
                values.extend(&bytes[item * size..(item + 1) * size]);
            }
        }
        if places.len() == sparse.count {
            return Ok(()); // no copy has one
        }
        let wanted = places.last().copied().unwrap_or(0);
        let (code, width) = narrowest(sparse.indices.component_type, wanted, 0);
        let indices = places.iter().flat_map(|i| i.to_le_bytes().into_iter().take(width)).collect();
        let indices = self.push_view(NewView { bytes: indices, stride: None, target: 0 });
        let values = self.push_view(NewView { bytes: values, stride: None, target: 0 });
        let own = &mut self.accessor(becomes)["sparse"];
        own["count"] = json!(places.len());
        own["indices"]["bufferView"] = json!(indices);
        own["indices"]["componentType"] = json!(code);
        own["values"]["bufferView"] = json!(values);
        for part in ["indices", "values"] {
            own[part].as_object_mut().map(|part| part.shift_remove("byteOffset"));
        }
        Ok(())
    }

    /// An accessor of indices for the triangles of `surface`: the one of the primitive at `at`, where all who use it are of this
    /// pool and surface.
    fn indices(&mut self, at: [usize; 2], surface: usize, pool: &VertexPool, triangles: &[[u32; 3]]) -> usize {
        let old = self.file.document.meshes[at[0]].primitives[at[1]].indices;
        let largest = triangles.as_flattened().iter().copied().max().unwrap_or(0);
        let kind = old.map_or(5121, |old| self.file.document.accessors[old].component_type);
        // The largest number of a type is not an index, it may end a strip.
        let (code, width) = narrowest(kind, largest, 1);
        let bytes = triangles.as_flattened().iter().flat_map(|i| i.to_le_bytes().into_iter().take(width)).collect();
        let mut accessor = old.map(|old| self.accessor(old).clone()).unwrap_or_default();
        for key in ["min", "max", "sparse", "normalized"] {
            accessor.shift_remove(key);
        }
        accessor.insert("componentType".into(), json!(code));
        accessor.insert("count".into(), json!(3 * triangles.len()));
        accessor.insert("type".into(), json!("SCALAR"));
        let is_own = |what: &Use| {
            let place = |at: &[usize; 2]| pool.primitives.iter().position(|own| own == at);
            matches!(what, Use::Indices(at) if place(at).is_some_and(|i| pool.surfaces[i] == surface))
        };
        let number = match old.filter(|old| self.uses[old].iter().all(is_own)) {
            Some(old) => {
                *self.accessor(old) = accessor;
                old
            }
            None => self.push_accessor(accessor),
        };
        self.point(number, NewView { bytes, stride: None, target: INDICES }, 0);
        number
    }

    /// Makes a primitive name its accessors.
    fn primitive(&mut self, at: [usize; 2], becomes: &BTreeMap<usize, usize>, uv: usize, indices: Option<usize>) {
        let (set, moved) = (self.set, self.moved);
        let primitive = self.made.tree["meshes"][at[0]]["primitives"][at[1]].as_object_mut().expect("it was read here");
        let renumber = |map: Option<&mut Value>| {
            for index in map.and_then(Value::as_object_mut).into_iter().flat_map(Map::values_mut) {
                let old = index.as_u64().and_then(|old| usize::try_from(old).ok());
                if let Some(new) = old.and_then(|old| becomes.get(&old)) {
                    *index = json!(new);
                }
            }
        };
        renumber(primitive.get_mut("attributes"));
        let targets = primitive.get_mut("targets").and_then(Value::as_array_mut);
        targets.into_iter().flatten().for_each(|target| renumber(Some(target)));
        let attributes = primitive["attributes"].as_object_mut().expect("it was read here");
        if let (Some(moved), Some(old)) = (moved, attributes.get(&texcoord(set)).cloned()) {
            for free in 0..=moved {
                attributes.entry(texcoord(free)).or_insert_with(|| old.clone());
            }
        }
        attributes.insert(texcoord(set), json!(uv));
        // Sets are counted without gaps.
        for lower in 0..set {
            attributes.entry(texcoord(lower)).or_insert_with(|| json!(uv));
        }
        if let Some(indices) = indices {
            primitive.insert("indices".into(), json!(indices));
            let mode = primitive.get("mode").and_then(Value::as_u64).unwrap_or(u64::from(TRIANGLES));
            if mode != u64::from(TRIANGLES) {
                primitive.insert("mode".into(), json!(TRIANGLES));
                self.made.listed += 1;
            }
        }
    }

    fn push_view(&mut self, view: NewView) -> usize {
        self.made.views.push(view);
        self.file.document.buffer_views.len() + self.made.views.len() - 1
    }

    fn point(&mut self, accessor: usize, view: NewView, offset: usize) {
        let number = self.push_view(view);
        self.point_at(accessor, number, offset);
    }

    fn point_at(&mut self, accessor: usize, view: usize, offset: usize) {
        let accessor = self.accessor(accessor);
        accessor.insert("bufferView".into(), json!(view));
        match offset {
            0 => drop(accessor.shift_remove("byteOffset")),
            _ => drop(accessor.insert("byteOffset".into(), json!(offset))),
        }
    }
}

/// Code and bytes of the narrowest type of indices from `least` up that holds `largest` with so many numbers to spare.
fn narrowest(least: u32, largest: u32, spare: u32) -> (u32, usize) {
    let all =
        [(ComponentType::U8, 5121, 0xff), (ComponentType::U16, 5123, 0xffff), (ComponentType::U32, 5125, u32::MAX)];
    let fits = |(_, code, most): &&(ComponentType, u32, u32)| *code >= least && largest <= most - spare;
    let (kind, code, _) = all.iter().find(fits).unwrap_or(&all[2]);
    (*code, kind.size())
}
