//! The rooms of core and of the command: they import as docs/ARCHITECTURE.md says, and no two files import each other.
//!
//! A room is a folder of core/src or cli/src. The page's tables "Rooms of core" and "Rooms of the command" have a row for each,
//! with the rooms that it may import, which stand above it, so that arrows point down. Inside a room too, no file is
//! reached by what it imports. What is imported is a file, never a folder's `mod.rs`, so that each arrow is seen. A type's
//! name is defined once, and is not that of a type that some file imports from another crate.
//! Limits: a method that another file defines on a type is no import; names that a macro puts together are not seen; an
//! inner module is one of tests.

use super::{code, module, paths, root, sources};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;

/// A crate and the page's table of its rooms.
struct House {
    /// Its folder.
    folder: &'static str,
    /// What its own programs and tests call it.
    name: &'static str,
    /// Heading of the table.
    table: &'static str,
    /// Names and texts of its files.
    files: Vec<(String, String)>,
}

fn core() -> House {
    let folder = "core/src";
    House { folder, name: "seamwright_core", table: "Rooms of core", files: sources(folder) }
}

fn command() -> House {
    let folder = "cli/src";
    House { folder, name: "seamwright", table: "Rooms of the command", files: sources(folder) }
}

/// A row of the page's table.
struct Room {
    name: String,
    /// The rooms that it may import.
    imports: BTreeSet<String>,
    /// Whether the page names them one by one.
    is_list: bool,
}

/// The rooms of a table of the page, lowest first.
fn rooms(page: &str, table: &str) -> Vec<Room> {
    let section = page.split(&format!("\n## {table}\n")).nth(1).unwrap_or("");
    let section = section.split("\n## ").next().unwrap_or("");
    let mut rooms: Vec<Room> = Vec::new();
    for cells in section.lines().map(|line| line.split('|').map(str::trim).collect::<Vec<_>>()) {
        let ["", name, _, imports, ""] = cells[..] else { continue };
        let Some(name) = name.strip_prefix('`').and_then(|name| name.strip_suffix('`')) else { continue };
        let is_list = imports != "all above";
        let imports = match is_list {
            true => imports.split('`').skip(1).step_by(2).map(String::from).collect(),
            false => rooms.iter().map(|above| above.name.clone()).collect(),
        };
        rooms.push(Room { name: name.to_string(), imports, is_list });
    }
    rooms
}

/// Every path into the crate that a file names, from the root, and every path of a `use` outside of tests into another
/// crate, but for those that begin with `name`.
fn named(name: &str, file: &str, text: &str) -> (Vec<Vec<String>>, Vec<Vec<String>>) {
    let code = code(text);
    let own = module(file);
    let tests_begin = match own.iter().any(|part| part.ends_with("_tests")) {
        true => 0,
        false => code.find("#[cfg(test)]").unwrap_or(code.len()),
    };
    let is_word = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    // `paths` has those of `use` items and what begins with `crate::`; elsewhere `super::` may stand anywhere.
    let is_first = |at: usize| !code[..at].ends_with(is_word) && !code[..at].ends_with("use ");
    let supers = code.match_indices("super::").filter(|(at, _)| is_first(*at)).map(|(at, _)| {
        let path = code[at..].split(|c| !is_word(c)).next().unwrap_or("").to_string();
        (path, at > tests_begin, at > tests_begin && tests_begin > 0)
    });
    let (mut inside, mut outside) = (Vec::new(), Vec::new());
    for (path, in_tests, is_inner) in paths(&code).into_iter().chain(supers) {
        let in_tests = in_tests || tests_begin == 0;
        let parts: Vec<String> = path.split("::").filter(|part| !part.is_empty()).map(String::from).collect();
        let supers = parts.iter().take_while(|part| *part == "super").count();
        match parts.first().map(String::as_str) {
            Some("crate") => inside.push(parts[1..].to_vec()),
            Some("super") => {
                // The first `super` of an inner module is the file's own.
                let base = own[..own.len().saturating_sub(supers - usize::from(is_inner))].iter();
                inside.push(base.map(ToString::to_string).chain(parts[supers..].iter().cloned()).collect());
            }
            // A folder's own files.
            Some(first) if code.contains(&format!("mod {first};")) => {
                inside.push(own.iter().map(ToString::to_string).chain(parts).collect());
            }
            Some(first) if !in_tests && first != name => outside.push(parts),
            _ => {}
        }
    }
    (inside, outside)
}

