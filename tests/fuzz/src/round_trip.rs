//! A file read, written in every format, and read again: what must be the same.
//!
//! Shared by the fuzz target `round_trip` and the suite of the same name.

use glam::{DVec2, DVec3};
use seamwright::base::failure::Failure;
use seamwright::formats::format::Format;
use seamwright::formats::labels::kind::LabelKind;
use seamwright::formats::labels::{read, write};
use seamwright::formats::loaded::{Loaded, load_as};
use seamwright::formats::reading::Reading;
use seamwright::formats::target::{Mapping, Target};
use seamwright::mesh::polygons::Mesh;
use std::fs;
use std::path::Path;

/// Corners up to which a mesh is written.
const FEW: usize = 20_000;

/// What is wrong with what becomes of the file at `path`, whose folder is nobody else's; nothing where it is refused properly,
/// or comes back. `choice` picks the set of UVs and whether old ones stay.
pub fn fault(path: &Path, choice: u8) -> Option<String> {
    let (uv_set, keep) = (u32::from(choice % 3), choice & 4 != 0);
    for format in [Format::Glb, Format::Gltf, Format::Ply, Format::Obj, Format::Off] {
        let has_one = matches!(format, Format::Obj | Format::Off);
        let (uv_set, keep) = if has_one { (0, false) } else { (uv_set, keep) };
        let reading = Reading { uv_set, copies: !format.has_instances() };
        let loaded = match load_as(path, reading) {
            Ok(loaded) => loaded,
            Err(Failure::Input(text)) if text.contains(&path.display().to_string()) => return None,
            Err(other) => return Some(format!("{other:?}")),
        };
        if let Some(fault) = broken(&loaded) {
            return Some(fault);
        }
        if loaded.mesh().corners.len() > FEW || loaded.polygons().is_err() {
            continue;
        }
        if let Some(fault) = (format == Format::Obj).then(|| labelled(path, loaded.mesh())).flatten() {
            return Some(fault);
        }
        let ending = format.name().to_lowercase();
        let out = path.with_file_name("out").join(format!("a.{ending}"));
        let target = Target { uv_set, keep, ..Target::new(&out, format) };
        if let Some(fault) = written(&loaded, &target) {
            return Some(format!("{} to {}: {fault}", path.display(), format.name()));
        }
    }
    None
}

/// What of a mesh's promises does not hold.
fn broken(loaded: &Loaded) -> Option<String> {
    let mesh = loaded.mesh();
    let corners = mesh.corners.len();
    let of_corners = [
        mesh.corner_uv.as_ref().map_or(corners, Vec::len),
        mesh.corner_normals.as_ref().map_or(corners, Vec::len),
        mesh.edge_marks.as_ref().map_or(corners, Vec::len),
    ];
    let model = loaded.model();
    let holds = mesh.positions.iter().all(|p| p.is_finite())
        && mesh.corners.iter().all(|v| (*v as usize) < mesh.positions.len())
        && mesh.polygons().all(|p| p.len() >= 3)
        && mesh.polygon_start.last().map(|end| *end as usize) == Some(corners)
        && of_corners == [corners; 3]
        && mesh.tolerance.is_finite()
        && model.colours.as_ref().is_none_or(|colours| colours.len() == mesh.positions.len())
        && model.pieces.windows(2).all(|pair| pair[0].first <= pair[1].first)
        && model.pieces.iter().filter_map(|piece| piece.material).all(|m| (m as usize) < model.materials.len());
    (!holds).then(|| "the mesh is not whole".into())
}

/// Labels of `mesh`, written in every form and read again for it.
fn labelled(path: &Path, mesh: &Mesh) -> Option<String> {
    let labels: Vec<u32> = (0..mesh.polygon_count()).map(|p| (p % 3).min(p) as u32).collect();
    let folder = path.with_file_name("labels");
    fs::create_dir_all(&folder).expect("a temporary folder");
    for ending in ["seg", "json", "ply", "glb"] {
        let out = folder.join(format!("a.{ending}"));
        let mut bytes = Vec::new();
        let kind = LabelKind::of(&out).expect("an ending of labels");
        if write::write(&mut bytes, kind, mesh, &labels).is_err() {
            assert!(ending == "glb" && bytes.is_empty(), "memory takes all bytes");
            continue; // a coordinate that no float holds
        }
        fs::write(&out, &bytes).expect("a temporary file");
        match read::read("--labels", &out, mesh, path) {
            // A GLB has single precision and the order of its parts: faces at one place are one.
            Err(Failure::Input(text)) if ending == "glb" && text.contains(&out.display().to_string()) => {}
            Err(other) => return Some(format!("{other:?}")),
            Ok(back) if ending == "glb" || back.label == labels => {}
            Ok(back) => return Some(format!("labels in {ending}: {:?}, not {labels:?}", back.label)),
        }
    }
    fs::remove_dir_all(&folder).expect("a temporary folder");
    None
}

