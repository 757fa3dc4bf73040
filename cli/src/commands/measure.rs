//! `seamwright measure`: figures of UV-mapped meshes, whatever tool made them.
//!
//! With `--reference` it also says how far the file's charts, or labels, agree with other partitions of its faces.
//! A file that cannot be measured is named and left out; the command then ends with that file's exit code.

use crate::args::measure::{MeasureArgs, Sky};
use crate::base::failure::Failure;
use crate::figures::agreement::{self, AgreementRecord};
use crate::figures::exposure::{ExposureError, vertex_exposure};
use crate::figures::measure;
use crate::figures::record::{AtlasRecord, json};
use crate::figures::sampled::{SampledExposure, Weighting};
use crate::figures::table::table;
use crate::formats::format::Format;
use crate::formats::labels::read as labels;
use crate::formats::loaded::{Loaded, open};
use crate::formats::reading::Reading;
use crate::mesh::polygons::NO_UV;
use crate::mesh::view::PolygonView;
use crate::run::progress::{Reporter, Show};
use crate::run::threads::Pool;
use glam::DVec2;
use seamwright_core::base::progress::{Progress, Stage};
use std::io::{Write, stderr, stdout};
use std::path::{Path, PathBuf};

/// Runs `seamwright measure`.
pub fn measure(args: &MeasureArgs) -> Result<(), Failure> {
    if !args.reference.is_empty() && args.files.len() > 1 {
        let text =
            format!("--reference: labels are those of one mesh, but {} files are given; name one", args.files.len());
        return Err(Failure::Usage(text));
    }
    let pool = Pool::new(None).map_err(|e| Failure::Unreached(format!("cannot start threads: {e}")))?;
    // Lines of time a file would be noise beside the table.
    let show = if Show::fitting(false) == Show::Bar { Show::Bar } else { Show::Nothing };
    let (mut records, mut failures) = (vec![], vec![]);
    for path in &args.files {
        match measure_file(path, args, &pool, &mut Reporter::new(show)) {
            Ok(record) => records.push(record),
            Err(Failure::Stopped) => return Err(Failure::Stopped),
            Err(failure) => failures.push(failure),
        }
    }
    if !records.is_empty() {
        let text = match (args.json, args.files.len()) {
            (true, 1) => json(&records[0]),
            (true, _) => json(&records),
            (false, _) => {
                let agreement: String =
                    records.iter().flat_map(|r| &r.agreement).map(|a| format!("\n\n{}", agreement::table(a))).collect();
                format!("{}{agreement}\n\n{}", table(&records), foot(args))
            }
        };
        let printed = writeln!(stdout().lock(), "{text}");
        printed.map_err(|e| Failure::output("standard output", Path::new("-"), &e))?;
    }
    let last = failures.pop();
    // Nobody may be left to read it; the code still tells.
    failures.iter().for_each(|failure| writeln!(stderr(), "seamwright: {failure}").unwrap_or_default());
    last.map_or(Ok(()), Err)
}

fn measure_file(path: &Path, args: &MeasureArgs, pool: &Pool, reporter: &mut Reporter) -> Result<AtlasRecord, Failure> {
    let stream = args.format.as_deref().and_then(Format::named);
    let loaded = open(path, stream, Reading { uv_set: args.uv_set, ..Reading::default() })?;
    loaded.check_set(args.uv_set)?;
    // Labels can be compared on a mesh without UVs.
    let uv = if args.labels.is_some() { loaded.polygons()?.corner_uv.as_deref() } else { Some(loaded.mapped()?.1) };
    let mesh = loaded.polygons()?;
    let agreement = agree(&loaded, uv, args)?;
    let weighting = match args.exposure {
        Sky::Uniform => Some(Weighting::Uniform),
        Sky::Cosine => Some(Weighting::Cosine),
        Sky::None => None,
    };
    let values = weighting
        .map(|w| {
            let report = &mut |done, all| reporter.report(Stage::Exposure, done, all);
            vertex_exposure(mesh, w, args.rays as usize, pool, report)
        })
        .transpose()
        .map_err(|e| match e {
            ExposureError::Stopped => Failure::Stopped,
            ExposureError::Tree(e) => unmeasured(path, &e),
        })?;
    reporter.finish();
    let exposure = values.as_deref().zip(weighting).map(|(values, weighting)| SampledExposure { values, weighting });
    let none = vec![NO_UV; mesh.corners.len()];
    let polygons = PolygonView {
        positions: &mesh.positions,
        corners: &mesh.corners,
        polygon_start: &mesh.polygon_start,
        corner_uv: Some(uv.unwrap_or(&none)),
    };
    let record = measure::measure(&path.display().to_string(), polygons, exposure, args.resolution)
        .map_err(|e| unmeasured(path, &e))?;
    Ok(AtlasRecord { agreement, ..record })
}

/// How the charts, or `--labels`, agree with the references; `None` where there are none.
fn agree(loaded: &Loaded, uv: Option<&[DVec2]>, args: &MeasureArgs) -> Result<Option<AgreementRecord>, Failure> {
    if args.reference.is_empty() {
        return Ok(None);
    }
    let (mesh, path) = (loaded.mesh(), &loaded.path);
    let read = |file: &PathBuf| Ok((file.display().to_string(), labels::read("--reference", file, mesh, path)?));
    let references = args.reference.iter().map(read).collect::<Result<Vec<_>, Failure>>()?;
    let (compared, ours) = match (&args.labels, uv) {
        (Some(file), _) => (file.display().to_string(), labels::read("--labels", file, mesh, path)?.label),
        (None, uv) => {
            let charts = agreement::charts(mesh, uv.unwrap_or_default()).map_err(|e| unmeasured(path, &e))?;
            ("charts".to_string(), charts)
        }
    };
    agreement::compare(&compared, &ours, &references, mesh).map(Some).map_err(|e| unmeasured(path, &e))
}

/// How the sampled figures of the table came about.
fn foot(args: &MeasureArgs) -> String {
    let MeasureArgs { rays, resolution, .. } = args;
    let exposure = match args.exposure {
        Sky::Uniform => {
            format!("exposure: {rays} rays a vertex, every direction alike (--exposure cosine: as light falls in)")
        }
        Sky::Cosine => {
            format!("exposure: {rays} rays a vertex, weighed by the cosine (--exposure uniform: as libigl does)")
        }
        Sky::None => "exposure: not asked for (--exposure uniform or cosine)".to_string(),
    };
    let coverage = match resolution {
        0 => "fill: not asked for (--resolution)".to_string(),
        _ => format!("fill: share of the box of the UVs at {resolution} x {resolution} texels"),
    };
    let agreement = match args.reference.len() {
        0 => "",
        _ => {
            "\nhamming: share that differs after the best matching of labels; directional: mean of missing and false alarm, by area"
        }
    };
    format!(
        "{exposure}\n{coverage}{agreement}\n\
        seam, visible, noticed: length over sqrt(area), times exposure, and times what a break of the surface leaves to see\n\
        flat, sharp: share of the seams where the surface turns by less than 1 degree, by more than 35; \
        ratio: exposure of seams over that of all edges\n\
        no disk: charts with holes too; no plane: charts that are closed or have a handle"
    )
}

fn unmeasured(path: &Path, error: &dyn core::fmt::Display) -> Failure {
    Failure::Unreached(format!("{}: cannot be measured: {error}", path.display()))
}
