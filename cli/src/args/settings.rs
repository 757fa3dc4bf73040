//! How the atlas is made, as asked.

use clap::{Args, ValueEnum};
use seamwright_core::pipeline;
use seamwright_core::price::cost::Prefer;
use seamwright_core::price::given::HardEdges;

/// How the atlas is made.
#[derive(Clone, Copy, Debug, Args)]
pub struct SettingsArgs {
    /// Mean distortion to stay below: symmetric Dirichlet energy over 4, where 1 is an isometry. Lower: more seams
    #[arg(long, value_name = "BOUND", default_value_t = pipeline::Settings::default().distortion, value_parser = distortion)]
    pub distortion: f64,
    /// Charts of each connected piece
    #[arg(long, value_enum, default_value_t = ChartsArg::Few)]
    pub charts: ChartsArg,
    /// Whether the side of a cylinder, a pipe, a belt becomes a rectangle
    #[arg(long, value_enum, default_value_t = StraightenArg::Auto)]
    pub straighten: StraightenArg,
    /// How charts are placed
    #[arg(long, value_enum, default_value_t = PackingArg::Tight)]
    pub packing: PackingArg,
    /// What is given up where seams and a filled square are at odds
    #[arg(long, value_enum, default_value_t = PreferArg::Balance)]
    pub prefer: PreferArg,
    /// What is made of edges at which the file's shading breaks: split normals, borders of smoothing groups
    #[arg(long, value_enum, default_value_t = HardEdgesArg::Prefer)]
    pub hard_edges: HardEdgesArg,
    /// Side of the texture in texels
    #[arg(long, value_name = "TEXELS", default_value_t = pipeline::Settings::default().size, value_parser = clap::value_parser!(u32).range(16..=65536))]
    pub size: u32,
    /// Empty texels between charts
    #[arg(long, value_name = "TEXELS", default_value_t = pipeline::Settings::default().padding)]
    pub padding: u32,
    /// Exposure rays of each vertex
    #[arg(long, value_name = "COUNT", default_value_t = pipeline::Settings::default().rays, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub rays: u32,
    /// Further searches for seams, 100 at the most; what costs least to be seen and fills most is kept. 15 take about five times as long
    #[arg(long, value_name = "COUNT", default_value_t = pipeline::Settings::default().search, value_parser = clap::value_parser!(u32).range(0..=100))]
    pub search: u32,
    /// Seed of every random choice
    #[arg(long, default_value_t = pipeline::Settings::default().seed)]
    pub seed: u64,
}

/// Charts of each connected piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ChartsArg {
    /// As many as hide the seams best
    Few,
    /// One, where the bound and a flat layout without overlap allow it
    One,
}

/// Whether strips become rectangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StraightenArg {
    /// They stay as they have least distortion
    Off,
    /// Where a chart is a strip and the bound allows
    Auto,
}

/// How charts are placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PackingArg {
    /// Equal texel density, rotated, into one another's gaps
    Tight,
    /// One cell of a square grid a chart
    Grid,
}

/// What is given up for the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PreferArg {
    /// Fewer seams that are noticed; charts may be of any shape
    Seams,
    /// Both in their measure
    Balance,
    /// A square that is filled
    Fill,
}

/// What is made of shading breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum HardEdgesArg {
    /// A seam is hardly noticed there
    Prefer,
    /// Every break is a seam, as baking of normal maps wants it
    Require,
    /// Nothing: the turn of the surface alone counts
    Off,
}

impl SettingsArgs {
    /// The words on a command line that ask for the same.
    pub fn words(self) -> Vec<String> {
        let Self { distortion, charts, straighten, packing, prefer, hard_edges, size, padding, rays, search, seed } =
            self;
        fn name(value: impl ValueEnum) -> String {
            value.to_possible_value().map(|value| value.get_name().into()).unwrap_or_default()
        }
        let all = [
            ("--distortion", distortion.to_string()),
            ("--charts", name(charts)),
            ("--straighten", name(straighten)),
            ("--packing", name(packing)),
            ("--prefer", name(prefer)),
            ("--hard-edges", name(hard_edges)),
            ("--size", size.to_string()),
            ("--padding", padding.to_string()),
            ("--rays", rays.to_string()),
            ("--search", search.to_string()),
            ("--seed", seed.to_string()),
        ];
        all.into_iter().flat_map(|(flag, value)| [flag.into(), value]).collect()
    }

    /// As core takes them.
    pub fn to_core(self) -> pipeline::Settings {
        pipeline::Settings {
            distortion: self.distortion,
            charts: match self.charts {
                ChartsArg::Few => pipeline::Charts::Few,
                ChartsArg::One => pipeline::Charts::One,
            },
            straighten: match self.straighten {
                StraightenArg::Off => pipeline::Straighten::Off,
                StraightenArg::Auto => pipeline::Straighten::Auto,
            },
            packing: match self.packing {
                PackingArg::Tight => pipeline::Packing::Tight,
                PackingArg::Grid => pipeline::Packing::Grid,
            },
            prefer: match self.prefer {
                PreferArg::Seams => Prefer::Seams,
                PreferArg::Balance => Prefer::Balance,
                PreferArg::Fill => Prefer::Fill,
            },
            hard_edges: match self.hard_edges {
                HardEdgesArg::Prefer => HardEdges::Prefer,
                HardEdgesArg::Require => HardEdges::Require,
                HardEdgesArg::Off => HardEdges::Off,
            },
            size: self.size,
            padding: self.padding,
            rays: self.rays,
            search: self.search,
            seed: self.seed,
            ..pipeline::Settings::default()
        }
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
