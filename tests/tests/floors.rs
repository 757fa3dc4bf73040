//! The shape of the code: core uses few crates, dependencies are explained, files are short, open with what they are and cite
//! pages that exist.
//!
//! The rooms of core and of the command, and how they may import each other, are looked at in floors/rooms.rs.
//! `use` trees are expanded and every other path that begins with `crate::` is looked at too. Comments are skipped.
//! Limit: names that a macro puts together are not seen.

#[path = "floors/rooms.rs"]
mod rooms;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

const MAX_LINES: usize = 500;
/// Lines of a function of core at the most.
const LONGEST: usize = 80;
/// What core may import from outside.
const CORE_CRATES: &[&str] = &["core", "libm", "glam", "heapless", "bytemuck", "cpufeatures", "half"];
/// What core's own tests may import as well.
const TEST_CRATES: &[&str] = &["std", "approx", "quickcheck"];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Every .rs file below `folder` of the repository, sorted, with its path from there.
fn sources(folder: &str) -> Vec<(String, String)> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).into_iter().flatten() {
            let path = entry.expect("a readable folder").path();
            if path.is_dir() && !path.ends_with("target") {
                walk(&path, found);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                found.push(path);
            }
        }
    }
    let base = root().join(folder);
    let mut found = Vec::new();
    walk(&base, &mut found);
    found.sort();
    let name = |path: &Path| path.strip_prefix(&base).expect("below").to_str().expect("plain names").replace('\\', "/");
    found.iter().map(|path| (name(path), fs::read_to_string(path).expect("a text file"))).collect()
}

/// The module that a file of core/src holds: `rays/bvh.rs` is rays::bvh, `rays/mod.rs` rays, `lib.rs` the root.
fn module(file: &str) -> Vec<&str> {
    let stem = file.trim_end_matches(".rs");
    let stem = if stem == "lib" || stem == "mod" { "" } else { stem.trim_end_matches("/mod") };
    stem.split('/').filter(|part| !part.is_empty()).collect()
}

/// The text without comments. Strings that hold two slashes lose their end, which no import misses.
fn code(text: &str) -> String {
    text.lines().map(|line| line.split("//").next().unwrap_or("").to_string() + "\n").collect()
}

/// All paths of a `use` tree: `a::{b, c::d}` gives a::b and a::c::d.
fn expand(tree: &str) -> Vec<String> {
    let Some((head, rest)) = tree.split_once('{') else {
        return vec![tree.split(" as ").next().unwrap_or("").trim().to_string()];
    };
    let inner = rest.trim_end().strip_suffix('}').unwrap_or(rest);
    let mut depth = 0;
    let branches = inner.split(|c: char| {
        depth += i32::from(c == '{') - i32::from(c == '}');
        c == ',' && depth == 0
    });
    let branches = branches.map(str::trim).filter(|branch| !branch.is_empty());
    branches.flat_map(expand).map(|path| format!("{}{path}", head.trim())).collect()
}

/// Paths that the code names: those of `use` items, and anything else that begins with `crate::`. Each with whether it
/// stands after the file's first `#[cfg(test)]` and whether it is indented, that is, inside an inner module.
fn paths(code: &str) -> Vec<(String, bool, bool)> {
    let tests_begin = code.find("#[cfg(test)]").unwrap_or(code.len());
    let mut found = Vec::new();
    let mut at = 0;
    for line in code.split_inclusive('\n') {
        let indented = line.starts_with(' ');
        let bare = line.trim().trim_start_matches("pub(crate) ").trim_start_matches("pub(super) ");
        let bare = bare.trim_start_matches("pub ");
        if bare.starts_with("use ") {
            let start = at + line.find("use ").expect("it is there") + 4;
            let end = start + code[start..].find(';').expect("a use item ends");
            let joined = code[start..end].replace('\n', " ");
            found.extend(expand(&joined).into_iter().map(|path| (path, at > tests_begin, indented)));
        } else {
            for (i, _) in line.match_indices("crate::") {
                let path = line[i..].split(|c: char| !c.is_alphanumeric() && c != '_' && c != ':').next();
                found.push((path.unwrap_or("").to_string(), at > tests_begin, indented));
            }
        }
        at += line.len();
    }
    found
}

