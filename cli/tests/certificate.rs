//! `check`: atlases of ours keep every rule, and what breaks one by a step of the grid is refused, with the face and the reason.

use glam::{DVec2, DVec3};
use seamwright::certificate::distance::Texels;
use seamwright::certificate::fault::Fault;
use seamwright::certificate::verdict::{Rules, verdict};
use seamwright::formats::loaded::load;
use seamwright::mesh::polygons::{Mesh, NO_UV};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const GAP: Texels = Texels { size: 512, padding: 4 };
/// A step of the grid on which UVs are written.
const STEP: f64 = 1.0 / (1u32 << 24) as f64;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures").join(name)
}

fn seamwright(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_seamwright")).args(args).output().expect("the command starts")
}

/// Unwraps a fixture to `output`.
fn unwrap(name: &str, output: &Path) {
    let (input, output) = (fixture(name), output.display().to_string());
    let input = input.display().to_string();
    let done = seamwright(&["unwrap", &input, "-o", &output, "--size", "512", "--padding", "4", "-q"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}

#[test]
fn our_own_atlases_keep_every_rule() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let of_floats = folder.path().join("f.glb").display().to_string();
    for (name, output) in [
        ("cube.obj", "a.obj"),
        ("gear.obj", "b.obj"),
        ("faults/rigged.glb", "c.glb"),
        ("cube.obj", "d.glb"),
        ("cube.obj", "e.ply"),
        ("gear.obj", "f.glb"),
        // A text has the shortest decimals of floats, which read as other doubles.
        (&of_floats, "g.obj"),
    ] {
        let output = folder.path().join(output);
        unwrap(name, &output);
        let (input, output) = (fixture(name).display().to_string(), output.display().to_string());
        let done = seamwright(&["check", &output, "--input", &input, "--size", "512", "--padding", "4"]);
        let text = String::from_utf8_lossy(&done.stdout).into_owned() + &String::from_utf8_lossy(&done.stderr);
        assert!(done.status.success() && text.contains("every rule is kept"), "{name} {output}: {text}");
        // A wider gutter than was asked for is not there.
        let done = seamwright(&["check", &output, "--size", "512", "--padding", "40"]);
        let text = String::from_utf8_lossy(&done.stdout).into_owned();
        assert!(done.status.code() == Some(5) && text.contains("of another chart"), "{name} {output}: {text}");
    }
    let done = seamwright(&["check", &fixture("cube.obj").display().to_string()]);
    assert_eq!(done.status.code(), Some(5), "without UVs");
    assert!(String::from_utf8_lossy(&done.stdout).contains("no face has UVs"));
    let other = seamwright(&[
        "check",
        &folder.path().join("a.obj").display().to_string(),
        "--input",
        &fixture("gear.obj").display().to_string(),
    ]);
    assert!(String::from_utf8_lossy(&other.stdout).contains("another mesh than --input"));
}

/// Numbers by chance, the same ones each time.
struct Chance(u64);

impl Chance {
    fn below(&mut self, count: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 33) % count as u64) as usize
    }
}

/// An atlas, and which faces hang together in it.
struct Sound {
    mesh: Mesh,
    charts: Vec<Vec<usize>>,
}

impl Sound {
    fn of(name: &str) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.obj");
        unwrap(name, &path);
        let mesh = load(&path).expect("our own file").mesh().clone();
        let mut charts: Vec<Vec<usize>> = Vec::new();
        let mut left: Vec<usize> = (0..mesh.polygon_count()).rev().collect();
        let mut chart_of = vec![usize::MAX; mesh.polygon_count()];
        // By faces that share a vertex and its UV; slow and plain.
        while let Some(first) = left.pop() {
            if chart_of[first] != usize::MAX {
                continue;
            }
            let (mut chart, mut next) = (Vec::new(), vec![first]);
            chart_of[first] = charts.len();
            while let Some(face) = next.pop() {
                chart.push(face);
                let number = charts.len();
                for (other, chart) in chart_of.iter_mut().enumerate().filter(|(_, chart)| **chart == usize::MAX) {
                    if mesh.polygon(face).any(|a| mesh.polygon(other).any(|b| is_same(&mesh, a, b))) {
                        *chart = number;
                        next.push(other);
                    }
                }
            }
            charts.push(chart);
        }
        assert!(charts.len() > 1, "{name} has one chart");
        Self { mesh, charts }
    }
}

fn uv(mesh: &Mesh) -> &[DVec2] {
    mesh.corner_uv.as_deref().expect("an atlas")
}

fn is_same(mesh: &Mesh, a: usize, b: usize) -> bool {
    mesh.corners[a] == mesh.corners[b] && uv(mesh)[a] == uv(mesh)[b]
}

