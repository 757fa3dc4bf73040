//! What core's errors mean for the user.

use crate::base::failure::Failure;
use crate::formats::loaded::Loaded;
use seamwright_core::pipeline::UnwrapError;

/// Why there is no atlas of `loaded`, and what to do.
pub(super) fn refusal(loaded: &Loaded, error: UnwrapError) -> Failure {
    match error {
        UnwrapError::Cancelled => Failure::Stopped,
        UnwrapError::Overlap { .. } => Failure::Unreached(format!(
            "{}: {error}; nothing is written; please report the mesh",
            loaded.path.display()
        )),
        UnwrapError::Scratch(e) => Failure::Unreached(format!("{}: {e}; please report this", loaded.path.display())),
        other => Failure::Input(format!("{}: {other}; repair the mesh", loaded.path.display())),
    }
}
