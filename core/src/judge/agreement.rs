//! How far two labelings of the same faces agree: two partitions, or the charts of an atlas and a partition.
//!
//! Hamming distance after optimal matching; the directional Hamming distance of Huang, Dom 1995 and the Rand index (Rand
//! 1971) as Chen, Golovinskiy, Funkhouser 2009 use them for meshes; the adjusted Rand index (Hubert, Arabie 1985). Labels
//! are names: only which faces share one matters. Figures that end in `_aw` weigh a face by its area, the others count
//! faces, as that benchmark's Rand index does; its Hamming distance is by area.
//! Guarantee: exchanging the labelings changes no symmetric figure by more than rounding. Cost: O(f log f) and the matching.

use super::assignment::{Shared, assign, assign_need};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::sort;
use crate::mesh::view::NONE;

/// What two labelings have in common. Distances are shares in [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Agreement {
    /// Faces with a label in both; nothing else counts below.
    pub faces: usize,
    /// Faces without a label in one of them.
    pub left_out: usize,
    /// Different labels of the first, and of the second, the reference.
    pub labels: [usize; 2],
    /// Share of faces that differ after the matching of labels, one to one, under which the fewest do.
    pub hamming: f64,
    /// The same by area, matched by area.
    pub hamming_aw: f64,
    /// Share of the area in parts of the reference outside of the label that covers most of each.
    pub missing_aw: f64,
    /// Share of the area in labels of the first outside of the reference's part that covers most of each.
    pub false_alarm_aw: f64,
    /// Share of the pairs of faces that are together in both or apart in both. 1 where there is no pair.
    pub rand: f64,
    /// The same with pairs weighted by the product of their areas.
    pub rand_aw: f64,
    /// The Rand index less what chance gives, over the most that it could be more; 1 is equality, 0 chance.
    pub adjusted_rand: f64,
}

impl Agreement {
    /// Mean of the missing rate and the false alarm rate: the benchmark's Hamming distance.
    pub fn directional_hamming_aw(&self) -> f64 {
        0.5 * (self.missing_aw + self.false_alarm_aw)
    }
}

/// Scratch bytes that [`agreement`] needs.
pub const fn agreement_need(faces: usize) -> usize {
    let table = bytes_for::<u32>(faces).saturating_mul(6).saturating_add(bytes_for::<f64>(faces).saturating_mul(2));
    let sums = bytes_for::<f64>(faces).saturating_mul(4).saturating_add(bytes_for::<u32>(faces));
    table.saturating_add(sums).saturating_add(assign_need(faces, faces)).saturating_add(64)
}

/// Compares labeling `ours` with `reference`; both have one entry a face, [`NONE`] where a face has no label. `area` is
/// each face's weight, finite and not negative.
///
/// Panics unless the three have one length.
pub fn agreement(
    ours: &[u32],
    reference: &[u32],
    area: &[f64],
    mut scratch: Scratch,
) -> Result<Agreement, ScratchTooSmall> {
    assert!(ours.len() == reference.len() && ours.len() == area.len(), "one label of each and one area a face");
    scratch.require(agreement_need(ours.len()))?;
    let table = Contingency::new(ours, reference, area, &mut scratch)?;
    let faces = table.faces;
    let mut out =
        Agreement { faces, left_out: ours.len() - faces, labels: [table.rows(), table.columns], ..Default::default() };
    let of_rows = scratch.take::<f64>(table.rows())?;
    let of_columns = scratch.take::<f64>(table.columns)?;
    let partner = scratch.take::<u32>(table.rows())?;

    let counted = Sums::of(&table, table.count, of_rows, of_columns);
    out.hamming = share(counted.total - assign(partner, &table.shared(table.count), scratch.frame())?, counted.total);
    let pairs = counted.total * (counted.total - 1.0); // ordered ones; exact below 2^53
    let apart = counted.rows + counted.columns - 2.0 * counted.both;
    out.rand = if pairs > 0.0 { 1.0 - apart / pairs } else { 1.0 };
    out.adjusted_rand = counted.adjusted(pairs);

    let weighed = Sums::of(&table, table.area, of_rows, of_columns);
    out.hamming_aw = share(weighed.total - assign(partner, &table.shared(table.area), scratch.frame())?, weighed.total);
    let own = table.squares; // pairs of a face with itself
    let pairs = weighed.total * weighed.total - own;
    let apart = weighed.rows + weighed.columns - 2.0 * weighed.both;
    out.rand_aw = if pairs > 0.0 { 1.0 - (apart / pairs).clamp(0.0, 1.0) } else { 1.0 };
    out.missing_aw = share(weighed.total - weighed.most_of_columns, weighed.total);
    out.false_alarm_aw = share(weighed.total - weighed.most_of_rows, weighed.total);
    Ok(out)
}

