//! The seamwright command as a library: everything around core that needs files, threads, clocks or a terminal.
//!
//! Rooms, lowest first; each imports from rooms above it in this list alone, as docs/ARCHITECTURE.md has it:
//! - [`base`], [`args`]: how the command ends, colours; what is asked, in the words of the command line
//! - [`mesh`], [`files`], [`training`]: meshes in memory; outputs that appear whole or not at all; how maps are trained
//! - [`formats`], [`picture`]: files to meshes and back; pictures of meshes and atlases
//! - [`run`]: core's pipeline with a desktop's memory, threads, ray hierarchy and progress
//! - [`certificate`]: whether a written atlas keeps its rules, sharing nothing with what makes atlases
//! - [`figures`], [`report`]: figures of any UV-mapped mesh; what a run tells scripts
//! - [`batch`]: many files, each by a process of its own
//! - [`jobs`]: a whole job, from the loaded mesh to the outputs in their places
//! - [`commands`]: a file for each subcommand
#![forbid(unsafe_code)]

pub mod args;
pub mod base;
pub mod batch;
pub mod certificate;
pub mod commands;
pub mod figures;
pub mod files;
pub mod formats;
pub mod jobs;
pub mod mesh;
pub mod picture;
pub mod report;
pub mod run;
pub mod training;
