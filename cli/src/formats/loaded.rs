//! A mesh from a file, by the file's ending, and back to a file: the same one with other UVs where the format is the same.

use super::format::Format;
use super::gltf::file::GltfFile;
use super::gltf::{compose as gltf_compose, read as gltf, write as gltf_write};
use super::groups::Groups;
use super::model::Model;
use super::obj::{compose as obj_compose, file::ObjFile, material, read::read, write::write};
use super::ply::file::PlyFile;
use super::ply::{compose as ply_compose, read as ply, write as ply_write};
use super::reading::Reading;
use super::target::{Files, Main, Mapping, Target};
use super::{fbx, off, stl};
use crate::base::failure::Failure;
use crate::mesh::polygons::Mesh;
use crate::mesh::precision;
use glam::DVec2;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

/// The endings that [`load`] knows, for messages.
pub const ENDINGS: &str = ".obj, .ply, .stl, .off, .fbx, .glb and .gltf";

/// A mesh and what its file needs to be written back.
pub struct Loaded {
    /// Where it was read.
    pub path: PathBuf,
    content: Content,
}

/// What knows how to write a file again.
enum Content {
    Obj(ObjFile),
    Ply(PlyFile),
    Gltf(Box<GltfFile>),
    /// Its bytes as they were.
    Off(Model, Vec<u8>),
    /// Nothing: a mesh alone.
    Other(Model),
}

/// Reads the mesh at `path`, each mesh of a scene once.
pub fn load(path: &Path) -> Result<Loaded, Failure> {
    load_as(path, Reading::default())
}

/// Reads what is wanted of the file at `path`.
pub fn load_as(path: &Path, reading: Reading) -> Result<Loaded, Failure> {
    if path.as_os_str() == "-" {
        return Err(Failure::Usage("-: this command takes no standard input; name a file".into()));
    }
    let Some(format) = Format::of(path) else {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        let problem =
            if ending.is_empty() { "no file ending".into() } else { format!("unknown file ending .{ending}") };
        let text = format!("{}: {problem}; seamwright reads {ENDINGS}, so convert the mesh first", path.display());
        return Err(Failure::Input(text));
    };
    let bytes = std::fs::read(path).map_err(|e| Failure::input(path, &e))?;
    of_bytes(path, format, bytes, reading)
}

/// Reads what is wanted of the file at `path`, or of standard input, which holds `stream`, where `path` is `-`.
pub fn open(path: &Path, stream: Option<Format>, reading: Reading) -> Result<Loaded, Failure> {
    if path.as_os_str() != "-" {
        return load_as(path, reading);
    }
    let Some(format) = stream else {
        return Err(Failure::Usage("-: standard input has no ending; say with --format what it holds".into()));
    };
    let mut bytes = Vec::new();
    io::stdin().lock().read_to_end(&mut bytes).map_err(|e| Failure::input(path, &e))?;
    of_bytes(path, format, bytes, reading)
}

fn of_bytes(path: &Path, format: Format, bytes: Vec<u8>, reading: Reading) -> Result<Loaded, Failure> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let content = match format {
        Format::Obj => return load_obj(path, bytes),
        Format::Ply => ply::read(bytes, reading).map(Content::Ply),
        Format::Stl => stl::read(&bytes).map(Content::Other),
        Format::Off => off::read(&bytes).map(|model| Content::Off(model, bytes)),
        Format::Glb | Format::Gltf => gltf::read(&bytes, folder, reading).map(|file| Content::Gltf(Box::new(file))),
        Format::Fbx => fbx::read(&bytes, reading).map(Content::Other),
    };
    let content = content.map_err(|e| input_error(path, e.line, &e.problem))?;
    Ok(Loaded { path: path.to_path_buf(), content })
}

/// Reads an OBJ that is in memory already; `path` is what messages name.
pub fn load_obj(path: &Path, bytes: Vec<u8>) -> Result<Loaded, Failure> {
    let file = read(bytes).map_err(|e| input_error(path, e.line, &e.problem))?;
    Ok(Loaded { path: path.to_path_buf(), content: Content::Obj(file) })
}

