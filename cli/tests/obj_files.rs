//! OBJ files of many origins, read and written back: by our reader, by a minimal one, and by tobj.
//!
//! The mesh collections are not part of the project; where they are absent the tests say so and pass.

use glam::DVec2;
use quickcheck::{Arbitrary, Gen, QuickCheck};
use seamwright::formats::obj::file::ObjFile;
use seamwright::formats::obj::read::read;
use seamwright::formats::obj::write::write;
use std::path::{Path, PathBuf};

/// Where collections of meshes may lie beside the project; `SEAMWRIGHT_MESHES` names another place.
fn collection(name: &str) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let near = root.ancestors().map(|p| p.join("shared/meshes")).find(|p| p.is_dir());
    let Some(root) = std::env::var_os("SEAMWRIGHT_MESHES").map(PathBuf::from).or(near) else {
        println!("skipped: no shared/meshes beside the project");
        return Vec::new();
    };
    let entries = std::fs::read_dir(root.join(name)).into_iter().flatten().flatten();
    let mut paths: Vec<_> = entries.map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == "obj")).collect();
    paths.sort();
    paths
}

/// A UV that tells corners apart, on the grid of 2^-24, with some shared.
fn fake_uv(file: &ObjFile) -> Vec<DVec2> {
    let cell = |k: u32| f64::from(k % ((1 << 24) + 1)) / f64::from(1u32 << 24);
    let uv = |(c, v): (usize, &u32)| DVec2::new(cell(v.wrapping_mul(7919)), cell((c as u32 % 3).wrapping_mul(104729)));
    file.model.mesh.corners.iter().enumerate().map(uv).collect()
}

fn written(file: &ObjFile, uv: &[DVec2]) -> Vec<u8> {
    let mut out = Vec::new();
    write(&mut out, file, uv, None).expect("a vector takes all bytes");
    out
}

/// A minimal reader that shares no code with ours: whole lines, joints removed first.
#[derive(Debug, Default, PartialEq)]
struct Plain {
    positions: Vec<Vec<String>>,          // the words after `v`
    faces: Vec<Vec<(i64, Option<i64>)>>,  // vertex and normal from 1, resolved; dangling normals left out
    textures: Vec<Vec<(String, String)>>, // the uv words of each face's corners
    others: Vec<String>,                  // every other line as it is
}

fn plain(bytes: &[u8]) -> Plain {
    let latin: String = bytes.iter().map(|b| char::from(*b)).collect();
    let joined = latin.replace("\r\n", "\n").replace("\\\n", " ");
    let mut out = Plain::default();
    let (mut uv, mut raw, mut normals) = (Vec::new(), Vec::new(), 0);
    for line in joined.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.first() {
            Some(&"v") => out.positions.push(words[1..].iter().map(|w| w.to_string()).collect()),
            Some(&"vt") => uv.push((words[1].to_string(), words[2].to_string())),
            Some(&"f") if words.len() > 3 => {
                let split = |w: &&str| w.split('/').map(|i| i.parse().unwrap_or(0)).collect::<Vec<i64>>();
                let corners: Vec<Vec<i64>> = words[1..].iter().map(split).collect();
                raw.push((corners, out.positions.len() as i64, uv.len() as i64, normals));
            }
            _ => {
                normals += i64::from(words.first() == Some(&"vn"));
                out.others.push(line.to_string());
            }
        }
    }
    for (corners, v_count, t_count, n_count) in raw {
        let absolute = |i: i64, count: i64| if i < 0 { count + 1 + i } else { i };
        let field = |c: &Vec<i64>, k: usize| c.get(k).copied().unwrap_or(0);
        let normal = |c| Some(absolute(field(c, 2), n_count)).filter(|n| (1..=normals).contains(n));
        out.faces.push(corners.iter().map(|c| (absolute(c[0], v_count), normal(c))).collect());
        let texture = |c| uv.get((absolute(field(c, 1), t_count) - 1) as usize).cloned().unwrap_or_default();
        out.textures.push(corners.iter().map(texture).collect());
    }
    out
}

#[test]
fn every_file_comes_back_with_its_own_content_and_the_new_uvs() {
    let paths: Vec<_> = ["hard", "bench"].iter().flat_map(|name| collection(name)).collect();
    for path in paths {
        let bytes = std::fs::read(&path).expect("listed");
        let file = match read(bytes.clone()) {
            Ok(file) => file,
            Err(e) => {
                assert!(path.ends_with("ai_malformed.obj"), "{}: {e}", path.display());
                continue;
            }
        };
        let uv = fake_uv(&file);
        let out = written(&file, &uv);
        let (before, after) = (plain(&bytes), plain(&out));
        assert_eq!(before.positions, after.positions, "{}", path.display());
        assert_eq!(before.faces, after.faces, "{}", path.display());
        assert_eq!(before.others, after.others, "{}", path.display());
        let words = after.textures.iter().flatten();
        let read_back: Vec<_> = words.map(|(u, v)| DVec2::new(u.parse().unwrap(), v.parse().unwrap())).collect();
        assert_eq!(read_back, uv, "{}", path.display());

        let again = read(out.clone()).expect("our own output");
        assert_eq!(again.model.mesh.corner_uv.clone().unwrap_or_default(), uv, "{}", path.display());
        assert_eq!(written(&again, &uv), out, "writing twice changes nothing: {}", path.display());
    }
}

