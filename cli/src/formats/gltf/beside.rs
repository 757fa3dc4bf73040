//! The files that a `.gltf` names.

use super::uri::{decode_percent, has_scheme};
use serde_json::Value;
use std::path::Path;
use std::{fs, io};

/// Buffers and images in files of their own, as paths seen from the file's folder. Nothing where the text is no JSON.
pub fn files(text: &[u8]) -> Vec<String> {
    files_of(&serde_json::from_slice(text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text)).unwrap_or_default())
}

/// The same of the JSON.
pub fn files_of(tree: &Value) -> Vec<String> {
    let of = |list: &str| tree[list].as_array().cloned().unwrap_or_default();
    let uris =
        ["buffers", "images"].into_iter().flat_map(of).filter_map(|item| Some(item["uri"].as_str()?.to_string()));
    uris.filter(|uri| !has_scheme(uri)).map(|uri| decode_percent(&uri)).collect()
}

/// The bytes of such a file. What is none, such as a device or a pipe, may never end and is refused.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    if fs::metadata(path)?.is_file() { fs::read(path) } else { Err(io::Error::other("it is not a file")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_and_folders_are_not_read() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.bin");
        fs::write(&file, [7]).unwrap();
        assert_eq!(read(&file).unwrap(), [7]);
        for path in [folder.path(), &folder.path().join("b.bin"), Path::new("/dev/zero")] {
            assert!(read(path).is_err(), "{}", path.display());
        }
    }
}