/// The files that each file imports, by their places, and what is wrong with imports by themselves.
fn imports(house: &House) -> (Vec<BTreeSet<usize>>, Vec<String>) {
    let House { folder, name: own_name, files, .. } = house;
    let place: BTreeMap<String, usize> =
        files.iter().enumerate().map(|(i, (name, _))| (module(name).join("::"), i)).collect();
    let target = |path: &[String]| (0..=path.len()).rev().find_map(|n| place.get(&path[..n].join("::")).copied());
    let (mut arrows, mut faults) = (Vec::new(), Vec::new());
    for (i, (name, text)) in files.iter().enumerate() {
        let mut found = BTreeSet::new();
        for path in named(own_name, name, text).0 {
            match target(&path) {
                Some(to) if to == i => {}
                Some(to) if files[to].0.ends_with("mod.rs") || files[to].0 == "lib.rs" => {
                    faults.push(format!("{folder}/{name}: {} is a folder; name the file", path.join("::")));
                }
                to => found.extend(to),
            }
        }
        arrows.push(found);
    }
    (arrows, faults)
}

/// Circles of files, each as a line that ends where it begins.
fn circles(house: &House) -> Vec<String> {
    let House { folder, files, .. } = house;
    let (arrows, mut faults) = (imports(house).0, Vec::new());
    let mut is_done = vec![false; files.len()];
    for start in 0..files.len() {
        let mut way = vec![(start, arrows[start].iter())];
        while let Some((at, next)) = way.last_mut() {
            let at = *at;
            match next.next().filter(|_| !is_done[at]) {
                Some(to) => match way.iter().position(|(file, _)| file == to) {
                    Some(first) => {
                        let names: Vec<&str> = way[first..].iter().map(|(file, _)| files[*file].0.as_str()).collect();
                        faults.push(format!("{folder}/{}: {} > {}", files[*to].0, names.join(" > "), files[*to].0));
                    }
                    None => way.push((*to, arrows[*to].iter())),
                },
                None => {
                    is_done[at] = true;
                    way.pop();
                }
            }
        }
    }
    faults
}

/// The folder of a file; nothing at the root.
fn room_of(file: &str) -> &str {
    file.split_once('/').map_or("", |(room, _)| room)
}

/// What the table does not allow, what it allows and no file does, and what stands in no room.
fn strangers(house: &House, rooms: &[Room]) -> Vec<String> {
    let House { folder, files, .. } = house;
    let page = "docs/ARCHITECTURE.md";
    let mut faults = Vec::new();
    let mut unused: BTreeSet<(&str, &str)> = BTreeSet::new();
    for (i, Room { name, imports, is_list }) in rooms.iter().enumerate() {
        for other in imports.iter().filter(|other| !rooms[..i].iter().any(|above| above.name == **other)) {
            faults.push(format!("{page}: {name} may import {other}, which does not stand above it"));
        }
        unused.extend(imports.iter().filter(|_| *is_list).map(|other| (name.as_str(), other.as_str())));
    }
    for ((file, _), to) in files.iter().zip(imports(house).0) {
        let own = room_of(file);
        let Some(room) = rooms.iter().find(|room| room.name == own) else {
            if file != "lib.rs" && file != "main.rs" {
                faults.push(format!("{folder}/{file}: stands in no room of {page}"));
            }
            continue;
        };
        for to in to.into_iter().map(|to| &files[to].0) {
            let other = room_of(to);
            unused.remove(&(own, other));
            if other != own && !room.imports.contains(other) {
                faults.push(format!("{folder}/{file}: {own} may not import {other} ({to})"));
            }
        }
    }
    faults.extend(unused.iter().map(|(room, other)| format!("{page}: {room} imports nothing of {other}")));
    faults
}

/// The name that a line defines as a type, at the margin: those of traits and inner items are indented.
fn defined(line: &str) -> Option<&str> {
    let line = line.strip_prefix("pub").map_or(line, |rest| rest.split_once(' ').map_or("", |(_, rest)| rest));
    let (kind, rest) = line.split_once(' ')?;
    let is_type = ["struct", "enum", "union", "trait", "type"].contains(&kind);
    rest.split(|c: char| !c.is_alphanumeric()).next().filter(|_| is_type)
}

/// Names of types that name several things.
fn doubles(house: &House) -> Vec<String> {
    let House { folder, name: own_name, files, .. } = house;
    let mut homes: BTreeMap<&str, &str> = BTreeMap::new();
    let mut faults = Vec::new();
    for (file, text) in files.iter().filter(|(file, _)| !file.contains("_tests")) {
        for name in text.lines().take_while(|line| *line != "#[cfg(test)]").filter_map(defined) {
            if let Some(before) = homes.insert(name, file) {
                faults.push(format!("{folder}/{file}: {name} is a type of {folder}/{before} too"));
            }
        }
    }
    for (file, text) in files {
        for path in named(own_name, file, text).1 {
            if let Some(home) = path.last().and_then(|last| homes.get(last.as_str())).filter(|_| path.len() > 1) {
                faults.push(format!("{folder}/{file}: {} is not the type of {folder}/{home}", path.join("::")));
            }
        }
    }
    faults
}

fn page() -> String {
    fs::read_to_string(root().join("docs/ARCHITECTURE.md")).expect("docs/ARCHITECTURE.md")
}

