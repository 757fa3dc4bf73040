//! Runs that end early, wherever that is: the atlas is valid, and counted work gives it again.

use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use glam::DVec3;
use seamwright::formats::loaded::load;
use seamwright::mesh::polygons::Mesh;
use seamwright::run::threads::Pool;
use seamwright_core::base::progress::{Progress, Stage, Wish};
use seamwright_core::base::workers::{Serial, Workers};
use seamwright_core::pipeline::{CountedWork, Packing, Settings, UnwrapError};
use seamwright_tests::road::{input, judge, run, run_told, unsound};
use std::path::Path;

/// Sounds the alarm when tasks are handed to it for a given time, or as soon after that as a stage can end early.
struct Ringing<'r> {
    pool: Pool,
    left: AtomicUsize,
    alarm: &'r AtomicBool,
    can_end: &'r AtomicBool,
}

impl Workers for Ringing<'_> {
    fn run(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        let can_end = self.can_end.load(Ordering::Relaxed);
        let less = |left: usize| left.checked_sub(1).filter(|left| *left > 0 || can_end);
        if self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, less) == Ok(1) {
            self.alarm.store(true, Ordering::Relaxed);
        }
        self.pool.run(count, task);
    }
}

/// Counts the times that tasks are handed to it.
struct Counted {
    pool: Pool,
    calls: AtomicUsize,
}

impl Workers for Counted {
    fn run(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        self.calls.fetch_add(1, Ordering::Relaxed);
        self.pool.run(count, task);
    }
}

/// Answers `wish` once the alarm has sounded, and takes it back for `Finish`.
struct Hurried<'h> {
    alarm: &'h AtomicBool,
    can_end: &'h AtomicBool,
    wish: Wish,
    heard: Option<Stage>,
}

impl Progress for Hurried<'_> {
    fn report(&mut self, stage: Stage, done: usize, total: usize) -> Wish {
        let can_end = matches!(stage, Stage::Exposure | Stage::Seams | Stage::Pack) && done != total;
        self.can_end.store(can_end, Ordering::Relaxed);
        // What can end early does from here on.
        if self.alarm.swap(self.wish == Wish::Stop && self.alarm.load(Ordering::Relaxed), Ordering::Relaxed) {
            self.heard = Some(stage);
        }
        if self.heard.is_some() { self.wish } else { Wish::GoOn }
    }
}

fn settings() -> Settings {
    Settings { rays: 16, effort: 0.05, ..Settings::default() }
}

/// Ends after so many calls of the workers. The stage that heard of it, nothing where the run was done before.
fn end_after(calls: usize, mesh: &Mesh, settings: Settings) -> Option<Stage> {
    let (alarm, can_end) = (AtomicBool::new(false), AtomicBool::new(false));
    let (pool, left) = (Pool::new(Some(1)).unwrap(), AtomicUsize::new(calls));
    let workers = Ringing { pool, left, alarm: &alarm, can_end: &can_end };
    let mut progress = Hurried { alarm: &alarm, can_end: &can_end, wish: Wish::Finish, heard: None };
    let limited = Settings { ends_early: true, ..settings };
    let (atlas, report) = run_told(&input(mesh), &limited, &workers, 0, &mut progress, &alarm).unwrap();
    let wrong = unsound(&judge(mesh, &atlas), &atlas, &report);
    assert!(wrong.is_empty(), "after {calls} calls, {:?}: {wrong:?}", report.ended_early);
    if let Some(work) = report.ended_early {
        let again = run(mesh, &Settings { work, ..settings }, &Serial, 0).unwrap();
        assert!(again.0 == atlas, "after {calls} calls: {work:?} gives another atlas");
        assert_eq!(again.1.ended_early, Some(work));
    }
    progress.heard
}

fn fixture(name: &str) -> Mesh {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures").join(name);
    load(&path).unwrap().mesh().clone()
}

/// Meshes side by side as one.
fn together(meshes: &[Mesh]) -> Mesh {
    let mut all = Mesh { polygon_start: vec![0], ..Mesh::default() };
    for (i, mesh) in meshes.iter().enumerate() {
        let (vertices, corners) = (all.positions.len() as u32, all.corners.len() as u32);
        all.positions.extend(mesh.positions.iter().map(|p| *p + DVec3::X * 5.0 * i as f64));
        all.corners.extend(mesh.corners.iter().map(|v| v + vertices));
        all.polygon_start.extend(mesh.polygon_start[1..].iter().map(|c| c + corners));
    }
    all
}

