//! What is checked before the work: settings that fit together, and outputs that fall on nothing and can be written.

use super::job::Job;
use super::outputs::{refuse_clashes, refuse_over_inputs, refuse_two_streams};
use crate::args::group::GroupArg;
use crate::args::method::MethodArg;
use crate::base::failure::Failure;
use crate::files::drafts;
use crate::files::paths::{has_stdout, is_stdout};
use crate::formats::loaded::Loaded;
use seamwright_core::pipeline::{CountedWork, Settings};
use std::fs;
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

    /// No output may fall on another, nor the picture or the report on the input.
    pub fn check_paths(&self, input: &Path) -> Result<(), Failure> {
        let named = |path: &Path, ending: &str| {
            let special = fs::metadata(path).is_ok_and(|data| !data.is_file() && !data.is_dir());
            special || path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending))
        };
        if let Some(path) = self.sheet.as_deref().filter(|path| !named(path, "png")) {
            return Err(Failure::Usage(format!("--sheet {}: name a file that ends in .png", path.display())));
        }
        let json = self.json.as_deref().filter(|path| !is_stdout(path));
        let sheet = self.sheet.as_deref();
        let (map, curves) = (self.save_map.as_deref(), self.curves.as_deref());
        if let Some(path) = curves.filter(|path| !named(path, "png")) {
            return Err(Failure::Usage(format!("--curves {}: name a file that ends in .png", path.display())));
        }
        let clashes = [
            ("--save-map", map, "the mesh", Some(input)),
            ("--curves", curves, "the mesh", Some(input)),
            ("--save-map", map, "-o", Some(self.target.path.as_path())),
            ("--save-map", map, "--sheet", sheet),
            ("--save-map", map, "--json", json),
            ("--save-map", map, "--curves", curves),
            ("--curves", curves, "-o", Some(self.target.path.as_path())),
            ("--curves", curves, "--sheet", sheet),
            ("--curves", curves, "--json", json),
            ("--sheet", sheet, "the mesh", Some(input)),
            ("--json", json, "the mesh", Some(input)),
            ("--sheet", sheet, "-o", Some(self.target.path.as_path())),
            ("--json", json, "-o", Some(self.target.path.as_path())),
            ("--json", json, "--sheet", sheet),
        ];
        refuse_two_streams(&self.target, self.json.as_deref())?;
        if self.save_map.as_deref().is_some_and(is_stdout) {
            return Err(Failure::Usage("--save-map -: name a file".into()));
        }
        refuse_clashes(&clashes)?;
        refuse_over_inputs(&self.outputs(), &self.inputs)
    }

    /// The outputs that are named.
    fn outputs(&self) -> [(&'static str, Option<&Path>); 5] {
        [
            ("-o", Some(self.target.path.as_path())),
            ("--sheet", self.sheet.as_deref()),
            ("--json", self.json.as_deref().filter(|path| !is_stdout(path))),
            ("--save-map", self.save_map.as_deref()),
            ("--curves", self.curves.as_deref()),
        ]
    }

    /// No output may fall on a file that the mesh names.
    pub(super) fn check_beside(&self, loaded: &Loaded) -> Result<(), Failure> {
        let named: Vec<_> = loaded.beside().into_iter().map(|path| ("a file that the mesh names", path)).collect();
        refuse_over_inputs(&self.outputs(), &named)
    }

    /// Finds out whether all outputs can be written.
    pub(super) fn check_outputs(&self) -> Result<(), Failure> {
        let streams = [("--json", self.json.as_deref()), ("-o", Some(self.target.path.as_path()))];
        if let Some((flag, _)) = streams.iter().find(|(_, path)| path.is_some_and(is_stdout)).filter(|_| !has_stdout())
        {
            return Err(Failure::Output(format!("{flag} -: standard output is closed; name a file")));
        }
        drafts::check("-o", &self.target.path)?;
        let others = [("--sheet", &self.sheet), ("--save-map", &self.save_map), ("--curves", &self.curves)];
        for (flag, path) in others {
            path.as_deref().map_or(Ok(()), |path| drafts::check(flag, path))?;
        }
        self.json.as_deref().filter(|path| !is_stdout(path)).map_or(Ok(()), |path| drafts::check("--json", path))
    }
}
