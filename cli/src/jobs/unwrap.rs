//! Does a job: loads, unwraps, writes, reports.

use super::job::{Job, PartsSource};
use crate::args::method::MethodArg;
use crate::base::failure::Failure;
use crate::figures::measure::measure;
use crate::figures::record::AtlasRecord;
use crate::figures::sampled::{SampledExposure, Weighting};
use crate::files::drafts::Drafts;
use crate::files::paths::is_stdout;
use crate::formats::labels::read as labels;
use crate::formats::loaded::Loaded;
use crate::formats::target::Mapping;
use crate::mesh::view::PolygonView;
use crate::picture::{curves, drawing::Drawing};
use crate::report::asked::{InputReport, SettingsReport};
use crate::report::document::{RunReport, StageReport};
use crate::report::learning::LearningReport;
use crate::report::parts::{groups, tree};
use crate::report::result::ResultReport;
use crate::run::atlas::{self, Atlas};
use crate::run::parts::{self, MeshParts};
use crate::run::progress::{Reporter, Show};
use crate::run::stop::stop_requested;
use crate::run::threads::Pool;
use crate::training::map_file;
use seamwright_core::judge::measure::RESOLUTION;
use std::io::stdout;
use std::time::Instant;

/// How far over the bound still counts as reached: UVs on a grid of 2^-24 move the mean by about 1e-7.
const BOUND_SLACK: f64 = 1e-6;

impl Job {
    /// Loads, unwraps, writes, reports. Nothing is written unless everything can be.
    pub fn run(&self, load: impl FnOnce() -> Result<Loaded, Failure>) -> Result<(), Failure> {
        let start = Instant::now();
        self.check_outputs()?;
        let loaded = load()?;
        let mut reporter = Reporter::new(Show::fitting(self.run.quiet));
        let mut warnings = loaded.warnings().to_vec();
        warnings.extend(loaded.check(&self.target)?);
        let pool = Pool::new(self.run.threads.map(usize::from))
            .map_err(|e| Failure::Unreached(format!("--threads: cannot start them: {e}; ask for fewer")))?;
        warnings.iter().for_each(|w| reporter.say(&format!("warning: {}: {w}", loaded.path.display())));
        let parts = self.find_parts(&loaded, &pool, &mut reporter)?;
        let part = parts.as_ref().map(|parts| &parts.part[..]);
        let mut trainer = self.learning.clone();
        let atlas = pool.enter(|| {
            atlas::make_by(
                self.method,
                trainer.as_mut(),
                &loaded,
                part,
                self.keep_seams,
                &self.settings,
                &pool,
                &mut reporter,
            )
        })?;
        if let Some(trainer) = trainer.as_ref().filter(|t| t.summary.was_stopped) {
            let text =
                format!("training was stopped after {} steps; the best maps so far are used", trainer.summary.steps);
            reporter.say(&format!("warning: {}: {text}", loaded.path.display()));
            warnings.push(text);
        }
        let stages = reporter.finish().iter().map(StageReport::from).collect();
        let result = ResultReport::new(&atlas);
        for warning in result.warnings() {
            reporter.say(&format!("warning: {}: {warning}", loaded.path.display()));
            warnings.push(warning);
        }
        let missed = self.missed(&atlas);
        warnings.extend(missed.clone());

        let mut drafts = Drafts::new();
        let groups = self.groups.then(|| groups(parts.as_ref(), &atlas));
        let files = loaded.files(&self.target, Mapping { corner_uv: &atlas.corner_uv, groups: groups.as_ref() })?;
        files.warnings.iter().for_each(|w| reporter.say(&format!("warning: {}: {w}", loaded.path.display())));
        warnings.extend(files.warnings);
        for (path, bytes) in &files.beside {
            drafts.add_below("-o", path, |out| out.write_all(bytes))?;
        }
        drafts.add("-o", &self.target.path, files.main)?;
        if let Some(path) = &self.sheet {
            let picture = draw(&loaded, &atlas, &pool);
            drafts.add("--sheet", path, |out| out.write_all(&picture))?;
        }
        if let (Some(path), Some(trainer)) = (&self.save_map, &trainer) {
            drafts.add("--save-map", path, |out| map_file::write(out, trainer))?;
        }
        if let (Some(path), Some(trainer)) = (&self.curves, &trainer) {
            let picture = curves::png(&loaded.name(), trainer.samples(), &trainer.settings);
            drafts.add("--curves", path, |out| out.write_all(&picture))?;
        }
        let seconds = start.elapsed().as_secs_f64();
        let report = RunReport {
            version: env!("CARGO_PKG_VERSION"),
            input: InputReport::new(&loaded),
            output: self.target.path.display().to_string(),
            settings: SettingsReport {
                parts: self.parts.name(),
                ..SettingsReport::new(self.method, &self.settings, self.keep_seams, pool.count())
            },
            result,
            parts: parts.as_ref().map(|parts| tree(parts, &atlas)),
            learning: trainer.as_ref().map(LearningReport::new),
            metrics: self.json.as_ref().map(|_| self.metrics(&loaded, &atlas)).transpose()?,
            stages,
            seconds,
            warnings,
        };
        self.publish(drafts, &report)?;
        reporter.say(&format!(
            "{}: {} charts, distortion {:.4}, {:.1} % of the square used, {:.2} s",
            self.target.path.display(),
            report.result.charts,
            report.result.distortion,
            100.0 * report.result.utilisation,
            report.seconds
        ));
        missed.map_or(Ok(()), |text| Err(Failure::Unreached(text)))
    }