/// Rounding of positions, over the mesh's size, that the user is told of.
const COARSE: f64 = 1e-4;

/// `file:line: problem`; line 0 is the whole file.
fn input_error(path: &Path, line: usize, problem: &dyn core::fmt::Display) -> Failure {
    let line = if line == 0 { String::new() } else { format!(":{line}") };
    Failure::Input(format!("{}{line}: {problem}", path.display()))
}

impl Loaded {
    /// A mesh alone, which came from the same file.
    pub fn alone(&self, mesh: Mesh) -> Self {
        Self { path: self.path.clone(), content: Content::Other(Model::of(mesh)) }
    }

    /// The mesh and what its file says of it.
    pub fn model(&self) -> &Model {
        match &self.content {
            Content::Obj(file) => &file.model,
            Content::Ply(file) => &file.model,
            Content::Gltf(file) => &file.model,
            Content::Off(model, _) | Content::Other(model) => model,
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

    /// Refuses, before any work, a target that cannot be written, and says what of the file it does not take along.
    pub fn check(&self, target: &Target) -> Result<Vec<String>, Failure> {
        let model = self.model();
        let mut losses = match (&self.content, target.format) {
            (Content::Gltf(file), Format::Glb | Format::Gltf) => {
                gltf_write::writable(file, target).map_err(|e| input_error(&self.path, e.line, &e.problem))?;
                return Ok(Vec::new());
            }
            (Content::Ply(file), Format::Ply) => return Ok(ply_write::warnings(file)),
            (Content::Obj(_), Format::Obj) => return Ok(self.left_behind(target, &model.named)),
            (Content::Off(..), Format::Off) => return Ok(Vec::new()),
            (_, Format::Glb | Format::Gltf) => {
                gltf_compose::writable(model).map_err(|e| input_error(&self.path, e.line, &e.problem))?;
                Vec::new()
            }
            (_, Format::Ply) => ply_compose::losses(model),
            (_, Format::Off) => vec!["everything but vertices and polygons".into()],
            _ => Vec::new(),
        };
        losses.extend(model.rest.iter().cloned());
        let warning = (!losses.is_empty())
            .then(|| format!("{} does not take along: {}", target.format.name(), losses.join(", ")));
        let mut warnings: Vec<String> = warning.into_iter().collect();
        if target.format == Format::Obj {
            let textures = model.materials.iter().filter_map(|material| material.texture.clone());
            let textures: Vec<String> = textures.filter(|name| model.named.contains(name)).collect();
            warnings.extend(self.left_behind(target, &textures));
        }
        if matches!(target.format, Format::Glb | Format::Gltf) {
            let name = target.format.name();
            if model.mesh.polygons().any(|p| p.len() > 3) {
                warnings.push(format!("{name} holds triangles alone; polygons are cut into them"));
            }
            let rounding = precision::rounding(&model.mesh.positions);
            if rounding > COARSE {
                let share = 100.0 * rounding;
                warnings.push(format!(
                    "{name} holds floats, which round positions so far from the origin by {share:.2} % of the mesh's size; move it there"
                ));
            }
        }
        Ok(warnings)
    }

    /// The files that the mesh's own file names, and that lie beside it.
    pub fn beside(&self) -> Vec<PathBuf> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        self.model().named.iter().map(|name| folder.join(name)).filter(|path| path.is_file()).collect()
    }

    /// What to say of files that the target names and that only lie beside the input.
    fn left_behind(&self, target: &Target, names: &[String]) -> Vec<String> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let is_left = |name: &&String| folder.join(name).is_file() && !target.folder().join(name).is_file();
        let text =
            |name: &String| format!("{name} is named by it and not copied; put it beside {}", target.path.display());
        names.iter().filter(is_left).map(text).collect()
    }

