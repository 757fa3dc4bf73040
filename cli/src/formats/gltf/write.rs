//! A glTF with new UVs, as the files that it consists of.
//!
//! From `.glb` to `.glb` and from `.gltf` to `.gltf`, buffers and images stay where they are: in the container, in place as
//! base64, or in files beside. A buffer that changes is written under the name of the new file; what does not change is
//! copied where the new file lies in another folder. A `.gltf` that becomes a `.glb` takes everything in.

use super::beside;
use super::container::Container;
use super::edit::{check, with_uvs};
use super::file::GltfFile;
use super::pack::{Packed, pack};
use super::sets::{follow, free_set, other_uses};
use super::uri::{data_like, decode_percent, has_scheme, of_file};
use super::whole::take_in;
use crate::formats::error::FormatError;
use crate::formats::format::Format;
use crate::formats::target::{Files, Mapping, Target};
use serde_json::{Value, json};
use std::path::{Component, Path, PathBuf};
use std::{fs, io};

/// Why there are no files.
pub enum WriteError {
    /// The file's own parts do not fit together.
    Format(FormatError),
    /// Bytes cannot be read or put into one file.
    Io(PathBuf, io::Error),
}

/// Refuses, before any work, what [`write`] could not write.
pub fn writable(file: &GltfFile, target: &Target) -> Result<(), FormatError> {
    check(file, target.uv_set)
}

/// The files of `file` with the UVs of `mapping`.
pub fn write(file: &GltfFile, target: &Target, mapping: Mapping) -> Result<Files<'static>, WriteError> {
    check(file, target.uv_set).map_err(WriteError::Format)?;
    let moved = target.keep.then(|| free_set(&file.document));
    let mut edited = with_uvs(file, mapping.corner_uv, target.uv_set, moved).map_err(WriteError::Format)?;
    let mut warnings = other_uses(file, target.uv_set, moved);
    if edited.listed > 0 {
        warnings.push(format!("{} strips or fans are lists of triangles now, because seams split them", edited.listed));
    }
    if let Some(moved) = moved {
        follow(&mut edited.tree, target.uv_set, moved);
    }
    let packed = pack(file, edited);
    let mut out = Out { file, target, beside: Vec::new(), warnings };
    let container = match target.format {
        Format::Glb => out.binary(packed)?,
        _ => out.text(packed)?,
    };
    let bytes = if target.format == Format::Glb { container.glb() } else { container.text() };
    let bytes = bytes.map_err(|e| WriteError::Io(target.path.clone(), e))?;
    Ok(Files { beside: out.beside, warnings: out.warnings, ..Files::of(bytes) })
}

struct Out<'a> {
    file: &'a GltfFile,
    target: &'a Target,
    beside: Vec<(PathBuf, Vec<u8>)>,
    warnings: Vec<String>,
}

impl Out<'_> {
    fn binary(&mut self, packed: Packed) -> Result<Container, WriteError> {
        let old = &self.file.container;
        if !old.is_binary {
            let (tree, chunk, missing) = take_in(packed.tree, packed.buffers, &self.file.folder);
            self.warnings.extend(missing);
            return Ok(Container { tree, chunk: Some(chunk), ..Container::default() });
        }
        let Packed { mut tree, mut buffers, changed } = packed;
        let in_chunk = |tree: &Value| tree["buffers"].get(0).is_some_and(|buffer| buffer.get("uri").is_none());
        let mut chunk = None;
        if in_chunk(&tree) && !self.fallback(0) {
            chunk = Some(core::mem::take(&mut buffers[0]));
        }
        let others: Vec<usize> = (usize::from(chunk.is_some())..buffers.len()).collect();
        self.buffers(&mut tree, &buffers, changed, &others)?;
        self.images(&tree)?;
        Ok(Container { tree, chunk, others: old.others.clone(), ..Container::default() })
    }

    fn text(&mut self, packed: Packed) -> Result<Container, WriteError> {
        let Packed { mut tree, buffers, changed } = packed;
        let all: Vec<usize> = (0..buffers.len()).collect();
        self.buffers(&mut tree, &buffers, changed, &all)?;
        self.images(&tree)?;
        let old = &self.file.container;
        let indent = if old.is_binary { Some("  ".into()) } else { old.indent.clone() };
        Ok(Container { tree, indent, ..Container::default() })
    }

    fn fallback(&self, buffer: usize) -> bool {
        self.file.document.buffers.get(buffer).is_some_and(|buffer| buffer.is_fallback())
    }

    /// Puts buffers where they were, or beside the new file.
    fn buffers(
        &mut self,
        tree: &mut Value,
        buffers: &[Vec<u8>],
        changed: usize,
        which: &[usize],
    ) -> Result<(), WriteError> {
        let mut written = 0;
        for b in which.iter().copied() {
            if self.fallback(b) {
                continue;
            }
            let uri = tree["buffers"][b]["uri"].as_str().map(String::from);
            match &uri {
                Some(uri) if uri.starts_with("data:") => {
                    if b == changed {
                        tree["buffers"][b]["uri"] = json!(data_like(uri, &buffers[b]));
                    }
                }
                Some(uri) if b != changed => self.copied(uri)?,
                _ => {
                    let name = self.target.sibling(written, "bin");
                    written += 1;
                    tree["buffers"][b]["uri"] = json!(of_file(&name));
                    self.beside.push((self.target.folder().join(name), buffers[b].clone()));
                }
            }
        }
        Ok(())
    }

    /// Takes images in files along into another folder.
    fn images(&mut self, tree: &Value) -> Result<(), WriteError> {
        let images = tree.get("images").and_then(Value::as_array).into_iter().flatten();
        let uris = images.filter_map(|image| image.get("uri")?.as_str()).filter(|uri| !has_scheme(uri));
        for uri in uris.map(String::from).collect::<Vec<_>>() {
            self.copied(&uri)?;
        }
        Ok(())
    }

    /// Copies a file that a URI names to the same place seen from the new file.
    fn copied(&mut self, uri: &str) -> Result<(), WriteError> {
        let name = decode_percent(uri);
        if self.target.is_stream() && !has_scheme(uri) {
            self.warnings.push(format!("{uri} is named by it and not written; put it where the stream goes"));
            return Ok(());
        }
        let whole =
            |folder: &Path| fs::canonicalize(if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
        let (from, to) = (self.file.folder.join(&name), self.target.folder().join(&name));
        if has_scheme(uri)
            || matches!((whole(&self.file.folder), whole(self.target.folder())), (Ok(a), Ok(b)) if a == b)
        {
            return Ok(());
        }
        let inside = Path::new(&name).components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
        if !inside {
            self.warnings.push(format!("{uri} lies outside of the file's folder and is not copied; put it there"));
            return Ok(());
        }
        match (beside::read(&from), beside::read(&to)) {
            (Err(e), _) => self.warnings.push(format!("{} cannot be read ({e}) and is not copied", from.display())),
            (Ok(bytes), Ok(there)) if bytes == there => {}
            (Ok(_), Ok(_)) => {
                let error = io::Error::other(format!("another file than {} lies there", from.display()));
                return Err(WriteError::Io(to, error));
            }
            (Ok(bytes), Err(_)) => self.beside.push((to, bytes)),
        }
        Ok(())
    }
}
