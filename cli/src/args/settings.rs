//! How the atlas is made, as asked.

use clap::{Args, ValueEnum};
use seamwright_core::mesh::cracks::Weld;
use seamwright_core::pipeline;
use seamwright_core::price::cost::Prefer;
use seamwright_core::price::given::HardEdges;
use std::time::Duration;

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
    /// Whether straight borders lie on the edges of texels
    #[arg(long, value_enum, default_value_t = SnapArg::Off)]
    pub snap: SnapArg,
    /// Whether pieces of the same shape share their texels
    #[arg(long, value_enum, default_value_t = StackArg::Off)]
    pub stack: StackArg,
    /// Lay all but the first of a stack so many squares to the right, as bakers of normal maps want it
    #[arg(long, value_name = "SQUARES", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1))]
    pub stack_offset: u32,
    /// How charts are placed
    #[arg(long, value_enum, default_value_t = PackingArg::Tight)]
    pub packing: PackingArg,
    /// What is given up where seams and a filled square are at odds
    #[arg(long, value_enum, default_value_t = PreferArg::Balance)]
    pub prefer: PreferArg,
    /// What is made of edges at which the file's shading breaks: split normals, borders of smoothing groups
    #[arg(long, value_enum, default_value_t = HardEdgesArg::Prefer)]
    pub hard_edges: HardEdgesArg,
    /// Close cracks of up to this share of the mesh's diagonal in the working copy (1e-4, say), or of what width is found
    #[arg(long, value_name = "SHARE|auto", value_parser = weld)]
    pub weld: Option<WeldArg>,
    /// Side of the texture in texels
    #[arg(long, value_name = "TEXELS", default_value_t = pipeline::Settings::default().size, value_parser = clap::value_parser!(u32).range(16..=65536))]
    pub size: u32,
    /// Empty texels between charts
    #[arg(long, value_name = "TEXELS", default_value_t = pipeline::Settings::default().padding)]
    pub padding: u32,
    /// Exposure rays of each vertex
    #[arg(long, value_name = "COUNT", default_value_t = pipeline::Settings::default().rays, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub rays: u32,
    /// Further trials of the seams, 100 at the most: those in a random place are given up and searched for again, and what costs least to be seen is kept. 40 take about twice as long
    #[arg(long, value_name = "COUNT", default_value_t = pipeline::Settings::default().search, value_parser = clap::value_parser!(u32).range(0..=100))]
    pub search: u32,
    /// Seed of every random choice
    #[arg(long, default_value_t = pipeline::Settings::default().seed)]
    pub seed: u64,
    /// End after about so long with the best valid atlas that can be had by then. The report says after what work, for --work
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub time_limit: Option<f64>,
    /// End stages after so much counted work: exposure=N,seams=N,pack=N, each where it is wanted. The same bytes on any machine
    #[arg(long, value_name = "STAGE=N,...", value_parser = work, conflicts_with = "time_limit")]
    pub work: Option<pipeline::CountedWork>,
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
    /// Strips between sharp edges are cut out for it too, though more seams may be noticed
    Strips,
}

/// Whether charts are fitted to texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SnapArg {
    /// They lie where packing puts them
    Off,
    /// Borders that run along an axis lie on the edges of texels, where the bound allows
    Texel,
}

/// Whether pieces of the same shape share their texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StackArg {
    /// Each has its own
    Off,
    /// Those that are the same but for where they are and how they are turned lie over one another
    Same,
    /// Mirror images too, and the halves of what is its own mirror image; their UVs are mirrored
    Mirrored,
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

/// Which cracks are closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WeldArg {
    /// Those of a width that is found in the mesh
    Auto,
    /// Those up to this share of the diagonal
    Within(f64),
}

impl WeldArg {
    /// As it is written.
    pub fn name(self) -> String {
        match self {
            WeldArg::Auto => "auto".into(),
            WeldArg::Within(share) => share.to_string(),
        }
    }
}

