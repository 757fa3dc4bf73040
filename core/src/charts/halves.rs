//! Pieces that are their own mirror image are parted in their mirror planes, into halves of which one is the other mirrored.
//!
//! Of several planes that which parts along the longest edges is taken: a cut that costs nothing saves others.
//! Guarantee: no edge is marked that must not be cut. Limit: a face that crosses the plane leaves its piece whole.

use super::congruence::Likeness;
use super::mirror::{Mirror, mirror_need};
use super::pieces::Pieces;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::mesh::view::{NONE, next, prev};

/// Scratch bytes that [`part_halves`] uses.
pub const fn part_halves_need(faces: usize) -> usize {
    2 * bytes_for::<u32>(3 * faces) + mirror_need(faces)
}

/// How pieces are parted; all have an entry a corner of the given mesh.
pub struct Parting<'h> {
    /// Half-edges that are cut: those in mirror planes are.
    pub forced: &'h mut [u8],
    /// What cutting costs: no cut may be where two faces lie on two that are parted by the other diagonal.
    pub cost: &'h mut [f64],
    /// The mirror image of each corner of a piece that has a mirror plane, `NONE` of the others.
    pub mirror: &'h mut [u32],
}

/// Finds the mirror planes of `pieces`. With `over_diagonals`, diagonals of quads may differ on both sides.
pub fn part_halves(
    parting: Parting,
    pieces: &Pieces,
    likeness: Likeness,
    over_diagonals: bool,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let Parting { forced, cost, mirror } = parting;
    mirror.fill(NONE);
    for p in 0..pieces.count() {
        let mut frame = scratch.frame();
        let surface = &pieces.surface(p, &mut frame)?;
        let Some(Mirror { plane, image }) = Mirror::find(surface, likeness, over_diagonals, &mut frame)? else {
            continue;
        };
        let source = &pieces.source[pieces.corners(p)];
        let vertex = |c: u32| surface.mesh.vertex(c);
        for (c, from) in (0..).zip(source.iter().map(|from| *from as usize)) {
            forced[from] |= u8::from(surface.is_parted(c, &plane));
            mirror[from] = source[image[c as usize] as usize];
            // The image of a half-edge leads back from the image of its start; across a diagonal it does not.
            let back = image[c as usize];
            let end = image[next(c) as usize];
            if vertex(prev(back)) != vertex(end) {
                cost[from] = f64::INFINITY;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::charts::pieces::pieces_need;
    use crate::mesh::topology::{twins, twins_need};
    use crate::mesh::view::MeshView;
    use glam::DVec3;
    use std::{vec, vec::Vec};

    /// Lengths of the half-edges that are cut, and how many more must not be.
    fn marked(positions: &[DVec3], faces: &[[u32; 3]], held: Option<[u32; 2]>) -> (Vec<f64>, usize) {
        let mesh = MeshView { positions, faces };
        let mut twin = vec![0; mesh.corner_count()];
        let mut bytes = vec![0; twins_need(faces.len())];
        twins(&mut twin, mesh, Scratch::new(&mut bytes)).unwrap();
        let ends = |c: usize| [faces[c / 3][c % 3], faces[c / 3][(c + 1) % 3]];
        let is_held = |c: &usize| held.is_some_and(|h| ends(*c) == h || ends(*c) == [h[1], h[0]]);
        let cost: Vec<f64> = (0..twin.len()).map(|c| if is_held(&c) { f64::INFINITY } else { 1.0 }).collect();
        let mut forced = vec![0; twin.len()];
        let mut bytes = vec![0; pieces_need(faces.len())];
        let pieces = Pieces::new(mesh, &twin, &forced, &cost, &mut Scratch::new(&mut bytes)).unwrap();
        let mut bytes = vec![0; part_halves_need(faces.len())];
        let (mut mirror, mut prices) = (vec![0; twin.len()], cost.clone());
        let parting = Parting { forced: &mut forced, cost: &mut prices, mirror: &mut mirror };
        part_halves(parting, &pieces, Likeness::exact(1e-9), true, Scratch::new(&mut bytes)).unwrap();
        let held = (0..twin.len()).filter(|c| prices[*c] != cost[*c]).count();
        let length = |c: usize| positions[ends(c)[0] as usize].distance(positions[ends(c)[1] as usize]);
        ((0..twin.len()).filter(|c| forced[*c] != 0).map(length).collect(), held)
    }

    /// A roof over a ridge of length 2 from vertex 0 to 1, as far down on one side as `left` and on the other as `right`.
    fn roof(left: f64, right: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let at = DVec3::new;
        let positions = [at(0., 0., 1.), at(2., 0., 1.), at(2.5, left, 0.), at(0., left, 0.), at(2.5, -right, 0.)];
        ([&positions[..], &[at(0., -right, 0.)]].concat(), vec![[0, 1, 2], [0, 2, 3], [1, 0, 4], [0, 5, 4]])
    }

    #[test]
    fn a_roof_is_halved_along_its_ridge() {
        let (positions, faces) = roof(1.0, 1.0);
        assert_eq!(marked(&positions, &faces, None), (vec![2.0; 2], 0));
        // Not where that must not be cut.
        assert_eq!(marked(&positions, &faces, Some([0, 1])), (vec![], 0));
        // Nor where the sides differ.
        let (positions, faces) = roof(1.0, 1.01);
        assert_eq!(marked(&positions, &faces, None), (vec![], 0));
    }

    #[test]
    fn the_other_diagonal_on_the_other_side_is_no_matter() {
        let (positions, mut faces) = roof(1.0, 1.0);
        faces[2..].copy_from_slice(&[[1, 0, 5], [1, 5, 4]]);
        // The ridge is cut, and both diagonals, seen from both sides, must not be.
        assert_eq!(marked(&positions, &faces, None), (vec![2.0; 2], 4));
    }

    #[test]
    fn of_two_planes_the_one_with_the_longer_edges_is_taken() {
        // Two triangles on a long diagonal; the plane of the short one crosses both.
        let at = DVec3::new;
        let kite = [at(-2., 0., 0.), at(0., -1., 0.2), at(2., 0., 0.), at(0., 1., 0.2)];
        assert_eq!(marked(&kite, &[[0, 1, 2], [0, 2, 3]], None), (vec![4.0; 2], 0));
        // A pyramid over a diamond: both planes hold two of its edges.
        let pyramid = [at(-2., 0., 0.), at(0., -1., 0.), at(2., 0., 0.), at(0., 1., 0.), at(0., 0., 1.)];
        let long = marked(&pyramid, &[[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]], None);
        assert_eq!(long, (vec![DVec3::new(2., 0., 1.).length(); 4], 0));
    }

    #[test]
    fn a_turn_is_no_mirror_image() {
        // A propeller of two blades: half a turn lays it onto itself, no plane does.
        let at = DVec3::new;
        let p =
            [at(0., 0., 0.), at(0., 0., 1.), at(1., 0.2, 0.), at(1., -0.1, 0.8), at(-1., -0.2, 0.), at(-1., 0.1, 0.8)];
        let faces = [[0, 2, 3], [0, 3, 1], [0, 1, 5], [0, 5, 4]];
        assert_eq!(marked(&p, &faces, None).0, vec![]);
    }
}
