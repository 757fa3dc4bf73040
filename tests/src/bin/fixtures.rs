//! Writes the meshes of `fixtures/`, or larger versions of them for measuring.
//!
//! `fixtures [OUTDIR]` writes every committed file below OUTDIR (default `fixtures`).
//! `fixtures [OUTDIR] --only NAME --faces N[,N...]` writes OUTDIR/NAME_N.obj and .seg with about N faces each. Below the
//! committed size a fine surface is coarsened; where a limb is then three faces around, some may cross.
//! `fixtures OUTDIR --solids PATTERN` writes OUTDIR/NAME.obj for every simple solid whose name matches, `*` for anything:
//! thousands, a few kB each.
//! `fixtures OUTDIR --copies MESH --count N [--mirrored]` writes OUTDIR/MESH_N.obj: N copies of a mesh file under rigid motions by chance,
//! vertices and polygons of each in an order of its own; with `--mirrored` every other one is a mirror image.

use seamwright::formats::loaded::load;
use seamwright_tests::fixtures::{ALL, Fixture, GOLDEN, broken, faults};
use seamwright_tests::scenes::{Placed, scattered};
use seamwright_tests::solids;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::{env, fs, io};

struct Arguments {
    folder: Option<PathBuf>,
    only: Option<&'static Fixture>,
    faces: Vec<usize>,
    solids: Option<String>,
    copies: Option<PathBuf>,
    count: usize,
    mirrored: bool,
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
    let mut arguments = Arguments {
        folder: None,
        only: None,
        faces: Vec::new(),
        solids: None,
        copies: None,
        count: 8,
        mirrored: false,
    };
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
            "--solids" => {
                arguments.solids = Some(words.next().ok_or("--solids needs a pattern of names, '*' for all")?)
            }
            "--copies" => arguments.copies = Some(words.next().ok_or("--copies needs a mesh file")?.into()),
            "--count" => {
                let number = words.next().and_then(|n| n.parse().ok()).filter(|n| (1..=1000).contains(n));
                arguments.count = number.ok_or("--count needs a number from 1 to 1000")?;
            }
            "--mirrored" => arguments.mirrored = true,
            flag if flag.starts_with('-') => {
                return Err(format!("{flag}: only --only, --faces, --solids, --copies, --count, --mirrored are known"));
            }
            folder => arguments.folder = Some(folder.into()),
        }
    }
    if arguments.faces.iter().any(|n| !(500..=4_000_000).contains(n)) {
        return Err("--faces: from 500 to 4000000".into());
    }
    if arguments.solids.is_some() && arguments.folder.is_none() {
        return Err("--solids: name a folder for them".into());
    }
    if arguments.copies.is_some() && arguments.folder.is_none() {
        return Err("--copies: name a folder for them".into());
    }
    Ok(arguments)
}

fn write_all(arguments: &Arguments) -> io::Result<()> {
    let folder = arguments.folder.as_deref().unwrap_or(Path::new("fixtures"));
    fs::create_dir_all(folder)?;
    if let Some(pattern) = &arguments.solids {
        let all = solids::family().into_iter().chain(solids::random());
        return write_solids(folder, all.filter(|solid| solids::matches(&solid.name, pattern)));
    }
    if let Some(file) = &arguments.copies {
        return write_copies(folder, file, arguments.count, arguments.mirrored);
    }
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
        fs::create_dir_all(folder.join("faults"))?;
        for (name, bytes) in faults::files() {
            fs::write(folder.join("faults").join(name), bytes)?;
        }
        fs::create_dir_all(folder.join("golden"))?;
        for (name, faces) in GOLDEN {
            let (mesh, _) = Fixture::named(name).expect("a fixture").files(faces);
            fs::write(folder.join("golden").join(name).with_extension("obj"), mesh)?;
        }
        fs::create_dir_all(folder.join("solids"))?;
        write_solids(&folder.join("solids"), solids::KEPT.iter().filter_map(|name| solids::named(name)))?;
    }
    Ok(())
}

fn write_solids(folder: &Path, solids: impl Iterator<Item = solids::Solid>) -> io::Result<()> {
    let mut count = 0;
    for solid in solids {
        // Not with_extension: names have decimal points.
        fs::write(folder.join(format!("{}.obj", solid.name)), solid.obj())?;
        count += 1;
    }
    println!("{count} solids");
    Ok(())
}

fn write_copies(folder: &Path, file: &Path, count: usize, mirrored: bool) -> io::Result<()> {
    let mesh = load(file).map_err(|e| io::Error::other(e.to_string()))?.mesh().clone();
    let bodies: Vec<Placed> = (0..count).map(|k| Placed { mesh: &mesh, mirrored: mirrored && k % 2 == 1 }).collect();
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    fs::write(folder.join(format!("{name}_{count}.obj")), scattered(&bodies, 1, Some(6)).obj())
}

fn write(folder: &Path, name: &str, fixture: &Fixture, faces: usize) -> io::Result<()> {
    let (mesh, labels) = fixture.files(faces);
    println!("{name}: {} faces", labels.lines().count());
    fs::write(folder.join(name).with_extension("obj"), mesh)?;
    fs::write(folder.join(name).with_extension("seg"), labels)
}
