//! Parts against people's: `parts_bench FOLDER [CGAL_TABLE]` prints Rand errors and seconds per category, as Markdown.
//!
//! FOLDER holds `ID_category.obj` and `labels/ID_K.seg`, the K-th person's label of each face (Chen, Golovinskiy,
//! Funkhouser, *A benchmark for 3D mesh segmentation*, SIGGRAPH 2009). The error of a mesh is the share of pairs of faces
//! that one labelling joins and the other parts, averaged over people; that of a category the mean over its meshes. Four
//! runs: `auto`; N, the category's rounded mean number of parts over all people; the published method with its numbers
//! and with the number of clusters left to the information criterion. People are compared among themselves.
//! CGAL_TABLE holds lines `mesh seconds error` of `tests/bench/cgal_parts.sh`, run just before. Seconds are this
//! thread's time on a processor, ray hierarchy, diameters and cut together.

use seamwright_core::base::{scratch::Scratch, workers::Serial};
use seamwright_core::mesh::topology::{twins, twins_need};
use seamwright_core::mesh::view::MeshView;
use seamwright_core::parts::settings::{Count, PartSettings};
use seamwright_core::pipeline::partition::{partition, partition_need};
use seamwright_core::rays::binned::BinnedBuilder;
use seamwright_tests::{load_obj, rand_error, seconds};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::read_to_string;

/// One mesh with its people's labels.
struct Case {
    name: String,
    mesh: (Vec<glam::DVec3>, Vec<[u32; 3]>),
    people: Vec<Vec<u32>>,
}

/// Errors and seconds of one mesh, by run; the last two columns are people's error and CGAL's.
const COLUMNS: [&str; 6] = ["auto", "N given", "published", "published, BIC", "people", "CGAL"];

fn main() {
    let mut args = std::env::args().skip(1);
    let folder = args.next().expect("usage: parts_bench FOLDER [CGAL_TABLE]");
    let cgal = args.next().map(|path| table(&path)).unwrap_or_default();
    let mut categories: BTreeMap<String, Vec<Case>> = BTreeMap::new();
    for case in cases(&folder) {
        let category = case.name.split_once('_').map_or("", |n| n.1).to_string();
        categories.entry(category).or_default().push(case);
    }
    println!(
        "| category | N | {} | parts | s |\n|---|---|{}---|---|",
        COLUMNS.join(" | "),
        "---|".repeat(COLUMNS.len())
    );
    let mut all = Vec::new();
    for (category, cases) in &categories {
        let counts: Vec<f64> = cases.iter().flat_map(|c| &c.people).map(|p| part_count(p) as f64).collect();
        let n = (counts.iter().sum::<f64>() / counts.len() as f64).round() as u32;
        let rows: Vec<Row> = cases.iter().map(|case| measure(case, n, &cgal)).collect();
        rows.iter().for_each(|row| eprintln!("{}", row.line()));
        println!("{}", mean(category, &n.to_string(), &rows).line());
        all.extend(rows);
    }
    println!("{}", mean("mean", "", &all).line());
    let total = |pick: &dyn Fn(&Row) -> f64| all.iter().map(pick).sum::<f64>();
    println!("\nseconds in all: auto {:.2}, CGAL {:.2}", total(&|r| r.seconds), total(&|r| r.cgal_seconds));
}

struct Row {
    name: String,
    n: String,
    errors: [f64; COLUMNS.len()],
    parts: f64,
    seconds: f64,
    cgal_seconds: f64,
}

impl Row {
    fn line(&self) -> String {
        let errors: Vec<String> = self.errors.iter().map(|e| format!("{e:.3}")).collect();
        format!("| {} | {} | {} | {:.1} | {:.2} |", self.name, self.n, errors.join(" | "), self.parts, self.seconds)
    }
}

fn mean(name: &str, n: &str, rows: &[Row]) -> Row {
    let over = |pick: &dyn Fn(&Row) -> f64| rows.iter().map(pick).sum::<f64>() / rows.len() as f64;
    Row {
        name: name.into(),
        n: n.into(),
        errors: std::array::from_fn(|i| over(&|r| r.errors[i])),
        parts: over(&|r| r.parts),
        seconds: over(&|r| r.seconds),
        cgal_seconds: over(&|r| r.cgal_seconds),
    }
}

