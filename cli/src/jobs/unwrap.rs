//! Does a job: loads, unwraps, writes, reports.

use super::hints::hints;
use super::job::{Job, PartsSource};
use super::missed::cause;
use super::outputs::{add_mesh, publish, refuse_over_named, report_failure};
use super::sets::{self, Joined, Set, has_triangle, sets};
use crate::args::group::GroupArg;
use crate::args::parts::PartsArg;
use crate::base::counted::counted;
use crate::base::failure::Failure;
use crate::figures::measure::measure;
use crate::figures::record::AtlasRecord;
use crate::figures::sampled::{SampledExposure, Weighting};
use crate::files::drafts::Drafts;
use crate::formats::labels::read as labels;
use crate::formats::loaded::Loaded;
use crate::formats::target::Mapping;
use crate::mesh::polygons::Mesh;
use crate::mesh::view::PolygonView;
use crate::picture::{curves, drawing::Drawing};
use crate::report::asked::{InputReport, SettingsReport};
use crate::report::document::{RunReport, StageReport};
use crate::report::learning::LearningReport;
use crate::report::parts::{groups, tree};
use crate::report::result::{ResultReport, SetReport};
use crate::run::atlas::{self, Atlas};
use crate::run::parts::{self, MeshParts};
use crate::run::progress::{Reporter, Show};
use crate::run::threads::Pool;
use crate::training::map_file;
use crate::training::trainer::Trainer;
use seamwright_core::judge::measure::RESOLUTION;
use seamwright_core::mesh::cracks::Weld;
use seamwright_core::pipeline::published::FEW;
use seamwright_core::pipeline::{CountedWork, Settings};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// How far over the bound still counts as reached: UVs on a grid of 2^-24 move the mean by about 1e-7.
const BOUND_SLACK: f64 = 1e-6;

impl Job {
    /// Loads, unwraps, writes, reports. Nothing is written unless everything can be, but for a report that says why there is
    /// no atlas of the mesh at `input`.
    pub fn run(&self, input: &Path, load: impl FnOnce() -> Result<Loaded, Failure>) -> Result<(), Failure> {
        self.check_outputs()?;
        let missed = self.atlas(load).inspect_err(|failure| report_failure(self.json.as_deref(), input, failure))?;
        missed.map_or(Ok(()), |text| Err(Failure::Unreached(text)))
    }

