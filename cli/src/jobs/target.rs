//! Where a job's mesh goes, by what was asked and the ending that was named.

use crate::args::writing::WritingArgs;
use crate::base::failure::Failure;
use crate::files::paths::is_stdout;
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
    let stream = asked.format.as_deref().and_then(Format::named);
    if stream.is_some() && !is_stdout(&asked.output) && input.as_os_str() != "-" {
        return Err(refuse("--format", "files have their endings; it says what - is".into()));
    }
    let written = |format: &Format| format.refusal().is_none();
    let of_input = || Format::of(input).or(stream).filter(written).unwrap_or(Format::Obj);
    let format = match Format::of(&asked.output) {
        _ if is_stdout(&asked.output) => stream.unwrap_or_else(of_input),
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
    if format == Format::Obj && asked.set.uv_set > 0 {
        return Err(refuse(&format!("--uv-set {}", asked.set.uv_set), "OBJ holds one set of UVs, number 0".into()));
    }
    if format == Format::Obj && asked.set.keep {
        return Err(refuse("--keep", "OBJ holds one set of UVs".into()));
    }
    Ok(Target { path: asked.output.clone(), format, uv_set: asked.set.uv_set, keep: asked.set.keep })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::writing::UvSetArgs;

    fn asked(output: &str) -> WritingArgs {
        WritingArgs {
            output: output.into(),
            format: None,
            set: UvSetArgs { uv_set: 0, keep: false },
            without_uvs: false,
        }
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
        refused(&WritingArgs { set: UvSetArgs { uv_set: 1, keep: false }, ..asked("b.obj") }, "--uv-set 1");
        refused(&WritingArgs { set: UvSetArgs { uv_set: 0, keep: true }, ..asked("b.obj") }, "--keep");
        assert!(target(&WritingArgs { without_uvs: true, ..asked("b.off") }).is_ok());
    }

    #[cfg(unix)]
    #[test]
    fn what_has_no_ending_gets_what_came_in() {
        let format = |input: &str| target(&asked("/dev/null"), Path::new(input)).map(|t| t.format);
        assert_eq!([format("a.glb"), format("a.stl")], [Ok(Format::Glb), Ok(Format::Obj)]);
    }

    #[test]
    fn streams_are_what_is_said_or_what_came_in() {
        let format = |input: &str, output: &str, said: Option<&str>| {
            let asked = WritingArgs { format: said.map(String::from), ..asked(output) };
            target(&asked, Path::new(input)).map(|t| t.format).map_err(|failure| failure.code())
        };
        assert_eq!(format("a.glb", "-", None), Ok(Format::Glb));
        assert_eq!(format("a.glb", "-", Some("ply")), Ok(Format::Ply));
        assert_eq!(format("-", "-", Some("ply")), Ok(Format::Ply));
        assert_eq!(format("-", "b.obj", Some("stl")), Ok(Format::Obj));
        assert_eq!(format("a.obj", "b.obj", Some("obj")), Err(2));
        assert_eq!(format("-", "-", Some("stl")), Err(2));
    }
}
