//! The parts of a glTF document that a mesh needs, as its JSON names them.
//!
//! Indices are what the file says; whoever follows one checks it.

use super::uri::decode_percent;
use crate::formats::error::FormatError;
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub struct Document {
    pub asset: Asset,
    pub extensions_used: Vec<String>,
    pub extensions_required: Vec<String>,
    pub scene: Option<usize>,
    pub scenes: Vec<GltfScene>,
    pub nodes: Vec<GltfNode>,
    pub meshes: Vec<GltfMesh>,
    pub materials: Vec<GltfMaterial>,
    pub textures: Vec<GltfTexture>,
    pub images: Vec<GltfImage>,
    pub accessors: Vec<Accessor>,
    pub buffer_views: Vec<BufferView>,
    pub buffers: Vec<Buffer>,
    pub skins: Vec<Value>,
    pub animations: Vec<Value>,
    pub cameras: Vec<Value>,
    pub extensions: BTreeMap<String, Value>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct Asset {
    pub version: String,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct GltfScene {
    pub nodes: Vec<usize>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct GltfNode {
    pub name: Option<String>,
    pub mesh: Option<usize>,
    pub children: Vec<usize>,
    pub matrix: Option<[f64; 16]>, // column after column
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>, // x, y, z, w
    pub scale: Option<[f64; 3]>,
    pub extensions: NodeExtensions,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub instancing: Option<Instancing>,
}

#[derive(Deserialize)]
pub struct Instancing {
    #[serde(default)]
    pub attributes: BTreeMap<String, usize>,
}

#[derive(Deserialize)]
pub struct GltfMesh {
    pub name: Option<String>,
    pub primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
pub struct Primitive {
    pub attributes: BTreeMap<String, usize>,
    pub indices: Option<usize>,
    pub material: Option<usize>,
    pub mode: Option<u32>,
    #[serde(default)]
    pub targets: Vec<BTreeMap<String, usize>>,
    #[serde(default)]
    pub extensions: BTreeMap<String, Value>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub struct GltfMaterial {
    pub name: Option<String>,
    pub pbr_metallic_roughness: Option<GltfLook>,
    pub normal_texture: Option<TextureUse>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub struct GltfLook {
    pub base_color_factor: Option<[f64; 4]>,
    pub base_color_texture: Option<TextureUse>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct TextureUse {
    pub index: usize,
    #[serde(default)]
    pub tex_coord: u32,
}

#[derive(Deserialize)]
pub struct GltfTexture {
    pub source: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct GltfImage {
    pub name: Option<String>,
    pub uri: Option<String>,
    pub mime_type: Option<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Accessor {
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: u32,
    #[serde(default)]
    pub normalized: bool,
    pub count: usize,
    #[serde(rename = "type")]
    pub shape: String,
    pub sparse: Option<Sparse>,
}

#[derive(Deserialize)]
pub struct Sparse {
    pub count: usize,
    pub indices: SparseIndices,
    pub values: SparseValues,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseIndices {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: u32,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseValues {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: usize,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct BufferView {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: Option<usize>,
    #[serde(default)]
    pub extensions: ViewExtensions,
}

/// Of the two names, which mean the same for what is read here, files have one.
#[derive(Deserialize, Default)]
#[serde(default)]
pub struct ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression", alias = "KHR_meshopt_compression")]
    pub meshopt: Option<Compressed>,
}

/// Where the compressed bytes of a buffer view lie.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Compressed {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: usize,
    pub count: usize,
    pub mode: String,
    pub filter: Option<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Buffer {
    pub uri: Option<String>,
    pub byte_length: usize,
    #[serde(default)]
    pub extensions: BTreeMap<String, Value>,
}

impl Document {
    /// What the tree says. Whoever requires an extension that is needed to find the geometry finds out where it is missing.
    pub fn of(tree: &Value) -> Result<Self, FormatError> {
        let document =
            Self::deserialize(tree).map_err(|e| FormatError::whole(format!("not glTF 2.0: {e}; export it again")))?;
        match document.asset.version.starts_with("2.") {
            true => Ok(document),
            false => Err(FormatError::whole(format!("glTF '{}', not 2.0; export it again", document.asset.version))),
        }
    }
}

/// The name of a set of UVs.
pub(super) fn texcoord(set: u32) -> String {
    format!("TEXCOORD_{set}")
}

impl GltfImage {
    /// What a file of the image is called: its own name where it lies in one, else one made of its name or number.
    pub fn file_name(&self, number: usize) -> String {
        if let Some(uri) = self.uri.as_deref().filter(|uri| !uri.starts_with("data:")) {
            return decode_percent(uri);
        }
        let inside = self.uri.as_deref().and_then(|uri| uri.strip_prefix("data:"));
        let ending = match self.mime_type.as_deref().or(inside) {
            Some(kind) if kind.starts_with("image/jpeg") => "jpg",
            Some(kind) if kind.starts_with("image/webp") => "webp",
            Some(kind) if kind.starts_with("image/ktx2") => "ktx2",
            _ => "png",
        };
        let name = self.name.clone().unwrap_or_else(|| format!("image{number}"));
        if name.contains('.') { name } else { format!("{name}.{ending}") }
    }
}

impl Buffer {
    /// Whether it only stands for what buffer views hold uncompressed, and has no bytes.
    pub fn is_fallback(&self) -> bool {
        let says = |name: &str| self.extensions.get(name).is_some_and(|e| e["fallback"] == Value::Bool(true));
        self.uri.is_none() && ["EXT_meshopt_compression", "KHR_meshopt_compression"].iter().any(|name| says(name))
    }
}
