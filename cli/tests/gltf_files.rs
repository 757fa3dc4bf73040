//! glTF files through the library: what came in goes out, but for the UVs. The files are looked at by a reader of a few lines
//! that shares nothing with the command's.

use glam::DVec2;
use seamwright::formats::format::Format;
use seamwright::formats::loaded::{Loaded, load, load_as};
use seamwright::formats::reading::Reading;
use seamwright::formats::target::{Mapping, Target};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/faults").join(name)
}

/// Writes `loaded` to `target` and gives the main file.
fn written(loaded: &Loaded, target: &Target, uv: impl Fn(usize) -> DVec2) -> Vec<u8> {
    let uv: Vec<DVec2> = (0..loaded.mesh().corners.len()).map(uv).collect();
    loaded.check(target).expect("it can be written");
    let files = loaded.files(target, Mapping { corner_uv: &uv, groups: None }).expect("it can be written");
    for (path, bytes) in &files.beside {
        fs::create_dir_all(path.parent().expect("a folder")).expect("a temporary folder");
        fs::write(path, bytes).expect("a temporary file");
    }
    let mut out = Vec::new();
    (files.main)(&mut out).expect("memory takes all bytes");
    out
}

fn glb() -> Target {
    Target::new(Path::new("out.glb"), Format::Glb)
}

/// A file as its JSON and bytes.
struct Plain {
    json: Value,
    data: Vec<u8>,
}

impl Plain {
    fn of(bytes: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four")) as usize;
        assert_eq!(word(8), bytes.len());
        let end = 20 + word(12);
        Self { json: serde_json::from_slice(&bytes[20..end]).expect("JSON"), data: bytes[end + 8..].to_vec() }
    }

    fn number(value: &Value) -> usize {
        value.as_u64().expect("a whole number") as usize
    }

    fn view(&self, view: &Value, from: &Value) -> &[u8] {
        let view = &self.json["bufferViews"][Self::number(view)];
        let start = view["byteOffset"].as_u64().unwrap_or(0) + from.as_u64().unwrap_or(0);
        let length = Self::number(&view["byteLength"]) - from.as_u64().unwrap_or(0) as usize;
        &self.data[start as usize..start as usize + length]
    }

    /// The bytes of each item, with those of sparse ones in their places.
    fn items(&self, accessor: &Value) -> Vec<Vec<u8>> {
        let a = &self.json["accessors"][Self::number(accessor)];
        let width = match a["type"].as_str() {
            Some("SCALAR") => 1,
            Some("VEC2") => 2,
            Some("VEC3") => 3,
            _ => 4,
        };
        let part = |kind: &Value| match kind.as_u64() {
            Some(5120 | 5121) => 1,
            Some(5122 | 5123) => 2,
            _ => 4,
        };
        let size = width * part(&a["componentType"]);
        let count = Self::number(&a["count"]);
        let mut items = vec![vec![0; size]; count];
        if !a["bufferView"].is_null() {
            let stride = self.json["bufferViews"][Self::number(&a["bufferView"])]["byteStride"].as_u64();
            let stride = stride.map_or(size, |stride| stride as usize);
            let bytes = self.view(&a["bufferView"], &a["byteOffset"]);
            items
                .iter_mut()
                .enumerate()
                .for_each(|(i, item)| item.copy_from_slice(&bytes[i * stride..i * stride + size]));
        }
        let sparse = &a["sparse"];
        for i in 0..sparse["count"].as_u64().unwrap_or(0) as usize {
            let wide = part(&sparse["indices"]["componentType"]);
            let place = &self.view(&sparse["indices"]["bufferView"], &Value::Null)[i * wide..(i + 1) * wide];
            let place = place.iter().rev().fold(0, |n, b| n << 8 | usize::from(*b));
            items[place] = self.view(&sparse["values"]["bufferView"], &Value::Null)[i * size..(i + 1) * size].to_vec();
        }
        items
    }

