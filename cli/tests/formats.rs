//! Meshes of every format, from a file to an OBJ with UVs.

use glam::DVec2;
use seamwright::formats::loaded::load;
use seamwright::formats::obj::read::read;
use std::fs;
use std::path::Path;

/// Loads `folder/name` and reads back the OBJ that is written for it, with corner c at (c / 8, 0).
fn through(folder: &Path, name: &str) -> (seamwright::mesh::polygons::Mesh, String) {
    let loaded = load(&folder.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
    let uv: Vec<_> = (0..loaded.mesh().corners.len()).map(|c| DVec2::new(c as f64 / 8.0, 0.0)).collect();
    let mut out = Vec::new();
    loaded.write_obj(&mut out, &uv, None).expect("a vector takes all bytes");
    let text = String::from_utf8(out.clone()).expect("plain text");
    let back = read(out).expect("our own output").model.mesh;
    assert_eq!(back.corners, loaded.mesh().corners, "{name}");
    assert_eq!(back.corner_uv, Some(uv), "{name}");
    (back, text)
}

#[test]
fn one_triangle_comes_through_in_every_format() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    let points = [[0.5f32, 0.0, 0.0], [1.5, 0.0, 0.0], [0.5, 0.1, 0.0]];
    let floats: Vec<u8> = points.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();

    let head = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nelement face 1\nproperty list uchar uchar vertex_indices\nend_header\n";
    let files: [(&str, Vec<u8>); 6] = [
        ("a.obj", b"v .5 0 0\nv 1.5 0 0\nv .5 0.10000000149011612 0\nf 1 2 3".to_vec()),
        ("a.PLY", [head.as_bytes(), &floats, &[3, 0, 1, 2]].concat()),
        ("a.stl", [&[0; 80][..], &[1, 0, 0, 0], &[0; 12], &floats, &[0; 2]].concat()),
        ("my mesh.bin", floats.clone()),
        (
            "a.gltf",
            br#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0,"name":"n"}],"meshes":[{"primitives":[{"attributes":
            {"POSITION":0}}]}],"buffers":[{"byteLength":36,"uri":"my%20mesh.bin"}],"bufferViews":[{"buffer":0,
            "byteLength":36}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}]}"#
                .to_vec(),
        ),
        ("b.stl", b"solid\nvertex .5 0 0\nvertex 1.5 0 0\nvertex .5 0.10000000149011612 0\nendloop\nendsolid".to_vec()),
    ];
    for (name, bytes) in &files {
        fs::write(folder.join(name), bytes).expect("writable");
    }
    for name in ["a.obj", "a.PLY", "a.stl", "b.stl", "a.gltf"] {
        let (mesh, text) = through(folder, name);
        // Floats are written as the shortest decimals that read back as the same floats.
        let read_back: Vec<_> = mesh.positions.iter().map(|p| p.as_vec3().to_array()).collect();
        assert_eq!(read_back, points, "{name}");
        assert_eq!(text.contains("\no n\nf "), name == "a.gltf", "{text}");
    }
}

/// The polygons and the warnings of a fixture.
fn fault(name: &str) -> Result<(usize, String), String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/faults").join(name);
    load(&path).map(|loaded| (loaded.mesh().polygon_count(), loaded.warnings().join("\n"))).map_err(|e| e.to_string())
}

#[test]
fn texts_are_read_whatever_their_line_ends_and_headers_are() {
    for name in ["carriage_returns.stl", "one_line.stl", "byte_order_mark.stl"] {
        assert_eq!(fault(name), Ok((2, String::new())), "{name}");
    }
    let (polygons, warning) = fault("rows_beyond_header.ply").expect("it is read");
    assert!(
        polygons == 2 && warning.contains("more values than the header names") && warning.contains("line 15"),
        "{warning}"
    );
    let (polygons, warning) = fault("stray_header_line.ply").expect("it is read");
    assert!(polygons == 2 && warning.contains("line 3") && warning.contains("Made by an exporter"), "{warning}");
    let problem = fault("negative_index.ply").expect_err("it is refused");
    assert!(problem.contains("face 1 names vertex -1"), "{problem}");
    assert_eq!(fault("coloured_faces.off"), Ok((1, String::new())));
}
