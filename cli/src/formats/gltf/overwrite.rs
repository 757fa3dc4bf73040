//! UVs written over the old ones: where no vertex is split and their bytes are theirs alone, a file does not grow.

use super::document::{BufferView, Document};
use super::file::GltfFile;
use super::numbers::Layout;

/// Items of two floats in a buffer, and what they become.
pub(super) struct Overwrite {
    pub buffer: usize,
    /// First byte, and bytes from one item to the next.
    pub start: usize,
    /// See `start`.
    pub stride: usize,
    pub uv: Vec<[f32; 2]>,
}

impl Overwrite {
    /// Does it.
    pub fn write(&self, bytes: &mut [u8]) {
        let items = bytes.get_mut(self.start..).unwrap_or_default().chunks_mut(self.stride);
        for (item, uv) in items.zip(&self.uv) {
            if let Some(item) = item.get_mut(..8) {
                item.copy_from_slice(uv.map(f32::to_le_bytes).as_flattened());
            }
        }
    }
}

/// The buffer that new bytes go to: the chunk of a `.glb`, else the one where the file's vertices lie.
pub(super) fn home(file: &GltfFile) -> Option<usize> {
    let document = &file.document;
    if file.container.is_binary && document.buffers.first().is_some_and(|b| b.uri.is_none() && !b.is_fallback()) {
        return Some(0);
    }
    let users = file.surfaces.iter().flat_map(|surface| &surface.users);
    let positions = users.filter_map(|[m, p]| document.meshes[*m].primitives[*p].attributes.get("POSITION"));
    let views = positions.filter_map(|index| document.buffer_views.get(document.accessors.get(*index)?.buffer_view?));
    let of_view = views.map(|view| view.extensions.meshopt.as_ref().map_or(view.buffer, |packed| packed.buffer));
    let real = |buffer: &usize| document.buffers.get(*buffer).is_some_and(|b| !b.is_fallback());
    of_view.chain(0..document.buffers.len()).find(real)
}

/// Where the UVs `uv` can be written over those of accessor `index`. `None` where these are no plain floats, lie in a buffer
/// that stays as it is, or share a byte with anything else.
pub(super) fn over(file: &GltfFile, index: usize, uv: &[[f32; 2]]) -> Option<Overwrite> {
    let document = &file.document;
    let accessor = document.accessors.get(index)?;
    let is_plain = accessor.component_type == 5126 && accessor.shape == "VEC2" && accessor.sparse.is_none();
    let own = accessor.buffer_view.filter(|_| is_plain && accessor.count == uv.len())?;
    let layout = file.numbers().layout(index).ok()?;
    let view = &document.buffer_views[own];
    if view.extensions.meshopt.is_some() || home(file) != Some(view.buffer) || layout.stride < 8 {
        return None;
    }
    let end = view.byte_offset + view.byte_length;
    let meets = |(v, other): (usize, &BufferView)| {
        let (buffer, start, length) = match &other.extensions.meshopt {
            Some(packed) => (packed.buffer, packed.byte_offset, packed.byte_length),
            None => (other.buffer, other.byte_offset, other.byte_length),
        };
        v != own && buffer == view.buffer && start < end && view.byte_offset < start.saturating_add(length)
    };
    let is_shared = document.buffer_views.iter().enumerate().any(meets);
    (!is_shared && is_alone(file, document, index, &layout, own)).then(|| Overwrite {
        buffer: view.buffer,
        start: view.byte_offset + layout.start,
        stride: layout.stride,
        uv: uv.to_vec(),
    })
}

/// Whether no other accessor has a byte of accessor `index` in its view.
fn is_alone(file: &GltfFile, document: &Document, index: usize, layout: &Layout, view: usize) -> bool {
    let numbers = file.numbers();
    let span = |l: &Layout, count: usize| l.start..l.start + (count.max(1) - 1) * l.stride + l.size;
    let own = span(layout, document.accessors[index].count);
    document.accessors.iter().enumerate().all(|(other, accessor)| {
        let is_part =
            accessor.sparse.as_ref().is_some_and(|s| s.indices.buffer_view == view || s.values.buffer_view == view);
        if is_part {
            return false;
        }
        if other == index || accessor.buffer_view != Some(view) {
            return true;
        }
        let Ok(l) = numbers.layout(other) else { return false };
        let its = span(&l, accessor.count);
        if its.start >= own.end || own.start >= its.end {
            return true;
        }
        // One in the other's gaps.
        let (a, b) = (layout.start % layout.stride, l.start % l.stride);
        let fits = a + layout.size <= layout.stride && b + l.size <= l.stride;
        l.stride == layout.stride && fits && (a + layout.size <= b || b + l.size <= a)
    })
}
