//! Random and broken files through the command's library: an error that names the file, or a valid atlas; never a panic.
//!
//! Soups of polygons on a tiny lattice (repeated corners, slits, folds, edges of many faces, faces without area) and bytes
//! of sound files with something wrong: cut off, doubled, overwritten, numbers replaced by hostile ones. All is seeded; a
//! case that fails stays in the folder that the message names, and its smallest form goes to fixtures/regressions, whose
//! files are tried here too. FUZZ_CASES=100000 tries more than the tests' share.

use glam::DVec2;
use seamwright::base::failure::Failure;
use seamwright::formats::loaded::{load, load_obj};
use seamwright::mesh::polygons::Mesh;
use seamwright::run::atlas;
use seamwright::run::progress::{Reporter, Show};
use seamwright_core::base::random::hash;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::Serial;
use seamwright_core::judge::input::UvMesh;
use seamwright_core::judge::measure::{measure, measure_need};
use seamwright_core::mesh::cracks::Weld;
use seamwright_core::pipeline::{Charts, Packing, Settings};
use std::fmt::Write;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Cases of each kind: a few seconds.
const CASES: u64 = 150;

fn cases() -> u64 {
    std::env::var("FUZZ_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(CASES)
}

/// Draws of one case.
struct Draw {
    case: u64,
    drawn: u64,
}

impl Draw {
    fn below(&mut self, n: usize) -> usize {
        self.drawn += 1;
        (hash(77, self.case, self.drawn) % n.max(1) as u64) as usize
    }

    fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }
}

/// Triangles of the file that have an area to speak of (above 1e-9 of the mean, and of the square of their longest side) in space and
/// none in UV, and those that have a negative one.
fn turned(mesh: &Mesh, uv: &[DVec2]) -> [usize; 2] {
    let size = mesh.positions.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let at = |c: usize| mesh.positions[mesh.corners[c] as usize] / size;
    let area = |[a, b, c]: [usize; 3]| (at(b) - at(a)).cross(at(c) - at(a)).length();
    let fan = |p: Range<usize>| (p.start + 1..p.end - 1).map(move |c| [p.start, c, c + 1]);
    let areas: Vec<f64> = mesh.polygons().flat_map(fan).map(area).collect();
    let least = 1e-9 * areas.iter().sum::<f64>() / areas.len() as f64;
    let longest = |[a, b, c]: [usize; 3]| {
        [[a, b], [b, c], [c, a]].map(|[p, q]| at(p).distance_squared(at(q))).into_iter().fold(0.0, f64::max)
    };
    let in_uv = |[a, b, c]: [usize; 3]| (uv[b] - uv[a]).perp_dot(uv[c] - uv[a]);
    let has_area = |t: &[usize; 3]| area(*t) > least && area(*t) > 1e-9 * longest(*t);
    let triangles = || mesh.polygons().filter(|p| p.len() == 3).flat_map(fan).filter(has_area).map(in_uv);
    [triangles().filter(|uv| *uv == 0.0).count(), triangles().filter(|uv| *uv < 0.0).count()]
}

/// Triangles of the file that overlap another by core's judge, those included that repair drops.
fn overlapping(mesh: &Mesh, uv: &[DVec2]) -> usize {
    let triangles = || mesh.polygons().filter(|p| p.len() == 3).map(|p| [p.start, p.start + 1, p.start + 2]);
    let corners: Vec<_> = triangles().map(|t| t.map(|c| mesh.corners[c])).collect();
    let corner_uv: Vec<_> = triangles().map(|t| t.map(|c| uv[c])).collect();
    let mut bytes = vec![0; measure_need(mesh.positions.len(), corners.len(), 0)];
    let mesh = UvMesh { positions: &mesh.positions, triangles: &corners, corner_uv: &corner_uv };
    measure(mesh, None, 0, Scratch::new(&mut bytes)).expect("a whole mesh and enough memory").exact.overlapping_faces
}

