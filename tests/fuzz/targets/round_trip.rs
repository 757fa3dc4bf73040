//! Bytes as a mesh of any format, written in every format and read again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use seamwright_fuzz::MESHES;
use seamwright_fuzz::round_trip::fault;
use std::fs;

fuzz_target!(|bytes: &[u8]| {
    let [kind, choice, bytes @ ..] = bytes else { return };
    // A folder of its own, so that a glTF that names other files finds none.
    let folder = std::env::temp_dir().join(format!("seamwright_round_trip_{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder for temporary files");
    let path = folder.join(format!("a.{}", MESHES[usize::from(*kind) % MESHES.len()]));
    fs::write(&path, bytes).expect("a temporary file");
    if let Some(fault) = fault(&path, *choice) {
        panic!("{fault}");
    }
});
