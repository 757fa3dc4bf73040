//! The seamwright command as a library: everything around core that needs files, threads, clocks or a terminal.
//!
//! - [`args`], [`commands`], [`failure`]: the command line, what it does, how it ends
//! - [`load`], [`mesh`], [`obj`], [`formats`]: files to meshes and back
//! - [`atlas`], [`hierarchy`], [`threads`]: core's pipeline with a desktop's memory, library and threads
//! - [`learning`], [`map_file`]: how maps are trained, and trained maps in files
//! - [`labels`], [`parts`]: which part each face belongs to, from files and found by core
//! - [`exposure`], [`measure`], [`agreement`], [`picture`]: figures and pictures of any UV-mapped mesh
//! - [`progress`], [`report`], [`save`]: what people and scripts see, and outputs that appear whole or not at all
#![forbid(unsafe_code)]

pub mod agreement;
pub mod args;
pub mod atlas;
pub mod commands;
pub mod exposure;
pub mod failure;
pub mod formats;
pub mod hierarchy;
pub mod labels;
pub mod learning;
pub mod load;
pub mod map_file;
pub mod measure;
pub mod mesh;
pub mod obj;
pub mod parts;
pub mod picture;
pub mod progress;
pub mod report;
pub mod save;
pub mod threads;
