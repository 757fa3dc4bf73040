//! Packing: behaviour on exact small cases, degenerate input, and random charts against a naive check.

use glam::DVec2;
use seamwright_core::base::random::unit_f64;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::{Serial, Workers};
use seamwright_core::pack::flat_charts::FlatCharts;
use seamwright_core::pack::layout::{pack, pack_need};
use seamwright_core::pack::placement::Placement;
use seamwright_core::pack::settings::{Mode, PackSettings, PackSummary};

/// Charts as fans or strips of triangles; every triangle has vertices of its own chart only.
#[derive(Default)]
struct Set {
    uv: Vec<DVec2>,
    faces: Vec<[u32; 3]>,
    chart: Vec<u32>,
    count: usize,
    upright: Vec<u8>,
}

impl Set {
    /// Adds a chart of quads given by their least corner and size.
    fn boxes(mut self, boxes: &[[f64; 4]]) -> Self {
        for &[x, y, w, h] in boxes {
            let first = self.uv.len() as u32;
            self.uv.extend([(0.0, 0.0), (w, 0.0), (w, h), (0.0, h)].map(|(a, b)| DVec2::new(x + a, y + b)));
            self.faces.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
            self.chart.extend([self.count as u32; 2]);
        }
        self.count += 1;
        self
    }

    /// Adds a star-shaped chart with `corners` random radii.
    fn star(mut self, seed: u64, corners: u32) -> Self {
        let (first, chart) = (self.uv.len() as u32, self.count as u64);
        self.uv.push(DVec2::new(7.0, -3.0));
        for i in 0..corners {
            let radius = (0.2 + unit_f64(seed, chart, i as u64)) * (0.3 + unit_f64(seed, chart, 1000));
            let angle = i as f64 / corners as f64 * std::f64::consts::TAU;
            self.uv.push(self.uv[first as usize] + radius * DVec2::from_angle(angle));
            self.faces.push([first, first + 1 + i, first + 1 + (i + 1) % corners]);
            self.chart.push(chart as u32);
        }
        self.count += 1;
        self
    }

    fn view(&self) -> FlatCharts<'_> {
        FlatCharts { uv: &self.uv, faces: &self.faces, chart: &self.chart, count: self.count, upright: &self.upright }
    }

    fn pack_with(&self, settings: &PackSettings, workers: &dyn Workers) -> (Vec<Placement>, PackSummary) {
        let mut bytes = vec![0; pack_need(self.faces.len(), self.count, settings)];
        let mut placements = vec![Placement::IDENTITY; self.count];
        let summary = pack(&mut placements, &self.view(), settings, &mut Scratch::new(&mut bytes), workers).unwrap();
        (placements, summary)
    }

    fn pack(&self, settings: &PackSettings) -> (Vec<Placement>, PackSummary) {
        self.pack_with(settings, &Serial)
    }

    fn placed(&self, placements: &[Placement]) -> Vec<[DVec2; 3]> {
        let place =
            |(face, chart): (&[u32; 3], &u32)| face.map(|v| placements[*chart as usize].apply(self.uv[v as usize]));
        self.faces.iter().zip(&self.chart).map(place).collect()
    }

    /// The least distance of triangles of different charts, by every pair; 0 where they overlap.
    fn least_distance(&self, placements: &[Placement]) -> f64 {
        let placed = self.placed(placements);
        let mut least = f64::INFINITY;
        for (i, a) in placed.iter().enumerate() {
            for (j, b) in placed.iter().enumerate().skip(i + 1) {
                if self.chart[i] != self.chart[j] {
                    least = least.min(triangles_apart(a, b));
                }
            }
        }
        least
    }

    /// What every tight packing must keep.
    fn assert_valid(&self, placements: &[Placement], summary: &PackSummary, settings: &PackSettings) {
        let inside = |p: &DVec2| p.min_element() >= 0.0 && p.max_element() <= 1.0;
        assert!(self.placed(placements).iter().flatten().all(inside), "inside the unit square");
        for p in placements {
            assert_eq!(p.scale, placements[0].scale, "one scale");
            assert!((p.turn.length() - 1.0).abs() < 1e-12, "a rotation");
        }
        assert_eq!(summary.padding, settings.padding as f64);
        let border = settings.padding as f64 / settings.size as f64;
        let clear = |p: &DVec2| p.min_element() >= border && p.max_element() <= 1.0 - border;
        assert!(self.placed(placements).iter().flatten().all(clear), "off the border of the square");
        let texels = self.least_distance(placements) * settings.size as f64;
        assert!(texels >= settings.padding as f64, "{texels} texels between two charts");
    }
}