fn shift(mesh: &mut Mesh, chart: &[usize], by: DVec2) {
    for corner in chart.iter().flat_map(|f| mesh.polygon(*f)).collect::<Vec<_>>() {
        mesh.corner_uv.as_mut().expect("an atlas")[corner] += by;
    }
}

/// A change that breaks a rule. Gives the faces that it touches.
type Change = fn(&Sound, &mut Chance, &mut Mesh) -> Vec<usize>;
/// Whether a fault is one that the change makes.
type Meant = fn(&Fault) -> bool;

fn unmapped(_: &Sound, chance: &mut Chance, mesh: &mut Mesh) -> Vec<usize> {
    let face = chance.below(mesh.polygon_count());
    let corner = mesh.polygon(face).start;
    mesh.corner_uv.as_mut().expect("an atlas")[corner] = NO_UV;
    vec![face]
}

/// A face's first two corners change their UVs.
fn crossed(_: &Sound, chance: &mut Chance, mesh: &mut Mesh) -> Vec<usize> {
    let face = chance.below(mesh.polygon_count());
    let corner = mesh.polygon(face).start;
    mesh.corner_uv.as_mut().expect("an atlas").swap(corner, corner + 1);
    vec![face]
}

/// A vertex is drawn a step of the grid beyond what lies opposite to it.
fn pushed(_: &Sound, chance: &mut Chance, mesh: &mut Mesh) -> Vec<usize> {
    let face = chance.below(mesh.polygon_count());
    let corners = mesh.polygon(face);
    let (start, n) = (corners.start, corners.len());
    let own = uv(mesh)[start];
    let opposite = if n == 3 { uv(mesh)[start + 1].midpoint(uv(mesh)[start + 2]) } else { uv(mesh)[start + n / 2] };
    let to = opposite + (opposite - own).normalize() * STEP;
    let moved: Vec<usize> = (0..mesh.corners.len()).filter(|c| is_same(mesh, *c, start)).collect();
    moved.iter().for_each(|c| mesh.corner_uv.as_mut().expect("an atlas")[*c] = to);
    (0..mesh.polygon_count()).filter(|f| mesh.polygon(*f).any(|c| moved.contains(&c))).collect()
}

fn collapsed(_: &Sound, chance: &mut Chance, mesh: &mut Mesh) -> Vec<usize> {
    let face = chance.below(mesh.polygon_count());
    let corners = mesh.polygon(face);
    let to = uv(mesh)[corners.start];
    mesh.corner_uv.as_mut().expect("an atlas")[corners].fill(to);
    vec![face]
}

/// A chart is laid onto a face of another.
fn stacked(sound: &Sound, chance: &mut Chance, mesh: &mut Mesh) -> Vec<usize> {
    let (from, to) = two(sound, chance);
    let middle = |face: usize| {
        let corners = mesh.polygon(face);
        let count = corners.len() as f64;
        uv(mesh)[corners].iter().sum::<DVec2>() / count
    };
    let by = middle(to[chance.below(to.len())]) - middle(from[0]);
    shift(mesh, from, by);
    from.clone()
}

/// A chart comes closer to another than the gutter, by a step of the grid.
fn narrowed(sound: &Sound, chance: &mut Chance, mesh: &mut Mesh) -> Vec<usize> {
    let (from, to) = two(sound, chance);
    let points = |chart: &[usize]| chart.iter().flat_map(|f| mesh.polygon(*f)).map(|c| uv(mesh)[c]).collect::<Vec<_>>();
    let (a, b) = (points(from), points(to));
    let pairs = a.iter().flat_map(|a| b.iter().map(move |b| (*a, *b)));
    let (p, q) = pairs.min_by(|x, y| x.0.distance(x.1).total_cmp(&y.0.distance(y.1))).expect("points");
    let gap = f64::from(GAP.padding) / f64::from(GAP.size);
    shift(mesh, from, (q - p) - (q - p).normalize() * (gap - STEP));
    from.clone()
}

/// A chart reaches out of the square, by a step of the grid.
fn outside(sound: &Sound, chance: &mut Chance, mesh: &mut Mesh) -> Vec<usize> {
    let chart = &sound.charts[chance.below(sound.charts.len())];
    let points = || chart.iter().flat_map(|f| mesh.polygon(*f)).map(|c| uv(mesh)[c]);
    let low = points().reduce(DVec2::min).expect("points");
    let high = points().reduce(DVec2::max).expect("points");
    let by = [DVec2::new(-low.x - STEP, 0.0), DVec2::new(0.0, -low.y - STEP), DVec2::new(1.0 + STEP - high.x, 0.0)];
    shift(mesh, chart, by[chance.below(3)]);
    chart.clone()
}

