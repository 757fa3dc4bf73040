//! A learned map in a file: little-endian on every machine, a checksum at the end.
//!
//! Layout: `Header`; the weights (f16, in the order of core's `ChartNet::layers`, each layer's matrix (outputs, inputs) before its
//! bias); the cuts, a bit for each half-edge of the working mesh, lowest first; the corrections (corner as u32, its UV as two f64); the
//! FNV-1a hash (u64) of all bytes before it. Whatever is not exactly that is refused.

use super::trainer::{FitTrainer, WIDEST};
use crate::base::failure::Failure;
use crate::mesh::polygons::Mesh;
use bytemuck::{Pod, Zeroable, bytes_of, pod_read_unaligned};
use glam::DVec2;
use half::f16;
use seamwright_core::learn::backbone::Widths;
use seamwright_core::learn::fit::FitSettings;
use std::io::{self, Write};
use std::path::Path;

const MAGIC: [u8; 8] = *b"seamMAP\n";
/// Goes up when the layout changes.
const VERSION: u32 = 2;
/// Half-edges of a mesh at the most.
const MOST_CORNERS: usize = u32::MAX as usize;
/// Bytes of a correction.
const CORRECTION: usize = 4 + 16;

/// The first bytes; each number little-endian.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
struct Header {
    magic: [u8; 8],
    version: [u8; 4],
    hidden: [u8; 4],
    code: [u8; 4],
    weights: [u8; 4],
    corners: [u8; 4],
    corrections: [u8; 4],
    mesh: [u8; 8],
}

/// Writes the map of `trainer`, learned of the mesh with that hash.
pub fn write(out: &mut dyn Write, trainer: &FitTrainer, mesh: u64) -> io::Result<()> {
    out.write_all(&bytes(trainer, mesh))
}

fn bytes(trainer: &FitTrainer, mesh: u64) -> Vec<u8> {
    let Widths { hidden, code } = trainer.settings.widths;
    let number = |x: usize| (x as u32).to_le_bytes();
    let corrections: Vec<_> = trainer.corrected.iter().enumerate().filter(|(_, uv)| !uv.is_nan()).collect();
    let header = Header {
        magic: MAGIC,
        version: VERSION.to_le_bytes(),
        hidden: number(hidden),
        code: number(code),
        weights: number(trainer.weights.len()),
        corners: number(trainer.cut.len()),
        corrections: number(corrections.len()),
        mesh: mesh.to_le_bytes(),
    };
    let mut bytes = bytes_of(&header).to_vec();
    bytes.extend(trainer.weights.iter().flat_map(|w| f16::from_f32(*w).to_le_bytes()));
    let byte = |cuts: &[u8]| cuts.iter().enumerate().fold(0, |byte, (i, cut)| byte | u8::from(*cut != 0) << i);
    bytes.extend(trainer.cut.chunks(8).map(byte));
    for (corner, uv) in corrections {
        bytes.extend(number(corner));
        bytes.extend(uv.to_array().iter().flat_map(|x| x.to_le_bytes()));
    }
    bytes.extend(hash(&bytes).to_le_bytes());
    bytes
}

/// Reads a map; the message of a failure names what is wrong with the file.
pub fn read(path: &Path) -> Result<FitTrainer, Failure> {
    let bytes = std::fs::read(path).map_err(|e| Failure::input(path, &e))?;
    parse(&bytes).map_err(|text| Failure::Input(format!("{}: {text}", path.display())))
}

