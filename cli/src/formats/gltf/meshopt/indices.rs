//! The codecs of indices: triangles by the edges and vertices that were met lately, and plain sequences.
//!
//! A triangle's byte names one of the last 15 edges and how its third vertex is found (new, met lately, or a difference), or
//! says that all three are found so. Indices that are differences are variable-length integers behind the triangles' bytes;
//! a table of 16 often met pairs of codes ends the stream.

/// The indices of a stream of triangles; `count` is a multiple of 3.
pub(super) fn triangles(stream: &[u8], count: usize) -> Option<Vec<u32>> {
    let version = stream.first().filter(|head| **head & 0xf0 == 0xe0)? & 0x0f;
    let end = stream.len().checked_sub(16)?;
    let codes = stream.get(1..1 + count / 3)?;
    let data = stream.get(1 + count / 3..end)?;
    let free = match version {
        0 => 15,
        1 => 13, // 13 and 14 are the neighbours of the last free index
        _ => return None,
    };
    let mut met =
        Met { edges: [[u32::MAX; 2]; 16], edge: 0, vertices: [u32::MAX; 16], vertex: 0, next: 0, last: 0, data };
    let mut out = Vec::with_capacity(count);
    for code in codes {
        let (high, low) = (code >> 4, code & 15);
        let [a, b, c] = if high < 15 {
            let [a, b] = met.edges[met.edge.wrapping_sub(1 + usize::from(high)) & 15];
            let c = if low < free {
                let c = if low == 0 {
                    met.fresh()
                } else {
                    met.vertices[met.vertex.wrapping_sub(1 + usize::from(low)) & 15]
                };
                met.push(c, low == 0);
                c
            } else {
                let c = match low {
                    13 => met.last.wrapping_sub(1),
                    14 => met.last.wrapping_add(1),
                    _ => met.free()?,
                };
                met.last = c;
                met.push(c, true);
                c
            };
            met.join(c, b);
            met.join(a, c);
            [a, b, c]
        } else {
            let is_listed = low < 14;
            let pair = if is_listed { stream[end + usize::from(low)] } else { met.byte()? };
            if !is_listed && pair == 0 {
                met.next = 0;
            }
            let ways = [if low == 15 { 15 } else { 0 }, pair >> 4, pair & 15];
            // New vertices are numbered before any is read as a difference, and before any is pushed.
            let mut found = ways.map(|way| match way {
                0 => met.fresh(),
                way => met.vertices[met.vertex.wrapping_sub(usize::from(way)) & 15],
            });
            if !is_listed {
                for (vertex, _) in found.iter_mut().zip(ways).filter(|(_, way)| *way == 15) {
                    *vertex = met.free()?;
                    met.last = *vertex;
                }
            }
            let [a, b, c] = found;
            met.push(a, true);
            met.push(b, ways[1] == 0 || !is_listed && ways[1] == 15);
            met.push(c, ways[2] == 0 || !is_listed && ways[2] == 15);
            met.join(b, a);
            met.join(c, b);
            met.join(a, c);
            found
        };
        out.extend([a, b, c]);
    }
    met.data.is_empty().then_some(out)
}

/// The indices of a plain sequence: differences from one of two baselines.
pub(super) fn sequence(stream: &[u8], count: usize) -> Option<Vec<u32>> {
    stream.first().filter(|head| matches!(head, 0xd0 | 0xd1))?;
    let mut data = stream.get(1..stream.len().checked_sub(4)?)?;
    let mut last = [0u32; 2];
    let mut out = Vec::with_capacity(count.min(data.len()));
    for _ in 0..count {
        let value = integer(&mut data)?;
        let base = &mut last[value as usize & 1];
        *base = base.wrapping_add(unzigzag(value >> 1));
        out.push(*base);
    }
    data.is_empty().then_some(out)
}

/// What was met lately, and the bytes that are left.
struct Met<'a> {
    edges: [[u32; 2]; 16],
    edge: usize,
    vertices: [u32; 16],
    vertex: usize,
    next: u32,
    last: u32,
    data: &'a [u8],
}

impl Met<'_> {
    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.data.split_first()?;
        self.data = rest;
        Some(*first)
    }

    /// The next new vertex.
    fn fresh(&mut self) -> u32 {
        self.next = self.next.wrapping_add(1);
        self.next.wrapping_sub(1)
    }

    /// A vertex by its difference from the last one that was found so.
    fn free(&mut self) -> Option<u32> {
        Some(self.last.wrapping_add(unzigzag(integer(&mut self.data)?)))
    }

    fn push(&mut self, vertex: u32, stays: bool) {
        self.vertices[self.vertex] = vertex;
        self.vertex = (self.vertex + usize::from(stays)) & 15;
    }

    fn join(&mut self, a: u32, b: u32) {
        self.edges[self.edge] = [a, b];
        self.edge = (self.edge + 1) & 15;
    }
}

/// Seven bits a byte, low ones first, five bytes at the most.
fn integer(data: &mut &[u8]) -> Option<u32> {
    let mut value = 0;
    for i in 0..5 {
        let (byte, rest) = data.split_first()?;
        *data = rest;
        value |= u32::from(byte & 127) << (7 * i);
        if *byte < 128 {
            break;
        }
    }
    Some(value)
}

fn unzigzag(v: u32) -> u32 {
    v >> 1 ^ (v & 1).wrapping_neg()
}