#[test]
fn rooms_import_what_the_page_says() {
    for house in [core(), command()] {
        let rooms = rooms(&page(), house.table);
        let faults = strangers(&house, &rooms);
        assert!(faults.is_empty() && rooms.len() > 5 && house.files.len() > 50, "\n{}", faults.join("\n"));
        let folders: BTreeSet<&str> =
            house.files.iter().filter_map(|(file, _)| Some(file.split_once('/')?.0)).collect();
        let named = rooms.iter().map(|room| room.name.as_str()).collect();
        assert_eq!(folders, named, "folders of {}, rooms of the page", house.folder);
    }
}

#[test]
fn no_two_files_import_each_other() {
    for house in [core(), command()] {
        let faults = [imports(&house).1, circles(&house)].concat();
        assert!(faults.is_empty(), "\n{}", faults.join("\n"));
    }
}

#[test]
fn a_type_has_a_name_of_its_own() {
    for house in [core(), command()] {
        let faults = doubles(&house);
        assert!(faults.is_empty(), "\n{}", faults.join("\n"));
    }
}

/// A small crate of these files, without their ending.
fn small(files: &[(&str, &str)]) -> House {
    let files = files.iter().map(|(name, text)| (format!("{name}.rs"), text.to_string())).collect();
    House { folder: "x", name: "x", table: "Rooms", files }
}

#[test]
fn circles_are_seen_within_rooms_and_across_them_and_in_tests() {
    let seen = |files: &[(&str, &str)]| circles(&small(files)).len();
    assert_eq!(seen(&[("a/x", "use super::y::Y;"), ("a/y", "use crate::a::x::X;")]), 1);
    assert_eq!(
        seen(&[("a/x", "use crate::b::y::Y;"), ("b/y", "use super::z::Z;"), ("b/z", "fn f() -> crate::a::x::X {}")]),
        1
    );
    assert_eq!(
        seen(&[
            ("a/x", "use crate::{a::y as z, b};"),
            ("a/y", "#[cfg(test)]\nmod tests {\n    use super::super::x::f;\n}")
        ]),
        1
    );
    assert_eq!(seen(&[("a/x", "fn f(y: &super::y::Y) {}"), ("a/y", "use super::x;")]), 1);
    let down =
        [("a/x", "use super::y::Y; // not crate::a::z"), ("a/y", "use std::a::x;"), ("a/z", "use super::{x, y::Y};")];
    assert_eq!(seen(&down), 0);
    assert_eq!(seen(&[("a/x", "#[cfg(test)]\nmod tests {\n    use super::*;\n}")]), 0);
}

#[test]
fn folders_are_not_imported() {
    let seen =
        |text: &str| imports(&small(&[("a/mod", "pub mod x;"), ("a/x", ""), ("b/y", text), ("lib", "")])).1.len();
    assert_eq!(seen("use crate::a;\nuse crate::a::Re;\nuse crate::Root;"), 3);
    assert_eq!(seen("use crate::a::x;\nuse crate::a::x::{X, f};"), 0);
}

#[test]
fn what_the_table_does_not_allow_is_seen() {
    let page = "\n## Rooms\n\n| room | holds | may import |\n|---|---|---|\n| `a` | x | nothing |\n| `b` | y | `a` |\n| `c` | z | all above |\n";
    let seen = |files: &[(&str, &str)]| strangers(&small(files), &rooms(page, "Rooms"));
    let (a, b) = (("a/x", "struct X;"), ("b/y", "use crate::a::x::X;"));
    assert!(seen(&[a, b, ("c/z", "use crate::a::x::X;"), ("main", ""), ("lib", "")]).is_empty());
    assert_eq!(seen(&[a, b, ("a/w", "use crate::b::y::Y;")]), ["x/a/w.rs: a may not import b (b/y.rs)"]);
    assert_eq!(seen(&[a]), ["docs/ARCHITECTURE.md: b imports nothing of a"]);
    assert_eq!(seen(&[a, b, ("d/v", ""), ("stray", "")]).len(), 2);
    let upside = page.replace("| x | nothing |", "| x | `c` |");
    assert!(
        strangers(&small(&[a, b]), &rooms(&upside, "Rooms"))
            .iter()
            .any(|fault| fault.contains("does not stand above it"))
    );
}

#[test]
fn a_name_of_two_types_is_seen() {
    let seen = |files: &[(&str, &str)]| doubles(&small(files)).len();
    assert_eq!(seen(&[("a/x", "pub struct Report {"), ("a/y", "enum Report {")]), 1);
    assert_eq!(seen(&[("a/x", "pub(super) type File = u8;"), ("a/y", "use std::fs::{self, File};")]), 1);
    assert_eq!(
        seen(&[("a/x", "pub struct X;\n    type Item = X;"), ("a/y", "use crate::a::x::X;\n    type Item = X;")]),
        0
    );
}
