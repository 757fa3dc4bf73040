//! The rooms of the command: what docs/ARCHITECTURE.md says of them holds, and its files import one way.
//!
//! A room is a folder of cli/src. The table "Rooms of the command" names each and those that it may import, which stand above it,
//! so that arrows point down. No two files import each other, directly or by way of others, inside a room either. A type's name
//! is defined once and is not that of a type imported from elsewhere.
//! Every path that begins with `crate::`, `super::` or, in a file that declares modules, with one of these is looked at.
//! Limits: an inherent method that another file defines is no import; names that a macro puts together are not seen.

use super::{code, module, paths, root, sources};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;

/// Files of a crate: name and text.
type Files = Vec<(String, String)>;

/// The files that each file imports, by their places in `files`.
fn imports(files: &Files) -> Vec<BTreeSet<usize>> {
    let place: BTreeMap<Vec<&str>, usize> = files.iter().enumerate().map(|(i, (name, _))| (module(name), i)).collect();
    let target = |path: &[&str]| (0..=path.len()).rev().find_map(|n| place.get(&path[..n]).copied());
    let of_file = |(i, (name, text)): (usize, &(String, String))| {
        let code = code(text);
        let mut found: BTreeSet<usize> =
            absolute(&module(name), &code).iter().filter_map(|path| target(path)).filter(|to| *to != i).collect();
        // A file's own modules are named without `self`; lib.rs only lists rooms.
        for child in code.lines().filter_map(|line| line.trim().trim_start_matches("pub ").strip_prefix("mod ")) {
            let child = child.trim_end_matches(';');
            if code.contains(&format!("{child}::")) {
                found.extend(target(&[&module(name)[..], &[child]].concat()).filter(|to| *to != i));
            }
        }
        found
    };
    files.iter().enumerate().map(of_file).collect()
}

/// All paths into the crate that the code of module `own` names, from the crate's root.
fn absolute<'a>(own: &[&'a str], code: &'a str) -> Vec<Vec<&'a str>> {
    let mut found = Vec::new();
    for (path, _, indented) in paths(code).into_iter().chain(inner_supers(code)) {
        let parts: Vec<&'a str> = path.split("::").map(|part| &code[code.find(part).unwrap_or(0)..][..part.len()]).collect();
        let supers = parts.iter().take_while(|part| **part == "super").count();
        if parts[0] == "crate" {
            found.push(parts[1..].to_vec());
        } else if supers > 0 {
            let up = supers - usize::from(indented); // an inner module's first `super` is the file's own module
            found.push([&own[..own.len().saturating_sub(up)], &parts[supers..]].concat());
        }
    }
    found
}
