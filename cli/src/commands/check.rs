//! `seamwright check`: whether a written atlas keeps its rules, decided without rounding.

use crate::args::check::CheckArgs;
use crate::args::group::GroupArg;
use crate::base::failure::Failure;
use crate::certificate::distance::Texels;
use crate::certificate::verdict::{MOST, Rules, verdict};
use crate::formats::format::Format;
use crate::formats::loaded::open;
use crate::formats::model::{Model, Piece};
use crate::formats::reading::Reading;
use std::io::{Write, stdout};
use std::path::{Path, PathBuf};

/// Faults that are printed.
const SHOWN: usize = 20;

/// Runs `seamwright check`.
pub fn check(args: &CheckArgs) -> Result<(), Failure> {
    let name = args.file.display();
    let stream = args.format.as_deref().and_then(Format::named);
    let loaded = open(&args.file, stream, Reading { uv_set: args.uv_set, ..Reading::default() })?;
    // As the file was read that was unwrapped.
    let copies = !Format::of(&args.file).or(stream).is_some_and(Format::has_instances);
    let read = |path: &PathBuf| open(path, stream, Reading { uv_set: args.uv_set, copies });
    let input = args.input.as_ref().map(read).transpose()?;
    let squares = squares(loaded.model(), args.group);
    let rules = Rules {
        squares: squares.as_deref(),
        gap: args.size.zip(args.padding).map(|(size, padding)| Texels { size, padding }),
        input: input.as_ref().map(|input| input.mesh()),
    };
    let found = verdict(loaded.polygons()?, rules);
    let mut lines: Vec<String> = found.faults.iter().take(SHOWN).map(|fault| format!("{name}: {fault}")).collect();
    if found.faults.is_empty() {
        let told = |count: usize, what: &str| if count == 0 { String::new() } else { format!(", {count} {what}") };
        let (flat, turned) = (told(found.flat, "without area"), told(found.turned, "turned against their neighbours"));
        lines.push(format!(
            "{name}: every rule is kept by {} faces{flat}{turned} in {} charts",
            found.faces, found.charts
        ));
    }
    let printed = lines.iter().try_for_each(|line| writeln!(stdout().lock(), "{line}"));
    printed.map_err(|e| Failure::output("standard output", Path::new("-"), &e))?;
    match found.faults.len() {
        0 => Ok(()),
        count => {
            let more = if count >= MOST { " or more" } else { "" };
            Err(Failure::Unreached(format!(
                "{name}: {count}{more} breaches of rules, the first {SHOWN} above; unwrap it again"
            )))
        }
    }
}

/// A number for each polygon, the same for those that share a unit square.
fn squares(model: &Model, group: GroupArg) -> Option<Vec<u32>> {
    let number = |piece: &Piece| match group {
        GroupArg::Scene => None,
        GroupArg::Mesh => Some(piece.mesh),
        GroupArg::Primitive => Some(piece.primitive),
    };
    let mut squares = vec![u32::MAX; model.mesh.polygon_count()];
    for (piece, polygons) in model.runs() {
        squares[polygons].fill(number(piece)?);
    }
    (group != GroupArg::Scene).then_some(squares)
}
