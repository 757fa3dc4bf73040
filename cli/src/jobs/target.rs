//! Where a job's mesh goes, by what was asked and the ending that was named.

use crate::args::writing::WritingArgs;
use crate::base::failure::Failure;
use crate::formats::format::Format;
use crate::formats::target::Target;
use std::fs;
use std::path::Path;

/// The target that `asked` names for the mesh at `input`. What its format cannot hold is refused.
pub fn target(asked: &WritingArgs, input: &Path) -> Result<Target, Failure> {
    let refuse = |flag: &str, text: String| Failure::Usage(format!("{flag}: {text}"));
    let named = format!("-o {}", asked.output.display());
    const OTHERS: &str = "name a file that ends in .obj, .ply, .glb or .gltf";
    // What is no regular file, such as a pipe, has no ending to go by: it gets what came in.
    let special = fs::metadata(&asked.output).is_ok_and(|data| !data.is_file() && !data.is_dir());
    let of_input = || Format::of(input).filter(|format| format.refusal().is_none()).unwrap_or(Format::Obj);
    let format = match Format::of(&asked.output) {
        Some(format) => format,
        None if special => of_input(),
        None => return Err(refuse(&named, format!("unknown ending; {OTHERS}"))),
    };
    match format.refusal() {
        Some(why) if format == Format::Off && !asked.without_uvs => {
            return Err(refuse(&named, format!("{why}; {OTHERS}, or add --without-uvs")));
        }
        Some(why) if format != Format::Off => return Err(refuse(&named, format!("{why}; {OTHERS}"))),
        None if asked.without_uvs => {
            return Err(refuse("--without-uvs", format!("{} holds UVs; leave it out", format.name())));
        }
        _ => {}
    }
    if format == Format::Obj && asked.uv_set > 0 {
        return Err(refuse(&format!("--uv-set {}", asked.uv_set), "OBJ holds one set of UVs, number 0".into()));
    }
    if format == Format::Obj && asked.keep {
        return Err(refuse("--keep", "OBJ holds one set of UVs".into()));
    }
    Ok(Target { path: asked.output.clone(), format, uv_set: asked.uv_set, keep: asked.keep })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(output: &str) -> WritingArgs {
        WritingArgs { output: output.into(), uv_set: 0, keep: false, without_uvs: false }
    }

    #[test]
    fn the_ending_decides_and_what_holds_no_uvs_is_refused_with_its_reason() {
        let target = |asked: &WritingArgs| target(asked, Path::new("a.ply"));
        assert_eq!(target(&asked("b.GLB")).map(|t| t.format), Ok(Format::Glb));
        let refused = |asked: &WritingArgs, reason: &str| {
            let failure = target(asked).expect_err("it is refused");
            assert!(failure.code() == 2 && failure.to_string().contains(reason), "{failure}");
        };
        refused(&asked("b.stl"), "STL holds no UVs");
        refused(&asked("b.fbx"), "not written");
        refused(&asked("b"), "unknown ending");
        refused(&asked("b.off"), "--without-uvs");
        refused(&WritingArgs { without_uvs: true, ..asked("b.ply") }, "leave it out");
        refused(&WritingArgs { uv_set: 1, ..asked("b.obj") }, "--uv-set 1");
        refused(&WritingArgs { keep: true, ..asked("b.obj") }, "--keep");
        assert!(target(&WritingArgs { without_uvs: true, ..asked("b.off") }).is_ok());
    }

    #[cfg(unix)]
    #[test]
    fn what_has_no_ending_gets_what_came_in() {
        let format = |input: &str| target(&asked("/dev/null"), Path::new(input)).map(|t| t.format);
        assert_eq!([format("a.glb"), format("a.stl")], [Ok(Format::Glb), Ok(Format::Obj)]);
    }
}