impl SettingsArgs {
    /// The words on a command line that ask for the same.
    pub fn words(self) -> Vec<String> {
        let Self {
            distortion,
            charts,
            straighten,
            snap,
            stack,
            stack_offset,
            packing,
            prefer,
            hard_edges,
            weld,
            size,
            padding,
            rays,
            search,
            seed,
            time_limit,
            work,
        } = self;
        fn name(value: impl ValueEnum) -> String {
            value.to_possible_value().map(|value| value.get_name().into()).unwrap_or_default()
        }
        let all = [
            ("--distortion", distortion.to_string()),
            ("--charts", name(charts)),
            ("--straighten", name(straighten)),
            ("--snap", name(snap)),
            ("--stack", name(stack)),
            ("--stack-offset", stack_offset.to_string()),
            ("--packing", name(packing)),
            ("--prefer", name(prefer)),
            ("--hard-edges", name(hard_edges)),
            ("--size", size.to_string()),
            ("--padding", padding.to_string()),
            ("--rays", rays.to_string()),
            ("--search", search.to_string()),
            ("--seed", seed.to_string()),
        ];
        let limits = [
            ("--weld", weld.map(WeldArg::name)),
            ("--time-limit", time_limit.map(|limit| limit.to_string())),
            ("--work", work.map(work_words)),
        ];
        let limits = limits.into_iter().filter_map(|(flag, value)| Some((flag, value?)));
        all.into_iter().chain(limits).flat_map(|(flag, value)| [flag.into(), value]).collect()
    }

    /// The time limit.
    pub fn limit(self) -> Option<Duration> {
        self.time_limit.map(Duration::from_secs_f64)
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
                StraightenArg::Strips => pipeline::Straighten::Strips,
            },
            snap: match self.snap {
                SnapArg::Off => pipeline::Snap::Off,
                SnapArg::Texel => pipeline::Snap::Texel,
            },
            stack: match self.stack {
                StackArg::Off => pipeline::Stacking::Off,
                StackArg::Same => pipeline::Stacking::Same,
                StackArg::Mirrored => pipeline::Stacking::Mirrored,
            },
            stack_offset: self.stack_offset,
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
            weld: match self.weld {
                None => Weld::Equal,
                Some(WeldArg::Auto) => Weld::Auto,
                Some(WeldArg::Within(share)) => Weld::Within(share),
            },
            size: self.size,
            padding: self.padding,
            rays: self.rays,
            search: self.search,
            seed: self.seed,
            ends_early: self.time_limit.is_some(),
            work: self.work.unwrap_or(pipeline::CountedWork::ALL),
            ..pipeline::Settings::default()
        }
    }
}

/// CountedWork as [`work`] reads it: stages without a limit are left out.
pub fn work_words(work: pipeline::CountedWork) -> String {
    let pipeline::CountedWork { exposure, seams, pack } = work;
    let stages = [("exposure", exposure), ("seams", seams), ("pack", pack)];
    let stages = stages.iter().filter(|(_, limit)| *limit != u64::MAX);
    stages.map(|(name, limit)| format!("{name}={limit}")).collect::<Vec<_>>().join(",")
}

fn work(word: &str) -> Result<pipeline::CountedWork, String> {
    let mut work = pipeline::CountedWork::ALL;
    for part in word.split(',') {
        let (name, limit) = part.split_once('=').ok_or("write for example exposure=4096,seams=200000,pack=1")?;
        let stage = match name {
            "exposure" => &mut work.exposure,
            "seams" => &mut work.seams,
            "pack" => &mut work.pack,
            _ => return Err(format!("no stage '{name}' can end early; exposure, seams and pack can")),
        };
        *stage = limit.parse().map_err(|_| format!("'{limit}' is no count"))?;
    }
    Ok(work)
}

/// A time that can pass.
fn seconds(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(seconds) if seconds > 0.0 && seconds <= 1e7 => Ok(seconds),
        Ok(_) => Err("write seconds above 0 and up to 10000000".into()),
        Err(_) => Err("not a number; write for example 2.5".into()),
    }
}

/// The widest crack that is closed.
const WIDEST: f64 = 0.01;

/// Which cracks are closed.
fn weld(word: &str) -> Result<WeldArg, String> {
    if word == "auto" {
        return Ok(WeldArg::Auto);
    }
    crack(word).map(WeldArg::Within).map_err(|e| if word.parse::<f64>().is_ok() { e } else { format!("{e}, or auto") })
}

/// A share of the diagonal that cracks may have.
pub(super) fn crack(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(share) if share > 0.0 && share <= WIDEST => Ok(share),
        Ok(_) => Err(format!("a crack is wider than 0 and at most {WIDEST} of the mesh's diagonal; 1e-4 is usual")),
        Err(_) => Err("write a share of the mesh's diagonal, for example 1e-4".into()),
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
