//! Decimation and the way back: invariants on made and on real meshes.

use glam::DVec3;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::carry::proxy::{proxy_costs, proxy_costs_need};
use seamwright_core::carry::slide::Slides;
use seamwright_core::carry::transfer::{Transferred, transfer, transfer_need};
use seamwright_core::charts::surface::Surface;
use seamwright_core::first::disks::cut_to_disks;
use seamwright_core::mesh::collapse::Collapse;
use seamwright_core::mesh::decimate::{decimate, decimate_need};
use seamwright_core::mesh::topology::{twins, twins_need};
use seamwright_core::mesh::view::{MeshView, NONE, next};
use seamwright_core::solve::energy::Rest;
use std::collections::{BTreeMap, BTreeSet};

#[derive(Clone, Debug, PartialEq)]
struct Mesh {
    positions: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    twin: Vec<u32>,
}

/// What a decimation may not change.
#[derive(Debug, PartialEq)]
struct ComponentShape {
    bad_edges: usize,
    components: usize,
    euler: i64,
    border_loops: usize,
}

impl Mesh {
    fn new(positions: Vec<DVec3>, faces: Vec<[u32; 3]>) -> Self {
        let mut twin = vec![0; 3 * faces.len()];
        let mut bytes = vec![0; twins_need(faces.len())];
        let mesh = MeshView { positions: &positions, faces: &faces };
        twins(&mut twin, mesh, Scratch::new(&mut bytes)).unwrap();
        Self { positions, faces, twin }
    }

    fn view(&self) -> MeshView<'_> {
        MeshView { positions: &self.positions, faces: &self.faces }
    }

    fn shape(&self) -> ComponentShape {
        let mesh = self.view();
        let mut edges: BTreeMap<(u32, u32), Vec<bool>> = BTreeMap::new();
        let mut label: Vec<u32> = (0..self.positions.len() as u32).collect();
        let mut border = BTreeMap::new();
        for c in 0..self.twin.len() as u32 {
            let (a, b) = (mesh.vertex(c), mesh.vertex(next(c)));
            edges.entry((a.min(b), a.max(b))).or_default().push(a < b);
            join(&mut label, a, b);
            if self.twin[c as usize] == NONE {
                border.insert(a, b);
            }
        }
        let bad_edges = edges.values().filter(|e| e.len() > 2 || (e.len() == 2 && e[0] == e[1])).count();
        let used: BTreeSet<u32> = self.faces.iter().flatten().copied().collect();
        let components = used.iter().map(|v| root(&label, *v)).collect::<BTreeSet<_>>().len();
        let mut loops: Vec<u32> = (0..self.positions.len() as u32).collect();
        border.iter().for_each(|(a, b)| join(&mut loops, *a, *b));
        let border_loops = border.keys().map(|v| root(&loops, *v)).collect::<BTreeSet<_>>().len();
        let euler = used.len() as i64 - edges.len() as i64 + self.faces.len() as i64;
        ComponentShape { bad_edges, components, euler, border_loops }
    }
}

fn root(label: &[u32], mut v: u32) -> u32 {
    while label[v as usize] != v {
        v = label[v as usize];
    }
    v
}

fn join(label: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(label, a), root(label, b));
    label[a.max(b) as usize] = a.min(b);
}

struct Coarse {
    mesh: Mesh,
    vertex: Vec<u32>,
    history: Vec<Collapse>,
}

fn coarsen(mesh: &Mesh, target: usize) -> Coarse {
    let (n, f) = (mesh.positions.len(), mesh.faces.len());
    let (mut faces, mut vertex, mut history) = (vec![[0; 3]; f], vec![0; n], vec![Collapse::default(); n]);
    let mut bytes = vec![0; decimate_need(n, f)];
    let scratch = Scratch::new(&mut bytes);
    let done = decimate(
        &mut faces,
        &mut vertex,
        &mut history,
        mesh.view(),
        &mesh.twin,
        &vec![0; mesh.twin.len()],
        target,
        scratch,
    )
    .unwrap();
    faces.truncate(done.faces);
    vertex.truncate(done.vertices);
    history.truncate(done.collapses);
    let positions = vertex.iter().map(|v| mesh.positions[*v as usize]).collect();
    Coarse { mesh: Mesh::new(positions, faces), vertex, history }
}

