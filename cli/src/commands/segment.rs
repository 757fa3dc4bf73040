//! `seamwright segment`: a mesh in, a label for each of its faces out.

use crate::args::parts::PartsArg;
use crate::args::segment::SegmentArgs;
use crate::base::failure::Failure;
use crate::files::drafts::Drafts;
use crate::formats::labels::{kind::LabelKind, write::write};
use crate::formats::loaded::load;
use crate::jobs::outputs::{check_writable, refuse_clashes, refuse_over};
use crate::picture::parts::PartsDrawing;
use crate::run::parts::find;
use crate::run::progress::{Reporter, Show};
use crate::run::stop::stop_requested;
use crate::run::threads::Pool;

/// Runs `seamwright segment`.
pub fn segment(args: &SegmentArgs) -> Result<(), Failure> {
    let shown = args.output.display();
    let Some(kind) = LabelKind::of(&args.output) else {
        return Err(Failure::Usage(format!("-o {shown}: name a file that ends in .seg, .json, .ply or .glb")));
    };
    let outputs = [("-o", Some(args.output.as_path())), ("--sheet", args.sheet.as_deref())];
    refuse_over(&outputs, "the mesh", &args.mesh)?;
    refuse_clashes(&outputs)?;
    if let Some(sheet) =
        args.sheet.as_deref().filter(|path| !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")))
    {
        return Err(Failure::Usage(format!("--sheet {}: name a file that ends in .png", sheet.display())));
    }
    check_writable(&outputs)?;
    let loaded = load(&args.mesh)?;
    let mut reporter = Reporter::new(Show::fitting(args.run.quiet));
    let pool = Pool::new(args.run.threads.map(usize::from))
        .map_err(|e| Failure::Unreached(format!("--threads: cannot start them: {e}; ask for fewer")))?;
    loaded.warnings().iter().for_each(|w| reporter.say(&format!("warning: {}: {w}", loaded.path.display())));
    // The flag of this command has no `off`.
    let settings = args.parts.to_core(args.seed).unwrap_or_default();
    let parts = find(&loaded, settings, &pool, &mut reporter)?;
    reporter.finish();
    let mesh = loaded.mesh();
    let mut drafts = Drafts::new();
    drafts.add("-o", &args.output, |out| write(out, kind, mesh, &parts.part))?;
    if let Some(path) = &args.sheet {
        let title = format!("{}  {} parts", loaded.name(), parts.count);
        let picture = PartsDrawing { title, mesh, part: &parts.part, diameter: &parts.diameter }.png(&pool);
        drafts.add("--sheet", path, |out| out.write_all(&picture))?;
    }
    if stop_requested() {
        return Err(Failure::Stopped);
    }
    drafts.publish()?;
    reporter.say(&format!("{shown}: {} parts", parts.count));
    match args.parts {
        PartsArg::Count(wanted) if wanted as usize != parts.count => Err(Failure::Unreached(format!(
            "--parts {wanted}: the labels are written, but there are {} parts; each piece of the mesh is one at least, and each part has a face",
            parts.count
        ))),
        _ => Ok(()),
    }
}
