//! Development harness.
use glam::{DVec2, DVec3};
use seamwright_core::atlas::{energy::Rest, seams, surface::Surface};
use seamwright_core::base::{scratch::Scratch, workers::Workers};
use seamwright_core::mesh::{topology, view::MeshView};
use std::time::Instant;

fn main() {
    for path in std::env::args().skip(1) {
        run(&path);
    }
}

fn load(path: &str) -> (Vec<DVec3>, Vec<[u32; 3]>, Vec<f64>) {
    let text = String::from_utf8_lossy(&std::fs::read(path).unwrap()).into_owned();
    let (mut p, mut f) = (vec![], vec![]);
    for l in text.lines() {
        let w: Vec<_> = l.split_whitespace().collect();
        if l.starts_with("v ") {
            p.push(DVec3::new(w[1].parse().unwrap(), w[2].parse().unwrap(), w[3].parse().unwrap()));
        } else if l.starts_with("f ") {
            let c: Vec<u32> = w[1..].iter().map(|t| t.split('/').next().unwrap().parse::<u32>().unwrap() - 1).collect();
            for i in 1..c.len() - 1 {
                f.push([c[0], c[i], c[i + 1]]);
            }
        }
    }
    let name = std::path::Path::new(path).file_stem().unwrap().to_str().unwrap();
    let ao = std::fs::read_to_string(format!("/tmp/ao/{name}.txt")).unwrap();
    let ao: Vec<f64> = ao.lines().map(|l| l.parse().unwrap()).collect();
    // weld
    let mut map = std::collections::BTreeMap::new();
    let mut q = vec![];
    let mut a = vec![];
    let ids: Vec<u32> = p
        .iter()
        .zip(&ao)
        .map(|(x, o)| {
            *map.entry([x.x.to_bits(), x.y.to_bits(), x.z.to_bits()]).or_insert_with(|| {
                q.push(*x);
                a.push(*o);
                q.len() as u32 - 1
            })
        })
        .collect();
    let mut f: Vec<[u32; 3]> = f.into_iter().map(|t| t.map(|i| ids[i as usize])).collect();
    f.retain(|t| t[0] != t[1] && t[1] != t[2] && t[0] != t[2]);
    let lo = q.iter().fold(DVec3::INFINITY, |l, x| l.min(*x));
    let hi = q.iter().fold(DVec3::NEG_INFINITY, |l, x| l.max(*x));
    let s = 1.0 / (hi - lo).max_element();
    q.iter_mut().for_each(|x| *x = (*x - (lo + hi) * 0.5) * s);
    (q, f, a)
}

fn run(path: &str) {
    let (p, f, ao) = load(path);
    let mesh = MeshView { positions: &p, faces: &f };
    let mut bytes = vec![0u8; 3000 * f.len() + 100_000_000];
    let mut scratch = Scratch::new(&mut bytes);
    let mut twin = vec![0; 3 * f.len()];
    let bad = topology::twins(&mut twin, mesh, scratch.frame()).unwrap();
    let area: f64 = (0..f.len()).map(|i| mesh.area_vector(i).length() * 0.5).sum();
    let rest: Vec<Rest> = f.iter().map(|t| Rest::new(t.map(|v| p[v as usize]), 1e-9)).collect();
    let eps: f64 = std::env::var("EPS").ok().and_then(|s| s.parse().ok()).unwrap_or(0.05);
    let pw: f64 = std::env::var("POW").ok().and_then(|s| s.parse().ok()).unwrap_or(4.0);
    let cost: Vec<f64> = (0..3 * f.len() as u32)
        .map(|c| {
            let (a, b) = (mesh.vertex(c), mesh.vertex(seamwright_core::mesh::view::next(c)));
            let e = 0.5 * (ao[a as usize] + ao[b as usize]);
            (p[a as usize] - p[b as usize]).length() * (eps + e.powf(pw))
        })
        .collect();
    let surface = Surface::new(mesh, &twin, &rest, &cost, &mut scratch).unwrap();
    let t0 = Instant::now();
    let mut cut = vec![0u8; 3 * f.len()];
    let mut uv = vec![DVec2::ZERO; 3 * f.len()];
    let bound: f64 = std::env::var("BOUND").ok().and_then(|s| s.parse().ok()).unwrap_or(1.025);
    seams::make_charts(
        &mut uv,
        &mut cut,
        &surface,
        seams::Budget { distortion: bound, one: false },
        scratch.frame(),
        &Two,
        &mut || true,
    )
    .unwrap();
    println!("{path} {:.4} {:?}", seams::distortion(&uv, &rest), t0.elapsed());
    {
        let name = std::path::Path::new(path).file_stem().unwrap().to_str().unwrap();
        let mut o = String::new();
        for v in &p {
            o += &format!("v {} {} {}\n", v.x, v.y, v.z);
        }
        let (mut chart, mut queue) = (vec![0; f.len()], vec![0; f.len()]);
        let count = surface.charts(&cut, &mut chart, &mut queue);
        let mut lo = vec![DVec2::INFINITY; count];
        let mut hi = vec![DVec2::NEG_INFINITY; count];
        for c in 0..uv.len() {
            let k = chart[c / 3] as usize;
            lo[k] = lo[k].min(uv[c]);
            hi[k] = hi[k].max(uv[c]);
        }
        let mut shift = vec![DVec2::ZERO; count];
        let (mut x, mut y, mut h) = (0.0, 0.0, 0.0f64);
        for k in 0..count {
            let s = hi[k] - lo[k];
            if x > 1.5 {
                x = 0.0;
                y += h + 0.02;
                h = 0.0;
            }
            shift[k] = DVec2::new(x, y) - lo[k];
            x += s.x + 0.02;
            h = h.max(s.y);
        }
        for (c, u) in uv.iter().enumerate() {
            let u = *u + shift[chart[c / 3] as usize];
            o += &format!("vt {} {}\n", u.x, u.y);
        }
        for (i, t) in f.iter().enumerate() {
            o += &format!("f {}/{} {}/{} {}/{}\n", t[0] + 1, 3 * i + 1, t[1] + 1, 3 * i + 2, t[2] + 1, 3 * i + 3);
        }
        std::fs::create_dir_all("/tmp/out").unwrap();
        std::fs::write(format!("/tmp/out/{name}.obj"), o).unwrap();
    }
}

struct Two;
impl Workers for Two {
    fn run(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        if count < 2 {
            return (0..count).for_each(task);
        }
        let at = std::sync::atomic::AtomicUsize::new(0);
        std::thread::scope(|s| {
            for _ in 0..2 {
                s.spawn(|| {
                    loop {
                        let i = at.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                        if i >= count {
                            break;
                        }
                        task(i);
                    }
                });
            }
        });
    }
}
