//! Packs the charts of UV-mapped OBJ files and prints how full the square is.
//!
//! `pack_bench [--size N] [--padding N] [--effort X] [--threads N] [--out DIR] FILE.obj...`
//! Charts are the faces joined by UV vertices, each scaled to its area in 3D and turned over where it is mirrored.
//! `fill` is the share of texel centres of the unit square that charts cover, after fitting their common box into it:
//! what the judge measures. `--out` writes each packed OBJ into a folder. See tests/bench/pack_peers.py for the peers.

use glam::{DVec2, DVec3};
use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::union_find::UnionFind;
use seamwright_core::base::workers::Workers;
use seamwright_core::pack::flat_charts::FlatCharts;
use seamwright_core::pack::layout::{pack, pack_need};
use seamwright_core::pack::placement::Placement;
use seamwright_core::pack::settings::PackSettings;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{env, error::Error, fmt::Write, fs, path::Path, time::Instant};

fn main() -> Result<(), Box<dyn Error>> {
    let mut settings = PackSettings::default();
    let (mut threads, mut out, mut files) = (1, None, Vec::new());
    let mut args = env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut value = || args.next().ok_or(format!("{arg} needs a value"));
        match arg.as_str() {
            "--size" => settings.size = value()?.parse()?,
            "--padding" => settings.padding = value()?.parse()?,
            "--effort" => settings.effort = value()?.parse()?,
            "--seed" => settings.seed = value()?.parse()?,
            "--threads" => threads = value()?.parse()?,
            "--out" => out = Some(value()?),
            _ => files.push(arg),
        }
    }
    println!("{:<28} {:>6} {:>7} {:>7} {:>7} {:>8}", "file", "charts", "area", "fill", "padding", "seconds");
    let (mut fills, mut seconds) = (0.0, 0.0);
    for file in &files {
        let mut atlas = Atlas::read(Path::new(file))?;
        atlas.equalise_density();
        let start = (Instant::now(), cpu_seconds());
        let charts = FlatCharts {
            uv: &atlas.uv,
            faces: &atlas.faces,
            chart: &atlas.chart,
            count: atlas.chart_count,
            upright: &[],
        };
        let mut bytes = vec![0; pack_need(charts.faces.len(), charts.count, &settings)];
        let mut placements = vec![Placement::IDENTITY; charts.count];
        let summary = pack(&mut placements, &charts, &settings, &mut Scratch::new(&mut bytes), &Threads(threads))?;
        let took = cpu_seconds().zip(start.1).map_or(start.0.elapsed().as_secs_f64(), |(now, then)| now - then);
        atlas.place(&placements);
        let fill = atlas.fill(settings.size as usize);
        let name = Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let area = summary.utilisation;
        println!("{name:<28} {:>6} {area:>7.4} {fill:>7.4} {:>7.3} {took:>8.3}", atlas.chart_count, summary.padding);
        (fills, seconds) = (fills + fill, seconds + took);
        if let Some(folder) = &out {
            fs::create_dir_all(folder)?;
            fs::write(Path::new(folder).join(format!("{name}.obj")), atlas.to_obj())?;
        }
    }
    let count = files.len().max(1) as f64;
    println!("{:<28} {:>6} {:>7} {:>7.4} {:>7} {:>8.3}", "mean", "", "", fills / count, "", seconds / count);
    Ok(())
}

/// A UV-mapped mesh: faces by UV vertex, and the 3D point of each UV vertex.
struct Atlas {
    uv: Vec<DVec2>,
    points: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    chart: Vec<u32>,
    chart_count: usize,
}

impl Atlas {
    fn read(path: &Path) -> Result<Self, Box<dyn Error>> {
        let (mut positions, mut uv, mut faces, mut points) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for line in fs::read_to_string(path)?.lines() {
            let mut words = line.split_whitespace();
            match words.next() {
                Some("v") => {
                    let p: Vec<f64> = words.map(str::parse).take(3).collect::<Result<_, _>>()?;
                    positions.push(DVec3::new(p[0], p[1], p[2]));
                }
                Some("vt") => {
                    let p: Vec<f64> = words.map(str::parse).take(2).collect::<Result<_, _>>()?;
                    uv.push(DVec2::new(p[0], p[1]));
                    points.push(DVec3::ZERO);
                }
                Some("f") => {
                    let mut polygon = Vec::new();
                    for word in words {
                        let mut ids = word.split('/');
                        let (v, t) = (ids.next().unwrap_or(""), ids.next().unwrap_or(""));
                        let index = |s: &str, n: usize| -> Result<usize, Box<dyn Error>> {
                            let i: i64 = s.parse()?;
                            Ok(if i > 0 { i as usize - 1 } else { (n as i64 + i) as usize })
                        };
                        let (v, t) = (index(v, positions.len())?, index(t, uv.len())?);
                        points[t] = positions[v];
                        polygon.push(t as u32);
                    }
                    (2..polygon.len()).for_each(|i| faces.push([polygon[0], polygon[i - 1], polygon[i]]));
                }
                _ => {}
            }
        }
        let (chart, chart_count) = charts_of(uv.len(), &faces);
        Ok(Self { uv, points, faces, chart, chart_count })
    }

