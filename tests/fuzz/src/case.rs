//! A mesh and settings out of bytes: vertices on a lattice, of any float or of hostile ones; polygons of any vertices.

use crate::bytes::Bytes;
use glam::{DVec2, DVec3};
use seamwright_core::mesh::cracks::Weld;
use seamwright_core::pipeline::{Charts, CountedWork, Input, Packing, Settings, Snap, Stacking, Straighten};
use seamwright_core::price::cost::Prefer;
use seamwright_core::price::given::HardEdges;
use std::collections::HashMap;
use std::fmt::Write;

/// Coordinates that arithmetic trips over.
pub const HOSTILE: [f64; 16] = [
    0.0,
    1.0,
    -1.0,
    0.5,
    -0.0,
    1e-9,
    1.0 + f64::EPSILON,
    5e-324,
    1e-160,
    1e160,
    f64::MAX,
    -f64::MAX,
    f64::MIN_POSITIVE,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
];

/// How all coordinates are stretched.
const SCALES: [f64; 8] = [1.0, 1.0, 1.0, 1e-30, 1e30, 1e300, 1e-300, 1e-6];
/// Triangles at the most, before any is cut in four.
const MOST_TRIANGLES: usize = 40;

/// A mesh as `pipeline` takes it.
#[derive(Clone, Debug, Default)]
pub struct Case {
    pub positions: Vec<DVec3>,
    pub corners: Vec<u32>,
    pub polygon_start: Vec<u32>,
    pub kept_uv: Option<Vec<DVec2>>,
    pub parts: Option<Vec<u32>>,
}

impl Case {
    /// Reads a mesh; `finer` times its polygons are cut into triangles and these in four.
    pub fn read(bytes: &mut Bytes, finer: usize) -> Self {
        let mut case = Self { polygon_start: vec![0], ..Self::default() };
        let (kind, scale, flags) = (bytes.byte() % 4, bytes.pick(&SCALES), bytes.byte());
        let vertices = usize::from(bytes.byte()) % 48 + 1;
        for _ in 0..vertices {
            case.positions.push(position(kind, bytes) * scale);
        }
        let (has_uv, has_parts, is_wild) = (flags & 3 == 1, flags & 12 == 4, flags & 0xf0 == 0xf0);
        let (mut uv, mut parts, mut triangles) = (vec![], vec![], 0);
        while !bytes.is_empty() && triangles < MOST_TRIANGLES {
            let head = bytes.byte();
            let count = [3, 3, 3, 4, 3, 5, 4, 8][usize::from(head) & 7];
            for _ in 0..count {
                let byte = bytes.byte();
                let (vertex, is_odd) = (usize::from(byte & 0x7f) % vertices, byte & 0x80 != 0);
                let beyond = [vertices as u32, u32::MAX, 1 << 31, 0][usize::from(byte & 3)];
                case.corners.push(if is_wild && is_odd { beyond } else { vertex as u32 });
                let p = case.positions[vertex];
                let moved = HOSTILE[usize::from(byte) & 15];
                uv.push(if is_odd { DVec2::new(moved, p.y) } else { DVec2::new(p.x, p.y + p.z) });
            }
            case.polygon_start.push(case.corners.len() as u32);
            parts.push([0, 1, 2, u32::MAX][usize::from(head >> 3) & 3]);
            triangles += count - 2;
        }
        for _ in 0..finer {
            (uv, parts) = case.subdivide(&uv, &parts);
        }
        case.kept_uv = has_uv.then_some(uv);
        case.parts = has_parts.then_some(parts);
        case
    }