#[test]
fn a_run_that_is_broken_off_anywhere_gives_a_valid_atlas_that_its_work_gives_again() {
    let several = together(&["cube.obj", "gear.obj", "torus.obj", "hand.obj", "torus.obj"].map(fixture));
    for (mesh, search) in [(fixture("quadruped.obj"), 0), (several, 0), (fixture("gear.obj"), 2)] {
        let settings = Settings { search, ..settings() };
        // One thread: how far a trial gets that another breaks off, and so the count, is not given with more.
        let counted = Counted { pool: Pool::new(Some(1)).unwrap(), calls: AtomicUsize::new(0) };
        run(&mesh, &settings, &counted, 0).unwrap();
        let all = counted.calls.into_inner();
        // Here and there, and everywhere in packing and before it.
        let scattered = core::iter::successors(Some(1), |calls| Some(3 * calls + 1));
        let calls = scattered.take_while(|calls| *calls < all).chain(all.saturating_sub(4)..=all);
        let heard: Vec<Stage> = calls.filter_map(|calls| end_after(calls, &mesh, settings)).collect();
        for stage in [Stage::Exposure, Stage::Seams, Stage::Pack] {
            assert!(heard.contains(&stage), "{heard:?}");
        }
    }
}

#[test]
fn stages_end_at_limits_of_work_one_by_one() {
    let mesh = fixture("quadruped.obj");
    let whole = run(&mesh, &settings(), &Serial, 0).unwrap();
    assert_eq!(whole.1.ended_early, None);
    let none = CountedWork { exposure: 0, seams: 0, pack: 0 };
    for work in [
        CountedWork { exposure: 0, ..CountedWork::ALL },
        CountedWork { seams: 0, ..CountedWork::ALL },
        CountedWork { pack: 0, ..CountedWork::ALL },
        none,
    ] {
        let (atlas, report) = run(&mesh, &Settings { work, ..settings() }, &Serial, 0).unwrap();
        assert_eq!(unsound(&judge(&mesh, &atlas), &atlas, &report), Vec::<String>::new(), "{work:?}");
        assert_eq!(report.ended_early, Some(work));
        assert!(report.utilisation < whole.1.utilisation || work.pack > 0);
    }
    let most = CountedWork { exposure: 1 << 40, seams: 1 << 40, pack: 1 << 20 };
    let same = run(&mesh, &Settings { work: most, ..settings() }, &Serial, 0).unwrap();
    assert!(same.0 == whole.0);
}

/// Carrying cuts over from the coarse mesh is between two marks: at none is what was found there lost.
#[test]
fn whoever_waits_longer_does_not_get_many_charts_instead_of_few() {
    let mesh = fixture("quadruped.obj");
    let (mut seams, mut charts, mut few) = (0, usize::MAX, usize::MAX);
    loop {
        let work = CountedWork { seams, ..CountedWork::ALL };
        let (_, report) =
            run(&mesh, &Settings { work, rays: 8, packing: Packing::Grid, ..settings() }, &Serial, 0).unwrap();
        few = few.min(charts);
        charts = report.chart_count;
        assert!(charts <= few.saturating_mul(3), "{charts} charts at {seams} instead of {few}");
        let Some(ended) = report.ended_early else { break };
        seams = ended.seams + 1;
    }
    assert!(charts < 10);
}

#[test]
fn who_wants_to_stop_is_answered_by_the_alarm() {
    let mesh = fixture("quadruped.obj");
    for calls in [1, 4, 30, 200] {
        let (alarm, can_end) = (AtomicBool::new(false), AtomicBool::new(false));
        let (pool, left) = (Pool::new(Some(2)).unwrap(), AtomicUsize::new(calls));
        let workers = Ringing { pool, left, alarm: &alarm, can_end: &can_end };
        let mut progress = Hurried { alarm: &alarm, can_end: &can_end, wish: Wish::Stop, heard: None };
        let stopped = run_told(&input(&mesh), &settings(), &workers, 0, &mut progress, &alarm);
        assert_eq!(stopped.err(), Some(UnwrapError::Cancelled));
    }
}