fn parse(bytes: &[u8]) -> Result<FitTrainer, String> {
    const SIZE: usize = size_of::<Header>();
    if bytes.len() < SIZE || bytes[..MAGIC.len()] != MAGIC {
        return Err("not a map of seamwright; write one with unwrap --save-map".into());
    }
    let header: Header = pod_read_unaligned(&bytes[..SIZE]);
    let version = u32::from_le_bytes(header.version);
    if version != VERSION {
        return Err(format!("version {version} of the map format; this seamwright reads {VERSION}, so learn it anew"));
    }
    let numbers = [header.hidden, header.code, header.weights, header.corners, header.corrections];
    let [hidden, code, weights, corners, corrections] = numbers.map(|x| u32::from_le_bytes(x) as usize);
    let is_width = |x: usize| (1..=WIDEST).contains(&x);
    let settings = FitSettings { widths: Widths { hidden, code }, ..FitSettings::STANDARD };
    if !is_width(hidden) || !is_width(code) || corners > MOST_CORNERS {
        return Err(format!("damaged: widths {hidden} and {code}; write it anew"));
    }
    let mut trainer = FitTrainer::new("given".into(), settings);
    let expected =
        SIZE as u64 + 2 * weights as u64 + corners.div_ceil(8) as u64 + (CORRECTION * corrections) as u64 + 8;
    if bytes.len() as u64 != expected || weights != trainer.weights.len() {
        return Err(format!("damaged: {} bytes where {expected} belong; copy or write it anew", bytes.len()));
    }
    let (body, sum) = bytes.split_at(bytes.len() - 8);
    if hash(body).to_le_bytes() != sum {
        return Err("damaged: the checksum is wrong; copy or write it anew".into());
    }
    let (stored, rest) = body[SIZE..].split_at(2 * weights);
    for (to, from) in trainer.weights.iter_mut().zip(stored.chunks_exact(2)) {
        *to = f16::from_le_bytes(pod_read_unaligned(from)).to_f32();
    }
    let (cuts, rest) = rest.split_at(corners.div_ceil(8));
    let unused = 8 * cuts.len() - corners;
    if cuts.last().is_some_and(|last| last.leading_zeros() < unused as u32) {
        return Err("damaged: cuts beyond the last half-edge; write it anew".into());
    }
    trainer.cut = (0..corners).map(|c| cuts[c / 8] >> (c % 8) & 1).collect();
    trainer.corrected = vec![DVec2::NAN; corners];
    let mut least = 0; // corners ascend
    for correction in rest.chunks_exact(CORRECTION) {
        let corner = u32::from_le_bytes(pod_read_unaligned(&correction[..4])) as usize;
        let uv = [4, 12].map(|at| f64::from_le_bytes(pod_read_unaligned(&correction[at..at + 8])));
        match trainer.corrected.get_mut(corner) {
            Some(to) if corner >= least && uv.iter().all(|x| x.is_finite()) => {
                (*to, least) = (DVec2::from(uv), corner + 1);
            }
            _ => return Err("damaged: a correction that belongs nowhere; write it anew".into()),
        }
    }
    if !trainer.weights.iter().all(|w| w.is_finite()) {
        return Err("a weight that is no number; learn it anew".into());
    }
    trainer.given = Some(u64::from_le_bytes(header.mesh));
    Ok(trainer)
}

/// By which a map knows the mesh that it was learned of: its positions and polygons.
pub fn mesh_hash(mesh: &Mesh) -> u64 {
    let positions = mesh.positions.iter().flat_map(|p| p.to_array()).flat_map(|x| x.to_le_bytes());
    let lists = mesh.corners.iter().chain(&mesh.polygon_start).flat_map(|i| i.to_le_bytes());
    fnv(positions.chain(lists))
}

fn hash(bytes: &[u8]) -> u64 {
    fnv(bytes.iter().copied())
}

/// FNV-1a (Fowler, Noll, Vo).
fn fnv(bytes: impl Iterator<Item = u8>) -> u64 {
    bytes.fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trainer() -> FitTrainer {
        let widths = Widths { hidden: 3, code: 2 };
        let mut trainer = FitTrainer::new("draft".into(), FitSettings { widths, ..FitSettings::DRAFT });
        trainer.weights.iter_mut().enumerate().for_each(|(i, w)| *w = i as f32 / 8.0);
        trainer.cut = (0..21).map(|c| u8::from(c % 3 == 1)).collect();
        trainer.corrected = vec![DVec2::NAN; 21];
        trainer.corrected[20] = DVec2::new(-0.1, 1e-9);
        trainer
    }

    #[test]
    fn a_map_comes_back_and_the_bytes_are_the_same_on_every_machine() {
        let before = trainer();
        let bytes = bytes(&before, 0x0102);
        let after = parse(&bytes).unwrap();
        assert_eq!((after.given, after.settings.widths), (Some(0x0102), before.settings.widths));
        assert_eq!((&after.weights, &after.cut), (&before.weights, &before.cut));
        assert!((0..20).all(|c| after.corrected[c].is_nan()) && after.corrected[20] == before.corrected[20]);
        assert_eq!(bytes[8..20], [2, 0, 0, 0, 3, 0, 0, 0, 2, 0, 0, 0]);
        assert_eq!(bytes[40 + 2..][..2], [0x00, 0x30], "0.125 in 16 bits");
    }

    #[test]
    fn no_changed_missing_or_added_byte_is_taken() {
        let whole = bytes(&trainer(), 7);
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