    /// Cuts polygons into fans and each triangle in four.
    fn subdivide(&mut self, uv: &[DVec2], parts: &[u32]) -> (Vec<DVec2>, Vec<u32>) {
        let mut finer = Self { positions: self.positions.clone(), polygon_start: vec![0], ..Self::default() };
        let (mut finer_uv, mut finer_parts, mut middles) = (vec![], vec![], HashMap::new());
        for (ends, part) in self.polygon_start.windows(2).zip(parts) {
            for second in ends[0] as usize + 1..ends[1] as usize - 1 {
                let at = [ends[0] as usize, second, second + 1];
                let sides = [(0, 1), (1, 2), (2, 0)].map(|(i, k)| {
                    let (a, b) = (self.corners[at[i]], self.corners[at[k]]);
                    let place = |v: u32| self.positions.get(v as usize).copied().unwrap_or(DVec3::NAN);
                    let new = finer.positions.len() as u32;
                    let middle = *middles.entry((a.min(b), a.max(b))).or_insert(new);
                    if middle == new {
                        finer.positions.push(place(a) * 0.5 + place(b) * 0.5);
                    }
                    (middle, (uv[at[i]] + uv[at[k]]) * 0.5)
                });
                let corners = at.map(|c| (self.corners[c], uv[c]));
                let [a, b, c, ab, bc, ca] = [corners, sides].concat().try_into().expect("six");
                for triangle in [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]] {
                    finer.corners.extend(triangle.map(|corner| corner.0));
                    finer_uv.extend(triangle.map(|corner| corner.1));
                    finer.polygon_start.push(finer.corners.len() as u32);
                    finer_parts.push(*part);
                }
            }
        }
        *self = finer;
        (finer_uv, finer_parts)
    }

    /// As core takes it.
    pub fn input(&self) -> Input<'_> {
        let (kept_uv, parts) = (self.kept_uv.as_deref(), self.parts.as_deref());
        let Self { positions, corners, polygon_start, .. } = self;
        Input { kept_uv, parts, ..Input::new(positions, corners, polygon_start) }
    }

    /// As an OBJ, to look at and to keep.
    pub fn obj(&self) -> String {
        let mut text = String::new();
        for p in &self.positions {
            writeln!(text, "v {:?} {:?} {:?}", p.x, p.y, p.z).expect("memory");
        }
        for ends in self.polygon_start.windows(2) {
            let corners = &self.corners[ends[0] as usize..ends[1] as usize];
            let words: String = corners.iter().map(|v| format!(" {}", u64::from(*v) + 1)).collect();
            writeln!(text, "f{words}").expect("memory");
        }
        text
    }
}

fn position(kind: u8, bytes: &mut Bytes) -> DVec3 {
    match kind {
        0 => {
            // A lattice of 4 x 4 x 4, some places a little beside.
            let byte = bytes.byte();
            let [x, y, z] = [byte & 3, byte >> 2 & 3, byte >> 4 & 3].map(f64::from);
            DVec3::new(x + [0.0, 0.0, 1e-9, 0.3][usize::from(byte >> 6)], y, z)
        }
        1 => DVec3::from(bytes.array::<3>().map(|b| f64::from(b as i8) / 16.0)),
        2 => DVec3::from([0; 3].map(|_| f64::from(f32::from_le_bytes(bytes.array())))),
        _ => DVec3::from(bytes.array::<3>().map(|b| HOSTILE[usize::from(b) & 15])),
    }
}

/// Settings for which a run takes milliseconds; `is_wild` lets them leave their ranges.
pub fn settings(bytes: &mut Bytes, is_wild: bool) -> Settings {
    let sound = Settings {
        distortion: bytes.pick(&[1.025, 1.0001, 1.5, 1e9, 1.1, 1.0 + f64::EPSILON]),
        charts: bytes.pick(&[Charts::Few, Charts::One]),
        // The rasters of tight packing take a hundred times as long as all the rest.
        packing: if bytes.byte() == 255 { Packing::Tight } else { Packing::Grid },
        size: bytes.pick(&[1024, 16, 64, 256, 65536]),
        padding: bytes.pick(&[2, 0, 1, 4]),
        effort: bytes.pick(&[0.0, 0.01, 0.05]),
        rays: bytes.pick(&[8, 1, 3, 16]),
        hard_edges: bytes.pick(&[HardEdges::Prefer, HardEdges::Require, HardEdges::Off]),
        prefer: bytes.pick(&[Prefer::Balance, Prefer::Seams, Prefer::Fill]),
        search: bytes.pick(&[0, 1, 3]),
        weld: bytes.pick(&[Weld::Equal, Weld::Auto, Weld::Within(1e-3), Weld::Within(0.5)]),
        straighten: bytes.pick(&[Straighten::Auto, Straighten::Off, Straighten::Strips]),
        snap: bytes.pick(&[Snap::Off, Snap::Texel]),
        stack: Stacking::Off,
        stack_offset: 0,
        seed: u64::from(bytes.byte()),
        ends_early: bytes.pick(&[false, true]),
        work: bytes.pick(&[
            CountedWork::ALL,
            CountedWork { seams: 5000, ..CountedWork::ALL },
            CountedWork { exposure: 0, seams: 0, pack: 0 },
            CountedWork { pack: 1, ..CountedWork::ALL },
        ]),
    };
    if !is_wild {
        return sound;
    }
    Settings {
        distortion: bytes.pick(&[sound.distortion, 1.0, 0.0, -1.0, f64::NAN, f64::INFINITY, f64::MAX]),
        size: bytes.pick(&[sound.size, 0, 1, 2, u32::MAX]),
        padding: bytes.pick(&[sound.padding, 1 << 14, u32::MAX]),
        effort: bytes.pick(&[sound.effort, -1.0, f64::NAN]),
        rays: bytes.pick(&[sound.rays, 0]),
        ..sound
    }
}
