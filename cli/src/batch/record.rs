//! What was made of a file: kept beside the outputs in a hidden folder, so that a later run can tell what is done.

use super::digest::of_bytes;
use super::items::Item;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The folder of records, and of what is being made, seen from that of the outputs.
pub(super) const HIDDEN: &str = ".seamwright";

/// What was made of a file.
#[derive(Serialize, Deserialize)]
pub(super) struct JobRecord {
    /// What stands for the input and the settings.
    pub job: String,
    /// What stands for each output, by its path seen from the folder of outputs.
    pub outputs: BTreeMap<String, String>,
    /// The line that was printed.
    pub line: Value,
}

impl JobRecord {
    /// Where the record of `item` lies.
    pub fn path(folder: &Path, item: &Item) -> PathBuf {
        let mut name = item.name.clone().into_os_string();
        name.push(".json");
        folder.join(HIDDEN).join(name)
    }

    /// The one that an earlier run left, if it can be read.
    pub fn left(folder: &Path, item: &Item) -> Option<Self> {
        serde_json::from_slice(&fs::read(Self::path(folder, item)).ok()?).ok()
    }

    /// Whether it is of this job, and its outputs are there as they were written.
    pub fn holds(&self, folder: &Path, job: &str) -> bool {
        let is_there = |(name, digest): (&String, &String)| {
            fs::read(folder.join(name)).is_ok_and(|bytes| of_bytes(&bytes) == *digest)
        };
        self.job == job && self.outputs.iter().all(is_there)
    }
}
