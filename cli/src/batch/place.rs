//! Outputs that a child made, put in their places by renaming: each is whole, or not there.

use super::digest::of_bytes;
use super::record::JobRecord;
use crate::base::failure::Failure;
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Moves every file below `made` to the same place below `folder`, the one called `main` last. What another file of the batch
/// put there is not replaced by something else; `before` is what this one had there. Gives what stands for each.
pub(super) fn place(
    made: &Path,
    folder: &Path,
    main: &Path,
    before: Option<&JobRecord>,
) -> Result<BTreeMap<String, String>, Failure> {
    let mut names = Vec::new();
    below(made, Path::new(""), &mut names).map_err(|e| Failure::output("-o", made, &e))?;
    names.sort_by_key(|name| (name == main, name.clone()));
    let mut outputs = BTreeMap::new();
    for name in names {
        let (from, to) = (made.join(&name), folder.join(&name));
        let key = name.to_string_lossy().into_owned();
        let wrong = |e: io::Error| Failure::output("-o", &to, &e);
        let digest = of_bytes(&fs::read(&from).map_err(wrong)?);
        let is_own = name == main || before.is_some_and(|before| before.outputs.contains_key(&key));
        if !is_own && fs::read(&to).is_ok_and(|there| of_bytes(&there) != digest) {
            let text = "another file lies there, which another mesh may name; name the folders above the meshes, or another -o";
            return Err(Failure::Output(format!("-o {}: {text}", to.display())));
        }
        if let Some(parent) = to.parent() {
            fs::create_dir_all(parent).map_err(wrong)?;
        }
        fs::rename(&from, &to).map_err(wrong)?;
        outputs.insert(key, digest);
    }
    Ok(outputs)
}

fn below(folder: &Path, name: &Path, names: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let own = name.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            below(&entry.path(), &own, names)?;
        } else {
            names.push(own);
        }
    }
    Ok(())
}
