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
   Shapes stand in brackets: (n, 3) is n times 3 values, row after row. */";

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
    let (mut lines, mut is_safety) = (Vec::<&str>::new(), false);
    for line in text.lines() {
        if line == "// # Safety" {
            lines.pop(); // the empty line before it
            is_safety = true;
        }
        is_safety &= line.starts_with("//");
        if !is_safety {
            lines.push(line);
        }
    }
    lines.join("\n") + "\n"
}
