//! `seamwright check`: whether a written atlas keeps its rules, decided without rounding.

use crate::args::check::CheckArgs;
use crate::args::group::GroupArg;
use crate::base::counted::counted;
use crate::base::failure::Failure;
use crate::certificate::distance::Texels;
use crate::certificate::fault::Fault;
use crate::certificate::verdict::{MOST, Rules, verdict};
use crate::formats::format::Format;
use crate::formats::loaded::{Loaded, open};
use crate::formats::model::{Model, Piece};
use crate::formats::reading::Reading;
use crate::mesh::polygons::Mesh;
use std::io::{Write, stdout};
use std::path::{Path, PathBuf};

/// Faults that are printed.
const SHOWN: usize = 20;

/// Runs `seamwright check`.
pub fn check(args: &CheckArgs) -> Result<(), Failure> {
    let name = args.file.display();
    let is_stream = |path: &Path| path == Path::new("-");
    if is_stream(&args.file) && args.input.as_deref().is_some_and(is_stream) {
        return Err(Failure::Usage("--input -: standard input is the atlas already".into()));
    }
    let stream = args.format.as_deref().and_then(Format::named);
    let loaded = open(&args.file, stream, Reading { uv_set: args.uv_set, ..Reading::default() })?;
    loaded.check_set(args.uv_set)?;
    // As the file was read that was unwrapped.
    let copies = !Format::of(&args.file).or(stream).is_some_and(Format::has_instances);
    let read = |path: &PathBuf| open(path, stream, Reading { uv_set: args.uv_set, copies });
    let input = args.input.as_ref().map(read).transpose()?;
    let squares = squares(loaded.model(), args.group);
    let rules = Rules {
        squares: squares.as_deref(),
        gap: args.size.zip(args.padding).map(|(size, padding)| Texels { size, padding }),
        weld: args.weld,
        input: input.as_ref().map(|input| input.mesh()),
        stacks: args.stacked,
    };
    let mesh = loaded.polygons()?;
    let found = verdict(mesh, rules);
    let mut lines = lines(&found.faults, rules.input, &loaded).into_iter().map(|line| format!("{name}: {line}"));
    let mut lines: Vec<String> = lines.by_ref().take(SHOWN).collect();
    if found.faults.is_empty() {
        let told = |count: usize, what: &str| if count == 0 { String::new() } else { format!(", {count} {what}") };
        let (flat, turned) = (told(found.flat, "without area"), told(found.turned, "turned against their neighbours"));
        let stacked = told(found.stacked, "of charts that lie on others");
        lines.push(format!(
            "{name}: every rule is kept by {}{flat}{turned}{stacked} in {}",
            counted(found.faces, "polygon"),
            counted(found.charts, "chart")
        ));
    }
    let printed = lines.iter().try_for_each(|line| writeln!(stdout().lock(), "{line}"));
    printed.map_err(|e| Failure::output("standard output", Path::new("-"), &e))?;
    match found.faults.len() {
        0 => Ok(()),
        count => {
            let more = if count >= MOST { " or more" } else { "" };
            let shown = if lines.len() < count {
                format!(", the first {SHOWN} of them or their cause above")
            } else {
                String::new()
            };
            let breaches =
                if count == 1 { "1 breach of a rule".into() } else { format!("{count}{more} breaches of rules") };
            let is_stacked = !rules.stacks && verdict(mesh, Rules { stacks: true, ..rules }).faults.is_empty();
            let cure = if is_stacked { "with --stacked there is none" } else { "unwrap it again" };
            Err(Failure::Unreached(format!("{name}: {breaches}{shown}; {cure}")))
        }
    }
}

/// A line for each fault; where many have one cause, that alone.
fn lines(faults: &[Fault], input: Option<&Mesh>, loaded: &Loaded) -> Vec<String> {
    let of_mesh = |fault: &&Fault| matches!(fault, Fault::Missing(_) | Fault::Changed(_) | Fault::Added(_));
    let (count, polygons) = (faults.iter().filter(of_mesh).count(), loaded.mesh().polygon_count());
    let mut lines = Vec::new();
    let is_another = count >= SHOWN || count > 1 && count >= polygons;
    if let (true, Some(input)) = (is_another, input) {
        lines.push(format!(
            "another mesh than --input: {} here, {} there, and from face {} on they differ",
            counted(polygons, "polygon"),
            counted(input.polygon_count(), "polygon"),
            faults.iter().find(of_mesh).map_or(0, |fault| fault.face())
        ));
    }
    let bare = faults.iter().filter(|fault| matches!(fault, Fault::Unmapped(_))).count();
    let is_bare = bare > 0 && (loaded.mesh().corner_uv.is_none() || bare >= polygons.min(MOST));
    if is_bare {
        lines.push("no face has UVs".into());
    }
    let told = |fault: &&Fault| !(is_another && of_mesh(fault) || is_bare && matches!(fault, Fault::Unmapped(_)));
    lines.extend(faults.iter().filter(told).map(Fault::to_string));
    lines
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