/// What is wrong with what happened to the file; nothing where it was refused properly or has a valid atlas.
fn fault(path: &Path, settings: &Settings) -> Option<String> {
    let made = load(path).and_then(|loaded| {
        loaded.polygons()?;
        let atlas = atlas::make(&loaded, None, false, settings, &Serial, &mut Reporter::new(Show::Nothing))?;
        let mut written = Vec::new();
        loaded.write_obj(&mut written, &atlas.corner_uv, None).expect("memory takes all bytes");
        let mesh = loaded.mesh();
        let is_same = load_obj(path, written)?.mesh().corners == mesh.corners;
        let [empty, negative] = turned(mesh, &atlas.corner_uv);
        // Faces that their neighbours outvoted look the other way in the file.
        let turned = empty + negative.saturating_sub(atlas.report.repaired.flipped_faces);
        let wrong = [turned, overlapping(mesh, &atlas.corner_uv), usize::from(!is_same)];
        Ok((atlas, wrong))
    });
    match made {
        Ok((atlas, wrong)) => {
            let inside = atlas.corner_uv.iter().all(|uv| (0.0..=1.0).contains(&uv.x) && (0.0..=1.0).contains(&uv.y));
            let open = atlas.exposure.iter().all(|e| (0.0..=1.0).contains(e));
            let report = atlas.report;
            let sound = inside && open && report.overlapping == 0 && wrong == [0; 3];
            (!sound)
                .then(|| format!("inside {inside}, exposure {open}, turned, overlapping, lost {wrong:?}, {report:?}"))
        }
        Err(Failure::Input(text)) if text.contains(&path.display().to_string()) => None,
        Err(other) => Some(format!("{other:?}")),
    }
}

/// Tries a case in a file of its own that stays where it fails.
fn try_case(name: &str, bytes: &[u8], case: u64) {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("fuzz_{case}_{name}"));
    fs::write(&path, bytes).expect("the tests' folder can be written");
    let charts = if case.is_multiple_of(3) { Charts::One } else { Charts::Few };
    // Dozens of slivers take the tight packer seconds, and it has tests of its own.
    let packing = if case % 64 == 1 { Packing::Tight } else { Packing::Grid };
    let weld = [Weld::Equal, Weld::Auto, Weld::Within(1e-3), Weld::Within(0.5)][(case / 3 % 4) as usize];
    let settings = Settings { rays: 8, charts, packing, weld, ..Settings::default() };
    let outcome = std::panic::catch_unwind(|| fault(&path, &settings));
    match outcome {
        Ok(None) => fs::remove_file(&path).expect("it was written"),
        Ok(Some(fault)) => panic!("{}: {fault}", path.display()),
        Err(_) => panic!("{}: panicked", path.display()),
    }
}

/// Polygons over few lattice points, so that everything that can coincide does.
fn soup(draw: &mut Draw) -> String {
    let mut text = String::new();
    let vertices = 3 + draw.below(14);
    let side = draw.pick(&[2, 3, 4]);
    let flat = draw.below(4) == 0;
    for _ in 0..vertices {
        let [x, y, z] = [0; 3].map(|_| draw.below(side));
        let shift = draw.pick(&[0.0, 0.0, 0.0, 1e-9, 1e-5, 0.3]);
        writeln!(text, "v {} {} {}", x as f64 + shift, y, if flat { 0 } else { z }).expect("memory");
    }
    for _ in 0..1 + draw.below(25) {
        let corners = draw.pick(&[3, 3, 3, 4, 4, 5, 6, 8]);
        text.push('f');
        for _ in 0..corners {
            write!(text, " {}", 1 + draw.below(vertices)).expect("memory");
        }
        text.push('\n');
    }
    text
}

#[test]
fn soups_of_polygons_get_valid_atlases() {
    for case in 0..cases() {
        try_case("soup.obj", soup(&mut Draw { case, drawn: 0 }).as_bytes(), case);
    }
}

/// A sound OBJ with most of what the format has.
const OBJ: &[u8] = b"# a cube without a lid\nmtllib a.mtl\no cube\nv 0 0 0\nv 1 0 0 .5 .5 .5\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\n\
    v 1 1 1\nv 0 1 1\nvt 0 0\nvt 1 0\nvt .5 1\nvn 0 0 1\ng a b\nusemtl m\ns 1\nf 4/1/1 3/2/1 2/3/1 1/1/1\nf 1//1 2//1 6//1 5//1\n\
    f 2/1 3/2 7/3 6\nf -6 -5 -1 \\\n -2\nf 4 1 5 8\nl 1 2\np 3\n";
const PLY: &[u8] = b"ply\nformat ascii 1.0\ncomment c\nelement vertex 4\nproperty float x\nproperty double y\nproperty float z\n\
    property uchar red\nelement face 3\nproperty list uchar int vertex_indices\nend_header\n0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 1 9\n\
    3 0 1 2\n3 0 2 3\n4 0 1 2 3\n";
const STL: &[u8] =
    b"solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
    facet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 1e0\nendloop\nendfacet\nendsolid s\n";

fn binary_ply() -> Vec<u8> {
    let head = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 2\nproperty list uchar uint vertex_indices\nend_header\n";
    let points: Vec<u8> = [0f32, 0., 0., 1., 0., 0., 0., 1., 0.].iter().flat_map(|x| x.to_le_bytes()).collect();
    let face = |v: [u32; 3]| [&[3u8][..], &v.map(u32::to_le_bytes).concat()].concat();
    [head.as_bytes(), &points, &face([0, 1, 2]), &face([2, 1, 0])].concat()
}

