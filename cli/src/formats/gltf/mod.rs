//! glTF 2.0: `.glb`, and `.gltf` with its buffers.
//!
//! - `container`, `uri`, [`beside`]: chunks, text, and what lies elsewhere
//! - `document`: what the JSON says of a mesh
//! - `buffers`, `meshopt`, `numbers`: bytes, decompressed, and the numbers of accessors
//! - `scene`, `surface`, `rest`: what is drawn where, triangles of primitives, what only a glTF has
//! - [`mod@file`], [`read`]: a whole file, and how it comes about
//! - `pools`, `split`, `records`, `overwrite`, `edit`: what a new set of UVs changes; `pack`, `sets`, `whole`: what else follows from it
//! - [`mod@write`]: a file with other UVs; [`compose`]: one from scratch, for meshes that came in another format

pub mod beside;
mod buffers;
pub mod compose;
mod container;
mod document;
mod edit;
pub mod file;
mod meshopt;
mod numbers;
mod overwrite;
mod pack;
mod pools;
pub mod read;
mod records;
mod rest;
mod scene;
mod sets;
mod split;
mod surface;
mod uri;
mod whole;
pub mod write;
