//! A mesh from a file, by the file's ending.

use super::error::FormatError;
use super::groups::Groups;
use super::model::Model;
use super::obj::{compose::compose, file::ObjFile, read::read, write::write};
use super::{gltf::read as gltf, ply::read as ply, stl};
use crate::base::failure::Failure;
use crate::mesh::polygons::Mesh;
use glam::DVec2;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The endings that [`load`] knows, for messages.
pub const ENDINGS: &str = ".obj, .ply, .stl, .glb and .gltf";

/// A mesh and what its file needs to be written back.
pub struct Loaded {
    /// Where it was read.
    pub path: PathBuf,
    content: Content,
}

enum Content {
    /// Written back as it was, with other UVs.
    Obj(ObjFile),
    /// Written as an OBJ of its own.
    Other(Model),
}

/// Reads the mesh at `path`.
pub fn load(path: &Path) -> Result<Loaded, Failure> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let bytes = || std::fs::read(path).map_err(|e| Failure::input(path, &e));
    let other = |result: Result<Model, FormatError>| {
        result.map(Content::Other).map_err(|e| input_error(path, e.line, &e.problem))
    };
    let content = match ending.as_str() {
        "obj" => Content::Obj(from_obj(path, bytes()?)?),
        "ply" => other(ply::read(&bytes()?))?,
        "stl" => other(stl::read(&bytes()?))?,
        "glb" | "gltf" => other(gltf::read(&bytes()?, path.parent().unwrap_or(Path::new(""))))?,
        _ => {
            let problem =
                if ending.is_empty() { "no file ending".into() } else { format!("unknown file ending .{ending}") };
            let text = format!("{}: {problem}; seamwright reads {ENDINGS}, so convert the mesh first", path.display());
            return Err(Failure::Input(text));
        }
    };
    Ok(Loaded { path: path.to_path_buf(), content })
}

/// Reads an OBJ that is in memory already; `path` is what messages name.
pub fn load_obj(path: &Path, bytes: Vec<u8>) -> Result<Loaded, Failure> {
    Ok(Loaded { path: path.to_path_buf(), content: Content::Obj(from_obj(path, bytes)?) })
}

fn from_obj(path: &Path, bytes: Vec<u8>) -> Result<ObjFile, Failure> {
    read(bytes).map_err(|e| input_error(path, e.line, &e.problem))
}

/// `file:line: problem`; line 0 is the whole file.
fn input_error(path: &Path, line: usize, problem: &dyn core::fmt::Display) -> Failure {
    let line = if line == 0 { String::new() } else { format!(":{line}") };
    Failure::Input(format!("{}{line}: {problem}", path.display()))
}

impl Loaded {
    /// The mesh and what its file says of it.
    pub fn model(&self) -> &Model {
        match &self.content {
            Content::Obj(file) => &file.model,
            Content::Other(model) => model,
        }
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.model().mesh
    }

    /// The file's name without its folder, for people.
    pub fn name(&self) -> String {
        self.path.file_name().unwrap_or(self.path.as_os_str()).to_string_lossy().into_owned()
    }

    /// What was odd in the file.
    pub fn warnings(&self) -> &[String] {
        &self.model().warnings
    }

    /// Writes the mesh as OBJ with one UV a corner, and `groups` if any: the user's own file where it was one.
    pub fn write_obj(&self, out: &mut dyn Write, corner_uv: &[DVec2], groups: Option<&Groups>) -> io::Result<()> {
        match &self.content {
            Content::Obj(file) => write(out, file, corner_uv, groups),
            Content::Other(model) => compose(out, model, corner_uv, groups),
        }
    }

    /// The mesh, or a failure where it has no polygon.
    pub fn polygons(&self) -> Result<&Mesh, Failure> {
        match self.mesh() {
            mesh if mesh.polygon_count() > 0 => Ok(mesh),
            mesh => Err(Failure::Input(format!(
                "{}: {} vertices but no polygon of three or more corners; export the mesh with its faces",
                self.path.display(),
                mesh.positions.len()
            ))),
        }
    }

    /// The mesh, or a failure where it has no UV.
    pub fn mapped(&self) -> Result<(&Mesh, &[DVec2]), Failure> {
        let mesh = self.polygons()?;
        let uv = mesh.corner_uv.as_deref().ok_or_else(|| {
            Failure::Input(format!(
                "{}: no texture coordinates; unwrap it first: seamwright unwrap",
                self.path.display()
            ))
        })?;
        Ok((mesh, uv))
    }
}
