//! The numbers of accessors, with every bound checked: dense and sparse, of every type, normalised where they say so.

use super::buffers::Buffers;
use super::document::{Accessor, Document, Sparse};
use crate::formats::error::FormatError;
use crate::mesh::precision::of_floats;

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ComponentType {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

/// An accessor's place in its view, checked.
pub(super) struct Layout<'a> {
    pub kind: ComponentType,
    /// Numbers an item.
    pub width: usize,
    /// Bytes of an item, and from one to the next.
    pub size: usize,
    /// See `size`.
    pub stride: usize,
    /// First byte in `bytes`.
    pub start: usize,
    /// Those of the view; `None` where it has none and every item is zero.
    pub bytes: Option<&'a [u8]>,
}

/// Reads the numbers of a document.
#[derive(Clone, Copy)]
pub(super) struct Numbers<'a> {
    pub document: &'a Document,
    pub buffers: &'a Buffers,
}

impl<'a> Numbers<'a> {
    fn accessor(&self, index: usize) -> Result<&'a Accessor, FormatError> {
        self.document.accessors.get(index).ok_or_else(|| {
            FormatError::whole(format!(
                "accessor {index} is missing, there are {}; export it again",
                self.document.accessors.len()
            ))
        })
    }

    /// Number of items.
    pub fn count(&self, index: usize) -> Result<usize, FormatError> {
        self.accessor(index).map(|a| a.count)
    }

    /// Where the items lie, and that they lie there.
    pub fn layout(&self, index: usize) -> Result<Layout<'a>, FormatError> {
        let accessor = self.accessor(index)?;
        let wrong = |problem: String| FormatError::whole(format!("accessor {index} {problem}; export it again"));
        let kind = ComponentType::of(accessor.component_type)
            .ok_or_else(|| wrong(format!("has numbers of unknown type {}", accessor.component_type)))?;
        let width = width(&accessor.shape).ok_or_else(|| wrong(format!("is of unknown type {}", accessor.shape)))?;
        let size = size(&accessor.shape, kind).unwrap_or(0);
        let Some(view) = accessor.buffer_view else {
            return Ok(Layout { kind, width, size, stride: size, start: 0, bytes: None });
        };
        let bytes = self.buffers.view(self.document, view).ok_or_else(|| {
            wrong(format!("lies in buffer view {view}, which is missing or reaches beyond its buffer"))
        })?;
        let stride = self.document.buffer_views[view].byte_stride.unwrap_or(size).max(1);
        let last = accessor.count.checked_sub(1).map_or(Some(0), |n| n.checked_mul(stride)?.checked_add(size));
        let fits = last.and_then(|end| end.checked_add(accessor.byte_offset)).is_some_and(|end| end <= bytes.len());
        if !fits {
            let (count, given) = (accessor.count, bytes.len());
            return Err(wrong(format!("of {count} items does not fit the {given} bytes of its buffer view {view}")));
        }
        Ok(Layout { kind, width, size, stride, start: accessor.byte_offset, bytes: Some(bytes) })
    }

    /// All numbers of accessor `index`, `width` an item, normalised where it says so.
    pub fn values(&self, index: usize, width: usize) -> Result<Vec<f64>, FormatError> {
        let accessor = self.accessor(index)?;
        let layout = self.layout(index)?;
        if layout.width != width || accessor.shape.starts_with("MAT") {
            let text = format!("accessor {index} is {}, but {width} numbers an item are needed", accessor.shape);
            return Err(FormatError::whole(text + "; export it again"));
        }
        let mut values = match layout.bytes {
            Some(bytes) => items(layout.kind, width, layout.stride, &bytes[layout.start..], accessor.count),
            // What is zero throughout takes no bytes in the file; no mesh is.
            None if accessor.count <= self.buffers.bytes.iter().map(Vec::len).sum() => {
                vec![0.0; accessor.count * width]
            }
            None => {
                let text = format!("accessor {index} of {} items has no buffer view", accessor.count);
                return Err(FormatError::whole(text + "; export it again, without compression that is not read"));
            }
        };
        if let Some(sparse) = &accessor.sparse {
            self.fill(&mut values, sparse, index, &layout)?;
        }
        if accessor.normalized && layout.kind != ComponentType::F32 {
            let largest = layout.kind.largest();
            values.iter_mut().for_each(|x| *x = (*x / largest).max(-1.0)); // the lowest signed number is -1 too
        }
        Ok(values)
    }

    /// Puts the items that a sparse accessor has of its own in their places.
    fn fill(&self, values: &mut [f64], sparse: &Sparse, index: usize, layout: &Layout) -> Result<(), FormatError> {
        let (places, bytes) = self.sparse(sparse, index)?;
        let own = items(layout.kind, layout.width, layout.size, bytes, places.len());
        for (place, item) in places.iter().zip(own.chunks_exact(layout.width)) {
            let at = layout.width * *place as usize;
            values.get_mut(at..at + layout.width).ok_or_else(|| wrong_sparse(index))?.copy_from_slice(item);
        }
        Ok(())
    }

    /// Places and bytes of the items that a sparse accessor has of its own.
    pub fn sparse(&self, sparse: &Sparse, index: usize) -> Result<(Vec<u32>, &'a [u8]), FormatError> {
        let found = || {
            let kind = ComponentType::of(sparse.indices.component_type)?;
            let bytes = self.buffers.view(self.document, sparse.indices.buffer_view)?;
            let bytes = bytes.get(sparse.indices.byte_offset..)?;
            if sparse.count.checked_mul(kind.size())? > bytes.len() {
                return None;
            }
            let places = items(kind, 1, kind.size(), bytes, sparse.count).into_iter().map(|x| x as u32).collect();
            let own = self.buffers.view(self.document, sparse.values.buffer_view)?.get(sparse.values.byte_offset..)?;
            let accessor = self.document.accessors.get(index)?;
            let size = size(&accessor.shape, ComponentType::of(accessor.component_type)?)?;
            Some((places, own.get(..sparse.count.checked_mul(size)?)?))
        };
        found().ok_or_else(|| wrong_sparse(index))
    }

    /// How far numbers of accessor `index` may be from what they stand for, the largest of which is `largest`: half a step of
    /// whole numbers, half a last bit of floats.
    pub fn precision(&self, index: usize, largest: f64) -> f64 {
        let accessor = self.document.accessors.get(index);
        match accessor.and_then(|a| Some((ComponentType::of(a.component_type)?, a.normalized))) {
            None | Some((ComponentType::F32, _)) => of_floats(largest),
            Some((kind, true)) => 0.5 / kind.largest(),
            Some((_, false)) => 0.5,
        }
    }
}

