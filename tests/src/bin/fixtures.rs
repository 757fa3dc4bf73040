//! Writes the meshes of `fixtures/`, or larger versions of them for measuring.
//!
//! `fixtures [OUTDIR]` writes every committed file below OUTDIR (default `fixtures`).
//! `fixtures [OUTDIR] --only NAME --faces N[,N...]` writes OUTDIR/NAME_N.obj and .seg with about N faces each. Below the
//! committed size a fine surface is coarsened; where a limb is then three faces around, some may cross.

use seamwright_tests::fixtures::{ALL, Fixture, GOLDEN, broken};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::{env, fs, io};

struct Arguments {
    folder: PathBuf,
    only: Option<&'static Fixture>,
    faces: Vec<usize>,
}

fn main() -> ExitCode {
    match parse(env::args().skip(1)).and_then(|arguments| write_all(&arguments).map_err(|e| e.to_string())) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("fixtures: {message}");
            ExitCode::from(2)
        }
    }
}

fn parse(mut words: impl Iterator<Item = String>) -> Result<Arguments, String> {
    let mut arguments = Arguments { folder: "fixtures".into(), only: None, faces: Vec::new() };
    while let Some(word) = words.next() {
        match word.as_str() {
            "--only" => {
                let name = words.next().ok_or("--only needs a name")?;
                arguments.only = Some(Fixture::named(&name).ok_or_else(|| format!("--only {name}: no such fixture"))?);
            }
            "--faces" => {
                let list = words.next().ok_or("--faces needs a number, or several joined by commas")?;
                let numbers = list.split(',').map(|n| n.parse().map_err(|_| format!("--faces {n}: not a number")));
                arguments.faces = numbers.collect::<Result<_, _>>()?;
            }
            flag if flag.starts_with('-') => return Err(format!("{flag}: only --only and --faces are known")),
            folder => arguments.folder = folder.into(),
        }
    }
    if arguments.faces.iter().any(|n| !(500..=4_000_000).contains(n)) {
        return Err("--faces: from 500 to 4000000".into());
    }
    Ok(arguments)
}

fn write_all(arguments: &Arguments) -> io::Result<()> {
    let folder = &arguments.folder;
    fs::create_dir_all(folder)?;
    let wanted = |fixture: &&Fixture| arguments.only.is_none_or(|only| only.name == fixture.name);
    for fixture in ALL.iter().filter(wanted) {
        if arguments.faces.is_empty() {
            write(folder, fixture.name, fixture, fixture.faces)?;
        }
        for faces in &arguments.faces {
            write(folder, &format!("{}_{faces}", fixture.name), fixture, *faces)?;
        }
    }
    if arguments.only.is_none() && arguments.faces.is_empty() {
        fs::create_dir_all(folder.join("broken"))?;
        for (name, text) in broken::files() {
            fs::write(folder.join("broken").join(name).with_extension("obj"), text)?;
        }
        fs::create_dir_all(folder.join("golden"))?;
        for (name, faces) in GOLDEN {
            let (mesh, _) = Fixture::named(name).expect("a fixture").files(faces);
            fs::write(folder.join("golden").join(name).with_extension("obj"), mesh)?;
        }
    }
    Ok(())
}

fn write(folder: &Path, name: &str, fixture: &Fixture, faces: usize) -> io::Result<()> {
    let (mesh, labels) = fixture.files(faces);
    println!("{name}: {} faces", labels.lines().count());
    fs::write(folder.join(name).with_extension("obj"), mesh)?;
    fs::write(folder.join(name).with_extension("seg"), labels)
}