fn measure(case: &Case, n: u32, cgal: &BTreeMap<String, [f64; 2]>) -> Row {
    let start = seconds();
    let auto = segment(case, Count::Auto);
    let spent = seconds() - start;
    let runs = [
        auto.clone(),
        segment(case, Count::Exactly(n)),
        segment(case, Count::PUBLISHED),
        segment(case, Count::Published { clusters: None, lambda: 15.0 }),
    ];
    let error = |labels: &[u32]| average(case.people.iter().map(|p| rand_error(labels, p)));
    let others = |i: usize| (0..case.people.len()).filter(move |j| *j != i).map(|j| &case.people[j]);
    let among = (0..case.people.len()).map(|i| average(others(i).map(|p| rand_error(&case.people[i], p))));
    let [cgal_seconds, cgal_error] = cgal.get(&case.name).copied().unwrap_or([f64::NAN; 2]);
    let [a, b, c, d] = runs.map(|labels| error(&labels));
    Row {
        name: case.name.clone(),
        n: n.to_string(),
        errors: [a, b, c, d, average(among), cgal_error],
        parts: part_count(&auto) as f64,
        seconds: spent,
        cgal_seconds,
    }
}

fn average(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(s, n), x| (s + x, n + 1));
    sum / count as f64
}

fn segment(case: &Case, count: Count) -> Vec<u32> {
    let (positions, faces) = &case.mesh;
    let mesh = MeshView { positions, faces };
    let need = partition_need(faces.len(), positions.len(), &BinnedBuilder).max(twins_need(faces.len()));
    let mut bytes = vec![0u8; need];
    let mut twin = vec![0; 3 * faces.len()];
    twins(&mut twin, mesh, Scratch::new(&mut bytes)).expect("enough scratch");
    let (mut labels, mut diameter) = (vec![0; faces.len()], vec![0.0; faces.len()]);
    let settings = PartSettings { count, ..Default::default() };
    let scratch = Scratch::new(&mut bytes);
    partition(&mut labels, &mut diameter, mesh, &twin, &settings, &BinnedBuilder, scratch, &Serial)
        .unwrap_or_else(|e| panic!("{}: {e}", case.name));
    if let Ok(folder) = std::env::var("PARTS_OUT") {
        let name = match count {
            Count::Auto => "auto",
            Count::Exactly(_) => "count",
            Count::Published { .. } => "published",
        };
        let text: String = labels.iter().map(|l| format!("{l}\n")).collect();
        std::fs::write(format!("{folder}/{}_{name}.seg", case.name), text).expect("a writable folder");
    }
    labels
}

fn part_count(labels: &[u32]) -> usize {
    labels.iter().collect::<BTreeSet<_>>().len()
}

/// The meshes of the folder that have labels, by name.
fn cases(folder: &str) -> Vec<Case> {
    let names = |folder: &str, ending: &str| -> BTreeSet<String> {
        let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{folder}: {e}"));
        let names = entries.map(|e| e.expect("a readable folder").file_name().to_string_lossy().into_owned());
        names.filter_map(|n| n.strip_suffix(ending).map(str::to_string)).collect()
    };
    let people = names(&format!("{folder}/labels"), ".seg");
    let of = |id: &str| {
        let id = id.trim_start_matches('0');
        let own = people.iter().filter(|p| p.rsplit_once('_').is_some_and(|p| p.0 == id));
        own.map(|p| numbers(&format!("{folder}/labels/{p}.seg"))).collect::<Vec<_>>()
    };
    let meshes = names(folder, ".obj").into_iter().map(|name| {
        let people = of(name.split('_').next().unwrap_or(""));
        Case { mesh: load_obj(&format!("{folder}/{name}.obj")), people, name }
    });
    meshes.filter(|c| !c.people.is_empty()).collect()
}

fn numbers(path: &str) -> Vec<u32> {
    let text = read_to_string(path).unwrap_or_else(|e| panic!("{path}: {e}"));
    text.split_whitespace().map(|w| w.parse().unwrap_or_else(|_| panic!("{path}: {w} is no label"))).collect()
}

/// Lines `name x y`.
fn table(path: &str) -> BTreeMap<String, [f64; 2]> {
    let text = read_to_string(path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let line = |l: &str| {
        let mut words = l.split_whitespace();
        let name = words.next()?.to_string();
        Some((name, [words.next()?.parse().ok()?, words.next()?.parse().ok()?]))
    };
    text.lines().filter_map(line).collect()
}