fn triangles_apart(a: &[DVec2; 3], b: &[DVec2; 3]) -> f64 {
    let side = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p);
    let holds =
        |t: &[DVec2; 3], p: DVec2| side(t[0], t[1], t[2]) > 0.0 && (0..3).all(|i| side(t[i], t[(i + 1) % 3], p) >= 0.0);
    if a.iter().any(|p| holds(b, *p)) || b.iter().any(|p| holds(a, *p)) {
        return 0.0;
    }
    let to_segment = |p: DVec2, a: DVec2, b: DVec2| {
        let share = if a == b { 0.0 } else { ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0) };
        p.distance(a.lerp(b, share))
    };
    let mut least = f64::INFINITY;
    for i in 0..3 {
        for j in 0..3 {
            let (p, q, r, s) = (a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]);
            if side(p, q, r) * side(p, q, s) < 0.0 && side(r, s, p) * side(r, s, q) < 0.0 {
                return 0.0;
            }
            least = least.min(to_segment(p, r, s)).min(to_segment(r, p, q));
        }
    }
    least
}

struct Backwards;
impl Workers for Backwards {
    fn run(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        std::thread::scope(|scope| (0..count).rev().for_each(|i| drop(scope.spawn(move || task(i)))));
    }
}

#[test]
fn sixteen_equal_squares_fill_nearly_everything() {
    let set = (0..16).fold(Set::default(), |set, i| set.boxes(&[[i as f64, 2.0, 1.0, 1.0]]));
    let settings = PackSettings { padding: 2, ..PackSettings::default() };
    let (placements, summary) = set.pack(&settings);
    set.assert_valid(&placements, &summary, &settings);
    // Four in a row with three gaps and two borders of 2 texels: (1014 / 1024)^2 = .981; the rest is what the search leaves.
    assert!(summary.utilisation > 0.95, "{summary:?}");
}

#[test]
fn an_l_and_a_square_make_a_square() {
    let set = Set::default().boxes(&[[0.0, 0.0, 2.0, 1.0], [0.0, 1.0, 1.0, 1.0]]).boxes(&[[5.0, 5.0, 0.99, 0.99]]);
    let (placements, summary) = set.pack(&PackSettings::default());
    set.assert_valid(&placements, &summary, &PackSettings::default());
    assert!(summary.utilisation > 0.96, "{summary:?}");
}

#[test]
fn a_hole_takes_the_chart_that_fits_it() {
    let frame = [[0.0, 0.0, 3.0, 0.9], [0.0, 0.9, 0.9, 1.2], [2.1, 0.9, 0.9, 1.2], [0.0, 2.1, 3.0, 0.9]];
    let set = Set::default().boxes(&frame).boxes(&[[9.0, 0.0, 1.0, 1.0]]);
    let (placements, summary) = set.pack(&PackSettings::default());
    set.assert_valid(&placements, &summary, &PackSettings::default());
    // 7.56 + 1 of 9 when the square is inside.
    assert!(summary.utilisation > 0.9, "{summary:?}");
}

#[test]
fn random_charts_keep_their_distance() {
    for (seed, charts, padding, size) in [(1, 2, 0, 512), (2, 5, 2, 1024), (3, 12, 8, 512), (4, 40, 3, 1024)] {
        let set = (0..charts).fold(Set::default(), |set, _| set.star(seed, 9));
        let settings = PackSettings { padding, size, seed, effort: 0.2, ..PackSettings::default() };
        let (placements, summary) = set.pack(&settings);
        set.assert_valid(&placements, &summary, &settings);
    }
}

#[test]
fn many_charts_keep_their_distance_without_separation() {
    let set = (0..200).fold(Set::default(), |set, _| set.star(5, 5));
    let (placements, summary) = set.pack(&PackSettings::default());
    set.assert_valid(&placements, &summary, &PackSettings::default());
}