/// The crates that one file of core imports and may not, as lines for a person.
fn foreign(file: &str, text: &str) -> Vec<String> {
    let code = code(text);
    let is_tests = module(file).iter().any(|part| part.ends_with("_tests")); // a file that holds nothing else
    let mut faults = Vec::new();
    for (path, in_tests, _) in paths(&code) {
        let first = path.split("::").next().unwrap_or("");
        let is_local = ["self", "super", "crate"].contains(&first)
            || first.starts_with(char::is_uppercase)
            || code.contains(&format!("mod {first}"));
        let crates = if in_tests || is_tests { [CORE_CRATES, TEST_CRATES].concat() } else { CORE_CRATES.to_vec() };
        if !is_local && !crates.contains(&first) {
            faults.push(format!("core/src/{file}: {path} is not from a crate that core may use"));
        }
    }
    if code.contains("extern crate alloc") {
        faults.push(format!("core/src/{file}: core has no heap"));
    }
    faults
}

#[test]
fn core_imports_the_allowed_crates_only() {
    let sources = sources("core/src");
    assert!(!sources.is_empty());
    let faults: Vec<String> = sources.iter().flat_map(|(file, text)| foreign(file, text)).collect();
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

/// Names of the dependencies in a package's manifest, those of its tests included.
fn dependencies(package: &str) -> BTreeSet<String> {
    let manifest = fs::read_to_string(root().join(package).join("Cargo.toml")).expect("a manifest");
    let mut in_section = false;
    let mut names = BTreeSet::new();
    for line in manifest.lines().map(str::trim) {
        if line.starts_with('[') {
            in_section = line.ends_with("dependencies]");
        } else if in_section && line.contains('=') && !line.starts_with('#') {
            let name = line.split(['.', '=', ' ']).next().unwrap_or("");
            names.insert(name.trim_matches('"').to_string());
        }
    }
    names
}

#[test]
fn core_depends_on_the_allowed_crates_only() {
    let allowed = [CORE_CRATES, TEST_CRATES].concat();
    let extra: Vec<String> =
        dependencies("core").into_iter().filter(|name| !allowed.contains(&name.as_str())).collect();
    assert!(extra.is_empty(), "core/Cargo.toml: {extra:?}");
    let allowed = [&allowed[..], &["seamwright-core"]].concat();
    let extra: Vec<String> =
        dependencies("core/ffi").into_iter().filter(|name| !allowed.contains(&name.as_str())).collect();
    assert!(extra.is_empty(), "core/ffi/Cargo.toml: {extra:?}");
}

#[test]
fn the_reason_of_every_dependency_is_written_down() {
    let page = fs::read_to_string(root().join("docs/ARCHITECTURE.md")).expect("docs/ARCHITECTURE.md");
    let unexplained = |name: &String| !name.starts_with("seamwright") && !page.contains(&format!("`{name}`"));
    let names = ["core", "core/ffi", "cli", "tests"].into_iter().flat_map(dependencies);
    let missing: Vec<String> = names.filter(unexplained).collect();
    assert!(missing.is_empty(), "docs/ARCHITECTURE.md does not say why: {missing:?}");
}

/// Pages that a text cites and the repository lacks: paths that end with .md, and a name in capitals before a section's number.
fn lost_pages(text: &str) -> Vec<String> {
    let is_path = |c: char| c.is_alphanumeric() || "_-./".contains(c);
    let paths = text.split(|c| !is_path(c)).map(|word| word.trim_end_matches('.')).filter(|word| word.ends_with(".md"));
    let lost = paths.filter(|path| !root().join(path).is_file() && *path != ".md");
    let words: Vec<&str> = text.split_whitespace().collect();
    let cited = words.windows(2).filter(|pair| {
        let name = pair[0].trim_start_matches('(');
        let is_name = name.len() > 4 && name.chars().all(|c| c.is_ascii_uppercase());
        let number = pair[1].split(|c: char| !c.is_ascii_digit()).next().unwrap_or("");
        is_name && (1..3).contains(&number.len()) // a longer one is a year
    });
    lost.map(String::from).chain(cited.map(|pair| pair.join(" "))).collect()
}

#[test]
fn no_file_cites_a_page_that_is_not_here() {
    let mut faults = Vec::new();
    for folder in ["core", "cli", "tests"] {
        for (file, text) in sources(folder) {
            let comments =
                text.lines().filter_map(|line| Some(line.split_once("//")?.1)).collect::<Vec<_>>().join("\n");
            faults.extend(lost_pages(&comments).into_iter().map(|page| format!("{folder}/{file}: {page}")));
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
    assert_eq!(
        lost_pages("see docs/RESULTS.md, docs/LOST.md (DESIGN 4.10) and SSE 4.2"),
        ["docs/LOST.md", "(DESIGN 4.10)"]
    );
}

/// Functions of more than [`LONGEST`] lines, with their lengths. A function ends with a brace below its beginning.
fn long_functions(text: &str) -> Vec<(String, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let mut long = Vec::new();
    for (i, line) in lines.iter().enumerate() {
        let bare = line.trim_start();
        let named = bare.split_once("fn ").filter(|(before, _)| before.split(' ').all(|word| word.len() < 12));
        let Some((before, rest)) = named.filter(|(before, _)| !before.contains(['/', '"', '(', '='])) else { continue };
        let end = format!("{}}}", &line[..line.len() - bare.len()]);
        let length = lines[i..].iter().position(|line| *line == end).map_or(0, |n| n + 1);
        if length > LONGEST {
            let name = rest.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or("");
            long.push((format!("{before}{name}"), length));
        }
    }
    long
}

#[test]
fn functions_of_core_are_outlines_of_named_steps() {
    let mut faults = Vec::new();
    for (file, text) in sources("core/src").iter().filter(|(file, _)| !file.contains("_tests")) {
        for (name, lines) in long_functions(text) {
            faults.push(format!("core/src/{file}: {name} has {lines} lines, {LONGEST} at most"));
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
    let text =
        |lines| format!("impl X {{\n    pub const fn f(\n{}    ) {{\n    }}\n}}\n", "        x: u8,\n".repeat(lines));
    assert_eq!(long_functions(&text(LONGEST - 2)), [("pub const f".to_string(), LONGEST + 1)]);
    assert_eq!(long_functions(&text(LONGEST - 3)), []);
}

#[test]
fn every_file_is_short_and_opens_with_what_it_is() {
    let mut faults = Vec::new();
    for folder in ["core", "cli", "tests"] {
        for (file, text) in sources(folder) {
            if !text.starts_with("//!") {
                faults.push(format!("{folder}/{file}: does not open with //!"));
            }
            if text.lines().count() > MAX_LINES {
                faults.push(format!("{folder}/{file}: {} lines, {MAX_LINES} at most", text.lines().count()));
            }
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn a_crate_that_core_may_not_use_is_seen() {
    let seen = |file: &str, text: &str| foreign(file, text).len();
    assert_eq!(seen("rays/cast.rs", "use std::vec;\nuse serde::Deserialize;\nextern crate alloc;"), 3);
    assert_eq!(seen("learn/tape.rs", "use super::kernels::product;\nuse glam::Vec3;\nuse core::mem;"), 0);
    assert_eq!(seen("learn/tape.rs", "pub use self::ops::Op;\nmod ops;\nuse ops::Other;\nuse Op::*;"), 0);
    assert_eq!(seen("mesh/repair_tests/many.rs", "use super::*;\nuse std::vec;"), 0);
    assert_eq!(seen("mesh/topology.rs", "#[cfg(test)]\nmod tests {\n    use super::*;\n    use std::vec;\n}"), 0);
}
