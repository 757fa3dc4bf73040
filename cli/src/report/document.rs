//! The JSON report of a run: what went in, what was asked, what came out, and how long it took.
//!
//! Times differ from run to run; everything else is the same for the same input, settings and seed.

use super::asked::{InputReport, SettingsReport};
use super::learning::LearningReport;
use super::parts::PartReport;
use super::result::{ResultReport, SetReport};
use crate::figures::record::AtlasRecord;
use crate::run::progress::StageTime;
use serde::Serialize;
use std::io::{self, Write};

/// The report. Figures that are not finite become null.
#[derive(Debug, Serialize)]
pub struct RunReport {
    /// Version of seamwright.
    pub version: &'static str,
    /// What was read.
    pub input: InputReport,
    /// The OBJ that was written.
    pub output: String,
    /// What was asked.
    pub settings: SettingsReport,
    /// What came out, in core's own figures.
    pub result: ResultReport,
    /// The atlases, where there are several; `result` is all of them together.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub atlases: Option<Vec<SetReport>>,
    /// Parts and their charts, where the mesh was cut into parts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parts: Option<Vec<PartReport>>,
    /// How maps were trained, where they were.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub learning: Option<LearningReport>,
    /// The figures of `seamwright measure`, over the run's own exposure.
    pub metrics: Option<AtlasRecord>,
    /// Time of each stage.
    pub stages: Vec<StageReport>,
    /// Time from start to the written atlas.
    pub seconds: f64,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Time of a stage.
#[derive(Debug, Serialize)]
pub struct StageReport {
    /// Its name.
    pub stage: &'static str,
    /// Wall time, all visits together.
    pub seconds: f64,
}

impl From<&StageTime> for StageReport {
    fn from(time: &StageTime) -> Self {
        Self { stage: time.stage, seconds: time.time.as_secs_f64() }
    }
}

/// Writes a report: indented JSON and a line end.
pub fn write_json(report: &impl Serialize, out: &mut dyn Write) -> io::Result<()> {
    serde_json::to_writer_pretty(&mut *out, report)?;
    out.write_all(b"\n")
}
