//! The triangles of a primitive.

/// glTF's code for a list of triangles, the mode where none is given; strips and fans follow it.
pub(super) const TRIANGLES: u32 = 4;
const STRIP: u32 = 5;
const FAN: u32 = 6;

/// Whether a mode is one of triangles, not of points or lines.
pub(super) fn is_surface(mode: u32) -> bool {
    matches!(mode, TRIANGLES | STRIP | FAN)
}

/// Triangles of a primitive, counter-clockwise. Those of a strip or fan that name a vertex twice only join its parts and are
/// left out; of a list every three indices are one.
pub(super) fn triangles(mode: u32, indices: &[u32]) -> Vec<[u32; 3]> {
    let joins = |[a, b, c]: &[u32; 3]| a == b || b == c || c == a;
    match mode {
        STRIP => {
            let turn = |(i, t): (usize, &[u32])| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
            indices.windows(3).enumerate().map(turn).filter(|t| !joins(t)).collect()
        }
        FAN => {
            let first = indices.first().copied().unwrap_or(0);
            let rest = indices.get(1..).unwrap_or_default().windows(2);
            rest.map(|t| [first, t[0], t[1]]).filter(|t| !joins(t)).collect()
        }
        _ => indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_keep_their_outside_and_lose_what_only_joins_them() {
        assert_eq!(triangles(STRIP, &[0, 1, 2, 3, 3, 7, 7, 8, 9]), [[0, 1, 2], [2, 1, 3], [7, 8, 9]]);
        assert_eq!(triangles(FAN, &[5, 1, 2, 3]), [[5, 1, 2], [5, 2, 3]]);
        assert_eq!(triangles(TRIANGLES, &[0, 1, 2, 3, 3, 4, 9]), [[0, 1, 2], [3, 3, 4]]);
        assert_eq!(triangles(FAN, &[]), [[0; 3]; 0]);
    }
}