    /// The files that the mesh becomes with the UVs of `mapping`.
    pub fn files<'a>(&'a self, target: &'a Target, mapping: Mapping<'a>) -> Result<Files<'a>, Failure> {
        let model = self.model();
        let Mapping { corner_uv, groups } = mapping;
        let main = |write: Main<'a>| Files { main: write, beside: Vec::new(), warnings: Vec::new() };
        Ok(match (&self.content, target.format) {
            (Content::Obj(file), Format::Obj) => main(Box::new(move |out| write(out, file, corner_uv, groups))),
            (Content::Ply(file), Format::Ply) => {
                main(Box::new(move |out| ply_write::write(out, file, corner_uv, target.uv_set, target.keep)))
            }
            (Content::Gltf(file), Format::Glb | Format::Gltf) => {
                gltf_write::write(file, target, mapping).map_err(|e| self.unwritten(e))?
            }
            (Content::Off(_, bytes), Format::Off) => main(Box::new(move |out| out.write_all(bytes))),
            (_, Format::Off) => main(Box::new(move |out| off::compose(out, &model.mesh))),
            (_, Format::Ply) => {
                main(Box::new(move |out| ply_compose::compose(out, model, Some(corner_uv), target.uv_set)))
            }
            (_, Format::Glb | Format::Gltf) => {
                gltf_compose::write(model, target, mapping).map_err(|e| self.unwritten(e))?
            }
            _ => {
                let text = material::text(model).filter(|_| !target.is_stream());
                let library = text.as_ref().map(|_| target.sibling(0, "mtl"));
                let place = library.as_ref().map(|name| target.folder().join(name));
                let main =
                    move |out: &mut dyn Write| obj_compose::compose(out, model, library.as_deref(), corner_uv, groups);
                let beside = place.into_iter().zip(text.map(String::into_bytes)).collect();
                Files { main: Box::new(main), beside, warnings: Vec::new() }
            }
        })
    }

    fn unwritten(&self, error: gltf_write::WriteError) -> Failure {
        match error {
            gltf_write::WriteError::Format(e) => input_error(&self.path, e.line, &e.problem),
            gltf_write::WriteError::Io(path, e) => Failure::output("-o", &path, &e),
        }
    }

    /// Writes the mesh as OBJ with one UV a corner, and `groups` if any: the user's own file where it was one. No file of
    /// materials is named.
    pub fn write_obj(&self, out: &mut dyn Write, corner_uv: &[DVec2], groups: Option<&Groups>) -> io::Result<()> {
        match &self.content {
            Content::Obj(file) => write(out, file, corner_uv, groups),
            _ => obj_compose::compose(out, self.model(), None, corner_uv, groups),
        }
    }

    /// The mesh, or a failure where it has no polygon.
    pub fn polygons(&self) -> Result<&Mesh, Failure> {
        match self.mesh() {
            mesh if mesh.polygon_count() > 0 => Ok(mesh),
            mesh if mesh.positions.is_empty() => Err(Failure::Input(format!(
                "{}: no mesh in it, neither vertices nor polygons; export it anew",
                self.path.display()
            ))),
            mesh => Err(Failure::Input(format!(
                "{}: {} vertices but no polygon of three or more corners; export the mesh with its faces",
                self.path.display(),
                mesh.positions.len()
            ))),
        }
    }

    /// Refuses a set of UVs that the file has not, but for the first.
    pub fn check_set(&self, uv_set: u32) -> Result<(), Failure> {
        if uv_set == 0 {
            return Ok(());
        }
        let why = match &self.content {
            Content::Gltf(_) | Content::Ply(_) if self.mesh().corner_uv.is_some() => return Ok(()),
            Content::Gltf(_) | Content::Ply(_) => "it has no such set of UVs",
            _ => "its format holds one set of UVs, number 0",
        };
        Err(Failure::Input(format!("{}: --uv-set {uv_set}: {why}", self.path.display())))
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
