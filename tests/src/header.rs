//! The C header of core/ffi, rendered from its Rust definitions by cbindgen.

use cbindgen::{Builder, Config, DocumentationStyle, Language};
use std::path::{Path, PathBuf};

/// Where the header stands.
pub fn path() -> PathBuf {
    package().join("include/seamwright.h")
}

fn package() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../core/ffi")
}

const OPENING: &str = "\
/* seamwright: a UV atlas of a mesh, in the caller's memory. Generated from core/ffi/src by
   `cargo run -p seamwright-tests --bin header`; do not edit.

   Every function that answers int32_t answers SEAMWRIGHT_OK or another of the codes below. Nothing is allocated, nothing
   is kept between calls, and no thread is started; different threads may call at the same time with different buffers.
   Pointers point to as much as is said beside them, and nobody else writes there during a call; what can be checked is.
   Shapes stand in brackets: (n, 3) is n times 3 values, row after row.

   Every struct begins with its sizeof, so that it can grow at its end. `SeamwrightMesh mesh = SEAMWRIGHT_MESH_INIT;` says it
   and leaves the rest 0 and NULL, which say nothing; all structs have such a macro but the options, which
   `seamwright_defaults` fills. A program that was compiled with an older header may so use a newer library: what its structs
   lack counts as 0, or is not written. So may one with a newer header use an older library, where it says nothing that
   library does not know (SEAMWRIGHT_NEWER_STRUCT); figures that it does not know stay as they were. */";

/// What a struct begins as: its size, and a zero for each other field, since C++ and careful compilers want all of them.
/// Of the options 0 is no default.
fn initialiser(name: &str, fields: usize) -> Option<String> {
    let short = name.strip_prefix("Seamwright").filter(|short| *short != "Options")?;
    let zeros = ", 0".repeat(fields - 1);
    Some(format!("#define SEAMWRIGHT_{}_INIT {{sizeof({name}){zeros}}}", short.to_uppercase()))
}

/// The header's text.
pub fn render() -> String {
    let config = Config {
        language: Language::C,
        header: Some(OPENING.into()),
        include_guard: Some("SEAMWRIGHT_H".into()),
        no_includes: true,
        sys_includes: vec!["stddef.h".into(), "stdint.h".into()],
        cpp_compat: true,
        usize_is_size_t: true,
        documentation_style: DocumentationStyle::C99,
        tab_width: 4,
        ..Config::default()
    };
    let builder = Builder::new().with_config(config).with_src(package().join("src/lib.rs"));
    let mut text = Vec::new();
    builder.generate().expect("definitions that C can have").write(&mut text);
    let text = String::from_utf8(text).expect("text");
    // What Rust calls safety is C's everyday: the opening says it once.
    let (mut lines, mut is_safety, mut fields) = (Vec::<String>::new(), false, 0);
    for line in text.lines() {
        if line == "// # Safety" {
            lines.pop(); // the empty line before it
            is_safety = true;
        }
        is_safety &= line.starts_with("//");
        if !is_safety {
            lines.push(line.into());
        }
        fields += usize::from(line.ends_with(';') && line.starts_with("    ") && !line.contains("//"));
        if let Some(name) = line.strip_prefix("} ").and_then(|end| end.strip_suffix(';')) {
            lines.extend(initialiser(name, std::mem::take(&mut fields)));
        }
    }
    lines.join("\n") + "\n"
}