    /// Equal texel density, no mirrored chart.
    fn equalise_density(&mut self) {
        let mut sums = vec![[0.0; 3]; self.chart_count]; // signed and absolute UV area, 3D area
        for (face, &chart) in self.faces.iter().zip(&self.chart) {
            let [a, b, c] = face.map(|v| self.uv[v as usize]);
            let [p, q, r] = face.map(|v| self.points[v as usize]);
            let signed = (b - a).perp_dot(c - a);
            let sum = &mut sums[chart as usize];
            *sum = [sum[0] + signed, sum[1] + signed.abs(), sum[2] + (q - p).cross(r - p).length()];
        }
        let mut done = vec![false; self.uv.len()];
        for (face, &chart) in self.faces.iter().zip(&self.chart) {
            let [signed, flat, solid] = sums[chart as usize];
            let scale = if flat > 0.0 && solid > 0.0 { (solid / flat).sqrt() } else { 1.0 };
            for v in face.map(|v| v as usize) {
                if !std::mem::replace(&mut done[v], true) {
                    self.uv[v] *= DVec2::new(if signed < 0.0 { -scale } else { scale }, scale);
                }
            }
        }
    }

    fn place(&mut self, placements: &[Placement]) {
        let mut done = vec![false; self.uv.len()];
        for (face, &chart) in self.faces.iter().zip(&self.chart) {
            for v in face.map(|v| v as usize) {
                if !std::mem::replace(&mut done[v], true) {
                    self.uv[v] = placements[chart as usize].apply(self.uv[v]);
                }
            }
        }
    }

    /// Covered texel centres over all texels, the common box fitted into the unit square.
    fn fill(&self, size: usize) -> f64 {
        let used = || self.faces.iter().flatten().map(|&v| self.uv[v as usize]);
        let low = used().fold(DVec2::INFINITY, DVec2::min);
        let side = (used().fold(DVec2::NEG_INFINITY, DVec2::max) - low).max_element();
        let mut texels = vec![false; size * size];
        for face in &self.faces {
            let t = face.map(|v| (self.uv[v as usize] - low) / side * size as f64 - 0.5);
            let (bottom, top) = (t[0].min(t[1]).min(t[2]), t[0].max(t[1]).max(t[2]));
            for y in bottom.y.ceil().max(0.0) as usize..(top.y.ceil().max(0.0) as usize).min(size) {
                let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
                for i in 0..3 {
                    let (p, q) = (t[i], t[(i + 1) % 3]);
                    if (p.y <= y as f64) != (q.y <= y as f64) {
                        let x = p.x + (y as f64 - p.y) / (q.y - p.y) * (q.x - p.x);
                        (from, to) = (from.min(x), to.max(x));
                    }
                }
                if from < to {
                    let columns = from.ceil().max(0.0) as usize..(to.ceil().max(0.0) as usize).min(size);
                    columns.for_each(|x| texels[y * size + x] = true);
                }
            }
        }
        texels.iter().filter(|t| **t).count() as f64 / (size * size) as f64
    }

    fn to_obj(&self) -> String {
        let mut text = String::new();
        for p in &self.points {
            let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
        }
        for p in &self.uv {
            let _ = writeln!(text, "vt {} {}", p.x, p.y);
        }
        for f in &self.faces {
            let [a, b, c] = f.map(|v| v + 1);
            let _ = writeln!(text, "f {a}/{a} {b}/{b} {c}/{c}");
        }
        text
    }
}

/// Charts: faces joined by UV vertices, numbered by first face.
fn charts_of(uv_count: usize, faces: &[[u32; 3]]) -> (Vec<u32>, usize) {
    let mut parent = vec![0; uv_count];
    let mut sets = UnionFind::new(&mut parent);
    for f in faces {
        sets.union(f[0], f[1]);
        sets.union(f[0], f[2]);
    }
    let (mut number, mut count) = (vec![u32::MAX; uv_count], 0);
    let mut chart = Vec::new();
    for f in faces {
        let root = sets.find(f[0]) as usize;
        if number[root] == u32::MAX {
            (number[root], count) = (count, count + 1);
        }
        chart.push(number[root]);
    }
    (chart, count as usize)
}

/// CPU time of this thread where the system tells (Linux), so that a busy machine does not count.
fn cpu_seconds() -> Option<f64> {
    let text = fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split(' ').next()?.parse::<f64>().ok().map(|nanoseconds| nanoseconds * 1e-9)
}

/// A thread each.
struct Threads(usize);

impl Workers for Threads {
    fn run(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        let next = AtomicUsize::new(0);
        let work = || {
            while let Some(i) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|i| *i < count) {
                task(i);
            }
        };
        std::thread::scope(|scope| {
            (1..self.0).for_each(|_| drop(scope.spawn(work)));
            work();
        });
    }
}
