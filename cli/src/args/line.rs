//! The command line.

use clap::{Args, Parser, Subcommand, ValueEnum};
use seamwright_core::judge::measure::RESOLUTION;
use seamwright_core::learn::train;
use seamwright_core::{pipeline, segment};
use std::path::PathBuf;

const AFTER_HELP: &str = "\
Exit codes: 0 done, 2 wrong command line, 3 input unreadable or not a mesh, 4 output not writable,
5 the run could not reach what was asked, 130 stopped by Ctrl-C or a signal (no output is written).
Outputs replace files of the same name, each whole or not at all.";

/// UV unwrapping with charts that are parts and seams that hide.
#[derive(Debug, Parser)]
#[command(name = "seamwright", version, after_help = AFTER_HELP)]
pub struct CommandLine {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Give a mesh a UV atlas
    Unwrap(UnwrapArgs),
    /// Evaluate saved maps on a mesh, without training
    Apply(ApplyArgs),
    /// Find the parts of a mesh and write a label for each face
    Segment(SegmentArgs),
    /// Print the figures of UV-mapped OBJ files, whatever tool made them
    Measure(MeasureArgs),
    /// Draw a UV-mapped OBJ file: views, seams, checkerboard, atlas
    Render(RenderArgs),
    /// Unwrap a built-in mesh, to see what the main job does
    Demo(DemoArgs),
}

/// `unwrap`.
#[derive(Debug, Args)]
pub struct UnwrapArgs {
    /// The mesh (.obj, .ply, .stl, .glb, .gltf). Existing UVs are replaced
    pub mesh: PathBuf,
    /// The OBJ to write. May be the input itself: everything but the UVs of an OBJ stays byte for byte as it was
    #[arg(short, long, value_name = "OUT.obj")]
    pub output: PathBuf,
    /// What makes the map
    #[arg(long, value_enum, default_value_t = MethodArg::Exact)]
    pub method: MethodArg,
    /// How the atlas is made.
    #[command(flatten)]
    pub settings: SettingsArgs,
    /// How maps are trained.
    #[command(flatten)]
    pub learning: LearningArgs,
    /// Cut along the borders of the object's parts: off, auto, a number of parts, or published (see `segment`)
    #[arg(long, value_name = "N|auto|off", default_value = "off", value_parser = parts_or_off)]
    pub parts: PartsArg,
    /// Cut along the borders of these parts: .seg, .json, or a coloured .ply or .glb of the mesh
    #[arg(long, value_name = "FILE", conflicts_with = "parts")]
    pub labels: Option<PathBuf>,
    /// Put each chart of the OBJ in a group named after its part and chart
    #[arg(long)]
    pub groups: bool,
    /// Keep the borders of the UVs that the file has as cuts
    #[arg(long)]
    pub keep_seams: bool,
    /// Also draw the result
    #[arg(long, value_name = "OUT.png")]
    pub sheet: Option<PathBuf>,
    /// Also write a report; - is standard output
    #[arg(long, value_name = "REPORT.json|-")]
    pub json: Option<PathBuf>,
    /// How it runs.
    #[command(flatten)]
    pub run: RunArgs,
}

/// How the atlas is made.
#[derive(Clone, Copy, Debug, Args)]
pub struct SettingsArgs {
    /// Mean distortion to stay below: symmetric Dirichlet energy over 4, where 1 is an isometry. Lower: more seams
    #[arg(long, value_name = "BOUND", default_value_t = pipeline::Settings::default().distortion, value_parser = distortion)]
    pub distortion: f64,
    /// Charts of each connected piece
    #[arg(long, value_enum, default_value_t = ChartsArg::Few)]
    pub charts: ChartsArg,
    /// How charts are placed
    #[arg(long, value_enum, default_value_t = PackingArg::Tight)]
    pub packing: PackingArg,
    /// Side of the texture in texels
    #[arg(long, value_name = "TEXELS", default_value_t = pipeline::Settings::default().size, value_parser = clap::value_parser!(u32).range(16..=65536))]
    pub size: u32,
    /// Empty texels between charts
    #[arg(long, value_name = "TEXELS", default_value_t = pipeline::Settings::default().padding)]
    pub padding: u32,
    /// Exposure rays of each vertex
    #[arg(long, value_name = "COUNT", default_value_t = pipeline::Settings::default().rays, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub rays: u32,
    /// Seed of every random choice
    #[arg(long, default_value_t = pipeline::Settings::default().seed)]
    pub seed: u64,
}

