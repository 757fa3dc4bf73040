//! No target but a tool: at its start it writes the seeds of all targets to corpus/, and of each run of `unwrap` that it is
//! given it prints settings and mesh, the mesh as OBJ.
#![no_main]

use libfuzzer_sys::fuzz_target;
use seamwright_fuzz::bytes::Bytes;
use seamwright_fuzz::case::{Case, settings};
use std::path::Path;

fuzz_target!(
    init: {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        seamwright_fuzz::seeds::write(&here.join("corpus"), &here.join("../../fixtures")).expect("corpus/ can be written");
    },
    |bytes: &[u8]| {
        let mut bytes = Bytes(bytes);
        let flags = bytes.byte();
        println!("# flags {flags:#x} {:?}", settings(&mut bytes, flags & 7 == 7));
        let case = Case::read(&mut bytes, usize::from(flags & 0x18 == 0x18));
        println!("# UVs {:?}\n# parts {:?}\n{}", case.kept_uv, case.parts, case.obj());
    }
);