fn written(loaded: &Loaded, target: &Target) -> Option<String> {
    let mesh = loaded.mesh();
    let uv: Vec<DVec2> = (0..mesh.corners.len())
        .map(|c| DVec2::new((c % 1024) as f64 / 1024.0, (c / 1024 % 1024) as f64 / 1024.0))
        .collect();
    match loaded.check(target) {
        Ok(_) => {}
        Err(Failure::Input(_)) => return None,
        Err(other) => return Some(format!("{other:?}")),
    }
    let files = match loaded.files(target, Mapping { corner_uv: &uv, groups: None }) {
        Ok(files) => files,
        Err(Failure::Output(_)) => return None, // an image that lies where another file is
        Err(other) => return Some(format!("{other:?}")),
    };
    let folder = target.path.parent().unwrap_or(Path::new(""));
    fs::create_dir_all(folder).expect("a temporary folder");
    for (path, bytes) in files.beside.iter().filter(|(path, _)| path.starts_with(folder)) {
        fs::create_dir_all(path.parent().unwrap_or(folder)).expect("a temporary folder");
        fs::write(path, bytes).expect("a temporary file");
    }
    let mut bytes = Vec::new();
    (files.main)(&mut bytes).expect("memory takes all bytes");
    fs::write(&target.path, &bytes).expect("a temporary file");
    let again = match load_as(&target.path, Reading { uv_set: target.uv_set, ..Reading::default() }) {
        Ok(again) => again,
        Err(e) => return Some(format!("what was written is refused: {e}")),
    };
    fs::remove_dir_all(folder).expect("a temporary folder");
    let back = again.mesh();
    if matches!(target.format, Format::Glb | Format::Gltf) {
        return as_triangles(mesh, back, &uv);
    }
    if back.polygon_start != mesh.polygon_start {
        return Some(format!("{} polygons, not {}", back.polygon_count(), mesh.polygon_count()));
    }
    let places = |mesh: &Mesh| -> Vec<DVec3> { mesh.corners.iter().map(|v| mesh.positions[*v as usize]).collect() };
    if !places(mesh).iter().zip(&places(back)).all(|(a, b)| is_same(*a, *b)) {
        return Some("other positions".into());
    }
    if target.format != Format::Off && back.corner_uv.as_deref() != Some(&uv[..]) {
        let differs = back.corner_uv.iter().flatten().zip(&uv).position(|(a, b)| a != b);
        return Some(format!("other UVs, first at corner {differs:?}"));
    }
    None
}

/// Whether two coordinates are the same to a reader of floats.
fn is_same(a: DVec3, b: DVec3) -> bool {
    a == b || a.as_vec3() == b.as_vec3()
}

/// What is wrong with the triangles of a glTF, where polygons are cut and stand by object and material. A corner of the mesh is
/// known by its UV.
fn as_triangles(mesh: &Mesh, back: &Mesh, uv: &[DVec2]) -> Option<String> {
    let polygon_of: Vec<usize> = mesh.polygons().enumerate().flat_map(|(p, corners)| corners.map(move |_| p)).collect();
    let mut left: Vec<usize> = mesh.polygons().map(|p| p.len() - 2).collect();
    let back_uv = back.corner_uv.as_deref().unwrap_or_default();
    for corners in back.polygons() {
        let mut polygons = Vec::new();
        for c in corners {
            let own = back_uv.get(c).copied().unwrap_or(DVec2::NAN);
            let known = (own.x * 1024.0 + own.y * 1024.0 * 1024.0) as usize;
            if uv.get(known) != Some(&own) {
                return Some(format!("other UVs, first at corner {c}"));
            }
            if !is_same(mesh.positions[mesh.corners[known] as usize], back.positions[back.corners[c] as usize]) {
                return Some("other positions".into());
            }
            polygons.push(polygon_of[known]);
        }
        let first = polygons[0];
        if polygons != [first; 3] || left[first] == 0 {
            return Some(format!("a triangle of polygons {polygons:?}"));
        }
        left[first] -= 1;
    }
    left.iter().any(|n| *n > 0).then(|| "triangles are missing".into())
}
