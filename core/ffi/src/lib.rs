//! seamwright-ffi: core behind a C interface, in the caller's memory.
//!
//! Plain structs, pointers with counts, error codes; nothing opaque, nothing that has to be freed. `include/seamwright.h`
//! is generated from this crate (`cargo run -p seamwright-tests --bin header`), and a test compares them. No input makes
//! it panic: pointers, counts, alignment and options are checked before anything is read through them.
//! It is an ordinary Rust library in this workspace; as a static or shared library it is built with the feature
//! `standalone` and the profile `c`, see the README. `unsafe` lives in `slices`, `structs`, `host` and `panic`, and in the
//! functions that C calls, whose contract is the header.
#![no_std]

#[cfg(test)]
extern crate std;

mod code;
mod host;
mod measure;
#[cfg(feature = "standalone")]
mod panic;
mod slices;
mod structs;
mod surface;
mod types;
mod unwrap;

pub use code::*;
pub use measure::*;
pub use types::*;
pub use unwrap::*;

use core::ffi::c_char;

/// Number of this interface. It changes when a struct, a function or a code does, but not when one is added, or a field at
/// a struct's end.
pub const SEAMWRIGHT_INTERFACE: u32 = 2;

/// The interface that the library was built with; compare it with `SEAMWRIGHT_INTERFACE`.
// SAFETY: no other symbol has this name; so everywhere below.
#[unsafe(no_mangle)]
pub extern "C" fn seamwright_interface() -> u32 {
    SEAMWRIGHT_INTERFACE
}

/// The library's version, like "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn seamwright_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}
