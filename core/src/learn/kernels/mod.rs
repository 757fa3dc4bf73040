//! Matrix products whose every element is summed over the depth in order.
//!
//! Guaranteed for f32: every path, tile shape and number of threads gives the same bits, because each step is one fused
//! multiply-add, rounded once ([`fused`] computes it exactly where the machine has none).
//! f64 has the plain path alone, multiply then add: it is there to check the derivatives, not to be fast.
//! A path for another machine is a [`path::Path`], a panel width and a function that fills rows (see `tiles`).

#[macro_use]
#[cfg(any(target_arch = "x86_64", all(target_arch = "aarch64", target_feature = "neon")))]
mod tiles;

pub mod float;
pub mod fused;
#[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
mod neon;
pub mod number;
pub mod path;
mod plain;
pub mod product;
mod product_tests;
pub mod task;
#[cfg(target_arch = "x86_64")]
mod x86;
