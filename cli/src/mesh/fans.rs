//! Polygons as fans from their first corner: the judge's convention, which pictures and figures follow.

use seamwright_core::judge::input::fan;

/// The triangles of every polygon, as its number and three corners. `polygon_start` as of
/// [`Mesh`](super::polygons::Mesh).
pub fn fans(polygon_start: &[u32]) -> impl Iterator<Item = (usize, [u32; 3])> + '_ {
    let ends = polygon_start.windows(2).enumerate();
    ends.flat_map(|(p, ends)| fan(ends[0], ends[1]).map(move |triangle| (p, triangle)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pentagon_is_three_triangles_of_its_polygon() {
        let expected = [(0, [0, 1, 2]), (1, [3, 4, 5]), (1, [3, 5, 6]), (1, [3, 6, 7])];
        assert_eq!(fans(&[0, 3, 8]).collect::<Vec<_>>(), expected);
    }
}
