//! Seeds: small shapes of known kinds in the bytes that the targets read, and the files of `fixtures/`.

use seamwright::training::map_file;
use seamwright::training::trainer::FitTrainer;
use seamwright_core::learn::backbone::Widths;
use seamwright_core::learn::fit::FitSettings;
use std::fs;
use std::path::Path;

/// Sixteenths, and polygons of the vertices' numbers.
type Shape = (Vec<[i8; 3]>, Vec<Vec<u8>>);

/// Quads between rings of vertices; `closed` joins the last ring with the first, `turn` vertices on.
fn rings(rings: &[Vec<[i8; 3]>], closed: Option<usize>) -> Shape {
    let n = rings[0].len();
    let at = |ring: usize, i: usize| (ring * n + i % n) as u8;
    let mut faces = vec![];
    for r in 0..rings.len() - 1 {
        faces.extend((0..n).map(|i| vec![at(r, i), at(r, i + 1), at(r + 1, i + 1), at(r + 1, i)]));
    }
    if let Some(turn) = closed {
        let last = rings.len() - 1;
        faces.extend((0..n).map(|i| vec![at(last, i), at(last, i + 1), at(0, i + 1 + turn), at(0, i + turn)]));
    }
    (rings.concat(), faces)
}

fn shapes() -> Vec<(&'static str, Shape)> {
    let square = |z: i8, r: i8| vec![[r, r, z], [-r, r, z], [-r, -r, z], [r, -r, z]];
    let (tube, mut cube) =
        (rings(&[square(0, 16), square(32, 8), square(64, 16)], None), rings(&[square(0, 16), square(32, 16)], None));
    cube.1.extend([vec![3, 2, 1, 0], vec![4, 5, 6, 7]]);
    let around = |x: i8, y: i8| vec![[x * 4, y * 4, 0], [x * 2, y * 2, 16], [x * 2, y * 2, -16]];
    let loops = [around(8, 0), around(-4, 7), around(-4, -7)];
    let strip = |z: i8| (0..4).map(|x| [x * 16, z, 0]).collect::<Vec<_>>();
    let (sheet, mut open) = (rings(&[strip(0), strip(16), strip(32)], None), vec![]);
    open.extend(sheet.1.iter().filter(|face| !face.contains(&(face[0] + 3))).cloned());
    let book: Vec<Vec<u8>> = (2..8).map(|page| vec![0, 1, page]).collect();
    let pages = vec![[0, 0, 0], [0, 0, 16], [16, 0, 8], [8, 8, 8], [0, 16, 8], [-8, 8, 8], [-16, 0, 8], [0, -16, 8]];
    let fan: Vec<Vec<u8>> = (1..8).map(|i| vec![0, i, i + 1]).collect();
    let star = vec![
        [0, 0, 0],
        [16, 0, 9],
        [16, 16, 0],
        [0, 16, 9],
        [-16, 16, 0],
        [-16, 0, 9],
        [-16, -16, 0],
        [0, -16, 9],
        [16, -16, 0],
    ];
    let arrow = vec![[0, 0, 0], [32, 16, 0], [0, 32, 0], [8, 16, 0], [0, 16, 32]];
    vec![
        ("cube", cube),
        ("tube", tube),
        ("torus", rings(&loops, Some(0))),
        ("twisted", rings(&loops, Some(1))),
        ("sheet", (sheet.0, open)),
        ("book", (pages, book)),
        ("fan", (star, fan)),
        ("concave", (arrow, vec![vec![0, 1, 2, 3], vec![0, 3, 4], vec![2, 1, 0, 4]])),
        (
            "slivers",
            (vec![[0, 0, 0], [127, 1, 0], [127, 0, 0], [64, 0, 1]], vec![vec![0, 1, 2], vec![0, 3, 1], vec![0, 2, 3]]),
        ),
    ]
}