/// A band of `n` by `m` cells, closed in the directions asked for.
fn grid(n: u32, m: u32, close: [bool; 2], point: impl Fn(f64, f64) -> DVec3) -> Mesh {
    let (columns, rows) = (n + u32::from(!close[0]), m + u32::from(!close[1]));
    let at = |i: u32, j: u32| i % columns + columns * (j % rows);
    let mut positions = vec![];
    for j in 0..rows {
        for i in 0..columns {
            positions.push(point(f64::from(i) / f64::from(n), f64::from(j) / f64::from(m)));
        }
    }
    let mut faces = vec![];
    for j in 0..m {
        for i in 0..n {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    Mesh::new(positions, faces)
}

fn torus() -> Mesh {
    grid(60, 30, [true, true], |u, v| {
        let (s, t) = (u * std::f64::consts::TAU, v * std::f64::consts::TAU);
        let r = 0.35 + 0.12 * t.cos();
        DVec3::new(r * s.cos(), r * s.sin(), 0.12 * t.sin())
    })
}

fn tube() -> Mesh {
    grid(40, 30, [true, false], |u, v| {
        let s = u * std::f64::consts::TAU;
        DVec3::new(0.2 * s.cos(), 0.2 * s.sin(), v - 0.5)
    })
}

fn sheet() -> Mesh {
    grid(20, 20, [false, false], |u, v| DVec3::new(u, v, 0.1 * (5.0 * u).sin() * (4.0 * v).cos()))
}

/// A cube's grid, blown up to a sphere of radius 1/2.
fn sphere(cells: u32) -> Mesh {
    let mut number = BTreeMap::new();
    let mut positions = vec![];
    let mut faces = vec![];
    for side in 0..6 {
        let mut at = |i: u32, j: u32| {
            let (x, y) = (2 * i as i64 - i64::from(cells), 2 * j as i64 - i64::from(cells));
            let z = i64::from(cells);
            let p = match side {
                0 => [x, y, z],
                1 => [y, x, -z],
                2 => [y, z, x],
                3 => [x, -z, y],
                4 => [z, x, y],
                _ => [-z, y, x],
            };
            *number.entry(p).or_insert_with(|| {
                let p = DVec3::new(p[0] as f64, p[1] as f64, p[2] as f64);
                positions.push(p * (0.5 / p.length()));
                positions.len() as u32 - 1
            })
        };
        for j in 0..cells {
            for i in 0..cells {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                faces.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    Mesh::new(positions, faces)
}

/// A mesh beside the repository, or nothing, with a message.
fn bench(name: &str) -> Option<Mesh> {
    let path = format!("{}/../../shared/meshes/bench/{name}.obj", env!("CARGO_MANIFEST_DIR"));
    let Ok(text) = std::fs::read_to_string(&path) else {
        println!("skipped: {path} is not there");
        return None;
    };
    let (mut points, mut faces) = (vec![], vec![]);
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.first() {
            Some(&"v") => points.push([1, 2, 3].map(|i| words[i].parse::<f64>().unwrap())),
            Some(&"f") => {
                let index = |w: &str| w.split('/').next().unwrap().parse::<u32>().unwrap() - 1;
                let corner: Vec<u32> = words[1..].iter().map(|w| index(w)).collect();
                faces.extend((1..corner.len() - 1).map(|i| [corner[0], corner[i], corner[i + 1]]));
            }
            _ => {}
        }
    }
    let (mut number, mut positions) = (BTreeMap::new(), vec![]);
    let weld: Vec<u32> = points
        .iter()
        .map(|p| {
            *number.entry(p.map(f64::to_bits)).or_insert_with(|| {
                positions.push(DVec3::from_array(*p));
                positions.len() as u32 - 1
            })
        })
        .collect();
    faces.iter_mut().for_each(|f| *f = f.map(|v| weld[v as usize]));
    faces.retain(|f| f[0] != f[1] && f[1] != f[2] && f[2] != f[0]);
    let low = positions.iter().fold(DVec3::INFINITY, |l, p| l.min(*p));
    let high = positions.iter().fold(DVec3::NEG_INFINITY, |l, p| l.max(*p));
    let scale = 1.0 / (high - low).max_element();
    positions.iter_mut().for_each(|p| *p = (*p - low) * scale);
    Some(Mesh::new(positions, faces))
}

/// A cost that favours some edges, equal on both sides.
fn costs(mesh: &Mesh) -> Vec<f64> {
    (0..mesh.twin.len() as u32)
        .map(|c| {
            let (p, q) = (mesh.view().position(c), mesh.view().position(next(c)));
            (p - q).length() * (1.5 + (20.0 * (p + q).x).sin())
        })
        .collect()
}

/// Cuts the coarse mesh into disks and carries the cuts over.
fn carry(mesh: &Mesh, target: usize, slides: Slides) -> (Vec<u8>, Transferred, Coarse, Vec<u8>) {
    let coarse = coarsen(mesh, target);
    let rest = |m: &Mesh| -> Vec<Rest> {
        m.faces.iter().map(|f| Rest::new(f.map(|v| m.positions[v as usize]), 1e-9)).collect()
    };
    let (n, f) = (mesh.positions.len(), mesh.faces.len());
    let (fine_rest, coarse_rest) = (rest(mesh), rest(&coarse.mesh));
    let fine_cost = costs(mesh);
    let mut keep = vec![0; 40 * f + 1000];
    let mut keep = Scratch::new(&mut keep);
    let fine = Surface::new(mesh.view(), &mesh.twin, &fine_rest, &fine_cost, &mut keep).unwrap();
    let mut coarse_cost = vec![0.0; coarse.mesh.twin.len()];
    let mut bytes = vec![0; proxy_costs_need(n, coarse.vertex.len())];
    let scratch = Scratch::new(&mut bytes);
    let view = coarse.mesh.view();
    proxy_costs(&mut coarse_cost, view, &coarse.mesh.twin, &coarse.vertex, &fine, scratch).unwrap();
    let mut coarse_cut = vec![0; coarse.mesh.twin.len()];
    let mut cut = vec![0; 3 * f];
    let done = {
        let surface = Surface::new(view, &coarse.mesh.twin, &coarse_rest, &coarse_cost, &mut keep).unwrap();
        let mut bytes = vec![0; 1000 * coarse.mesh.faces.len() + 100_000];
        cut_to_disks(&mut coarse_cut, &surface, Scratch::new(&mut bytes)).unwrap();
        let mut bytes = vec![0; transfer_need(n, f)];
        let one_less = bytes.len() - 1;
        let short = Scratch::new(&mut bytes[..one_less]);
        assert!(transfer(&mut cut, &fine, &surface, &coarse_cut, &coarse.history, slides, short).is_err());
        let scratch = Scratch::new(&mut bytes);
        transfer(&mut cut, &fine, &surface, &coarse_cut, &coarse.history, slides, scratch).unwrap()
    };
    (cut, done, coarse, coarse_cut)
}

fn total(cut: &[u8], cost: &[f64]) -> f64 {
    cut.iter().zip(cost).map(|(cut, cost)| f64::from(*cut) * cost).sum()
}

const SLIDES: Slides = Slides { reach: 2.0, rounds: 3 };

#[test]
fn a_coarse_mesh_has_the_shape_of_the_fine_one() {
    for mesh in [torus(), tube(), sheet(), sphere(12)] {
        let coarse = coarsen(&mesh, mesh.faces.len() / 10);
        assert!(coarse.mesh.faces.len() <= mesh.faces.len() / 10);
        assert_eq!(coarse.mesh.shape(), mesh.shape());
        assert_eq!(coarse.history.len() + coarse.vertex.len(), mesh.positions.len());
        assert!(coarse.vertex.is_sorted());
    }
}

#[test]
fn collapses_end_before_anything_vanishes() {
    for (mesh, least) in [(torus(), 14), (tube(), 6), (sheet(), 1), (sphere(6), 4)] {
        let coarse = coarsen(&mesh, 0);
        assert_eq!(coarse.mesh.shape(), mesh.shape());
        assert!(coarse.mesh.faces.len() >= least);
    }
}

#[test]
fn small_meshes_stay_as_they_are() {
    let p = |x, y, z| DVec3::new(x, y, z);
    let positions = vec![p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(0.0, 1.0, 0.0), p(0.0, 0.0, 1.0)];
    let triangle = Mesh::new(positions.clone(), vec![[0, 1, 2]]);
    let tetrahedron = Mesh::new(positions, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]);
    let nothing = Mesh::new(vec![], vec![]);
    for mesh in [triangle, tetrahedron, nothing] {
        assert_eq!(coarsen(&mesh, 0).mesh.faces, *mesh.faces);
    }
}

#[test]
fn flat_faces_and_points_that_are_no_numbers_do_no_harm() {
    let mut mesh = sheet();
    mesh.positions[47] = mesh.positions[48];
    mesh.positions[200] = DVec3::NAN;
    let coarse = coarsen(&mesh, 100);
    assert_eq!(coarse.mesh.shape(), mesh.shape());
    assert!(coarse.vertex.contains(&200) && coarse.mesh.faces.len() < 200);
}

#[test]
fn a_coarse_sphere_is_near_the_sphere_and_no_face_looks_inwards() {
    let mesh = sphere(24);
    let coarse = coarsen(&mesh, mesh.faces.len() / 8).mesh;
    // Regular triangles of this number have sagitta L^2 / 6 R with L^2 = 4 / sqrt(3) area: 0.6 % of the diameter of 1;
    // half-edge collapses leave edges up to twice that long.
    for f in 0..coarse.faces.len() {
        let centre = coarse.faces[f].map(|v| coarse.positions[v as usize]).iter().sum::<DVec3>() / 3.0;
        let normal = coarse.view().area_vector(f).normalize();
        assert!(normal.dot(centre.normalize()) > 0.9, "face {f} is turned");
        assert!(0.5 - centre.length() < 4.0 * 0.006, "face {f} is {} deep", 0.5 - centre.length());
    }
}

#[test]
fn one_byte_less_than_needed_is_refused() {
    let mesh = sheet();
    let (n, f) = (mesh.positions.len(), mesh.faces.len());
    let (mut faces, mut vertex, mut history) = (vec![[7; 3]; f], vec![7; n], vec![Collapse::default(); n]);
    let mut bytes = vec![0; decimate_need(n, f) - 1];
    let scratch = Scratch::new(&mut bytes);
    let short = decimate(
        &mut faces,
        &mut vertex,
        &mut history,
        mesh.view(),
        &mesh.twin,
        &vec![0; mesh.twin.len()],
        10,
        scratch,
    );
    assert_eq!(short.unwrap_err().need, decimate_need(n, f));
    assert!(faces.iter().all(|f| *f == [7; 3]) && vertex.iter().all(|v| *v == 7));
}

#[test]
fn cuts_carried_over_give_the_same_charts() {
    for mesh in [torus(), tube(), sheet(), sphere(16)] {
        for slides in [Slides { reach: 0.0, rounds: 0 }, SLIDES] {
            let (_, done, ..) = carry(&mesh, mesh.faces.len() / 12, slides);
            assert!(done.is_faithful(), "{done:?}");
            assert_eq!((done.forbidden, done.strayed), (0, if slides.rounds == 0 { done.strayed } else { 0 }));
        }
    }
}

#[test]
fn sliding_makes_cuts_cheaper() {
    for mesh in [torus(), tube(), sphere(16)] {
        let cost = costs(&mesh);
        let (stiff, ..) = carry(&mesh, mesh.faces.len() / 12, Slides { reach: 0.0, rounds: 0 });
        let (slid, ..) = carry(&mesh, mesh.faces.len() / 12, SLIDES);
        assert!(total(&slid, &cost) < total(&stiff, &cost));
    }
}

#[test]
fn a_cut_that_ends_freely_ends_on_the_same_vertex() {
    let mesh = sphere(16);
    let (cut, _, coarse, coarse_cut) = carry(&mesh, 300, SLIDES);
    let tips = |mesh: &Mesh, cut: &[u8]| {
        let mut degree = vec![0; mesh.positions.len()];
        (0..cut.len() as u32).for_each(|c| degree[mesh.view().vertex(c) as usize] += u32::from(cut[c as usize]));
        (0..degree.len()).filter(|v| degree[*v] == 1).collect::<Vec<_>>()
    };
    let wanted: Vec<usize> = tips(&coarse.mesh, &coarse_cut).iter().map(|v| coarse.vertex[*v] as usize).collect();
    assert_eq!(tips(&mesh, &cut), wanted);
    assert!(wanted.len() >= 2);
}

#[test]
fn real_meshes_keep_their_shape_and_their_charts() {
    for (name, target) in [("bob", 2000), ("rocker-arm", 3000), ("potion", 4000), ("nefertiti", 10_000)] {
        let Some(mesh) = bench(name) else { return };
        let coarse = coarsen(&mesh, target);
        assert_eq!(coarse.mesh.shape(), mesh.shape(), "{name}");
        assert!(coarse.mesh.faces.len() <= target, "{name}");
        let again = coarsen(&mesh, target);
        assert!(again.mesh == coarse.mesh && again.history == coarse.history);
        let (_, done, ..) = carry(&mesh, target, SLIDES);
        assert!(done.is_faithful(), "{name}: {done:?}");
    }
}
