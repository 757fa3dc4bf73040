//! What a mesh with its UVs is written to, and the files that come of it.

use super::format::Format;
use super::groups::Groups;
use glam::DVec2;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Where and how a mesh is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Target {
    /// The file.
    pub path: PathBuf,
    /// Its format.
    pub format: Format,
    /// Which of its sets of UVs is written.
    pub uv_set: u32,
    /// Whether the UVs that this set has stay, as another set.
    pub keep: bool,
}

/// What is written beside the mesh: UVs, and what else the user wants to see in the file.
#[derive(Clone, Copy)]
pub struct Mapping<'a> {
    /// UV of each corner; NaN: none.
    pub corner_uv: &'a [DVec2], // (c)
    /// A group of each polygon, for formats that name them.
    pub groups: Option<&'a Groups<'a>>,
}

/// How the main file is written, once it is open.
pub type Main<'a> = Box<dyn FnOnce(&mut dyn Write) -> io::Result<()> + 'a>;

/// The files of a mesh.
pub struct Files<'a> {
    /// The one that was named.
    pub main: Main<'a>,
    /// Others that it names: buffers, images, materials.
    pub beside: Vec<(PathBuf, Vec<u8>)>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

impl Target {
    /// A file with the first set of UVs.
    pub fn new(path: &Path, format: Format) -> Self {
        Self { path: path.to_path_buf(), format, uv_set: 0, keep: false }
    }

    /// Whether it is standard output, which has no place for files beside it.
    pub fn is_stream(&self) -> bool {
        self.path.as_os_str() == "-"
    }

    /// The folder of the file.
    pub fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    /// The file's name with another ending and, for all but the first, a number.
    pub fn sibling(&self, number: usize, ending: &str) -> String {
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
        if number == 0 { format!("{stem}.{ending}") } else { format!("{stem}_{number}.{ending}") }
    }
}

impl<'a> Files<'a> {
    /// One file of bytes that are made already.
    pub fn of(bytes: Vec<u8>) -> Self {
        Self { main: Box::new(move |out| out.write_all(&bytes)), beside: Vec::new(), warnings: Vec::new() }
    }
}
