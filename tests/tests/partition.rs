//! Parts of whole meshes: against the known parts of our own fixtures, people's parts of a benchmark, and over threads.
//!
//! The benchmark's meshes are not ours to carry along: where the folder is absent the test says so and passes.

use seamwright::run::threads::Pool;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::{Serial, Workers};
use seamwright_core::mesh::topology::{twins, twins_need};
use seamwright_core::mesh::view::MeshView;
use seamwright_core::parts::settings::{Count, PartSettings};
use seamwright_core::pipeline::partition::{partition, partition_need};
use seamwright_core::rays::binned::BinnedBuilder;
use seamwright_tests::{load_obj, rand_error};
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn segment(path: &Path, count: Count, workers: &dyn Workers) -> (Vec<u32>, Vec<f32>) {
    let (positions, faces) = load_obj(path.to_str().expect("a plain path"));
    let mesh = MeshView { positions: &positions, faces: &faces };
    let need = partition_need(faces.len(), positions.len(), &BinnedBuilder).max(twins_need(faces.len()));
    let mut bytes = vec![0u8; need];
    let mut twin = vec![0; 3 * faces.len()];
    twins(&mut twin, mesh, Scratch::new(&mut bytes)).expect("enough scratch");
    let (mut labels, mut diameter) = (vec![0; faces.len()], vec![0.0; faces.len()]);
    let settings = PartSettings { count, ..Default::default() };
    let scratch = Scratch::new(&mut bytes);
    partition(&mut labels, &mut diameter, mesh, &twin, &settings, &BinnedBuilder, scratch, workers).expect("parts");
    (labels, diameter)
}

fn labels_of(path: &Path) -> Vec<u32> {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    text.split_whitespace().map(|w| w.parse().expect("a label")).collect()
}

#[test]
fn the_known_parts_of_fixtures_are_found() {
    // Measured 0.080, 0.120, 0.104; the bounds leave a quarter for the border's place. Known misses, which docs/METHODS.md
    // names: the hand's forearm stays with its palm (0.19), and the mug's wall (0.37) and the frame's bars (0.27) are cut.
    for (name, bound) in [("person", 0.1), ("quadruped", 0.15), ("chess_piece", 0.13)] {
        let known = labels_of(&root().join(format!("fixtures/{name}.seg")));
        let found = segment(&root().join(format!("fixtures/{name}.obj")), Count::Auto, &Serial).0;
        let error = rand_error(&found, &known);
        println!("{name}: Rand error {error:.3}, {} parts", 1 + found.iter().max().expect("faces"));
        assert!(error < bound, "{name}: {error}");
    }
}

#[test]
fn a_ball_is_one_part() {
    let found = segment(&root().join("fixtures/sphere.obj"), Count::Auto, &Serial).0;
    assert!(found.iter().all(|l| *l == 0), "{:?}", found.iter().max());
}

#[test]
fn threads_change_no_label_and_no_diameter() {
    let path = root().join("fixtures/hand.obj");
    let pool = Pool::new(Some(3)).expect("threads");
    for count in [Count::Auto, Count::Exactly(5), Count::PUBLISHED] {
        assert_eq!(segment(&path, count, &Serial), segment(&path, count, &pool));
    }
}

/// Meshes of a benchmark: one small one of each of several kinds.
#[test]
fn people_would_have_cut_alike() {
    let folder = root().join("../shared/meshes/psb");
    if !folder.exists() {
        return println!("skipped: no benchmark meshes beside the repository");
    }
    let names = ["052_glasses", "072_airplane", "092_ant", "124_octopus", "184_hand", "204_plier", "244_bird"];
    let mut sum = 0.0;
    for name in names {
        let found = segment(&folder.join(format!("{name}.obj")), Count::Auto, &Serial).0;
        let person = |k: usize| {
            folder.join(format!("labels/{}_{k}.seg", name.split('_').next().expect("a number").trim_start_matches('0')))
        };
        let people: Vec<_> = (0..).map(person).take_while(|p| p.exists()).map(|p| labels_of(&p)).collect();
        assert!(!people.is_empty(), "{name}");
        let error = people.iter().map(|p| rand_error(&found, p)).sum::<f64>() / people.len() as f64;
        println!("{name}: {error:.3}");
        sum += error;
    }
    // The goal over the whole benchmark; docs/RESULTS.md has the table.
    assert!(sum / names.len() as f64 <= 0.16);
}
