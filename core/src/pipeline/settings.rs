//! What the user can ask for.

use crate::mesh::cracks::Weld;
use crate::pack::settings::{Mode, PackSettings};
use crate::price::cost::Prefer;
use crate::price::given::HardEdges;

/// How many charts a connected component may have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Charts {
    /// As many as hide the seams best.
    #[default]
    Few,
    /// One, where overlap-free flattening and the bound allow it.
    One,
}

/// How charts are placed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Packing {
    /// Equal texel density, rotations, shapes in one another's gaps.
    #[default]
    Tight,
    /// One cell of a square grid a chart, each scaled to its cell.
    Grid,
}

/// Whether strips become rectangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Straighten {
    /// They stay as they have least distortion.
    Off,
    /// Where a chart is a strip and the bound allows.
    #[default]
    Auto,
    /// Strips between sharp edges are charts of their own too, whatever is noticed of the cuts.
    Strips,
}

/// Whether charts are fitted to the texture's texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Snap {
    /// They lie where packing puts them.
    #[default]
    Off,
    /// Straight borders that run along an axis lie on the edges of texels, where the bound allows. Charts are packed one texel farther
    /// apart, of which that may take as much.
    Texel,
}

/// Whether pieces that are alike share texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stacking {
    /// Each has its own.
    #[default]
    Off,
    /// Those that are the same shape moved lie over one another.
    Same,
    /// Mirror images do too, and the halves of what is its own mirror image.
    Mirrored,
}

/// What the user can ask for.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Bound on the mean symmetric Dirichlet energy over 4 (1 is an isometry); above 1.
    pub distortion: f64,
    /// Charts a component.
    pub charts: Charts,
    /// Whether the side of a cylinder, a pipe, a belt becomes a rectangle.
    pub straighten: Straighten,
    /// Whether charts are fitted to texels.
    pub snap: Snap,
    /// Whether pieces that are alike share texels.
    pub stack: Stacking,
    /// Units of the square by which all but the first of a stack lie to the right, as bakers of normal maps want it.
    pub stack_offset: u32,
    /// Placement.
    pub packing: Packing,
    /// Texture side in texels, for the padding.
    pub size: u32,
    /// Empty texels between charts, and at the border of the square.
    pub padding: u32,
    /// Search work of tight packing: 0 only fills, 1 takes up to a second of a desktop's core, a microcontroller wants
    /// 0.05. Charts of 13 atlases fill .7285 with 0.8 in 0.59 s of user time.
    pub effort: f64,
    /// Exposure rays a vertex.
    pub rays: u32,
    /// Which borders are welded in the working copy. A crack at a break of the shading stays a cut, unless `hard_edges` is off.
    pub weld: Weld,
    /// What is made of shading breaks in [`super::input::Input::edges`].
    pub hard_edges: HardEdges,
    /// What is given up where seams and fill are at odds.
    pub prefer: Prefer,
    /// Trials of ruin and recreate beyond those of any search, on the mesh, or the coarse one that it is cut by. Noticed seams become
    /// shorter; see docs/RESULTS.md.
    pub search: u32,
    /// Seed of every random value.
    pub seed: u64,
    /// Whether the caller may want stages to end early ([`Wish::Finish`](crate::base::progress::Wish::Finish), with an alarm): the exact
    /// method then keeps a copy of what it falls back to.
    pub ends_early: bool,
    /// Where stages end that would go on, for the exact method.
    pub work: CountedWork,
}

/// Counted work of the stages that can end early. Up to what a [report](super::report::Report) says was done, another run of the same input gives the
/// same atlas, on any machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CountedWork {
    /// Vertices whose exposure is cast.
    pub exposure: u64,
    /// Faces that the search for seams goes through, counted anew in each round.
    pub seams: u64,
    /// Improvements in packing.
    pub pack: u64,
}

impl CountedWork {
    /// No limit.
    pub const ALL: Self = Self { exposure: u64::MAX, seams: u64::MAX, pack: u64::MAX };

    /// That of stages which ended early: exposure, seams, pack. Nothing where none did.
    pub(super) fn of(stages: [Option<u64>; 3]) -> Option<Self> {
        let [exposure, seams, pack] = stages.map(|work| work.unwrap_or(u64::MAX));
        stages.iter().any(Option::is_some).then_some(Self { exposure, seams, pack })
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            distortion: 1.025,
            charts: Charts::Few,
            straighten: Straighten::Auto,
            snap: Snap::Off,
            stack: Stacking::Off,
            stack_offset: 0,
            packing: Packing::Tight,
            size: 1024,
            padding: 2,
            effort: 1.0,
            rays: 128,
            weld: Weld::Equal,
            hard_edges: HardEdges::Prefer,
            prefer: Prefer::Balance,
            search: 0,
            seed: 0,
            ends_early: false,
            work: CountedWork::ALL,
        }
    }
}

impl Settings {
    /// Whether a stage may end early.
    pub(super) fn can_end_early(&self) -> bool {
        self.ends_early || self.work != CountedWork::ALL
    }

    /// What packing is asked for.
    pub(super) fn pack(&self) -> PackSettings {
        let mode = match self.packing {
            Packing::Tight => Mode::Tight,
            Packing::Grid => Mode::Grid,
        };
        PackSettings {
            size: self.size,
            padding: self.padding.saturating_add(u32::from(self.snap == Snap::Texel)),
            mode,
            seed: self.seed,
            effort: self.effort,
            steps: u32::MAX,
        }
    }
}
