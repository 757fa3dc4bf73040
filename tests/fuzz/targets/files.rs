//! Bytes as a file of every kind that the command reads: refused with the file's name, or a whole mesh that is written as an
//! OBJ which reads back as the same mesh; labels, maps and settings likewise.
#![no_main]

use glam::{DVec2, DVec3};
use libfuzzer_sys::fuzz_target;
use seamwright::args::learning::LearningArgs;
use seamwright::base::failure::Failure;
use seamwright::figures::measure::measure;
use seamwright::formats::labels;
use seamwright::formats::loaded::{Loaded, load, load_obj};
use seamwright::mesh::polygons::Mesh;
use seamwright::mesh::view::PolygonView;
use seamwright::training::map_file;
use seamwright::training::trainer::Trainer;
use seamwright_fuzz::{MESHES, OTHERS};
use std::fs;
use std::path::{Path, PathBuf};

/// Corners up to which a mesh is also measured and written.
const FEW: usize = 300;

fuzz_target!(|bytes: &[u8]| {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    let kind = usize::from(*kind) % (MESHES.len() + OTHERS.len());
    let ending = MESHES.iter().chain(&OTHERS).nth(kind).expect("a number below their count");
    // A folder of its own, so that a glTF that names other files finds none.
    let folder = std::env::temp_dir().join(format!("seamwright_fuzz_{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder for temporary files");
    let path = folder.join(format!("a.{ending}"));
    fs::write(&path, bytes).expect("a temporary file");
    match *ending {
        _ if kind < MESHES.len() => read(&path),
        "map" => map(&path, bytes),
        "toml" => {
            let args = LearningArgs { file: Some(path.clone()), ..LearningArgs::default() };
            match Trainer::new(&args, 0) {
                Err(Failure::Usage(text)) => assert!(text.contains(&path.display().to_string()), "{text}"),
                other => drop(refused(other, &path)),
            }
        }
        _ => labelled(&path),
    }
});

/// The result, where it is not a proper refusal.
fn refused<T>(result: Result<T, Failure>, path: &Path) -> Option<T> {
    match result {
        Ok(made) => Some(made),
        Err(Failure::Input(text)) if text.contains(&path.display().to_string()) => None,
        Err(other) => panic!("{other:?}"),
    }
}

fn read(path: &Path) {
    let Some(loaded) = refused(load(path), path) else { return };
    let mesh = loaded.mesh();
    whole(mesh);
    if mesh.corners.len() > FEW || refused(loaded.polygons(), path).is_none() {
        return;
    }
    let uv: Vec<DVec2> = (0..mesh.corners.len()).map(|c| DVec2::new(c as f64 / 8.0, 0.25)).collect();
    let again = written(&loaded, &uv);
    assert_eq!(again.mesh().corners, mesh.corners, "other corners");
    assert_eq!(again.mesh().polygon_start, mesh.polygon_start, "other polygons");
    // Of other files than OBJ, coordinates that a float holds are written as floats.
    let are_same = |(a, b): (&DVec3, &DVec3)| a == b || a.as_vec3() == b.as_vec3();
    assert!(again.mesh().positions.iter().zip(&mesh.positions).all(are_same), "other positions");
    assert_eq!(again.mesh().corner_uv.as_deref(), Some(&uv[..]), "other UVs");
    if let Some(corner_uv) = mesh.corner_uv.as_deref() {
        let Mesh { positions, corners, polygon_start, .. } = mesh;
        let polygons = PolygonView { positions, corners, polygon_start, corner_uv: Some(corner_uv) };
        measure("a", polygons, None, 16).expect("a mesh that was read can be measured");
    }
}

/// What [`Mesh`] promises.
fn whole(mesh: &Mesh) {
    assert!(mesh.positions.iter().all(|p| p.is_finite()), "a position that is none");
    assert!(mesh.corners.iter().all(|v| (*v as usize) < mesh.positions.len()), "a corner of no vertex");
    assert!(mesh.polygons().all(|p| p.len() >= 3), "a polygon of two corners");
    assert_eq!(mesh.polygon_start.first(), Some(&0));
    assert_eq!(mesh.polygon_start.last().map(|end| *end as usize), Some(mesh.corners.len()));
    assert!(mesh.corner_uv.as_ref().is_none_or(|uv| uv.len() == mesh.corners.len()));
}

fn written(loaded: &Loaded, uv: &[DVec2]) -> Loaded {
    let mut text = Vec::new();
    loaded.write_obj(&mut text, uv, None).expect("memory takes all bytes");
    load_obj(&PathBuf::from("again.obj"), text).expect("what is written can be read")
}

/// A map, with the checksum that belongs to it: what is read is written as the same bytes.
fn map(path: &Path, bytes: &[u8]) {
    let body = &bytes[..bytes.len().saturating_sub(8)];
    let sum = body.iter().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3));
    let whole = [body, &u64::to_le_bytes(sum)].concat();
    fs::write(path, &whole).expect("a temporary file");
    let Some(trainer) = refused(map_file::read(path), path) else { return };
    let mut again = Vec::new();
    map_file::write(&mut again, &trainer, trainer.given.unwrap_or(0)).expect("memory takes all bytes");
    assert!(again == whole, "another map");
}

/// Labels for a strip of two quads.
fn labelled(path: &Path) {
    let mesh = Mesh {
        positions: (0..6).map(|i| DVec3::new((i % 3) as f64, (i / 3) as f64, 0.0)).collect(),
        corners: vec![0, 1, 4, 3, 1, 2, 5, 4],
        polygon_start: vec![0, 4, 8],
        ..Mesh::default()
    };
    if let Some(labels) = refused(labels::read::read("--labels", path, &mesh, Path::new("strip.obj")), path) {
        assert!(labels.label.len() == 2 && labels.label.iter().all(|l| (*l as usize) < labels.names.len()));
    }
}