/// A vertex of the mesh moves by the last bit of its largest coordinate.
fn moved(_: &Sound, chance: &mut Chance, mesh: &mut Mesh) -> Vec<usize> {
    let corner = chance.below(mesh.corners.len());
    let vertex = mesh.corners[corner] as usize;
    let place: &mut DVec3 = &mut mesh.positions[vertex];
    let axis = usize::from(place.y.abs() > place.x.abs());
    place[axis] = f64::from(place.as_vec3()[axis].next_up().next_up());
    (0..mesh.polygon_count()).filter(|f| mesh.polygon(*f).any(|c| mesh.corners[c] as usize == vertex)).collect()
}

/// A face is gone.
fn lost(_: &Sound, chance: &mut Chance, mesh: &mut Mesh) -> Vec<usize> {
    let face = chance.below(mesh.polygon_count());
    let corners = mesh.polygon(face);
    mesh.corners.drain(corners.clone());
    mesh.corner_uv.as_mut().expect("an atlas").drain(corners.clone());
    mesh.polygon_start.remove(face + 1);
    mesh.polygon_start[face + 1..].iter_mut().for_each(|start| *start -= corners.len() as u32);
    vec![face]
}

/// A corner names another vertex.
fn rewired(_: &Sound, chance: &mut Chance, mesh: &mut Mesh) -> Vec<usize> {
    let face = chance.below(mesh.polygon_count());
    let corner = mesh.polygon(face).start + chance.below(mesh.polygon(face).len());
    let own = mesh.positions[mesh.corners[corner] as usize];
    let other = chance.below(mesh.positions.len());
    let other = (0..mesh.positions.len()).map(|k| (other + k) % mesh.positions.len());
    let other = other.into_iter().find(|v| mesh.positions[*v] != own).expect("another place");
    mesh.corners[corner] = other as u32;
    vec![face]
}

fn two<'a>(sound: &'a Sound, chance: &mut Chance) -> (&'a Vec<usize>, &'a Vec<usize>) {
    let count = sound.charts.len();
    let from = chance.below(count);
    (&sound.charts[from], &sound.charts[(from + 1 + chance.below(count - 1)) % count])
}

#[test]
fn what_breaks_a_rule_by_a_step_is_refused_with_its_face_and_its_reason() {
    let kinds: [(&str, Change, Meant); 10] = [
        ("unmapped", unmapped, |f| matches!(f, Fault::Unmapped(_))),
        ("crossed", crossed, |f| matches!(f, Fault::Flipped(_))),
        ("pushed", pushed, |f| matches!(f, Fault::Flipped(_) | Fault::Overlap(..) | Fault::Empty(_))),
        ("collapsed", collapsed, |f| matches!(f, Fault::Empty(_))),
        ("stacked", stacked, |f| matches!(f, Fault::Overlap(..) | Fault::Outside(_))),
        ("narrowed", narrowed, |f| matches!(f, Fault::Gutter(..) | Fault::Overlap(..) | Fault::Outside(_))),
        ("outside", outside, |f| matches!(f, Fault::Outside(_))),
        ("moved", moved, |f| matches!(f, Fault::Changed(_))),
        ("lost", lost, |f| matches!(f, Fault::Missing(_))),
        ("rewired", rewired, |f| matches!(f, Fault::Changed(_))),
    ];
    for name in ["gear.obj", "cube.obj"] {
        let (sound, input) = (Sound::of(name), load(&fixture(name)).expect("a fixture"));
        let judge =
            |mesh: &Mesh| verdict(mesh, Rules { gap: Some(GAP), input: Some(input.mesh()), ..Rules::default() });
        assert_eq!(judge(&sound.mesh).faults, [], "{name}");
        assert_eq!(judge(&sound.mesh).charts, sound.charts.len(), "{name}");
        for (kind, change, is_meant) in &kinds {
            let mut chance = Chance(7);
            for round in 0..50 {
                let mut mesh = sound.mesh.clone();
                let touched: HashSet<usize> = change(&sound, &mut chance, &mut mesh).into_iter().collect();
                let faults = judge(&mesh).faults;
                let names = |f: &Fault| match f {
                    Fault::Overlap(a, b) | Fault::Gutter(a, b, _) => [*a, *b],
                    other => [other.face(); 2],
                };
                let is_named =
                    faults.iter().any(|f| is_meant(f) && names(f).iter().any(|f| touched.contains(&(*f as usize))));
                assert!(is_named, "{name}, {kind} {round}: {faults:?}, touched {touched:?}");
            }
        }
    }
}
