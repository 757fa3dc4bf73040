//! The files of a batch, and the name of what becomes of each.

use crate::args::batch::BatchArgs;
use crate::base::failure::Failure;
use crate::files::paths::same_file;
use crate::formats::format::Format;
use std::collections::BTreeMap;
use std::fs::{self, ReadDir};
use std::path::{Path, PathBuf};

/// A file to unwrap.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Item {
    /// Where it lies.
    pub input: PathBuf,
    /// What it becomes, seen from the folder of outputs.
    pub name: PathBuf,
}

/// This rank's share of the files, by name. Every rank that sees the same files has the same share each time.
pub fn items(args: &BatchArgs) -> Result<Vec<Item>, Failure> {
    if args.rank >= args.world_size {
        let (rank, size) = (args.rank, args.world_size);
        return Err(Failure::Usage(format!("--rank {rank}: ranks are counted from 0 and below --world-size {size}")));
    }
    let mut found = Found { output: fs::canonicalize(&args.output).ok(), inputs: BTreeMap::new() };
    for path in &args.inputs {
        found.take(path, true)?;
    }
    for (name, input) in &found.inputs {
        if same_file(&args.output.join(name), input) {
            return Err(over_itself(&args.output, input));
        }
    }
    if found.inputs.is_empty() {
        let named: Vec<String> = args.inputs.iter().map(|path| path.display().to_string()).collect();
        return Err(Failure::Input(format!("{}: no mesh in it", named.join(", "))));
    }
    let all = found.inputs.into_iter().map(|(name, input)| Item { input, name });
    Ok(all.skip(args.rank as usize).step_by(args.world_size as usize).collect())
}

fn over_itself(output: &Path, input: &Path) -> Failure {
    let text = format!("{} would be written over itself; choose another folder", input.display());
    Failure::Usage(format!("-o {}: {text}", output.display()))
}

struct Found {
    /// The folder of outputs: what lies there is no input.
    output: Option<PathBuf>,
    inputs: BTreeMap<PathBuf, PathBuf>, // by name
}

impl Found {
    fn take(&mut self, path: &Path, lists: bool) -> Result<(), Failure> {
        if path.is_dir() {
            if self.output.is_some() && fs::canonicalize(path).ok() == self.output {
                return Err(over_itself(path, path));
            }
            let entries = fs::read_dir(path).map_err(|e| Failure::input(path, &e))?;
            return self.folder(path, entries, Path::new(""));
        }
        if lists && path.extension().is_some_and(|e| e.eq_ignore_ascii_case("txt")) {
            let text = fs::read_to_string(path).map_err(|e| Failure::input(path, &e))?;
            let lines = text.trim_start_matches('\u{feff}').lines().map(str::trim).filter(|line| !line.is_empty());
            return lines.map(Path::new).try_for_each(|line| self.take(line, false));
        }
        let name = path.file_name().map(PathBuf::from);
        self.add(path, name.ok_or_else(|| Failure::Usage(format!("{}: names no file", path.display())))?)
    }

    /// Every mesh below a folder, but for what is hidden.
    fn folder(&mut self, folder: &Path, entries: ReadDir, name: &Path) -> Result<(), Failure> {
        if self.output.is_some() && fs::canonicalize(folder).ok() == self.output {
            return Ok(());
        }
        for entry in entries {
            let entry = entry.map_err(|e| Failure::input(folder, &e))?;
            let (path, own) = (entry.path(), name.join(entry.file_name()));
            if entry.file_name().to_string_lossy().starts_with('.') {
                continue;
            }
            // A link to a folder may lead round in a circle.
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                // A folder that cannot be read holds no file of this batch, and stops none.
                match fs::read_dir(&path) {
                    Ok(entries) => self.folder(&path, entries, &own)?,
                    Err(e) => eprintln!("warning: {}: {e}; nothing of it is taken", path.display()),
                }
            } else if path.is_file() && Format::of(&path).is_some() {
                self.add(&path, own)?;
            }
        }
        Ok(())
    }

    fn add(&mut self, input: &Path, name: PathBuf) -> Result<(), Failure> {
        let name = written_as(name);
        let text = |before: &Path| {
            format!(
                "{} and {} would both become {}; name the folders above them, or give each a run of its own",
                before.display(),
                input.display(),
                name.display()
            )
        };
        match self.inputs.get(&name) {
            Some(before) if before != input && !same_file(before, input) => Err(Failure::Usage(text(before))),
            Some(_) => Ok(()),
            None => {
                self.inputs.insert(name, input.to_path_buf());
                Ok(())
            }
        }
    }
}

/// The name of the output: that of the input where its format is written, else with another ending behind it.
fn written_as(name: PathBuf) -> PathBuf {
    let more = match Format::of(&name) {
        Some(Format::Fbx) => ".glb",
        Some(format) if format.refusal().is_some() => ".obj",
        _ => return name,
    };
    let mut longer = name.into_os_string();
    longer.push(more);
    longer.into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::line::{Command, CommandLine};
    use clap::Parser;

    fn names(folder: &Path, words: &[&str]) -> Result<Vec<String>, Failure> {
        let place =
            |word: &&str| if word.starts_with('-') || word.len() == 1 { (*word).into() } else { folder.join(word) };
        let words = words.iter().map(place);
        let line = CommandLine::parse_from(["seamwright".into(), PathBuf::from("batch")].into_iter().chain(words));
        let Command::Batch(args) = line.command else { unreachable!("batch was parsed") };
        Ok(items(&args)?.iter().map(|item| item.name.display().to_string()).collect())
    }

    #[test]
    fn folders_files_and_lists_are_dealt_to_ranks() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        for name in
            ["in/b.stl", "in/sub/a.GLB", "in/sub/c.fbx", "in/.hidden.obj", "in/notes.md", "in/out/z.obj", "d.obj"]
        {
            let path = folder.join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        fs::write(folder.join("list.txt"), format!("{}\n\n", folder.join("d.obj").display())).unwrap();
        let all = names(folder, &["in", "list.txt", "d.obj", "-o", "in/out"]).unwrap();
        assert_eq!(all, ["b.stl.obj", "d.obj", "sub/a.GLB", "sub/c.fbx.glb"]);
        let of =
            |rank| names(folder, &["in", "list.txt", "-o", "in/out", "--world-size", "3", "--rank", rank]).unwrap();
        assert_eq!([of("0"), of("1"), of("2")].concat(), ["b.stl.obj", "sub/c.fbx.glb", "d.obj", "sub/a.GLB"]);
        let refused = |words: &[&str]| names(folder, words).unwrap_err();
        assert_eq!(refused(&["in", "-o", "out", "--world-size", "3", "--rank", "3"]).code(), 2);
        assert!(refused(&["in/sub", "-o", "in/sub"]).to_string().contains("over itself"));
        assert!(refused(&["d.obj", "-o", "in/.."]).to_string().contains("over itself"));
        fs::write(folder.join("in/d.obj"), "").unwrap();
        assert!(refused(&["d.obj", "in/d.obj", "-o", "out"]).to_string().contains("would both become d.obj"));
    }
}
