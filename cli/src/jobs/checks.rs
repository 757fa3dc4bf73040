//! What is checked before the work: settings that fit together, and outputs that fall on nothing and can be written.

use super::job::Job;
use super::outputs::{
    NamedOutput, check_writable, refuse_clashes, refuse_other_pictures, refuse_over, refuse_two_streams,
};
use crate::args::group::GroupArg;
use crate::args::method::MethodArg;
use crate::base::failure::Failure;
use crate::files::paths::{has_stdout, is_stdout};
use seamwright_core::pipeline::{CountedWork, Settings};
use std::path::Path;

impl Job {
    /// Settings that contradict each other are refused.
    pub fn check_settings(&self) -> Result<(), Failure> {
        let Settings { size, padding, .. } = self.settings;
        if padding.saturating_mul(4) > size {
            return Err(Failure::Usage(format!(
                "--padding {padding}: too wide for --size {size}; a quarter of the size at the most"
            )));
        }
        if self.group != GroupArg::Scene && self.method == MethodArg::Neural {
            let text = "one atlas is learned at a time; leave it out, or take --method exact";
            return Err(Failure::Usage(format!("--group {}: {text}", self.group.name())));
        }
        let limits = [("--time-limit", self.limit.is_some()), ("--work", self.settings.work != CountedWork::ALL)];
        if let Some((flag, _)) = limits.iter().find(|(_, is_given)| *is_given && self.method == MethodArg::Neural) {
            let text = "a training does not end early; --steps shortens it, or take --method exact";
            return Err(Failure::Usage(format!("{flag}: {text}")));
        }
        Ok(())
    }

    /// No output may fall on another, nor any but the mesh's on the mesh at `input`, nor one on what else is read.
    pub fn check_paths(&self, input: &Path) -> Result<(), Failure> {
        refuse_other_pictures(&[("--sheet", self.sheet.as_deref()), ("--curves", self.curves.as_deref())])?;
        refuse_two_streams(&self.target, self.json.as_deref())?;
        if self.save_map.as_deref().is_some_and(is_stdout) {
            return Err(Failure::Usage("--save-map -: name a file".into()));
        }
        let outputs = self.outputs();
        refuse_over(&outputs[1..], "the mesh", input)?;
        refuse_clashes(&outputs)?;
        self.inputs.iter().try_for_each(|(flag, path)| refuse_over(&outputs, flag, path))
    }

    /// The outputs that are named, the mesh first.
    pub(super) fn outputs(&self) -> [NamedOutput<'_>; 5] {
        [
            ("-o", Some(self.target.path.as_path())),
            ("--sheet", self.sheet.as_deref()),
            ("--json", self.json.as_deref().filter(|path| !is_stdout(path))),
            ("--curves", self.curves.as_deref()),
            ("--save-map", self.save_map.as_deref()),
        ]
    }

    /// Finds out whether all outputs can be written.
    pub(super) fn check_outputs(&self) -> Result<(), Failure> {
        let streams = [("--json", self.json.as_deref()), ("-o", Some(self.target.path.as_path()))];
        if let Some((flag, _)) = streams.iter().find(|(_, path)| path.is_some_and(is_stdout)).filter(|_| !has_stdout())
        {
            return Err(Failure::Output(format!("{flag} -: standard output is closed; name a file")));
        }
        check_writable(&self.outputs())
    }
}