    /// The parts that were asked for.
    fn find_parts(&self, loaded: &Loaded, pool: &Pool, reporter: &mut Reporter) -> Result<Option<MeshParts>, Failure> {
        match &self.parts {
            PartsSource::Shape(arg) => {
                let settings = arg.to_core(self.settings.seed);
                settings.map(|settings| parts::find(loaded, settings, pool, reporter)).transpose()
            }
            PartsSource::File(file) => {
                let labels = labels::read("--labels", file, loaded.polygons()?, &loaded.path)?;
                parts::given(loaded, &labels, pool, reporter).map(Some)
            }
        }
    }

    /// What `seamwright measure` would say of the output, but over the exposure that the run worked with.
    fn metrics(&self, loaded: &Loaded, atlas: &Atlas) -> Result<AtlasRecord, Failure> {
        let mesh = loaded.mesh();
        let polygons = PolygonView {
            positions: &mesh.positions,
            corners: &mesh.corners,
            polygon_start: &mesh.polygon_start,
            corner_uv: Some(&atlas.corner_uv),
        };
        let exposure = SampledExposure { values: &atlas.exposure, weighting: Weighting::Cosine };
        let name = self.target.path.display().to_string();
        measure(&name, polygons, Some(exposure), RESOLUTION)
            .map_err(|e| Failure::Unreached(format!("--json: {name} cannot be measured: {e}")))
    }

    /// Puts the outputs in place, the report last.
    fn publish(&self, mut drafts: Drafts, report: &RunReport) -> Result<(), Failure> {
        match &self.json {
            Some(path) if !is_stdout(path) => drafts.add("--json", path, |out| report.write(out))?,
            _ => {}
        }
        if stop_requested() {
            return Err(Failure::Stopped);
        }
        drafts.publish()?;
        match &self.json {
            Some(path) if is_stdout(path) => {
                report.write(&mut stdout().lock()).map_err(|e| Failure::output("--json", path, &e))
            }
            _ => Ok(()),
        }
    }

    /// What to say where the atlas is not what was asked for. It is written all the same.
    fn missed(&self, atlas: &Atlas) -> Option<String> {
        if self.method == MethodArg::Neural {
            // A learned map has no bound; it promises nothing but is asked for an atlas that can be painted on.
            let bad = atlas.report.overlapping + atlas.report.flipped;
            return (bad > 0).then(|| {
                format!("--method neural: the atlas is written, but {bad} faces overlap or are flipped; --method hybrid has none")
            });
        }
        let (bound, reached) = (self.settings.distortion, atlas.report.distortion);
        let kept = reached <= bound * (1.0 + BOUND_SLACK); // not so where it is no number
        (!kept).then(|| {
            format!(
                "--distortion {bound}: the atlas is written, but its distortion is {reached:.4}; allow that much or more charts"
            )
        })
    }
}

/// The contact sheet of an atlas as PNG.
fn draw(loaded: &Loaded, atlas: &Atlas, pool: &Pool) -> Vec<u8> {
    let drawing = Drawing {
        title: format!("{}  distortion {:.4}", loaded.name(), atlas.report.distortion),
        mesh: loaded.mesh(),
        corner_uv: &atlas.corner_uv,
        polygon_chart: Some(&atlas.polygon_chart),
        exposure: Some(&atlas.exposure),
    };
    drawing.png(pool)
}
