//! What a network is told of the nodes of a cut surface, and what of it a training looks at.

use super::fitting::MOST_CHARTS;
use crate::base::random::hash;
use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::Slices;
use crate::base::sort;
use crate::base::workers::Workers;
use crate::charts::cut_mesh::CutMesh;
use crate::charts::surface::Surface;
use crate::learn::chart_net::ChartNet;
use crate::learn::fit::FitInput;
use crate::learn::tape::distortion::{REST, rest_of};
use crate::learn::tape::gap::JACOBIAN;
use crate::mesh::normals::{NormalWeight, vertex_normals};
use crate::mesh::view::NONE;
use crate::mesh::working::Working;
use crate::solve::energy::{MOLLIFY, Rest};
use crate::solve::modes::{MODES, modes};
use crate::solve::piece::Piece;
use glam::{DVec2, DVec3};

/// Scale of places among the features, of a chart's number and of modes; normals are of length 1.
const PLACE: f64 = 4.0;
const NUMBER: f32 = 2.0;
const MODE: f32 = 2.0;
/// Least size of a chart over the largest by which its modes are scaled.
const LEAST_SIZE: f32 = 0.01;
/// Share of a face's weight that is the same for all faces; the rest is its area.
const EVEN: f64 = 0.1;
/// Faces that are looked at together.
const BLOCK: usize = 256;
/// Nodes that a step of training looks at, at the most: of larger meshes each step sees other faces.
pub(super) const MOST_NODES: usize = 12_000;

/// The largest charts, as many as a network learns, of the faces that have a `slot`.
pub(super) fn largest_charts<'k>(
    surface: &Surface,
    cut: &[u8],
    slot: &[u32],
    keep: &mut Scratch<'k>,
) -> Result<CutMesh<'k>, ScratchTooSmall> {
    let faces = surface.mesh.faces.len();
    let is_chosen = keep.take::<u8>(faces)?;
    {
        let mut frame = keep.frame();
        let all = CutMesh::new(surface, cut, |f| slot[3 * f] != NONE, &mut frame)?;
        let order = frame.take::<u32>(all.count())?;
        order.iter_mut().zip(0..).for_each(|(k, n)| *k = n);
        sort::by_key(order, |k| (usize::MAX - all.faces_of(*k as usize).len(), *k));
        for k in order.iter().take(MOST_CHARTS) {
            all.faces_of(*k as usize).iter().for_each(|f| is_chosen[*f as usize] = 1);
        }
    }
    CutMesh::new(surface, cut, |f| is_chosen[f] != 0, keep)
}

/// Writes the features of all nodes, (nodes, features of `net`).
pub(super) fn write_features(
    features: &mut [f32],
    net: ChartNet,
    charts: &CutMesh,
    working: &Working,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let mesh = working.mesh();
    let vertex_of = |node: usize| mesh.vertex(charts.corner[node]) as usize;
    {
        let mut frame = scratch.frame();
        let normals = frame.take::<DVec3>(mesh.positions.len())?;
        vertex_normals(normals, mesh, NormalWeight::Angle);
        for (node, row) in features.rows_mut(net.features).enumerate() {
            let v = vertex_of(node);
            let (place, normal) = (mesh.positions[v] * PLACE, normals[v]);
            let values = [place.x, place.y, place.z, normal.x, normal.y, normal.z];
            row.iter_mut().zip(values).for_each(|(to, x)| *to = x as f32);
        }
    }
    let area = |k: usize| charts.faces_of(k).iter().map(|f| 0.5 * mesh.area_vector(*f as usize).length()).sum::<f64>();
    let most = (0..charts.count()).map(area).fold(0.0, f64::max);
    for k in 0..charts.count() {
        let (nodes, faces) = (charts.nodes_of(k), charts.faces_of(k));
        let mut frame = scratch.frame();
        let at = frame.take::<DVec3>(nodes.len())?;
        at.iter_mut().zip(nodes.clone()).for_each(|(at, node)| *at = mesh.positions[vertex_of(node)]);
        let triangles = frame.take::<[u32; 3]>(faces.len())?;
        let rest = frame.take::<Rest>(faces.len())?;
        for ((triangle, rest), f) in triangles.iter_mut().zip(rest.iter_mut()).zip(faces) {
            *triangle = charts.nodes_at(*f).map(|node| node - nodes.start as u32);
            *rest = Rest::new(triangle.map(|i| at[i as usize]), MOLLIFY);
        }
        let size = MODE * (sqrt(area(k) / most) as f32).max(LEAST_SIZE);
        let waves = frame.take::<f32>(MODES * nodes.len())?;
        let piece = Piece { triangles, rest, free: nodes.len(), at, springs: &[], walls: &[] };
        modes(waves, &piece, frame.frame(), workers)?;
        let rows = features[nodes.start * net.features..nodes.end * net.features].rows_mut(net.features);
        for (row, waves) in rows.zip(waves.rows(MODES)) {
            let (_, rest) = row.parted_mut(6);
            rest.iter_mut().zip(waves).for_each(|(to, wave)| *to = size * wave);
            rest[MODES..].fill(0.0);
            rest[MODES + k] = NUMBER;
        }
    }
    Ok(())
}

/// What a step of training looks at: the nodes and faces of the cut mesh with the map that is given; of a larger mesh, other blocks of
/// neighbouring faces every time it is filled.
pub(super) struct LearningSet<'s, 'a> {
    scene: LearningScene<'s>,
    area: f64,
    solid: f64,            // faces with an area
    blocks: &'a mut [u32], // in the order of this pass
    next: usize,           // block
    passes: u64,
    row_of: &'a mut [u32], // (nodes)
    features: &'a mut [f32],
    faces: &'a mut [u32],
    rest: &'a mut [f32],
    jacobians: &'a mut [f32],
    target: &'a mut [f32],
}