fn binary_stl() -> Vec<u8> {
    let facet = |points: [f32; 9]| [&[0; 12][..], &points.map(f32::to_le_bytes).concat(), &[0; 2]].concat();
    let facets = [facet([0., 0., 0., 1., 0., 0., 0., 1., 0.]), facet([1., 0., 0., 1., 1., 0., 0., 1., 0.])];
    [&[0; 80][..], &2u32.to_le_bytes(), &facets.concat()].concat()
}

fn glb() -> Vec<u8> {
    let mut json = br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"children":[1],
        "scale":[2,1,1]},{"mesh":0,"translation":[3,0,0]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,
        "mode":4}]}],"buffers":[{"byteLength":60}],"bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,
        "byteLength":12}],"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},{"bufferView":1,
        "componentType":5123,"count":6,"type":"SCALAR"}]}"#
        .to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let points = [0f32, 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 1.].map(f32::to_le_bytes).concat();
    let data = [points, [0u16, 1, 2, 0, 2, 3].map(u16::to_le_bytes).concat()].concat();
    let chunk = |kind: &[u8], data: &[u8]| [&(data.len() as u32).to_le_bytes()[..], kind, data].concat();
    let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", &data)].concat();
    [b"glTF", &2u32.to_le_bytes()[..], &(12 + chunks.len() as u32).to_le_bytes(), &chunks].concat()
}

/// Numbers that readers trip over.
const HOSTILE: &[&str] = &[
    "0",
    "-0",
    "-1",
    "1e308",
    "-1e308",
    "1e-320",
    "1e999",
    "nan",
    "inf",
    "4294967295",
    "4294967296",
    "2147483648",
    "-2147483649",
    "18446744073709551616",
    "1e",
    ".",
    "0x10",
    "",
    "1/1/1/1",
    "//",
    "999999999999",
    "\\",
    "\"",
    "[",
    "3.5",
];

/// The bytes with one to four things wrong.
fn broken(sound: &[u8], draw: &mut Draw) -> Vec<u8> {
    let mut bytes = sound.to_vec();
    for _ in 0..1 + draw.below(4) {
        let at = draw.below(bytes.len());
        match draw.below(7) {
            0 => bytes.truncate(at),
            1 => bytes[at] = draw.below(256) as u8,
            2 => {
                let end = (at + draw.below(40)).min(bytes.len());
                bytes.drain(at..end);
            }
            3 => {
                let end = (at + draw.below(200)).min(bytes.len());
                let copy = bytes[at..end].to_vec();
                bytes.splice(at..at, copy);
            }
            4 | 5 => {
                // A whole number of the text.
                let digit = |b: &u8| b.is_ascii_digit() || matches!(b, b'.' | b'-');
                let start = bytes[at..].iter().position(digit).map_or(at, |i| at + i);
                let end = bytes[start..].iter().position(|b| !digit(b)).map_or(bytes.len(), |i| start + i);
                bytes.splice(start..end, draw.pick(HOSTILE).bytes());
            }
            _ => bytes[at] ^= 1 << draw.below(8),
        }
        if bytes.is_empty() {
            break;
        }
    }
    bytes
}

#[test]
fn broken_files_are_refused_or_get_valid_atlases() {
    let sound: [(&str, Vec<u8>); 6] = [
        ("a.obj", OBJ.to_vec()),
        ("a.ply", PLY.to_vec()),
        ("a.stl", STL.to_vec()),
        ("b.ply", binary_ply()),
        ("b.stl", binary_stl()),
        ("a.glb", glb()),
    ];
    for (k, (name, bytes)) in sound.iter().enumerate() {
        try_case(name, bytes, 1 << 40);
        for case in 0..cases() {
            let case = ((k as u64 + 1) << 48) + case;
            try_case(name, &broken(bytes, &mut Draw { case, drawn: 0 }), case);
        }
    }
}

#[test]
fn what_once_went_wrong_does_not_any_more() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/regressions");
    let files: Vec<_> = fs::read_dir(&folder).expect("fixtures/regressions is there").flatten().collect();
    assert!(!files.is_empty(), "no file in {}", folder.display());
    for file in files {
        let name = file.file_name();
        // Both counts of charts; case 1 is packed tightly.
        for case in 0..3 {
            try_case(&name.to_string_lossy(), &fs::read(file.path()).expect("readable"), (1 << 60) + case);
        }
    }
}