    /// Vertices of the triangles' corners; lines and points as they are.
    fn corners(&self, primitive: &Value) -> Vec<usize> {
        let indices = self.items(&primitive["indices"]).into_iter();
        let indices: Vec<usize> = indices.map(|i| i.iter().rev().fold(0, |n, b| n << 8 | usize::from(*b))).collect();
        match primitive["mode"].as_u64() {
            Some(5) => {
                let strip = indices.windows(3).enumerate();
                strip.flat_map(|(i, t)| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] }).collect()
            }
            _ => indices,
        }
    }

    /// Everything that a corner of each primitive has, but for the attribute `without`.
    fn wedges(&self, without: &str) -> Vec<Vec<(String, Vec<Vec<u8>>)>> {
        let mut all = Vec::new();
        for primitive in self.json["meshes"][0]["primitives"].as_array().expect("primitives") {
            let corners = self.corners(primitive);
            let mut own = Vec::new();
            let targets = primitive["targets"].as_array().cloned().unwrap_or_default();
            for (k, map) in [&primitive["attributes"]].into_iter().chain(&targets).enumerate() {
                for (name, accessor) in map.as_object().expect("a map").iter().filter(|(name, _)| *name != without) {
                    let items = self.items(accessor);
                    own.push((format!("{k} {name}"), corners.iter().map(|v| items[*v].clone()).collect()));
                }
            }
            all.push(own);
        }
        all
    }
}

#[test]
fn a_character_keeps_everything_but_its_uvs() {
    let path = fixture("rigged.glb");
    let before = Plain::of(&fs::read(&path).expect("the fixture"));
    let loaded = load(&path).expect("a sound file");
    // Every corner another UV: every vertex is split as often as it has corners.
    let uv = |c: usize| DVec2::new((c % 64) as f64 / 64.0, (c / 64) as f64 / 64.0);
    let bytes = written(&loaded, &glb(), uv);
    let after = Plain::of(&bytes);
    assert_eq!(before.wedges("TEXCOORD_0"), after.wedges("TEXCOORD_0"));
    for key in
        ["nodes", "skins", "animations", "cameras", "materials", "textures", "images", "extras", "extensions", "scenes"]
    {
        assert_eq!(before.json[key], after.json[key], "{key}");
    }
    assert_eq!(
        before.view(&before.json["images"][0]["bufferView"], &Value::Null),
        after.view(&after.json["images"][0]["bufferView"], &Value::Null)
    );
    let [old, new] = [&before, &after].map(|file| &file.json["meshes"][0]);
    assert_eq!((&old["extras"], &old["weights"], &old["name"]), (&new["extras"], &new["weights"], &new["name"]));
    let primitives = new["primitives"].as_array().expect("primitives");
    // What shared its vertices shares them still; the lines keep the old ones.
    assert_eq!(primitives[0]["attributes"], primitives[1]["attributes"]);
    assert_eq!(primitives[3], old["primitives"][3]);
    assert_eq!((&primitives[2]["mode"], &primitives[1]["extras"]["a"]), (&Value::from(4), &Value::from(1)));
    // 36 corners of eight vertices: 28 copies; indices stay bytes, vertices interleaved, bounds and names as they were.
    let accessor = |value: &Value| &after.json["accessors"][Plain::number(value)];
    let positions = accessor(&primitives[0]["attributes"]["POSITION"]);
    assert_eq!(
        (&positions["count"], &positions["name"], &positions["max"][0]),
        (&Value::from(36), &Value::from("places"), &Value::from(1))
    );
    assert_eq!(accessor(&primitives[0]["indices"])["componentType"], 5121);
    let stride =
        |value: &Value| &after.json["bufferViews"][Plain::number(&accessor(value)["bufferView"])]["byteStride"];
    assert_eq!(stride(&primitives[0]["attributes"]["WEIGHTS_0"]), 44);
    // The UVs are those that were asked for, from the top left.
    let found = after.items(&primitives[1]["attributes"]["TEXCOORD_0"]);
    for (c, v) in after.corners(&primitives[1]).into_iter().enumerate() {
        let expected = uv(18 + c);
        let bytes = [expected.x as f32, (1.0 - expected.y) as f32].map(f32::to_le_bytes).concat();
        assert_eq!(found[v], bytes, "corner {c}");
    }
    // Once more, and nothing is added.
    let folder = tempfile::tempdir().expect("a temporary folder");
    let again = folder.path().join("again.glb");
    fs::write(&again, &bytes).expect("a temporary file");
    assert_eq!(written(&load(&again).expect("our own file"), &glb(), uv).len(), bytes.len());
}

#[test]
fn without_a_seam_nothing_is_split() {
    let path = fixture("rigged.glb");
    let loaded = load(&path).expect("a sound file");
    let before = Plain::of(&fs::read(&path).expect("the fixture"));
    let mesh = loaded.mesh();
    // Each primitive has the eight vertices of its accessor in the mesh.
    let by_vertex = |c: usize| DVec2::new(f64::from(mesh.corners[c] % 8) / 8.0, 0.5);
    let after = Plain::of(&written(&loaded, &glb(), by_vertex));
    for (old, new) in before.json["accessors"]
        .as_array()
        .expect("accessors")
        .iter()
        .zip(after.json["accessors"].as_array().expect("accessors"))
    {
        assert_eq!(old["count"], new["count"]);
    }
    assert_eq!(after.json["meshes"][0]["primitives"][2]["mode"], 5);
    assert_eq!(before.wedges("TEXCOORD_0"), after.wedges("TEXCOORD_0"));
}