/// How maps are trained (`neural`, `hybrid`).
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Training (--method neural, hybrid)")]
pub struct LearningArgs {
    /// What training begins with: draft, standard or paper (the published training). standard by default
    #[arg(long, value_name = "NAME", value_parser = preset)]
    pub preset: Option<String>,
    /// A file that changes the preset's settings (see docs/FORMATS.md)
    #[arg(long = "settings", value_name = "FILE.toml")]
    pub file: Option<PathBuf>,
    /// Steps of training
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..))]
    pub steps: Option<u32>,
    /// Weight of the loss that draws seams to hidden places; 0 turns it off
    #[arg(long, value_name = "WEIGHT", value_parser = weight)]
    pub visibility: Option<f64>,
    /// Also write the trained maps, for `seamwright apply`
    #[arg(long, value_name = "FILE")]
    pub save_map: Option<PathBuf>,
    /// Also draw the losses over the steps
    #[arg(long, value_name = "OUT.png")]
    pub curves: Option<PathBuf>,
}

/// `apply`.
#[derive(Debug, Args)]
pub struct ApplyArgs {
    /// The mesh that the maps were trained on, or a finer one in the same place
    pub mesh: PathBuf,
    /// Maps that `unwrap --save-map` wrote
    #[arg(long, value_name = "FILE")]
    pub map: PathBuf,
    /// The OBJ to write
    #[arg(short, long, value_name = "OUT.obj")]
    pub output: PathBuf,
    /// How the atlas is made.
    #[command(flatten)]
    pub settings: SettingsArgs,
    /// Also draw the result
    #[arg(long, value_name = "OUT.png")]
    pub sheet: Option<PathBuf>,
    /// Also write a report; - is standard output
    #[arg(long, value_name = "REPORT.json|-")]
    pub json: Option<PathBuf>,
    /// How it runs.
    #[command(flatten)]
    pub run: RunArgs,
}

/// How a run behaves.
#[derive(Clone, Copy, Debug, Args)]
pub struct RunArgs {
    /// Threads; as many as the machine runs at once by default. The result does not depend on it
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// `segment`.
#[derive(Debug, Args)]
pub struct SegmentArgs {
    /// The mesh (.obj, .ply, .stl, .glb, .gltf)
    pub mesh: PathBuf,
    /// What to write, by its ending: .seg (a label a line), .json (labels by face), coloured .ply or .glb
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// How many parts: auto, a number, or published (three clusters of shape diameter and graph cuts)
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = parts)]
    pub parts: PartsArg,
    /// Also draw parts and shape diameter
    #[arg(long, value_name = "OUT.png")]
    pub sheet: Option<PathBuf>,
    /// Seed of every random choice
    #[arg(long, default_value_t = pipeline::Settings::default().seed)]
    pub seed: u64,
    /// How it runs.
    #[command(flatten)]
    pub run: RunArgs,
}

/// How many parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartsArg {
    /// No parts.
    Off,
    /// As many as the shape has.
    Auto,
    /// This many.
    Count(u32),
    /// By the published method with its published numbers.
    Published,
}

/// `measure`.
#[derive(Debug, Args)]
pub struct MeasureArgs {
    /// UV-mapped OBJ files
    #[arg(required = true, value_name = "FILE.obj")]
    pub files: Vec<PathBuf>,
    /// Print JSON in place of a table: an object for one file, a list for several
    #[arg(long)]
    pub json: bool,
    /// How the sky over a vertex is weighed
    #[arg(long, value_enum, default_value_t = Sky::Uniform)]
    pub exposure: Sky,
    /// Exposure rays of each vertex
    #[arg(long, value_name = "COUNT", default_value_t = pipeline::Settings::default().rays, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub rays: u32,
    /// Say how far the file's charts agree with these partitions (.seg, .json, coloured .ply or .glb), each and on the mean
    #[arg(long, value_name = "LABELS", num_args = 1..)]
    pub reference: Vec<PathBuf>,
    /// Compare this partition with the references in place of the charts
    #[arg(long, value_name = "FILE", requires = "reference")]
    pub labels: Option<PathBuf>,
    /// Texels a side at which overlap and utilisation are sampled; 0 leaves them out
    #[arg(long, value_name = "TEXELS", default_value_t = RESOLUTION, value_parser = clap::value_parser!(u32).range(0..=16384))]
    pub resolution: u32,
}

/// `render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// A UV-mapped OBJ file
    #[arg(value_name = "FILE.obj")]
    pub file: PathBuf,
    /// The picture to write
    #[arg(short, long, value_name = "SHEET.png")]
    pub output: PathBuf,
}

