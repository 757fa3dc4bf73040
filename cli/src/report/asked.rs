//! What went in and what was asked, for the report.

use crate::args::method::MethodArg;
use crate::args::settings::work_words;
use crate::formats::loaded::Loaded;
use seamwright_core::mesh::cracks::Weld;
use seamwright_core::pipeline::{Charts, CountedWork, Packing, Settings, Snap, Stacking, Straighten};
use seamwright_core::price::cost::Prefer;
use seamwright_core::price::given::HardEdges;
use serde::Serialize;

/// What was read.
#[derive(Debug, Serialize)]
pub struct InputReport {
    /// Path as given.
    pub file: String,
    /// Vertices of the file, merged or not.
    pub vertices: usize,
    /// Polygons of three or more corners.
    pub polygons: usize,
    /// Corners of these polygons.
    pub corners: usize,
    /// Whether it had UVs.
    pub has_uv: bool,
}

/// What was asked.
#[derive(Debug, Serialize)]
#[expect(missing_docs, reason = "the names are the command line's")]
pub struct SettingsReport {
    pub method: &'static str,
    pub distortion: f64,
    pub charts: &'static str,
    pub straighten: &'static str,
    pub snap: &'static str,
    pub stack: &'static str,
    pub stack_offset: u32,
    pub packing: &'static str,
    pub prefer: &'static str,
    pub hard_edges: &'static str,
    pub weld: String,
    pub size: u32,
    pub padding: u32,
    pub rays: u32,
    pub search: u32,
    pub seed: u64,
    pub time_limit: Option<f64>,
    pub work: Option<String>,
    pub group: &'static str,
    pub uv_set: u32,
    pub parts: String,
    pub keep_seams: bool,
    pub threads: usize,
}

impl InputReport {
    /// What was read.
    pub fn new(loaded: &Loaded) -> Self {
        let mesh = loaded.mesh();
        Self {
            file: loaded.path.display().to_string(),
            vertices: mesh.positions.len(),
            polygons: mesh.polygon_count(),
            corners: mesh.corners.len(),
            has_uv: mesh.corner_uv.is_some(),
        }
    }
}

impl SettingsReport {
    /// What was asked.
    pub fn new(method: MethodArg, settings: &Settings, keep_seams: bool, threads: usize) -> Self {
        Self {
            method: method.name(),
            distortion: settings.distortion,
            charts: match settings.charts {
                Charts::Few => "few",
                Charts::One => "one",
            },
            straighten: match settings.straighten {
                Straighten::Off => "off",
                Straighten::Auto => "auto",
                Straighten::Strips => "strips",
            },
            snap: match settings.snap {
                Snap::Off => "off",
                Snap::Texel => "texel",
            },
            stack: match settings.stack {
                Stacking::Off => "off",
                Stacking::Same => "same",
                Stacking::Mirrored => "mirrored",
            },
            stack_offset: settings.stack_offset,
            packing: match settings.packing {
                Packing::Tight => "tight",
                Packing::Grid => "grid",
            },
            prefer: match settings.prefer {
                Prefer::Seams => "seams",
                Prefer::Balance => "balance",
                Prefer::Fill => "fill",
            },
            hard_edges: match settings.hard_edges {
                HardEdges::Prefer => "prefer",
                HardEdges::Require => "require",
                HardEdges::Off => "off",
            },
            weld: match settings.weld {
                Weld::Equal => "off".into(),
                Weld::Within(share) => share.to_string(),
                Weld::Auto => "auto".into(),
            },
            size: settings.size,
            padding: settings.padding,
            rays: settings.rays,
            search: settings.search,
            seed: settings.seed,
            time_limit: None,
            work: (settings.work != CountedWork::ALL).then(|| work_words(settings.work)),
            group: "scene",
            uv_set: 0,
            parts: "off".into(),
            keep_seams,
            threads,
        }
    }
}