#[test]
fn other_sets_stay_and_old_uvs_may_too() {
    let path = fixture("rigged.glb");
    let before = Plain::of(&fs::read(&path).expect("the fixture"));
    let uv = |c: usize| DVec2::new(c as f64 / 64.0, 0.25);
    let at = |uv_set: u32, keep: bool| {
        let loaded = load_as(&path, Reading { uv_set, ..Reading::default() }).expect("a sound file");
        Plain::of(&written(&loaded, &Target { uv_set, keep, ..glb() }, uv))
    };
    let second = at(1, false);
    // The first primitives' first set is theirs still; the strip has none and gets the same twice.
    assert_eq!(before.wedges("TEXCOORD_1")[..2], second.wedges("TEXCOORD_1")[..2]);
    let strip = &second.json["meshes"][0]["primitives"][2]["attributes"];
    assert_eq!(strip["TEXCOORD_0"], strip["TEXCOORD_1"]);
    let kept = at(0, true);
    let of = |file: &Plain, name: &str| {
        let wedges = file.wedges("").swap_remove(0);
        wedges.into_iter().find(|(own, _)| own == name).map(|(_, items)| items)
    };
    assert_eq!(of(&before, "0 TEXCOORD_0"), of(&kept, "0 TEXCOORD_2"));
    assert_eq!(of(&before, "0 TEXCOORD_1"), of(&kept, "0 TEXCOORD_1"));
    assert_eq!(kept.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"], 2);
}

#[test]
fn what_a_file_requires_is_no_reason_to_refuse_it_where_it_touches_no_geometry() {
    for name in ["required_webp.glb", "required_light.glb"] {
        let loaded = load(&fixture(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!((loaded.mesh().polygon_count(), loaded.warnings().len()), (12, 0), "{name}");
    }
    let problem = load(&fixture("draco.glb")).err().expect("it is refused").to_string();
    assert!(problem.contains("Draco") && problem.contains("gltf-transform copy"), "{problem}");
    let sparse = load(&fixture("sparse.glb")).expect("a sound file");
    assert_eq!(sparse.mesh().positions[6].to_array(), [1.5; 3]);
}

#[test]
fn instances_stand_once_in_a_gltf_and_each_for_itself_elsewhere() {
    let path = fixture("instanced.glb");
    let once = load(&path).expect("a sound file");
    assert_eq!(once.mesh().polygon_count(), 12);
    let node = Plain::of(&written(&once, &glb(), |_| DVec2::ZERO)).json["nodes"][0].clone();
    assert!(node["extensions"]["EXT_mesh_gpu_instancing"].is_object());
    let each = load_as(&path, Reading { copies: true, ..Reading::default() }).expect("a sound file");
    assert_eq!((each.mesh().polygon_count(), each.mesh().positions[23].x), (36, 5.0));
    // The larger of two nodes decides how large a mesh is.
    let rigged = load(&fixture("rigged.glb")).expect("a sound file");
    assert_eq!((rigged.mesh().polygon_count(), rigged.mesh().positions[1].x), (20, 11.0));
}

#[test]
fn what_an_obj_does_not_hold_is_named() {
    let loaded = load(&fixture("rigged.glb")).expect("a sound file");
    let told = loaded.check(&Target::new(Path::new("out.obj"), Format::Obj)).expect("it can be written").join("\n");
    for what in ["1 skin,", "2 morph targets", "1 animation", "1 camera", "TEXCOORD_1", "EXAMPLE_unknown"] {
        assert!(told.contains(what), "{what}: {told}");
    }
    // It stands wherever it is drawn.
    let loaded = load_as(&fixture("rigged.glb"), Reading { copies: true, ..Reading::default() }).expect("a sound file");
    let target = Target::new(Path::new("folder/out.obj"), Format::Obj);
    let uv = vec![DVec2::ZERO; loaded.mesh().corners.len()];
    let files = loaded.files(&target, Mapping { corner_uv: &uv, groups: None }).expect("it can be written");
    let (path, text) = &files.beside[0];
    assert_eq!(path, Path::new("folder/out.mtl"));
    assert_eq!(String::from_utf8_lossy(text), "newmtl skin\nmap_Kd image0.png\n\nnewmtl paint\nKd 1 0 0\n\n");
    let mut out = Vec::new();
    (files.main)(&mut out).expect("memory takes all bytes");
    let obj = String::from_utf8(out).expect("plain text");
    assert!(
        obj.starts_with("mtllib out.mtl\nv ")
            && obj.contains("\nvn ")
            && ["body", "large"].iter().all(|name| obj.contains(&format!("\no {name}\nusemtl skin\nf "))),
        "{obj}"
    );
    // Coordinates and colour of the first vertex.
    assert_eq!(obj.lines().nth(1).map(|line| line.split(' ').count()), Some(7));
}

#[test]
fn buffers_lie_where_they_lay_and_a_glb_takes_them_in() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let loaded = load(&fixture("rigged.glb")).expect("a sound file");
    let uv = |c: usize| DVec2::new(c as f64 / 64.0, 0.5);
    // A .glb as a .gltf has its bytes beside it.
    let first = folder.path().join("a b.gltf");
    fs::write(&first, written(&loaded, &Target::new(&first, Format::Gltf), uv)).expect("a temporary file");
    let json: Value = serde_json::from_slice(&fs::read(&first).expect("it is there")).expect("JSON");
    assert_eq!(json["buffers"][0]["uri"], "a%20b.bin");
    assert!(folder.path().join("a b.bin").is_file());
    // In another folder it takes what it names along, and an image that lies outside.
    let mut outside = json.clone();
    let png = [&b"\x89PNG"[..], &[7; 9]].concat();
    fs::create_dir(folder.path().join("images")).expect("a temporary folder");
    fs::write(folder.path().join("images/x y.png"), &png).expect("a temporary file");
    outside["images"][0] = serde_json::json!({ "uri": "images/x%20y.png" });
    fs::write(&first, serde_json::to_vec(&outside).expect("JSON")).expect("a temporary file");
    let loaded = load(&first).expect("our own file");
    let second = folder.path().join("elsewhere/c.gltf");
    let text = written(&loaded, &Target::new(&second, Format::Gltf), uv);
    fs::write(&second, text).expect("a temporary file");
    assert_eq!(fs::read(folder.path().join("elsewhere/images/x y.png")).expect("it was copied"), png);
    assert!(folder.path().join("elsewhere/c.bin").is_file());
    // As a .glb it takes all in.
    let whole = Plain::of(&written(&load(&second).expect("our own file"), &glb(), uv));
    assert_eq!(
        (whole.json["buffers"].as_array().map(Vec::len), &whole.json["buffers"][0]["uri"]),
        (Some(1), &Value::Null)
    );
    assert_eq!(whole.view(&whole.json["images"][0]["bufferView"], &Value::Null), png);
    assert_eq!(whole.json["images"][0]["mimeType"], "image/png");
    let before = Plain::of(&fs::read(fixture("rigged.glb")).expect("the fixture"));
    assert_eq!(before.wedges("TEXCOORD_0"), whole.wedges("TEXCOORD_0"));
}

#[test]
fn another_format_becomes_a_glb_of_triangles() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.obj");
    let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv .5 .5 0\nvn 0 0 1\no one\nusemtl red\nf 1//1 2//1 3//1 4//1\no two\nf 1//1 2//1 5//1 4//1\n";
    fs::write(&path, text).expect("a temporary file");
    let loaded = load(&path).expect("a sound file");
    let made = Plain::of(&written(&loaded, &glb(), |c| DVec2::new(c as f64 / 8.0, 0.0)));
    assert_eq!(made.json["nodes"].as_array().map(Vec::len), Some(2));
    assert_eq!(
        (&made.json["materials"][0]["name"], &made.json["meshes"][1]["name"]),
        (&Value::from("red"), &Value::from("two"))
    );
    let primitive = &made.json["meshes"][1]["primitives"][0];
    let (corners, uv) = (made.corners(primitive), made.items(&primitive["attributes"]["TEXCOORD_0"]));
    assert_eq!(corners.len(), 6);
    // The dent at the fifth vertex: both triangles meet in its diagonal, from corner 4 to corner 6.
    let us: Vec<f32> = corners.iter().map(|v| f32::from_le_bytes(uv[*v][..4].try_into().expect("four"))).collect();
    assert_eq!(us.iter().filter(|u| **u == 0.5).count() + us.iter().filter(|u| **u == 0.75).count(), 4, "{us:?}");
    assert!(loaded.check(&glb()).expect("it can be written").iter().any(|w| w.contains("triangles alone")));
}