fn wrong_sparse(index: usize) -> FormatError {
    FormatError::whole(format!("sparse accessor {index} names items or bytes that are not there; export it again"))
}

/// Numbers of an item of this type.
fn width(shape: &str) -> Option<usize> {
    Some(match shape {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" | "MAT2" => 4,
        "MAT3" => 9,
        "MAT4" => 16,
        _ => return None,
    })
}

/// Bytes of an item: each column of a matrix begins at a multiple of four.
fn size(shape: &str, kind: ComponentType) -> Option<usize> {
    let columns = match shape {
        "MAT2" => 2,
        "MAT3" => 3,
        "MAT4" => 4,
        _ => return Some(width(shape)? * kind.size()),
    };
    Some(columns * (columns * kind.size()).next_multiple_of(4))
}

/// `count` items of `width` numbers, `stride` bytes apart; all lie in `bytes`.
fn items(kind: ComponentType, width: usize, stride: usize, bytes: &[u8], count: usize) -> Vec<f64> {
    let size = width * kind.size();
    let item = |i: usize| bytes[i * stride..i * stride + size].chunks_exact(kind.size());
    (0..count).flat_map(item).map(|word| kind.number(word)).collect()
}

impl ComponentType {
    pub fn of(code: u32) -> Option<Self> {
        Some(match code {
            5120 => ComponentType::I8,
            5121 => ComponentType::U8,
            5122 => ComponentType::I16,
            5123 => ComponentType::U16,
            5125 => ComponentType::U32,
            5126 => ComponentType::F32,
            _ => return None,
        })
    }

    pub fn size(self) -> usize {
        match self {
            ComponentType::I8 | ComponentType::U8 => 1,
            ComponentType::I16 | ComponentType::U16 => 2,
            ComponentType::U32 | ComponentType::F32 => 4,
        }
    }

    /// What a normalised 1 is stored as.
    fn largest(self) -> f64 {
        match self {
            ComponentType::I8 => f64::from(i8::MAX),
            ComponentType::U8 => f64::from(u8::MAX),
            ComponentType::I16 => f64::from(i16::MAX),
            ComponentType::U16 => f64::from(u16::MAX),
            ComponentType::U32 => f64::from(u32::MAX),
            ComponentType::F32 => 1.0,
        }
    }

    fn number(self, word: &[u8]) -> f64 {
        let mut all = [0; 4]; // little endian, zero-extended
        all[..word.len()].copy_from_slice(word);
        let bits = u32::from_le_bytes(all);
        match self {
            ComponentType::I8 => f64::from(bits as i8),
            ComponentType::I16 => f64::from(bits as i16),
            ComponentType::U8 | ComponentType::U16 | ComponentType::U32 => f64::from(bits),
            ComponentType::F32 => f64::from(f32::from_bits(bits)),
        }
    }
}
