//! glTF 2.0: `.glb`, and `.gltf` with its buffers.

mod buffers;
mod document;
pub mod read;