#[test]
fn the_order_of_tasks_changes_no_bit() {
    let set = (0..6).fold(Set::default(), |set, _| set.star(6, 11));
    let settings = PackSettings { effort: 0.1, ..PackSettings::default() };
    assert_eq!(set.pack_with(&settings, &Serial), set.pack_with(&settings, &Backwards));
}

#[test]
fn scaling_by_a_power_of_two_changes_no_turn() {
    let set = (0..4).fold(Set::default(), |set, _| set.star(7, 8));
    let mut large = (0..4).fold(Set::default(), |set, _| set.star(7, 8));
    large.uv.iter_mut().for_each(|p| *p *= 1024.0);
    let settings = PackSettings { effort: 0.1, ..PackSettings::default() };
    let (small, large) = (set.pack(&settings).0, large.pack(&settings).0);
    assert!(small.iter().zip(&large).all(|(a, b)| a.turn == b.turn && a.scale == b.scale * 1024.0));
}

#[test]
fn one_chart_turns_into_its_smallest_square() {
    // A diamond: upright it fills half of its box, turned by 45 degrees all of it.
    let mut set = Set::default().boxes(&[[0.0, 0.0, 1.0, 1.0]]);
    let turn = DVec2::from_angle(0.7);
    set.uv.iter_mut().for_each(|p| *p = turn.rotate(*p));
    let (placements, summary) = set.pack(&PackSettings::default());
    set.assert_valid(&placements, &summary, &PackSettings { padding: 2, ..PackSettings::default() });
    // All of the square but the border: 2 texels, and a tenth for what rounding may take of them.
    assert!(summary.utilisation > (1019.8_f64 / 1024.0).powi(2), "{summary:?}");
}

#[test]
fn needles_points_and_empty_charts_are_placed() {
    let mut set =
        Set::default().boxes(&[[0.0, 0.0, 1.0, 1.0]]).boxes(&[[0.0, 0.0, 3.0, 0.0]]).boxes(&[[4.0, 4.0, 0.0, 0.0]]);
    set.count = 5; // charts 3 and 4 have no faces
    let (placements, summary) = set.pack(&PackSettings::default());
    assert!(placements.iter().all(|p| p.scale.is_finite() && p.translation.is_finite()));
    assert_eq!(placements[4], Placement::IDENTITY);
    assert!(summary.utilisation.is_finite() && set.least_distance(&placements[..3]) * 1024.0 >= 2.0);
}

#[test]
fn nothing_and_coordinates_that_are_no_numbers_do_no_harm() {
    assert_eq!(Set::default().pack(&PackSettings::default()).0, []);
    let mut set = Set::default().star(8, 5).star(8, 6);
    set.uv[1] = DVec2::new(f64::NAN, f64::INFINITY);
    assert!(set.pack(&PackSettings::default()).0.iter().all(|p| p.translation.is_finite()));
}

#[test]
fn extreme_scales_are_packed_or_left_but_never_panic() {
    for scale in [1e-300, 1e-150, 1e-12, 1e12, 1e150, 1e300] {
        let mut set = (0..4).fold(Set::default(), |set, _| set.star(12, 6));
        set.uv.iter_mut().for_each(|p| *p *= scale);
        let settings = PackSettings { effort: 0.02, ..PackSettings::default() };
        let (placements, _) = set.pack(&settings);
        if (1e-12..=1e12).contains(&scale) {
            assert!(set.least_distance(&placements) * 1024.0 >= 2.0);
        }
    }
}

#[test]
fn a_chart_as_wide_as_the_square_is_packed() {
    let set =
        Set::default().boxes(&[[0.0, 0.0, 9.0, 0.5]]).boxes(&[[0.0, 0.0, 9.0, 0.1]]).boxes(&[[0.0, 0.0, 0.1, 0.1]]);
    let settings = PackSettings { effort: 0.05, ..PackSettings::default() };
    let (placements, summary) = set.pack(&settings);
    set.assert_valid(&placements, &summary, &settings);
    assert!(summary.utilisation > 5.4 / 81.0 * 0.98, "{summary:?}");
}

