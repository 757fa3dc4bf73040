//! `seamwright transfer`: the atlas of one mesh on another mesh of the same shape.

use crate::args::transfer::TransferArgs;
use crate::base::counted::counted;
use crate::base::failure::Failure;
use crate::files::drafts::Drafts;
use crate::files::paths::is_stdout;
use crate::formats::format::Format;
use crate::formats::loaded::{Loaded, open};
use crate::formats::reading::Reading;
use crate::formats::target::{Mapping, Target};
use crate::jobs::outputs::{
    NamedOutput, add_mesh, check_writable, publish, refuse_clashes, refuse_over, refuse_over_named, refuse_two_streams,
    report_failure,
};
use crate::jobs::target::target;
use crate::picture::drawing::Drawing;
use crate::report::asked::InputReport;
use crate::report::document::StageReport;
use crate::report::transfer::{CarriedReport, warnings};
use crate::run::progress::{Reporter, Show};
use crate::run::threads::Pool;
use crate::run::transferred::{CarriedAtlas, make};
use seamwright_core::transfer::report::TransferReport;
use std::path::Path;
use std::time::Instant;

/// Runs `seamwright transfer`.
pub fn transfer(args: &TransferArgs) -> Result<(), Failure> {
    let target = target(&args.writing, &args.mesh)?;
    check_paths(args, &target)?;
    let carried =
        carry(args, &target).inspect_err(|failure| report_failure(args.json.as_deref(), &args.mesh, failure))?;
    missed(&args.mesh, &carried).map_or(Ok(()), |text| Err(Failure::Unreached(text)))
}

/// The whole run, with the atlas written.
fn carry(args: &TransferArgs, target: &Target) -> Result<TransferReport, Failure> {
    let start = Instant::now();
    let stream = args.writing.format.as_deref().and_then(Format::named);
    let reading = Reading { uv_set: target.uv_set, copies: !target.format.has_instances() };
    let source = open(&args.source, stream, reading)?;
    let mesh = open(&args.mesh, stream, reading)?;
    refuse_over_named(&outputs(args), &source)?;
    refuse_over_named(&outputs(args), &mesh)?;
    let mut reporter = Reporter::new(Show::fitting(args.run.quiet));
    let pool = Pool::new(args.run.threads.map(usize::from))
        .map_err(|e| Failure::Unreached(format!("--threads: cannot start them: {e}; ask for fewer")))?;
    let named = |loaded: &Loaded, all: &[String]| -> Vec<String> {
        all.iter().map(|w| format!("{}: {w}", loaded.path.display())).collect()
    };
    let mut told = named(&source, source.warnings());
    told.extend(named(&mesh, mesh.warnings()));
    told.extend(named(&mesh, &mesh.check(target)?));
    let atlas = pool.enter(|| make(&source, &mesh, args.size, &pool, &mut reporter))?;
    told.extend(warnings(&source, &mesh, &atlas.report));
    let stages = reporter.finish().iter().map(StageReport::from).collect();
    let mut drafts = Drafts::new();
    let files = mesh.files(target, Mapping { corner_uv: &atlas.corner_uv, groups: None })?;
    told.extend(named(&mesh, &files.warnings));
    add_mesh(&mut drafts, target, files)?;
    told.iter().for_each(|w| reporter.say(&format!("warning: {w}")));
    if let Some(path) = &args.sheet {
        let picture = draw(&mesh, &atlas, &pool);
        drafts.add("--sheet", path, |out| out.write_all(&picture))?;
    }
    let report = CarriedReport {
        version: env!("CARGO_PKG_VERSION"),
        source: InputReport::new(&source),
        input: InputReport::new(&mesh),
        output: target.path.display().to_string(),
        size: args.size,
        result: (&atlas.report).into(),
        stages,
        seconds: start.elapsed().as_secs_f64(),
        warnings: told,
    };
    publish(drafts, args.json.as_deref(), &report)?;
    let done = &report.result;
    reporter.say(&format!(
        "{}: {}, {:.1} % of the surface within two texels, {} moved, {:.2} s",
        report.output,
        counted(done.charts, "chart"),
        100.0 * done.within_two_texels,
        counted(done.moved_faces, "face"),
        report.seconds
    ));
    Ok(atlas.report)
}

/// No output may fall on another, nor one but the mesh's on an input.
fn check_paths(args: &TransferArgs, target: &Target) -> Result<(), Failure> {
    if args.source.as_os_str() == "-" && args.mesh.as_os_str() == "-" {
        return Err(Failure::Usage("-: standard input holds one mesh; name a file for the other".into()));
    }
    refuse_two_streams(target, args.json.as_deref())?;
    let outputs = outputs(args);
    refuse_over(&outputs, "the mesh with the atlas", &args.source)?;
    refuse_over(&outputs[1..], "the mesh", &args.mesh)?;
    refuse_clashes(&outputs)?;
    let sheet = args.sheet.as_deref();
    if let Some(path) = sheet.filter(|path| !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"))) {
        return Err(Failure::Usage(format!("--sheet {}: name a file that ends in .png", path.display())));
    }
    check_writable(&outputs)
}

/// The outputs that are named, the mesh first.
fn outputs(args: &TransferArgs) -> [NamedOutput<'_>; 3] {
    let json = args.json.as_deref().filter(|path| !is_stdout(path));
    [("-o", Some(args.writing.output.as_path())), ("--sheet", args.sheet.as_deref()), ("--json", json)]
}

fn draw(mesh: &Loaded, atlas: &CarriedAtlas, pool: &Pool) -> Vec<u8> {
    let drawing = Drawing {
        title: format!("{}  {:.3} within two texels", mesh.name(), atlas.report.within_two_texels),
        mesh: mesh.mesh(),
        corner_uv: &atlas.corner_uv,
        polygon_chart: Some(&atlas.polygon_chart),
        exposure: None,
    };
    drawing.png(pool)
}

/// Share of the surface within two texels below which the texture is as good as another mesh's.
const LOST: f64 = 0.5;

/// What to say where the atlas breaks a rule that the source's keeps, or the texture is lost. It is written all the same.
fn missed(mesh: &Path, done: &TransferReport) -> Option<String> {
    let mesh = mesh.display();
    let share = 100.0 * done.within_two_texels;
    if !done.copied && done.flipped > 0 || done.overlapping > done.source_overlapping {
        let why = match done.small {
            0 => "they are larger than the charts leave room for".into(),
            small => format!(
                "{} of pieces too small to see, as of flaps, lie upon others: remove those",
                counted(small, "face")
            ),
        };
        let (flipped, overlapping) = (counted(done.flipped, "face"), done.overlapping);
        return Some(format!(
            "{mesh}: the atlas is written, but {flipped} flipped and {overlapping} overlapping; {why}"
        ));
    }
    (done.within_two_texels < LOST).then(|| {
        format!("{mesh}: the atlas is written, but only {share:.1} % of the surface keeps its texels: it is another shape, or too coarse")
    })
}
