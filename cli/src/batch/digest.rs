//! What stands for the content of files and settings: SHA-256 in hexadecimal digits.

use crate::formats::format::Format;
use crate::formats::gltf::beside;
use sha2::{Digest, Sha256};
use std::fs;
use std::io;
use std::path::Path;

/// Of some bytes.
pub(super) fn of_bytes(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// Of a mesh's file, of the files that it names, and of the words by which it is unwrapped.
pub(super) fn of_job(input: &Path, words: &[String]) -> io::Result<String> {
    let mut hash = Sha256::new();
    let mut put = |bytes: &[u8]| {
        hash.update((bytes.len() as u64).to_le_bytes()); // so that no two lists of pieces are one text
        hash.update(bytes);
    };
    put(env!("CARGO_PKG_VERSION").as_bytes());
    words.iter().for_each(|word| put(word.as_bytes()));
    let bytes = fs::read(input)?;
    put(&bytes);
    if Format::of(input) == Some(Format::Gltf) {
        let folder = input.parent().unwrap_or(Path::new(""));
        // One that is missing is the reader's to name.
        beside::files(&bytes).iter().for_each(|name| put(&beside::read(&folder.join(name)).unwrap_or_default()));
    }
    Ok(hex(&hash.finalize()))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}