/// part / whole in [0, 1]; nothing is no share of nothing.
fn share(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { (part / whole).clamp(0.0, 1.0) } else { 0.0 }
}

/// How many faces, and how much area, each pair of labels shares; rows are ours, columns the reference's.
struct Contingency<'t> {
    row_start: &'t [u32], // (rows + 1)
    column: &'t [u32],    // (entries)
    count: &'t [f64],     // (entries)
    area: &'t [f64],      // (entries)
    columns: usize,
    faces: usize,
    squares: f64, // sum of the faces' squared areas
}

impl<'t> Contingency<'t> {
    fn new(ours: &[u32], reference: &[u32], area: &[f64], keep: &mut Scratch<'t>) -> Result<Self, ScratchTooSmall> {
        let n = ours.len();
        let column = keep.take::<u32>(n)?;
        let row_start = keep.take::<u32>(n + 1)?;
        let (counts, areas) = (keep.take::<f64>(n)?, keep.take::<f64>(n)?);
        let mut frame = keep.frame();
        let (order, place) = (frame.take::<u32>(n)?, frame.take::<u32>(n)?);
        let mut faces = 0;
        for f in 0..n {
            if ours[f] != NONE && reference[f] != NONE {
                order[faces] = f as u32;
                faces += 1;
            }
        }
        let order = &mut order[..faces];
        let squares = order.iter().fold(0.0, |sum, f| sum + area[*f as usize] * area[*f as usize]);
        // Columns by rank of the reference's labels.
        sort::by_key(order, |f| (reference[*f as usize], *f));
        let mut columns = 0;
        for group in order.runs(|a, b| reference[*a as usize] == reference[*b as usize]) {
            group.iter().for_each(|f| place[*f as usize] = columns);
            columns += 1;
        }
        sort::by_key(order, |f| (ours[*f as usize], place[*f as usize], *f));
        let (mut entries, mut rows) = (0, 0);
        for row in order.runs(|a, b| ours[*a as usize] == ours[*b as usize]) {
            for cell in row.runs(|a, b| place[*a as usize] == place[*b as usize]) {
                column[entries] = place[cell[0] as usize];
                counts[entries] = cell.len() as f64;
                areas[entries] = cell.iter().fold(0.0, |sum, f| sum + area[*f as usize]);
                entries += 1;
            }
            rows += 1;
            row_start[rows] = entries as u32;
        }
        Ok(Self {
            row_start: &row_start[..rows + 1],
            column: &column[..entries],
            count: &counts[..entries],
            area: &areas[..entries],
            columns: columns as usize,
            faces,
            squares,
        })
    }

    fn rows(&self) -> usize {
        self.row_start.len() - 1
    }

    fn shared(&self, value: &'t [f64]) -> Shared<'t> {
        Shared { row_start: self.row_start, column: self.column, value, columns: self.columns }
    }
}

/// Sums over a table.
struct Sums {
    total: f64,
    /// Of squares: of entries, of rows' sums, of columns' sums.
    both: f64,
    rows: f64,
    columns: f64,
    /// Of the largest entry of each row and of each column.
    most_of_rows: f64,
    most_of_columns: f64,
}

impl Sums {
    /// `of_rows` and `of_columns` are workspace.
    fn of(table: &Contingency, value: &[f64], of_rows: &mut [f64], of_columns: &mut [f64]) -> Self {
        let rows = || (0..table.rows()).map(|r| (r, table.row_start[r] as usize..table.row_start[r + 1] as usize));
        let square_sum = |sums: &[f64]| sums.iter().fold(0.0, |sum, x| sum + x * x);
        let add = |sum: f64, x: &f64| sum + x;
        of_columns.fill(0.0);
        for (r, entries) in rows() {
            of_rows[r] = value[entries.clone()].iter().fold(0.0, add);
            entries.for_each(|e| of_columns[table.column[e] as usize] += value[e]);
        }
        let (rows_squared, columns_squared) = (square_sum(of_rows), square_sum(of_columns));
        let total = of_rows.iter().fold(0.0, add);
        of_columns.fill(0.0);
        for (r, entries) in rows() {
            of_rows[r] = value[entries.clone()].iter().fold(0.0, |most, x| f64::max(most, *x));
            entries.for_each(|e| {
                of_columns[table.column[e] as usize] = of_columns[table.column[e] as usize].max(value[e])
            });
        }
        Self {
            total,
            both: square_sum(value),
            rows: rows_squared,
            columns: columns_squared,
            most_of_rows: of_rows.iter().fold(0.0, add),
            most_of_columns: of_columns.iter().fold(0.0, add),
        }
    }