/// The cut mesh, its features and the map that is given.
#[derive(Clone, Copy)]
pub(super) struct LearningScene<'a> {
    pub charts: &'a CutMesh<'a>,
    pub working: &'a Working<'a>,
    pub features: &'a [f32], // (nodes, width)
    pub width: usize,
    pub given: &'a [DVec2], // (nodes)
}

impl<'s, 'a> LearningSet<'s, 'a> {
    /// Room for what a step looks at.
    pub fn new(scene: LearningScene<'s>, keep: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        let (nodes, faces) = (scene.charts.node_count(), scene.charts.faces.len());
        let rows = nodes.min(MOST_NODES);
        // A block brings its nodes along, at the most three a face.
        let most = if rows < nodes { faces.min(2 * MOST_NODES) } else { faces };
        let blocks = keep.take::<u32>(faces.div_ceil(BLOCK))?;
        blocks.iter_mut().zip(0..).for_each(|(block, n)| *block = n);
        let shapes = scene.charts.faces.iter().map(|f| scene.rest(*f)[4]).filter(|area| *area > 0.0);
        let (area, solid) = shapes.fold((0.0, 0.0), |(sum, count), area| (sum + area, count + 1.0));
        let mut set = Self {
            scene,
            area,
            solid,
            blocks,
            next: 0,
            passes: 0,
            row_of: keep.take_filled::<u32>(nodes, NONE)?,
            features: keep.take::<f32>(scene.width * rows)?,
            faces: keep.take::<u32>(3 * most)?,
            rest: keep.take::<f32>(REST * most)?,
            jacobians: keep.take::<f32>(JACOBIAN * most)?,
            target: keep.take::<f32>(2 * rows)?,
        };
        set.fill();
        Ok(set)
    }

    /// Nodes that a step looks at.
    pub fn nodes(&self) -> usize {
        self.target.len() / 2
    }

    /// Whether a step looks at all there is.
    pub fn is_whole(&self) -> bool {
        self.nodes() == self.scene.charts.node_count()
    }

    /// Goes on to the next blocks, as many as there is room for.
    pub fn fill(&mut self) {
        let scene = self.scene;
        let (most_rows, most_faces) = (self.nodes(), self.faces.len() / 3);
        self.row_of.fill(NONE);
        self.rest.fill(0.0);
        self.faces.fill(0);
        let (mut rows, mut count) = (0, 0);
        for _ in 0..self.blocks.len() {
            if self.next == self.blocks.len() {
                (self.next, self.passes) = (0, self.passes + 1);
                let passes = self.passes;
                sort::by_key(self.blocks, |block| (hash(passes, 0, (*block).into()), *block));
            }
            let first = self.blocks[self.next] as usize * BLOCK;
            let block = &scene.charts.faces[first..(first + BLOCK).min(scene.charts.faces.len())];
            if rows + 3 * block.len() > most_rows && most_rows < scene.charts.node_count()
                || count + block.len() > most_faces
            {
                break;
            }
            self.next += 1;
            for f in block {
                for (i, node) in scene.charts.nodes_at(*f).into_iter().enumerate() {
                    let known = &mut self.row_of[node as usize];
                    if *known == NONE {
                        *known = rows as u32;
                        let node = node as usize;
                        self.target[2 * rows..2 * rows + 2].copy_from(&scene.given[node].as_vec2().to_array());
                        let from = &scene.features[node * scene.width..(node + 1) * scene.width];
                        self.features[rows * scene.width..(rows + 1) * scene.width].copy_from(from);
                        rows += 1;
                    }
                    self.faces[3 * count + i] = *known;
                }
                self.add_shape(count, *f);
                count += 1;
            }
        }
        let share = scene.charts.faces.len() as f32 / count.max(1) as f32;
        self.rest.as_chunks_mut::<REST>().0.iter_mut().for_each(|rest| rest[4] *= share);
        // Rows that are left are once more the first.
        for row in rows..most_rows {
            let (first, rest) = self.features.parted_mut(row * scene.width);
            rest[..scene.width].copy_from(&first[..scene.width]);
            (self.target[2 * row], self.target[2 * row + 1]) = (self.target[0], self.target[1]);
        }
    }

    /// Writes the rest shape of face `f` of the surface and its Jacobian in the given map to place `at`.
    fn add_shape(&mut self, at: usize, f: u32) {
        let (scene, shape) = (self.scene, self.scene.rest(f));
        let [p, q, r] = scene.charts.nodes_at(f).map(|node| scene.given[node as usize]);
        let (u, v) = (q - p, r - p);
        let columns = [u * shape[0] + v * shape[2], u * shape[1] + v * shape[3]];
        let jacobian = [columns[0].x, columns[1].x, columns[0].y, columns[1].y].map(|x| x as f32);
        let mut rest = shape.map(|x| x as f32);
        if shape[4] > 0.0 {
            rest[4] = ((1.0 - EVEN) * shape[4] / self.area + EVEN / self.solid) as f32;
        }
        self.rest[REST * at..REST * (at + 1)].copy_from(&rest);
        self.jacobians[JACOBIAN * at..JACOBIAN * (at + 1)].copy_from(&jacobian);
    }

    /// As the training takes it.
    pub fn input(&self) -> FitInput<'_> {
        let Self { features, faces, rest, jacobians, target, .. } = self;
        FitInput { features, faces, rest, jacobians, target }
    }
}

impl LearningScene<'_> {
    fn rest(&self, f: u32) -> [f64; REST] {
        let mesh = self.working.mesh();
        rest_of(self.charts.nodes_at(f).map(|node| mesh.position(self.charts.corner[node as usize]).to_array()))
    }
}
