//! The committed fixtures are what the generator makes, and they are what they say they are.

use seamwright_tests::fixtures::nets::Mesh;
use seamwright_tests::fixtures::{ALL, Fixture, GOLDEN, broken, check, digits, faults, obj};
use seamwright_tests::solids;
use std::path::PathBuf;
use std::sync::OnceLock;
use std::{fs, str};

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../fixtures")
}

/// Every good fixture with its mesh and labels, built once.
fn built() -> impl Iterator<Item = (&'static Fixture, &'static Mesh, &'static Vec<u32>)> {
    static BUILT: OnceLock<Vec<(Mesh, Vec<u32>)>> = OnceLock::new();
    let built = BUILT.get_or_init(|| ALL.iter().map(|fixture| fixture.build(fixture.faces)).collect());
    ALL.iter().zip(built).map(|(fixture, (mesh, labels))| (fixture, mesh, labels))
}

/// Fails where `text` is not what the committed `file` holds, naming the first line that differs.
fn same(file: &str, text: &str) {
    let committed = fs::read(folder().join(file)).unwrap_or_else(|e| panic!("fixtures/{file}: {e}"));
    let committed = str::from_utf8(&committed).expect("fixtures are text");
    let differs = committed.lines().zip(text.lines()).position(|(a, b)| a != b);
    assert!(committed == text, "fixtures/{file} is not what the generator makes: line {:?}", differs.map(|i| i + 1));
}

#[test]
fn the_generator_makes_every_committed_fixture_byte_for_byte() {
    for (fixture, mesh, labels) in built() {
        same(&format!("{}.obj", fixture.name), &obj::mesh_text(fixture, mesh, digits(fixture.faces)));
        same(&format!("{}.seg", fixture.name), &obj::labels_text(labels));
    }
}

#[test]
fn the_generator_makes_every_broken_fixture_byte_for_byte() {
    broken::files().iter().for_each(|(name, text)| same(&format!("broken/{name}.obj"), text));
}

#[test]
fn the_generator_makes_every_file_that_readers_got_wrong_byte_for_byte() {
    for (name, bytes) in faults::files() {
        let committed = fs::read(folder().join("faults").join(name)).unwrap_or_else(|e| panic!("faults/{name}: {e}"));
        assert!(committed == bytes, "fixtures/faults/{name} is not what the generator makes");
    }
}

#[test]
fn the_generator_makes_the_meshes_of_the_golden_runs_byte_for_byte() {
    for (name, faces) in GOLDEN {
        same(&format!("golden/{name}.obj"), &Fixture::named(name).expect("a fixture").files(faces).0);
    }
}

#[test]
fn the_generator_makes_the_solids_that_are_kept_byte_for_byte() {
    for name in solids::KEPT {
        same(&format!("solids/{name}.obj"), &solids::named(name).expect("one of the family").obj());
    }
}

#[test]
fn no_fixture_comes_from_elsewhere() {
    let known = |file: &str| {
        let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
        ALL.iter().any(|fixture| fixture.name == stem)
            || broken::files().iter().any(|(name, _)| *name == stem)
            || solids::KEPT.contains(&stem)
            || faults::files().iter().any(|(name, _)| *name == file)
    };
    for sub in ["", "broken", "faults", "golden", "solids"] {
        for entry in fs::read_dir(folder().join(sub)).expect("fixtures/ exists") {
            let name = entry.expect("a readable folder").file_name().into_string().expect("plain names");
            let is_mesh = [".obj", ".ply", ".stl", ".off", ".glb"].iter().any(|ending| name.ends_with(ending));
            assert!(!is_mesh || known(&name), "fixtures/{sub}/{name} is not made by the generator");
        }
    }
}

#[test]
fn fixtures_are_oriented_manifolds_of_the_topology_they_claim() {
    for (fixture, mesh, labels) in built() {
        let facts = check::facts(mesh, labels);
        println!("{}: {facts:?}", fixture.name);
        assert_eq!(facts.components, 1, "{}", fixture.name);
        assert_eq!(facts.loops, fixture.loops, "{}", fixture.name);
        let euler = 2 - 2 * fixture.genus as i64 - fixture.loops as i64;
        assert_eq!(facts.euler, euler, "{}", fixture.name);
        assert!(fixture.loops > 0 || facts.volume > 0.0, "{} is inside out", fixture.name);
        assert!(check::vertices_are_fans(mesh), "{}", fixture.name);
    }
}

#[test]
fn fixtures_do_not_cross_themselves() {
    for (fixture, mesh, _) in built() {
        let crossing = check::self_intersection(mesh, digits(fixture.faces));
        assert_eq!(crossing, None, "{}", fixture.name);
    }
}

#[test]
fn triangles_are_well_shaped() {
    for (fixture, mesh, labels) in built() {
        let facts = check::facts(mesh, labels);
        // The worst are 15 degrees, where the gear's edges cross cells; smooth solids have 23 and more.
        assert!(facts.least_angle > 12.0 && facts.thin < 0.01, "{}: {facts:?}", fixture.name);
    }
}

#[test]
fn every_part_is_labelled_and_in_as_many_pieces_as_it_should_be() {
    for (fixture, mesh, labels) in built() {
        assert_eq!(labels.len(), mesh.faces.len());
        for part in 0..fixture.parts.len() as u32 {
            let faces = labels.iter().filter(|label| **label == part).count();
            assert!(faces >= 20, "{}: {faces} faces of part {}", fixture.name, fixture.parts[part as usize]);
        }
        assert_eq!(check::facts(mesh, labels).label_pieces, fixture.pieces, "{}", fixture.name);
    }
}

#[test]
fn versions_of_other_sizes_are_as_sound() {
    let quadruped = Fixture::named("quadruped").expect("the quadruped");
    for faces in [1_000, 3_000, 25_000] {
        let (mesh, labels) = quadruped.build(faces);
        let facts = check::facts(&mesh, &labels);
        assert_eq!((facts.components, facts.euler), (1, 2), "{faces}");
        assert!(mesh.faces.len().abs_diff(faces) < faces / 4, "{} faces for {faces}", mesh.faces.len());
        // Horns of a thousand faces are three faces around: there they may touch.
        assert!(faces < 3_000 || facts.least_angle > 12.0, "{faces}: {facts:?}");
        let crossing = check::self_intersection(&mesh, digits(faces));
        assert!(faces < 3_000 || crossing.is_none(), "{faces}: {crossing:?}");
    }
}
