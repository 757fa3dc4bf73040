//! The parts of a glTF document that a mesh needs, as its JSON names them, and the `.glb` container around it.
//!
//! Indices are what the file says; whoever follows one checks it.

use crate::formats::error::FormatError;
use serde::Deserialize;

/// What this reader understands and a file may require.
const UNDERSTOOD: &[&str] = &["KHR_mesh_quantization", "KHR_materials_unlit", "KHR_texture_transform"];

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub struct Document {
    pub asset: Asset,
    pub extensions_required: Vec<String>,
    pub scene: Option<usize>,
    pub scenes: Vec<GltfScene>,
    pub nodes: Vec<GltfNode>,
    pub meshes: Vec<GltfMesh>,
    pub materials: Vec<Material>,
    pub accessors: Vec<Accessor>,
    pub buffer_views: Vec<BufferView>,
    pub buffers: Vec<Buffer>,
}

#[derive(Deserialize, Default)]
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
}

#[derive(Deserialize)]
pub struct GltfMesh {
    pub name: Option<String>,
    pub primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
pub struct Primitive {
    pub attributes: Attributes,
    pub indices: Option<usize>,
    pub material: Option<usize>,
    pub mode: Option<u32>,
}

#[derive(Deserialize)]
pub struct Attributes {
    #[serde(rename = "POSITION")]
    pub position: Option<usize>,
    #[serde(rename = "NORMAL")]
    pub normal: Option<usize>,
    #[serde(rename = "TEXCOORD_0")]
    pub texture: Option<usize>,
    #[serde(rename = "COLOR_0")]
    pub colour: Option<usize>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub struct Material {
    pub name: Option<String>,
    pub pbr_metallic_roughness: Option<GltfLook>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub struct GltfLook {
    pub base_color_factor: Option<[f64; 4]>,
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
    pub sparse: Option<serde_json::Value>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct BufferView {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Buffer {
    pub uri: Option<String>,
    pub byte_length: usize,
}

/// The document and the binary chunk, if there is one, of a `.gltf` or `.glb`.
pub fn read(bytes: &[u8]) -> Result<(Document, Option<&[u8]>), FormatError> {
    let (json, binary) = if bytes.starts_with(b"glTF") { chunks(bytes)? } else { (bytes, None) };
    let json = json.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(json);
    let document: Document =
        serde_json::from_slice(json).map_err(|e| FormatError::whole(format!("not glTF 2.0: {e}; export it again")))?;
    if !document.asset.version.starts_with("2.") {
        return Err(FormatError::whole(format!("glTF '{}', not 2.0; export it again", document.asset.version)));
    }
    match document.extensions_required.iter().find(|e| !UNDERSTOOD.contains(&e.as_str())) {
        Some(extension) => Err(FormatError::whole(format!("it needs {extension}; export it without"))),
        None => Ok((document, binary)),
    }
}

/// JSON and binary chunk of a `.glb`.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), FormatError> {
    let broken = || FormatError::whole("a .glb that is cut short or damaged; export it again");
    let word = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
    let chunk = |at: usize| {
        let length = word(at)? as usize;
        Some((bytes.get(at + 4..at + 8)?, bytes.get(at + 8..(at + 8).checked_add(length)?)?))
    };
    if word(4) != Some(2) {
        return Err(broken());
    }
    let (_, json) = chunk(12).filter(|(kind, _)| *kind == b"JSON").ok_or_else(broken)?;
    let second = 20 + json.len();
    if second >= bytes.len() {
        return Ok((json, None));
    }
    let (kind, binary) = chunk(second).ok_or_else(broken)?;
    Ok((json, Some(binary).filter(|_| kind == b"BIN\0")))
}
