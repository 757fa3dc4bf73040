//! Buffer views compressed as `EXT_meshopt_compression` and `KHR_meshopt_compression` say, decompressed.
//!
//! - [`decode`]: a whole view
//! - `bytes`: the codec of attributes; `indices`: those of triangles and sequences; `filters`: what is made of the numbers

mod bytes;
pub mod decode;
mod filters;
mod indices;
