//! `seamwright batch`: many files, a line of JSON for each.

use crate::args::batch::BatchArgs;
use crate::base::failure::Failure;
use crate::batch::items::items;
use crate::batch::run::run;
use seamwright_core::pipeline::Settings;

/// Runs `seamwright batch`.
pub fn batch(args: &BatchArgs) -> Result<(), Failure> {
    let Settings { size, padding, .. } = args.settings.to_core();
    if padding.saturating_mul(4) > size {
        let text = format!("--padding {padding}: too wide for --size {size}; a quarter of the size at the most");
        return Err(Failure::Usage(text));
    }
    run(args, &items(args)?)
}