#[test]
fn a_long_chart_among_many_stays_in_the_square_and_off_the_others() {
    // More charts than are separated together from the start, and one that fits into their square only aslant.
    for seed in 0..6 {
        let long = Set::default().boxes(&[[0.0, 0.0, 7.5 + 0.25 * seed as f64, 2.5]]);
        let lead = (0..4).fold(long, |set, _| set.boxes(&[[0.0, 0.0, 2.5, 2.5]]));
        let set = (0..16).fold(lead, |set, _| set.boxes(&[[0.0, 0.0, 0.5, 0.5]]));
        let settings = PackSettings { effort: 0.1, seed, ..PackSettings::default() };
        let (placements, summary) = set.pack(&settings);
        set.assert_valid(&placements, &summary, &settings);
    }
}

#[test]
fn padding_that_cannot_be_kept_is_reported() {
    let set = (0..64).fold(Set::default(), |set, _| set.star(9, 4));
    let (placements, summary) = set.pack(&PackSettings { size: 16, padding: 8, ..PackSettings::default() });
    assert!(summary.padding < 8.0 && summary.padding >= 0.0);
    assert!(set.least_distance(&placements) * 16.0 >= summary.padding);
}

#[test]
fn one_byte_too_little_is_refused_and_nothing_written() {
    for mode in [Mode::Tight, Mode::Grid] {
        let set = (0..3).fold(Set::default(), |set, _| set.star(10, 7));
        let settings = PackSettings { mode, effort: 0.05, ..PackSettings::default() };
        let need = pack_need(set.faces.len(), set.count, &settings);
        let mut bytes = vec![0; need];
        let mut placements = vec![Placement::IDENTITY; 3];
        let mut run =
            |bytes: &mut [u8]| pack(&mut placements, &set.view(), &settings, &mut Scratch::new(bytes), &Serial);
        let refused = run(&mut bytes[1..]).unwrap_err();
        assert_eq!((refused.need, refused.given), (need, need - 1));
        assert!(run(&mut bytes).is_ok());
    }
}

#[test]
fn the_grid_follows_its_formula() {
    let set = (0..5).fold(Set::default(), |set, i| set.boxes(&[[i as f64, -1.0, 2.0, 1.0 + i as f64]]));
    let settings = PackSettings { mode: Mode::Grid, size: 100, padding: 2, ..PackSettings::default() };
    let (placements, _) = set.pack(&settings);
    // G = ceil(sqrt 5) = 3, pad = 2 texels of a cell of 100/3; chart 4 stands in column 1 of row 1.
    let (cells, pad) = (3.0, 0.06);
    let chart = set.placed(&placements)[8];
    let corner = DVec2::splat((1.0 + pad) / cells);
    assert!(chart[0].distance(corner) < 1e-12, "{chart:?}");
    // Its longer side of 5 fills the cell but for the padding.
    assert!((chart[2].y - corner.y - (1.0 - 2.0 * pad) / cells).abs() < 1e-12);
}

#[test]
fn charts_that_stand_upright_are_turned_by_quarters_alone() {
    for count in [1, 2, 20, 200] {
        let mut set = Set::default();
        for i in 0..count as u64 {
            set = match i % 2 {
                0 => set.boxes(&[[0.0, 0.0, 0.3 + unit_f64(1, 0, i), 0.2], [0.1, 0.2, 0.1, unit_f64(1, 1, i)]]),
                _ => set.star(i, 9),
            };
        }
        set.upright = (0..count).map(|i| 1 - i % 2).collect();
        let (placements, summary) = set.pack(&PackSettings::default());
        let quarters = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
        assert!(placements.iter().step_by(2).all(|p| quarters.contains(&p.turn)), "{placements:?}");
        assert_eq!(summary.padding, 2.0);
        if count == 20 {
            assert!(placements.iter().any(|p| !quarters.contains(&p.turn)), "the others turn freely");
        }
    }
}

#[test]
fn a_long_chart_lies_across_and_a_shorter_one_stands() {
    // Over the root of all area a bar of 1 by 0.1 is 2.9 long beside a small square, one of 1 by 0.5 1.4.
    for (width, stands) in [(0.1, false), (0.5, true)] {
        let mut set = Set::default().boxes(&[[0.0, 0.0, 1.0, width]]).boxes(&[[2.0, 0.0, 0.14, 0.14]]);
        set.upright = vec![1, 0];
        let (placements, _) = set.pack(&PackSettings::default());
        let turn = placements[0].turn;
        assert_eq!(turn.x * turn.y == 0.0, stands, "{turn}");
    }
}