/// The shapes in the bytes that `case::Case::read` reads, with UVs to keep and parts for some.
fn meshes() -> Vec<(String, Vec<u8>)> {
    let mut seeds = vec![];
    for (name, (positions, faces)) in shapes() {
        for (variant, flags) in [0, 5].into_iter().enumerate() {
            let mut bytes = vec![1, 0, flags, positions.len() as u8 - 1];
            bytes.extend(positions.iter().flatten().map(|x| *x as u8));
            for (i, face) in faces.iter().enumerate() {
                let size = match face.len() {
                    3 => 0,
                    4 => 3,
                    _ => 5,
                };
                bytes.push(size | ((i % 2) as u8 * 8 * variant as u8));
                bytes.extend(face);
            }
            seeds.push((format!("{name}{variant}"), bytes));
        }
    }
    seeds
}

/// Files of the kinds that `fixtures/` has none of, by their place in [`crate::MESHES`] and, behind it, [`crate::OTHERS`].
fn small_files() -> Vec<(&'static str, u8, Vec<u8>)> {
    let stl = "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid s\n";
    let facet: Vec<u8> =
        [0f32, 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 0.].into_iter().flat_map(f32::to_le_bytes).collect();
    let binary = [&[0; 80][..], &1u32.to_le_bytes(), &facet, &[0; 2]].concat();
    let json = |buffer: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,"name":"n","scale":[2,1,1]}}],
            "materials":[{{"name":"m","pbrMetallicRoughness":{{"baseColorFactor":[1,0,0,1]}}}}],"meshes":[{{"primitives":[{{"attributes":
            {{"POSITION":0}},"material":0,"mode":4}}]}}],"buffers":[{{{buffer}"byteLength":36}}],"bufferViews":[{{"buffer":0,
            "byteLength":36}}],"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}]}}"#
        )
    };
    let gltf = json(&format!(r#""uri":"data:application/octet-stream;base64,{}","#, "AAAAAAAAgD8AAAAA".repeat(3)));
    let mut text = json("").into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let chunk = |kind: &[u8], data: &[u8]| [&(data.len() as u32).to_le_bytes()[..], kind, data].concat();
    let chunks = [chunk(b"JSON", &text), chunk(b"BIN\0", &facet[12..])].concat();
    let glb = [&b"glTF"[..], &2u32.to_le_bytes(), &(12 + chunks.len() as u32).to_le_bytes(), &chunks].concat();
    let fbx = r#"; FBX 7.4.0 project file
        FBXHeaderExtension: { FBXHeaderVersion: 1003
            FBXVersion: 7400 }
        Objects: {
            Geometry: 1, "Geometry::g", "Mesh" {
                Vertices: *12 { a: 0,0,0,1,0,0,1,1,0,0,1,0 }
                PolygonVertexIndex: *6 { a: 0,1,-3,0,2,-4 }
                LayerElementUV: 0 { Name: "UVMap"
                    MappingInformationType: "ByPolygonVertex"
                    ReferenceInformationType: "IndexToDirect"
                    UV: *8 { a: 0,0,1,0,1,1,0,1 }
                    UVIndex: *6 { a: 0,1,2,0,2,3 } }
                LayerElementMaterial: 0 { MappingInformationType: "AllSame"
                    ReferenceInformationType: "IndexToDirect"
                    Materials: *1 { a: 0 } }
                Layer: 0 { LayerElement: { Type: "LayerElementUV"
                        TypedIndex: 0 }
                    LayerElement: { Type: "LayerElementMaterial"
                        TypedIndex: 0 } } }
            Model: 2, "Model::m", "Mesh" { Properties70: { P: "Lcl Scaling", "Lcl Scaling", "", "A",-1,2,1 } }
            Material: 3, "Material::m", "" { Properties70: { P: "DiffuseColor", "Color", "", "A",1,0.5,0 } } }
        Connections: { C: "OO",1,2
            C: "OO",3,2
            C: "OO",2,0 }
        "#;
    let widths = Widths { hidden: 1, code: 1 };
    let mut trainer = FitTrainer::new("draft".into(), FitSettings { widths, ..FitSettings::DRAFT });
    trainer.cut = vec![1; 6];
    let mut map = vec![];
    map_file::write(&mut map, &trainer, 1).expect("memory takes all bytes");
    vec![
        ("small.stl", 2, stl.into()),
        ("binary.stl", 2, binary),
        ("small.glb", 3, glb.clone()),
        ("small.gltf", 4, gltf.into()),
        (
            "small.off",
            5,
            b"COFF\n4 2 0\n0 0 0 1 0 0 1\n1 0 0 0 1 0 1\n1 1 0 0 0 1 1\n0 1 0 1 1 1 1\n3 0 1 2\n3 0 2 3\n".to_vec(),
        ),
        ("small.fbx", 6, fbx.into()),
        ("small.seg", 7, b"0\n7\n".to_vec()),
        ("list.json", 8, b"[1, \"leg\"]".to_vec()),
        ("map.json", 8, b"{\"0\": 1, \"1\": 2.0}".to_vec()),
        ("labels.glb", 10, glb),
        ("small.map", 11, map),
        ("small.toml", 12, b"preset = \"draft\"\nwidth = 8\nsteps = 3\n[weights]\nfold = 0.5\n".to_vec()),
    ]
}

/// Writes the seeds of all targets into `folder`, a folder each; `fixtures` is the repository's.
pub fn write(folder: &Path, fixtures: &Path) -> std::io::Result<()> {
    for target in ["unwrap", "border", "learned", "files", "round_trip"] {
        fs::create_dir_all(folder.join(target))?;
    }
    for (name, mesh) in meshes() {
        for (variant, packing) in [0, 255].into_iter().enumerate() {
            let charts = variant as u8;
            // What each target reads before the mesh.
            let heads: [(&str, &[u8]); 2] = [
                ("unwrap", &[0, 0, charts, packing, 0, 0, 0, 0, 1]),
                ("border", &[0, 0, 0, 1, 0, 0, 0, charts, packing, 0]),
            ];
            for (target, head) in heads {
                fs::write(folder.join(target).join(format!("{name}_{variant}")), [head, &mesh].concat())?;
            }
        }
        // Parts by shape and by labels, training, and maps: published, of charts, and given.
        for what in [0u8, 1, 2, 3, 11, 19, 7] {
            let head = [what, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
            let head = if what == 2 { &head[..] } else { &head[..9] };
            fs::write(folder.join("learned").join(format!("{name}_{what}")), [head, &mesh].concat())?;
        }
    }
    for (name, kind, bytes) in small_files() {
        fs::write(folder.join("files").join(name), [&[kind][..], &bytes].concat())?;
        if usize::from(kind) < crate::MESHES.len() {
            fs::write(folder.join("round_trip").join(name), [&[kind, 0][..], &bytes].concat())?;
        }
    }
    for from in ["faults", "regressions", "broken"] {
        for file in fs::read_dir(fixtures.join(from))?.flatten() {
            let (path, name) = (file.path(), file.file_name().to_string_lossy().into_owned());
            let Some(kind) = crate::MESHES.iter().position(|ending| name.ends_with(ending)) else { continue };
            for choice in [0u8, 5] {
                let head = [kind as u8, choice];
                fs::write(
                    folder.join("round_trip").join(format!("{name}_{choice}")),
                    [&head[..], &fs::read(&path)?].concat(),
                )?;
            }
        }
    }
    for from in ["faults", "regressions", "broken", ""] {
        for file in fs::read_dir(fixtures.join(from))?.flatten() {
            let (path, name) = (file.path(), file.file_name().to_string_lossy().into_owned());
            let mut endings = crate::MESHES.iter().chain(&crate::OTHERS);
            let Some(kind) = endings.position(|ending| name.ends_with(ending)) else { continue };
            let bytes = fs::read(path)?;
            if bytes.len() < 4096 {
                fs::write(folder.join("files").join(&name), [&[kind as u8][..], &bytes].concat())?;
            }
        }
    }
    Ok(())
}
