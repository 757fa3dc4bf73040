//! From polygons to a UV atlas and to parts: the one room that knows the order of the stages.

mod alike;
mod decimal;
mod early;
mod exact;
mod exposure;
pub mod fitting;
mod forced;
pub mod input;
mod kept;
pub mod learning;
mod mend;
pub mod neural;
mod nodes;
pub mod order;
pub mod partition;
pub mod pieces;
pub mod polygons;
pub mod published;
pub mod report;
pub mod settings;
mod stacks;
mod tears;
mod training;
pub mod unwrap;

pub use input::{Input, Output};
pub use report::{Report, UnwrapError};
pub use settings::{Charts, CountedWork, Packing, Settings, Snap, Stacking, Straighten};
pub use unwrap::{Method, need_for, unwrap, unwrap_by, unwrap_need};
