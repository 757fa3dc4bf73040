//! What is asked, in the words of the command line.
//!
//! - [`mod@line`]: the whole, with a file for each subcommand
//! - [`settings`], [`method`], [`learning`], [`parts`], [`run`]: words that several of them take

pub mod apply;
pub mod batch;
pub mod check;
pub mod demo;
pub mod group;
pub mod learning;
pub mod line;
pub mod measure;
pub mod method;
pub mod parts;
pub mod render;
pub mod run;
pub mod segment;
pub mod settings;
pub mod transfer;
pub mod unwrap;
pub mod writing;