#[test]
fn tobj_reads_the_same_polygons_and_uvs_from_our_output() {
    let paths: Vec<_> = ["hard", "bench"].iter().flat_map(|name| collection(name)).collect();
    for path in paths {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let bytes = std::fs::read(&path).expect("listed");
        let Ok(file) = read(bytes.clone()) else { continue };
        let uv = fake_uv(&file);
        let models = match tobj_models(&written(&file, &uv)) {
            Ok(models) => models,
            Err(e) => {
                let before = tobj_models(&bytes).map(|_| ());
                assert!(before.is_err(), "{name}: tobj reads the original, but of ours it says: {e}");
                println!("{name}: tobj refuses the original too: {e}");
                continue;
            }
        };
        let mut corner = 0;
        for mesh in models.iter().map(|m| &m.mesh) {
            if mesh.texcoord_indices.len() < mesh.indices.len() {
                continue; // lines and points count as faces there
            }
            for i in 0..mesh.indices.len() {
                let (v, t) = (mesh.indices[i] as usize, mesh.texcoord_indices[i] as usize);
                let position = file.model.mesh.positions[file.model.mesh.corners[corner] as usize].to_array();
                assert_eq!(mesh.positions[3 * v..3 * v + 3], position, "{name}");
                assert_eq!(mesh.texcoords[2 * t..2 * t + 2], uv[corner].to_array(), "{name}");
                corner += 1;
            }
        }
        assert_eq!(corner, file.model.mesh.corners.len(), "{name}");
    }
}

fn tobj_models(bytes: &[u8]) -> Result<Vec<tobj::Model>, tobj::LoadError> {
    let options = tobj::LoadOptions::default();
    tobj::load_obj_buf(&mut &bytes[..], &options, |_| Ok(Default::default())).map(|(models, _)| models)
}

/// Bytes that look like an OBJ and are broken somewhere.
#[derive(Clone, Debug)]
struct Broken(Vec<u8>);

impl Arbitrary for Broken {
    fn arbitrary(g: &mut Gen) -> Self {
        let pieces: [&[u8]; 26] = [
            b"v 0 0 0\n",
            b"v 1 0 0\n",
            b"v 0 1 0 1\r\n",
            b"vt .5 .5\n",
            b"vt\n",
            b"vn 0 0 1\r",
            b"f 1 2 3\n",
            b"f -1 -2 -3\n",
            b"f 1/1/1 2/1/1 \\\n3/1/1\n",
            b"f",
            b" ",
            b"/",
            b"\\",
            b"\n",
            b"#",
            b"-",
            b"1e400",
            b"nan",
            b"0",
            b"9",
            b"l 1/1 2/1\n",
            b"usemtl \xff\xfe\n",
            b"99999999999",
            b"\t",
            b"\r\n",
            b"\xEF\xBB\xBF",
        ];
        let count = usize::arbitrary(g) % 40;
        let mut bytes: Vec<u8> =
            (0..count).flat_map(|_| g.choose(&pieces).copied().unwrap_or_default().to_vec()).collect();
        for _ in 0..u8::arbitrary(g) % 4 {
            if let Some(i) = usize::arbitrary(g).checked_rem(bytes.len()) {
                bytes[i] = u8::arbitrary(g);
            }
        }
        Broken(bytes)
    }
}

fn never_panics(bytes: Vec<u8>) -> bool {
    let Ok(file) = read(bytes) else { return true };
    assert!(file.model.mesh.corners.iter().all(|v| (*v as usize) < file.model.mesh.positions.len()));
    let uv = fake_uv(&file);
    let again = read(written(&file, &uv)).expect("what was readable stays readable");
    again.model.mesh.positions == file.model.mesh.positions
        && again.model.mesh.corners == file.model.mesh.corners
        && again.model.mesh.polygon_start == file.model.mesh.polygon_start
        && again.corner_normal == file.corner_normal
        && again.model.mesh.corner_uv.unwrap_or_default() == uv
}

#[test]
fn random_bytes_never_panic() {
    QuickCheck::new().tests(2000).quickcheck(never_panics as fn(Vec<u8>) -> bool);
}

#[test]
fn broken_files_never_panic_and_survive_a_round_trip() {
    fn holds(broken: Broken) -> bool {
        never_panics(broken.0)
    }
    QuickCheck::new().tests(5000).quickcheck(holds as fn(Broken) -> bool);
}

#[test]
fn cut_and_damaged_real_files_never_panic() {
    let mut state = 1u64;
    let mut random = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as usize
    };
    for path in collection("hard") {
        let bytes = std::fs::read(&path).expect("listed");
        let bytes = &bytes[..bytes.len().min(4000)];
        for _ in 0..40 {
            let mut damaged = bytes[..random() % (bytes.len() + 1)].to_vec();
            for _ in 0..random() % 6 {
                if !damaged.is_empty() {
                    let i = random() % damaged.len();
                    damaged[i] = b" \n\\/-#0f\xff"[random() % 9];
                }
            }
            assert!(never_panics(damaged), "{}", path.display());
        }
    }
}