    /// The adjusted Rand index over counts; `pairs` are the ordered pairs of faces.
    fn adjusted(&self, pairs: f64) -> f64 {
        let together = |squares: f64| squares - self.total; // ordered pairs in one cell
        let (both, rows, columns) = (together(self.both), together(self.rows), together(self.columns));
        let expected = if pairs > 0.0 { rows / pairs * columns } else { 0.0 };
        let most = 0.5 * (rows + columns);
        if most > expected { (both - expected) / (most - expected) } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random;
    use approx::assert_abs_diff_eq;
    use std::{vec, vec::Vec};

    fn judge(ours: &[u32], reference: &[u32], area: &[f64]) -> Agreement {
        let mut bytes = vec![0; agreement_need(ours.len())];
        agreement(ours, reference, area, Scratch::new(&mut bytes)).unwrap()
    }

    #[test]
    fn the_same_partition_under_other_names_agrees_in_full() {
        let a = judge(&[4, 4, 9, 9, 0], &[1, 1, 0, 0, 7], &[1.0, 2.0, 3.0, 4.0, 5.0]);
        let expected =
            Agreement { faces: 5, labels: [3, 3], rand: 1.0, rand_aw: 1.0, adjusted_rand: 1.0, ..Default::default() };
        assert_eq!(a, expected);
    }

    #[test]
    fn six_faces_give_the_figures_counted_by_hand() {
        // Table (rows ours): [2 1 0], [0 1 2]. Matched 2 + 2 of 6. Of 15 pairs: ours has 3 + 3 together, the reference
        // 1 + 1 + 1, both 1 + 1; 6 + 3 - 2 * 2 = 5 disagree. Expected 6 * 3 / 15 = 1.2, most 4.5: (2 - 1.2) / (4.5 - 1.2).
        let a = judge(&[0, 0, 0, 1, 1, 1], &[0, 0, 1, 1, 2, 2], &[1.0; 6]);
        let near = |x: f64, y: f64| (x - y).abs() < 1e-15; // one rounding of a quotient of small whole numbers
        assert!(near(a.hamming, 2.0 / 6.0) && near(a.rand, 10.0 / 15.0) && near(a.adjusted_rand, 0.8 / 3.3), "{a:?}");
        // Equal areas: as by count. Parts lie in the label that covers most: 2 + 1 + 2; labels in parts: 2 + 2.
        assert!(near(a.hamming_aw, 2.0 / 6.0) && near(a.rand_aw, 10.0 / 15.0), "{a:?}");
        assert!(near(a.missing_aw, 1.0 / 6.0) && near(a.false_alarm_aw, 2.0 / 6.0), "{a:?}");
        assert!(near(a.directional_hamming_aw(), 1.5 / 6.0));
    }

    #[test]
    fn area_decides_where_it_is_asked_for() {
        let a = judge(&[0, 0, 1], &[0, 1, 1], &[1.0, 10.0, 1.0]);
        assert_abs_diff_eq!(a.hamming, 1.0 / 3.0, epsilon = 1e-15);
        assert_abs_diff_eq!(a.hamming_aw, 2.0 / 12.0, epsilon = 1e-15);
        // Pairs: 10, 1, 10; the first and the last disagree.
        assert_abs_diff_eq!(a.rand, 1.0 / 3.0, epsilon = 1e-15);
        assert_abs_diff_eq!(a.rand_aw, 1.0 / 21.0, epsilon = 1e-14);
    }

    #[test]
    fn faces_without_a_label_count_nowhere_and_nothing_is_no_disagreement() {
        let a = judge(&[0, NONE, 1, 1], &[0, 1, NONE, 1], &[1.0; 4]);
        assert_eq!((a.faces, a.left_out, a.labels, a.hamming, a.rand), (2, 2, [2, 2], 0.0, 1.0));
        let none = judge(&[NONE], &[3], &[1.0]);
        assert_eq!((none.faces, none.hamming, none.rand, none.rand_aw, none.adjusted_rand), (0, 0.0, 1.0, 1.0, 1.0));
        assert_eq!(judge(&[], &[], &[]).left_out, 0);
        assert_eq!(judge(&[5], &[3], &[0.0]).hamming_aw, 0.0);
    }

    /// Best matching of labels by trying every assignment of `ours` to `reference` labels.
    fn naive_hamming(ours: &[u32], reference: &[u32], weight: &[f64], k: u32, row: u32, used: u32) -> f64 {
        if row == k {
            return 0.0;
        }
        let shared =
            |c: u32| (0..ours.len()).filter(|f| ours[*f] == row && reference[*f] == c).map(|f| weight[f]).sum::<f64>();
        let alone = naive_hamming(ours, reference, weight, k, row + 1, used);
        (0..k).filter(|c| used >> c & 1 == 0).fold(alone, |best, c| {
            best.max(shared(c) + naive_hamming(ours, reference, weight, k, row + 1, used | 1 << c))
        })
    }

    #[test]
    fn random_labelings_give_the_figures_of_counting_pairs_and_trying_matchings() {
        for seed in 0..60u64 {
            let n = 2 + (random::hash(seed, 0, 0) % 40) as usize;
            let k = 1 + (random::hash(seed, 0, 1) % 4) as u32;
            let draw = |stream, f: usize| (random::hash(seed, stream, f as u64) % u64::from(k)) as u32;
            let ours: Vec<u32> = (0..n).map(|f| draw(1, f)).collect();
            let reference: Vec<u32> = (0..n).map(|f| draw(2, f)).collect();
            let area: Vec<f64> = (0..n).map(|f| 0.1 + random::unit_f64(seed, 3, f as u64)).collect();
            let a = judge(&ours, &reference, &area);
            let (mut same, mut all, mut same_aw, mut all_aw) = (0.0, 0.0, 0.0, 0.0);
            for i in 0..n {
                for j in 0..i {
                    let agree = f64::from(u8::from((ours[i] == ours[j]) == (reference[i] == reference[j])));
                    (same, all) = (same + agree, all + 1.0);
                    let w = area[i] * area[j];
                    (same_aw, all_aw) = (same_aw + agree * w, all_aw + w);
                }
            }
            // Sums of at most 800 terms of one sign, each rounded once: 800 x 2^-53 and the cancellation of two squares.
            let near = |x: f64, y: f64| (x - y).abs() < 1e-11;
            assert!(near(a.rand, same / all) && near(a.rand_aw, same_aw / all_aw), "{seed}: {a:?}");
            let ones = vec![1.0; n];
            assert!(
                near(a.hamming, 1.0 - naive_hamming(&ours, &reference, &ones, k, 0, 0) / n as f64),
                "{seed}: {a:?}"
            );
            let total: f64 = area.iter().sum();
            assert!(
                near(a.hamming_aw, 1.0 - naive_hamming(&ours, &reference, &area, k, 0, 0) / total),
                "{seed}: {a:?}"
            );
            let b = judge(&reference, &ours, &area);
            assert!(
                near(a.hamming_aw, b.hamming_aw)
                    && near(a.rand_aw, b.rand_aw)
                    && near(a.adjusted_rand, b.adjusted_rand)
            );
            assert!(near(a.missing_aw, b.false_alarm_aw) && near(a.false_alarm_aw, b.missing_aw), "{seed}");
        }
    }

    #[test]
    fn hundreds_of_charts_against_a_partition_need_no_more_than_was_said() {
        // Every face a label of its own on both sides: the largest table there can be.
        let labels: Vec<u32> = (0..600).collect();
        let turned: Vec<u32> = (0..600).map(|f| (f * 7) % 600).collect();
        let a = judge(&labels, &turned, &vec![1.0; 600]);
        assert_eq!((a.hamming, a.rand, a.labels), (0.0, 1.0, [600, 600]));
    }

    #[test]
    fn too_little_memory_is_an_error() {
        let need = agreement_need(2);
        let mut bytes = vec![0; need - 1];
        let result = agreement(&[0, 1], &[0, 0], &[1.0, 1.0], Scratch::new(&mut bytes));
        assert_eq!(result, Err(ScratchTooSmall { need, given: need - 1 }));
    }
}
