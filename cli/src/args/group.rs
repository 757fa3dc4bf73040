//! What shares an atlas, as asked.

use clap::ValueEnum;

/// What shares an atlas.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum GroupArg {
    /// Everything: one atlas
    Scene,
    /// Each mesh of a glTF, each object of an OBJ: an atlas each
    Mesh,
    /// Each primitive of a glTF, each material of an object of an OBJ: an atlas each
    Primitive,
}

impl GroupArg {
    /// As on the command line.
    pub fn name(self) -> &'static str {
        match self {
            GroupArg::Scene => "scene",
            GroupArg::Mesh => "mesh",
            GroupArg::Primitive => "primitive",
        }
    }
}
