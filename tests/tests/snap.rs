//! `Snap::Texel` on our own fixtures: straight borders lie on the edges of texels, and nothing else is lost.

use glam::DVec2;
use seamwright::formats::loaded::load;
use seamwright::mesh::polygons::Mesh;
use seamwright::run::threads::Pool;
use seamwright_core::pipeline::{Packing, Settings, Snap};
use seamwright_tests::road::{Atlas, judge, run, unsound};
use std::collections::HashMap;
use std::path::Path;

const SIZE: u32 = 256;

/// Length of the borders that run along an axis for two texels or more, and how much of it lies on edges of texels.
fn straight(mesh: &Mesh, atlas: &Atlas) -> (f64, f64) {
    let texels = |c: u32| atlas.corner_uv[c as usize] * f64::from(SIZE);
    let key = |p: DVec2| p.to_array().map(f64::to_bits);
    let mut sides: HashMap<_, (u32, [DVec2; 2])> = HashMap::new();
    for polygon in mesh.polygon_start.windows(2) {
        for c in polygon[0]..polygon[1] {
            let after = if c + 1 == polygon[1] { polygon[0] } else { c + 1 };
            let ends = [texels(c), texels(after)];
            let mut name = ends.map(key);
            name.sort_unstable();
            sides.entry(name).or_insert((0, ends)).0 += 1;
        }
    }
    let (mut all, mut on) = (0.0, 0.0);
    for (_, [a, b]) in sides.values().filter(|(count, _)| *count == 1) {
        for axis in 0..2 {
            let length = (a[1 - axis] - b[1 - axis]).abs();
            if (a[axis] - b[axis]).abs() < 1e-4 && length >= 2.0 {
                all += length;
                let off = [a[axis], b[axis]].map(|x| (x - x.round()).abs());
                on += if off.iter().all(|off| *off < 1e-6) { length } else { 0.0 };
            }
        }
    }
    (all, on)
}

#[test]
fn straight_borders_lie_on_the_edges_of_texels_and_the_atlas_is_as_sound_as_without() {
    let pool = Pool::new(Some(2)).unwrap();
    for name in ["cube.obj", "frame.obj", "gear.obj", "mug.obj", "sheet.obj"] {
        let loaded = load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures").join(name)).unwrap();
        let mesh = loaded.mesh();
        for packing in [Packing::Tight, Packing::Grid] {
            let settings = Settings { size: SIZE, rays: 64, effort: 0.2, packing, ..Settings::default() };
            let (atlas, report) = run(mesh, &settings, &pool, 0).unwrap();
            let (_, on) = straight(mesh, &atlas);
            let snapped = Settings { snap: Snap::Texel, ..settings };
            let (laid, laid_report) = run(mesh, &snapped, &pool, 0).unwrap();
            let (all, laid_on) = straight(mesh, &laid);
            assert!(laid_on >= 0.97 * all, "{name}: {laid_on} of {all} texels");
            // Without, borders lie on edges by chance alone.
            assert!(all == 0.0 || on < 0.5 * laid_on, "{name}: {on} without, {laid_on} with");
            assert_eq!(unsound(&judge(mesh, &laid), &laid, &laid_report), Vec::<String>::new(), "{name}");
            let bound = settings.distortion.max(report.distortion);
            assert!(laid_report.distortion <= bound + 1e-6, "{name}: {}", laid_report.distortion);
        }
    }
}