    /// The whole run. Gives what was missed of what was asked, with the atlas written.
    fn atlas(&self, load: impl FnOnce() -> Result<Loaded, Failure>) -> Result<Option<String>, Failure> {
        let start = Instant::now();
        let loaded = load()?;
        refuse_over_named(&self.outputs(), &loaded)?;
        let mut reporter = Reporter::new(Show::fitting(self.run.quiet));
        if let Some(limit) = self.limit {
            reporter.limit(start, limit);
        }
        let mut warnings = loaded.warnings().to_vec();
        warnings.extend(loaded.check(&self.target)?);
        let pool = Pool::new(self.run.threads.map(usize::from))
            .map_err(|e| Failure::Unreached(format!("--threads: cannot start them: {e}; ask for fewer")))?;
        warnings.iter().for_each(|w| reporter.say(&format!("warning: {}: {w}", loaded.path.display())));
        let parts = self.find_parts(&loaded, &pool, &mut reporter)?;
        let mut trainer = self.learning.clone();
        let made = self.make(&loaded, parts.as_ref(), trainer.as_mut(), &pool, &mut reporter)?;
        let atlas = &made.atlas;
        for text in self.not_as_asked(parts.as_ref(), trainer.as_ref()) {
            reporter.say(&format!("warning: {}: {text}", loaded.path.display()));
            warnings.push(text);
        }
        let stages = reporter.finish().iter().map(StageReport::from).collect();
        let result = ResultReport::new(atlas);
        if let Some(work) = result.ended_early.as_ref().filter(|_| self.limit.is_some()) {
            let text = format!("time was up before the best was found; --work {work} gives the same atlas again");
            reporter.say(&format!("warning: {}: {text}", loaded.path.display()));
            warnings.push(text);
        }
        if self.settings.weld != Weld::Equal {
            reporter.say(&result.welded());
        }
        let hints = hints(loaded.mesh(), atlas, self.settings.weld != Weld::Equal);
        let crowded = self.crowded(atlas).filter(|_| !self.asks_for_padding());
        for warning in result.warnings().into_iter().chain(hints).chain(crowded) {
            reporter.say(&format!("warning: {}: {warning}", loaded.path.display()));
            warnings.push(warning);
        }
        made.empty.iter().for_each(|text| reporter.say(&format!("warning: {}: {text}", loaded.path.display())));
        warnings.extend(made.empty.clone());
        let missed = made.all(&loaded).find_map(|(mesh, atlas)| self.missed(mesh, atlas));
        warnings.extend(missed.clone());
        // Whoever limits the time or the work has asked for what can be had by then.
        let missed = missed.filter(|_| self.limit.is_none() && self.settings.work == CountedWork::ALL);

        let mut drafts = Drafts::new();
        let groups = self.groups.then(|| groups(parts.as_ref(), atlas));
        let mut files = loaded.files(&self.target, Mapping { corner_uv: &atlas.corner_uv, groups: groups.as_ref() })?;
        files.warnings.iter().for_each(|w| reporter.say(&format!("warning: {}: {w}", loaded.path.display())));
        warnings.append(&mut files.warnings);
        add_mesh(&mut drafts, &self.target, files)?;
        if let Some(path) = &self.sheet {
            for (path, picture) in made.pictures(path, &loaded, &pool) {
                drafts.add("--sheet", &path, |out| out.write_all(&picture))?;
            }
        }
        if let (Some(path), Some(Trainer::Fit(fit))) = (&self.save_map, &trainer) {
            let mesh = map_file::mesh_hash(loaded.mesh());
            drafts.add("--save-map", path, |out| map_file::write(out, fit, mesh))?;
        }
        if let (Some(path), Some(trainer)) = (&self.curves, &trainer) {
            let picture = curves::png(&loaded.name(), &trainer.curves().terms);
            drafts.add("--curves", path, |out| out.write_all(&picture))?;
        }
        let seconds = start.elapsed().as_secs_f64();
        let report = RunReport {
            version: env!("CARGO_PKG_VERSION"),
            input: InputReport::new(&loaded),
            output: self.target.path.display().to_string(),
            settings: SettingsReport {
                parts: self.parts.name(),
                group: self.group.name(),
                uv_set: self.target.uv_set,
                time_limit: self.limit.map(|limit| limit.as_secs_f64()),
                ..SettingsReport::new(self.method, &self.settings, self.keep_seams, pool.count())
            },
            result,
            atlases: self.reports(&made)?,
            parts: parts.as_ref().map(|parts| tree(parts, atlas)),
            learning: trainer.as_ref().map(|trainer| LearningReport::new(trainer, &atlas.report)),
            metrics: match &self.json {
                Some(_) if made.sets.is_empty() => Some(self.metrics(loaded.mesh(), atlas)?),
                _ => None,
            },
            stages,
            seconds,
            warnings,
        };
        publish(drafts, self.json.as_deref(), &report)?;
        reporter.say(&format!(
            "{}: {}{}, distortion {:.4}, {:.1} % of the square used, {:.2} s",
            self.target.path.display(),
            counted(report.result.charts, "chart"),
            if report.result.stacked > 0 {
                format!(" ({} of them stacked)", report.result.stacked)
            } else {
                String::new()
            },
            report.result.distortion,
            100.0 * report.result.utilisation,
            report.seconds
        ));
        Ok(missed)
    }