/// `demo`.
#[derive(Debug, Args)]
pub struct DemoArgs {
    /// Folder to write to; made if it is not there
    #[arg(short, long, value_name = "DIR", default_value = "seamwright-demo")]
    pub output: PathBuf,
    /// How it runs.
    #[command(flatten)]
    pub run: RunArgs,
}

/// What makes the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MethodArg {
    /// Cuts by exposure and distortion, then flattening; no training
    Exact,
    /// A network's own map of each piece, cut where it tears; charts may overlap, which is reported
    Neural,
    /// Networks say where seams hide, the exact stages make the atlas
    Hybrid,
}

/// Charts of each connected piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ChartsArg {
    /// As many as hide the seams best
    Few,
    /// One, where the bound and a flat layout without overlap allow it
    One,
}

/// How the sky over a vertex is weighed in `measure`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Sky {
    /// Every direction alike, as libigl does
    Uniform,
    /// By the cosine with the normal, as light falls in; what unwrap uses
    Cosine,
    /// No rays, no figures of exposure
    None,
}

/// How charts are placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PackingArg {
    /// Equal texel density, rotated, into one another's gaps
    Tight,
    /// One cell of a square grid a chart
    Grid,
}

impl MethodArg {
    /// As on the command line.
    pub fn name(self) -> &'static str {
        match self {
            MethodArg::Exact => "exact",
            MethodArg::Neural => "neural",
            MethodArg::Hybrid => "hybrid",
        }
    }
}

impl SettingsArgs {
    /// As core takes them.
    pub fn to_core(self) -> pipeline::Settings {
        pipeline::Settings {
            distortion: self.distortion,
            charts: match self.charts {
                ChartsArg::Few => pipeline::Charts::Few,
                ChartsArg::One => pipeline::Charts::One,
            },
            packing: match self.packing {
                PackingArg::Tight => pipeline::Packing::Tight,
                PackingArg::Grid => pipeline::Packing::Grid,
            },
            size: self.size,
            padding: self.padding,
            rays: self.rays,
            seed: self.seed,
            ..pipeline::Settings::default()
        }
    }
}

impl PartsArg {
    /// As core takes it; `None` for off.
    pub fn to_core(self, seed: u64) -> Option<segment::parts::Settings> {
        let count = match self {
            PartsArg::Off => return None,
            PartsArg::Auto => segment::parts::Count::Auto,
            PartsArg::Count(count) => segment::parts::Count::Exactly(count),
            PartsArg::Published => segment::parts::Count::PUBLISHED,
        };
        Some(segment::parts::Settings { count, seed })
    }

    /// As on the command line.
    pub fn name(self) -> String {
        match self {
            PartsArg::Off => "off".into(),
            PartsArg::Auto => "auto".into(),
            PartsArg::Count(count) => count.to_string(),
            PartsArg::Published => "published".into(),
        }
    }
}

fn parts(word: &str) -> Result<PartsArg, String> {
    match word {
        "auto" => Ok(PartsArg::Auto),
        "published" => Ok(PartsArg::Published),
        _ => match word.parse::<u32>() {
            Ok(count) if count > 0 => Ok(PartsArg::Count(count)),
            _ => Err("write auto, published or a number of parts, 1 or more".into()),
        },
    }
}

fn parts_or_off(word: &str) -> Result<PartsArg, String> {
    if word == "off" { Ok(PartsArg::Off) } else { parts(word).map_err(|e| e.replace("write ", "write off, ")) }
}

fn preset(word: &str) -> Result<String, String> {
    let known = train::Settings::preset(word).map(|_| word.to_string());
    known.ok_or_else(|| "write draft, standard or paper".into())
}

fn weight(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(weight) if weight >= 0.0 && weight.is_finite() => Ok(weight),
        _ => Err("write a number, 0 or more".into()),
    }
}

/// A bound that something can satisfy.
fn distortion(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(bound) if bound > 1.0 && bound.is_finite() => Ok(bound),
        Ok(_) => Err("the bound must be above 1, which is no distortion at all; 1.025 is the default".into()),
        Err(_) => Err("not a number; write for example 1.025".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_sound() {
        CommandLine::command().debug_assert();
    }

    #[test]
    fn the_defaults_are_those_of_core() {
        let line = CommandLine::parse_from(["seamwright", "unwrap", "a.obj", "-o", "b.obj"]);
        let Command::Unwrap(args) = line.command else { unreachable!("unwrap was parsed") };
        assert_eq!(format!("{:?}", args.settings.to_core()), format!("{:?}", pipeline::Settings::default()));
    }
}
