//! Which file a path names.

use std::fs;
use std::path::Path;

/// Whether two paths name one regular file, there already or not.
pub fn same_file(a: &Path, b: &Path) -> bool {
    let whole = |path: &Path| {
        fs::canonicalize(path).or_else(|_| {
            let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
            Ok::<_, std::io::Error>(fs::canonicalize(folder)?.join(path.file_name().unwrap_or_default()))
        })
    };
    let regular = |path: &Path| fs::metadata(path).map_or(true, |data| data.is_file());
    regular(a) && matches!((whole(a), whole(b)), (Ok(a), Ok(b)) if a == b)
}

/// Whether a standard output that scripts read from is there. What was closed when the program began was opened as the null
/// device for reading and writing by then, as no shell opens it; only Linux tells.
pub fn has_stdout() -> bool {
    let is_null = fs::read_link("/proc/self/fd/1").is_ok_and(|to| to == Path::new("/dev/null"));
    let flags = fs::read_to_string("/proc/self/fdinfo/1").unwrap_or_default();
    let flags = flags.lines().find_map(|line| u32::from_str_radix(line.strip_prefix("flags:")?.trim(), 8).ok());
    !(is_null && flags.is_some_and(|flags| flags & 3 == 2))
}

/// Whether `path` stands for standard output.
pub fn is_stdout(path: &Path) -> bool {
    path.as_os_str() == "-"
}
