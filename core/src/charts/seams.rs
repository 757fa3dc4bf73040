//! The cuts of a surface as paths between nodes: branching points, free ends, the border.

use super::surface::Surface;

/// Lists the half-edges of the path that begins with `first`, in order, up to a node or once round, and marks both sides of each in
/// `seen`; returns how many there are. `is_cut` tells of a half-edge, `is_node` of a vertex.
pub fn walk_seam(
    list: &mut [u32],
    seen: &mut [u8], // (3 f)
    first: u32,
    surface: &Surface,
    is_cut: impl Fn(u32) -> bool,
    is_node: impl Fn(u32) -> bool,
) -> usize {
    let (mut at, mut len) = (first, 0);
    loop {
        let (back, end) = (surface.twin[at as usize], surface.far_end(at));
        seen[at as usize] = 1;
        seen[back as usize] = 1;
        list[len] = at;
        len += 1;
        let on = surface.corners_at(end).iter().find(|c| is_cut(**c) && **c != back);
        match on {
            Some(c) if !is_node(end) && *c != first => at = *c,
            _ => return len,
        }
    }
}