    /// What is not as the user asked for it, and no failure.
    fn not_as_asked(&self, parts: Option<&MeshParts>, trainer: Option<&Trainer>) -> Vec<String> {
        let mut told = Vec::new();
        if let (PartsSource::Shape(PartsArg::Count(wanted)), Some(found)) = (&self.parts, parts)
            && *wanted as usize != found.count
        {
            let why = "each piece of the mesh is one at least, and each part has a face";
            told.push(format!("--parts {wanted}: there are {}; {why}", found.count));
        }
        match trainer {
            Some(trainer) if trainer.was_stopped() => told.push(format!(
                "training was stopped after {} steps; what was learned by then is used",
                trainer.steps()
            )),
            Some(Trainer::Published(published)) if published.summary.maps == 0 => {
                told.push(format!("no piece has {FEW} vertices, so that none was trained; their maps are exact"));
            }
            _ => {}
        }
        told
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

    /// The atlas of each set of polygons that shares one.
    fn make(
        &self,
        loaded: &Loaded,
        parts: Option<&MeshParts>,
        trainer: Option<&mut Trainer>,
        pool: &Pool,
        reporter: &mut Reporter,
    ) -> Result<Made, Failure> {
        let part = parts.map(|parts| &parts.part[..]);
        let settings = &self.settings;
        if self.group == GroupArg::Scene {
            let make = || atlas::make_by(trainer, loaded, part, self.keep_seams, settings, pool, reporter);
            return pool.enter(make).map(|atlas| Made { atlas, sets: Vec::new(), empty: Vec::new() });
        }
        let mesh = loaded.polygons()?;
        let mut joined = Joined::new(mesh);
        let (mut made, mut empty) = (Vec::new(), Vec::new());
        for set in sets(loaded.model(), self.group) {
            let (own, vertices) = sets::part(mesh, &set.polygons);
            if !has_triangle(&own) {
                empty.push(format!("'{}' has no triangle with three different corners; its UVs are 0, 0", set.name));
                continue;
            }
            let alone = loaded.alone(own);
            let part: Option<Vec<u32>> = part.map(|all| set.polygons.iter().map(|p| all[*p as usize]).collect());
            // What has no UVs of its own has no seams to keep.
            let keep =
                self.keep_seams && alone.mesh().corner_uv.as_ref().is_some_and(|uv| uv.iter().any(|uv| uv.is_finite()));
            let atlas = pool.enter(|| atlas::make_by(None, &alone, part.as_deref(), keep, settings, pool, reporter))?;
            joined.add(&set, &vertices, &atlas);
            made.push((set, alone, atlas));
        }
        if made.is_empty() {
            let text = "the mesh holds no triangle with three different corners; repair the mesh";
            return Err(Failure::Input(format!("{}: {text}", loaded.path.display())));
        }
        Ok(Made { atlas: joined.finish(), sets: made, empty })
    }

    /// What to tell of each of several atlases.
    fn reports(&self, made: &Made) -> Result<Option<Vec<SetReport>>, Failure> {
        let report = |(set, alone, atlas): &(Set, Loaded, Atlas)| {
            Ok(SetReport {
                name: set.name.clone(),
                faces: set.polygons.len(),
                result: ResultReport::new(atlas),
                metrics: self.json.as_ref().map(|_| self.metrics(alone.mesh(), atlas)).transpose()?,
            })
        };
        let reports: Vec<SetReport> = made.sets.iter().map(report).collect::<Result<_, Failure>>()?;
        Ok(Some(reports).filter(|reports| !reports.is_empty()))
    }

    /// What `seamwright measure` would say of the output, but over the exposure that the run worked with.
    fn metrics(&self, mesh: &Mesh, atlas: &Atlas) -> Result<AtlasRecord, Failure> {
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

    /// Whether the padding, or the texture's size, is not that of any run.
    fn asks_for_padding(&self) -> bool {
        let (own, any) = (&self.settings, Settings::default());
        own.padding != any.padding || own.size != any.size
    }

    /// What to say where charts have no room for the padding.
    fn crowded(&self, atlas: &Atlas) -> Option<String> {
        let Settings { padding, size, .. } = self.settings;
        let (charts, kept) = (counted(atlas.report.chart_count, "chart"), atlas.report.padding);
        (kept < f64::from(padding)).then(|| {
            format!("--padding {padding}: the atlas is written, but its {charts} have room for {kept:.1} texels between them on --size {size}: a larger size or less padding")
        })
    }

    /// What to say where the atlas is not what was asked for. It is written all the same.
    fn missed(&self, mesh: &Mesh, atlas: &Atlas) -> Option<String> {
        if let Some(Trainer::Published(_)) = self.learning {
            // The published map has no bound; it promises nothing but is asked for an atlas that can be painted on.
            let bad = atlas.report.overlapping + atlas.report.flipped;
            return (bad > 0).then(|| {
                format!("--preset paper: the atlas is written, but {bad} faces overlap or are flipped; other presets have none")
            });
        }
        if self.asks_for_padding()
            && let Some(text) = self.crowded(atlas)
        {
            return Some(text);
        }
        let (bound, reached) = (self.settings.distortion, atlas.report.distortion);
        let kept = reached <= bound * (1.0 + BOUND_SLACK); // not so where it is no number
        (!kept).then(|| {
            let cause = cause(mesh, &atlas.corner_uv);
            format!("--distortion {bound}: the atlas is written, but its distortion is {reached:.4}, {cause}")
        })
    }
}

/// What was made of a mesh.
struct Made {
    /// The whole.
    atlas: Atlas,
    /// The atlas of each set, with its mesh, where there are several.
    sets: Vec<(Set, Loaded, Atlas)>,
    /// Sets that have nothing to unwrap, in words.
    empty: Vec<String>,
}

impl Made {
    /// Every atlas that has a unit square of its own, with its mesh.
    fn all<'a>(&'a self, loaded: &'a Loaded) -> impl Iterator<Item = (&'a Mesh, &'a Atlas)> {
        let whole = self.sets.is_empty().then_some((loaded.mesh(), &self.atlas));
        whole.into_iter().chain(self.sets.iter().map(|(_, alone, atlas)| (alone.mesh(), atlas)))
    }

    /// A contact sheet, or one of each set, numbered from 0, as PNG.
    fn pictures(&self, path: &Path, loaded: &Loaded, pool: &Pool) -> Vec<(PathBuf, Vec<u8>)> {
        if self.sets.is_empty() {
            return vec![(path.to_path_buf(), draw(loaded, &self.atlas, pool))];
        }
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let numbered = self.sets.iter().enumerate();
        numbered
            .map(|(k, (_, alone, atlas))| (path.with_file_name(format!("{stem}_{k}.png")), draw(alone, atlas, pool)))
            .collect()
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
