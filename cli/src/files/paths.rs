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

/// Whether `path` stands for standard output.
pub fn is_stdout(path: &Path) -> bool {
    path.as_os_str() == "-"
}
