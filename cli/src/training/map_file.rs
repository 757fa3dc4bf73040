//! Trained maps in a file: little-endian on every machine, weights in 16 bits, a checksum at the end.
//!
//! Layout: `Header`; for each map its `Frame3` (12 f64, row by row: three rows of a linear map, then what is added), then its
//! weights (f16, in the order of `core::learn::backbone::NAMES`, each layer's matrix (outputs, inputs) before its bias); the
//! FNV-1a hash (u64) of all bytes before it. Whatever is not exactly that is refused.

use crate::base::failure::Failure;
use crate::training::trainer::{Trainer, WIDEST};
use bytemuck::{Pod, Zeroable, bytes_of, pod_read_unaligned};
use half::f16;
use seamwright_core::learn::backbone::Widths;
use seamwright_core::learn::training::TrainSettings;
use seamwright_core::pipeline::learning::MOST;
use std::io::{self, Write};
use std::path::Path;

const MAGIC: [u8; 8] = *b"seamMAP\n";
/// Goes up when the layout changes.
const VERSION: u32 = 1;

/// The first bytes; each number little-endian.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
struct Header {
    magic: [u8; 8],
    version: [u8; 4],
    hidden: [u8; 4],
    code: [u8; 4],
    maps: [u8; 4],
    side: [u8; 4],
}

/// Writes the maps of `trainer`.
pub fn write(out: &mut dyn Write, trainer: &Trainer) -> io::Result<()> {
    out.write_all(&bytes(trainer))
}

fn bytes(trainer: &Trainer) -> Vec<u8> {
    let Widths { hidden, code } = trainer.settings.widths;
    let count = trainer.summary.maps;
    let number = |x: usize| (x as u32).to_le_bytes();
    let header = Header {
        magic: MAGIC,
        version: VERSION.to_le_bytes(),
        hidden: number(hidden),
        code: number(code),
        maps: number(count),
        side: (trainer.settings.side as f32).to_le_bytes(),
    };
    let mut bytes = bytes_of(&header).to_vec();
    let width = trainer.settings.widths.parameter_count();
    for (frame, weights) in trainer.frames.iter().zip(trainer.weights.chunks_exact(width)).take(count) {
        bytes.extend(frame.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend(weights.iter().flat_map(|w| f16::from_f32(*w).to_le_bytes()));
    }
    bytes.extend(hash(&bytes).to_le_bytes());
    bytes
}

/// Reads maps; the message of a failure names what is wrong with the file.
pub fn read(path: &Path) -> Result<Trainer, Failure> {
    let bytes = std::fs::read(path).map_err(|e| Failure::input(path, &e))?;
    parse(&bytes).map_err(|text| Failure::Input(format!("{}: {text}", path.display())))
}

fn parse(bytes: &[u8]) -> Result<Trainer, String> {
    const SIZE: usize = size_of::<Header>();
    if bytes.len() < SIZE || bytes[..MAGIC.len()] != MAGIC {
        return Err("not a map of seamwright; write one with unwrap --save-map".into());
    }
    let header: Header = pod_read_unaligned(&bytes[..SIZE]);
    let version = u32::from_le_bytes(header.version);
    if version != VERSION {
        return Err(format!("version {version} of the map format; this seamwright reads {VERSION}, so train it anew"));
    }
    let [hidden, code, maps] = [header.hidden, header.code, header.maps].map(|x| u32::from_le_bytes(x) as usize);
    let is_width = |x: usize| (1..=WIDEST).contains(&x);
    if !is_width(hidden) || !is_width(code) || !(1..=MOST).contains(&maps) {
        return Err(format!("damaged: {maps} maps of widths {hidden} and {code}; write it anew"));
    }
    let side = f64::from(f32::from_le_bytes(header.side));
    let widths = Widths { hidden, code };
    let count = widths.parameter_count();
    let expected = SIZE + maps * (12 * 8 + 2 * count) + 8;
    if bytes.len() != expected {
        return Err(format!("damaged: {} bytes where {expected} belong; copy or write it anew", bytes.len()));
    }
    let (body, sum) = bytes.split_at(expected - 8);
    if hash(body).to_le_bytes() != sum {
        return Err("damaged: the checksum is wrong; copy or write it anew".into());
    }
    let mut trainer = Trainer::with("given".into(), TrainSettings { widths, side, ..TrainSettings::STANDARD }, true);
    trainer.given = maps;
    for (k, map) in body[SIZE..].chunks_exact(12 * 8 + 2 * count).enumerate() {
        let (frame, weights) = map.split_at(12 * 8);
        for (to, from) in trainer.frames[k].as_flattened_mut().iter_mut().zip(frame.chunks_exact(8)) {
            *to = f64::from_le_bytes(pod_read_unaligned(from));
        }
        for (to, from) in trainer.weights[k * count..].iter_mut().zip(weights.chunks_exact(2)) {
            *to = f16::from_le_bytes(pod_read_unaligned(from)).to_f32();
        }
        if !trainer.frames[k].as_flattened().iter().all(|x| x.is_finite()) {
            return Err("damaged: a frame that is not a number; write it anew".into());
        }
    }
    if !side.is_finite() || !trainer.weights.iter().all(|w| w.is_finite()) {
        return Err("a number that is none; train it anew".into());
    }
    Ok(trainer)
}

/// FNV-1a (Fowler, Noll, Vo).
fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trainer() -> Trainer {
        let widths = Widths { hidden: 3, code: 2 };
        let mut trainer = Trainer::with("draft".into(), TrainSettings { widths, ..TrainSettings::DRAFT }, true);
        trainer.summary.maps = 2;
        trainer.weights.iter_mut().enumerate().for_each(|(i, w)| *w = i as f32 / 8.0);
        trainer.frames[1] = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0], [-1e9, 0.0, 1e-9]];
        trainer
    }

    #[test]
    fn maps_come_back_and_the_bytes_are_the_same_on_every_machine() {
        let before = trainer();
        let bytes = bytes(&before);
        let after = parse(&bytes).unwrap();
        let used = 2 * before.settings.widths.parameter_count();
        assert_eq!((after.given, after.settings.widths), (2, before.settings.widths));
        assert_eq!(after.settings.side, before.settings.side);
        assert_eq!((&after.frames[..2], &after.weights[..used]), (&before.frames[..2], &before.weights[..used]));
        assert_eq!(bytes[8..24], [1, 0, 0, 0, 3, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0]);
        assert_eq!(bytes[28 + 96 + 2..][..2], [0x00, 0x30], "0.125 in 16 bits");
    }

    #[test]
    fn no_changed_missing_or_added_byte_is_taken() {
        let whole = bytes(&trainer());
        for at in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[at] ^= 0x20;
            assert!(parse(&damaged).is_err(), "byte {at}");
            assert!(parse(&whole[..at]).is_err(), "the first {at} bytes");
        }
        assert!(parse(&[&whole[..], &[0]].concat()).is_err_and(|e| e.contains("damaged")));
        assert!(parse(b"v 1 2 3").is_err_and(|e| e.contains("not a map")));
        let mut later = whole;
        later[8] = 9;
        assert!(parse(&later).is_err_and(|e| e.contains("version 9")));
    }
}
