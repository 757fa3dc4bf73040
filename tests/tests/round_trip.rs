//! Fixtures and broken files through every writer and back.
//!
//! The same rules as the fuzz target `round_trip`, on seeded damage. FUZZ_CASES=100000 tries more than the tests' share.

#[path = "../fuzz/src/round_trip.rs"]
mod round_trip;

use round_trip::fault;
use seamwright_core::base::random::hash;
use seamwright_tests::fixtures::faults;
use std::fs;
use std::path::Path;

/// Cases of each file: seconds in all.
const CASES: u64 = 40;

/// The bytes with a few of them changed, left out or doubled.
fn damaged(bytes: &[u8], case: u64) -> Vec<u8> {
    let draw = |k: u64, n: usize| (hash(91, case, k) % n.max(1) as u64) as usize;
    let mut bytes = bytes.to_vec();
    for k in 0..1 + case % 3 {
        let (at, length) = (draw(4 * k, bytes.len()), draw(4 * k + 1, 12));
        let end = (at + length).min(bytes.len());
        match draw(4 * k + 2, 6) {
            0 => bytes.truncate(at),
            1 => drop(bytes.drain(at..end)),
            2 => {
                let copy = bytes[at..end].to_vec();
                bytes.splice(at..at, copy);
            }
            3 => {
                // A number of the text.
                let digits: Vec<usize> = (0..bytes.len()).filter(|i| bytes[*i].is_ascii_digit()).collect();
                let Some(digit) = digits.get(draw(4 * k + 3, digits.len())) else { continue };
                bytes[*digit] = b'0' + (draw(4 * k + 1, 10)) as u8;
            }
            _ if at < bytes.len() => bytes[at] = draw(4 * k + 3, 256) as u8,
            _ => {}
        }
    }
    bytes
}

fn try_file(name: &str, bytes: &[u8], case: u64) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("round_trip_{case}"));
    fs::create_dir_all(&folder).expect("the tests' folder can be written");
    let path = folder.join(name);
    fs::write(&path, bytes).expect("the tests' folder can be written");
    let outcome = std::panic::catch_unwind(|| fault(&path, case as u8));
    match outcome {
        Ok(None) => fs::remove_dir_all(&folder).expect("it was written"),
        Ok(Some(fault)) => panic!("{}: {fault}", path.display()),
        Err(_) => panic!("{}: panicked", path.display()),
    }
}

/// A small mesh in the formats that the fixtures have no sound file of.
fn sound() -> Vec<(&'static str, Vec<u8>)> {
    let ply = "ply\nformat ascii 1.0\ncomment c\nelement vertex 4\nproperty float x\nproperty double y\nproperty float z\nproperty float s\n\
        property float t\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 3\nproperty list uchar float texcoord\n\
        property list uchar int vertex_indices\nelement more 2\nproperty list int short a\nend_header\n0 0 0 .1 .2 9 8 7\n\
        1 0 0 .1 .2 9 8 7\n1 1 0 .1 .2 9 8 7\n0 1 1 .1 .2 9 8 7\n6 0 0 1 0 1 1 3 0 1 2\n0 2 0 1\n0 4 0 1 2 3\n1 5\n0\n";
    let strips = "ply\nformat ascii 1.0\nelement vertex 4\nproperty int x\nproperty int y\nproperty int z\nelement tristrips 1\n\
        property list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n6 0 1 2 3 -1 0\n";
    let obj = "mtllib a.mtl\no a\nv 0 0 0\nv 1 0 0 .5 .5 .5\nv 1 1 0\nv 0 1 0.1\nvt 0 0\nvt 1 1\nvn 0 0 1\ng b\nusemtl red\ns 1\n\
        f 1/1/1 2/2/1 3/1/1\ns off\nf 1//1 3 4\\\n\nusemtl blue\no c\nf -4 -3 -2 -1\nl 1/1 2/2\n";
    let far = "v 0 0 0\nv 1e308 1 1\nv 0 1 0\nvt 1e300 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
    vec![("a.ply", ply.into()), ("strips.ply", strips.into()), ("a.obj", obj.into()), ("far.obj", far.into())]
}

#[test]
fn files_come_back_in_every_format() {
    let cases = std::env::var("FUZZ_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(CASES);
    for (k, (name, bytes)) in faults::files().into_iter().chain(sound()).enumerate() {
        for choice in 0..8 {
            try_file(name, &bytes, (k as u64) << 32 | choice);
        }
        for case in 0..cases {
            let case = (k as u64 + 1000) << 32 | case;
            try_file(name, &damaged(&bytes, case), case);
        }
    }
}
