//! Which label of one partition answers to which of another: the matching that shares most.
//!
//! The Hungarian method by shortest augmenting paths (Kuhn 1955; Jonker, Volgenant 1987) on a sparse table: a pair that
//! shares nothing is no edge, and a row may stay alone at no gain, so the table need not be square. Guarantee: the sum over
//! the matched pairs is the greatest possible, up to the rounding of sums; of equally good ones the lowest columns win.
//! Cost: for each row a search over the entries that its alternating paths reach; rows x entries at the worst.

use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::mesh::view::NONE;

/// A table of what rows and columns share; absent entries are 0.
#[derive(Clone, Copy)]
pub struct Shared<'a> {
    /// First entry of each row, and the number of entries at the end.
    pub row_start: &'a [u32], // (rows + 1)
    /// Column of each entry, below `columns`.
    pub column: &'a [u32], // (entries)
    /// What row and column share; finite, not negative.
    pub value: &'a [f64], // (entries)
    /// Number of columns.
    pub columns: usize,
}

impl Shared<'_> {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.row_start.len() - 1
    }

    fn row(&self, r: usize) -> core::ops::Range<usize> {
        self.row_start[r] as usize..self.row_start[r + 1] as usize
    }
}

/// Scratch bytes that [`assign`] needs.
pub const fn assign_need(rows: usize, columns: usize) -> usize {
    let all = rows.saturating_add(columns); // each row has a column of its own that stands for staying alone
    let of_rows = bytes_for::<f64>(rows).saturating_add(bytes_for::<u32>(rows));
    let of_columns = bytes_for::<f64>(all).saturating_mul(2).saturating_add(bytes_for::<u32>(all).saturating_mul(3));
    of_rows.saturating_add(of_columns).saturating_add(bytes_for::<u8>(all))
}

/// Writes the column matched to each row, or [`NONE`], and returns what the matched pairs share.
///
/// `partner` has one entry a row.
pub fn assign(partner: &mut [u32], table: &Shared, mut scratch: Scratch) -> Result<f64, ScratchTooSmall> {
    let (rows, all) = (table.rows(), table.rows() + table.columns);
    scratch.require(assign_need(rows, table.columns))?;
    let mut search = Matching {
        table,
        row_dual: scratch.take(rows)?,
        column_of: scratch.take_filled(rows, NONE)?,
        column_dual: scratch.take(all)?,
        distance: scratch.take(all)?,
        from: scratch.take(all)?,
        row_of: scratch.take_filled(all, NONE)?,
        reached: scratch.take(all)?,
        state: scratch.take(all)?,
    };
    (0..rows).for_each(|r| search.augment(r));
    let mut sum = 0.0;
    for (r, out) in partner.iter_mut().enumerate() {
        let column = search.column_of[r];
        let entry = table.row(r).find(|e| table.column[*e] == column);
        *out = entry.map_or(NONE, |_| column);
        sum += entry.map_or(0.0, |e| table.value[e]);
    }
    Ok(sum)
}

const UNSEEN: u8 = 0;
const SEEN: u8 = 1;
const DONE: u8 = 2;

/// The state of the method: costs are negated values, and duals keep every reduced cost of a matched row at 0 or above.
struct Matching<'s> {
    table: &'s Shared<'s>,
    row_dual: &'s mut [f64],    // (rows)
    column_of: &'s mut [u32],   // (rows)
    column_dual: &'s mut [f64], // (all)
    distance: &'s mut [f64],    // (all)
    from: &'s mut [u32],        // (all), the row that reached it
    row_of: &'s mut [u32],      // (all)
    reached: &'s mut [u32],     // (all), a list
    state: &'s mut [u8],        // (all)
}

impl Matching<'_> {
    /// Matches row `source`, turning matches round along the shortest alternating path.
    fn augment(&mut self, source: usize) {
        let table = self.table;
        let (mut row, mut base, mut count) = (source, 0.0, 0);
        let end = loop {
            let alone = (table.columns + row, 0.0);
            let entries = table.row(row).map(|e| (table.column[e] as usize, table.value[e]));
            for (column, value) in entries.chain([alone]) {
                let distance = base - value - self.row_dual[row] - self.column_dual[column];
                if self.state[column] == UNSEEN {
                    self.state[column] = SEEN;
                    self.reached[count] = column as u32;
                    count += 1;
                } else if self.state[column] == DONE || distance >= self.distance[column] {
                    continue;
                }
                self.distance[column] = distance;
                self.from[column] = row as u32;
            }
            // The row's own column is always there to end at, so there is a next one.
            let seen = self.reached[..count].iter().map(|c| *c as usize).filter(|c| self.state[*c] == SEEN);
            let nearest = seen.min_by(|a, b| self.distance[*a].total_cmp(&self.distance[*b]).then(a.cmp(b)));
            let Some(column) = nearest else { return };
            self.state[column] = DONE;
            base = self.distance[column];
            match self.row_of[column] {
                NONE => break column,
                next => row = next as usize,
            }
        };
        self.row_dual[source] += base;
        for &column in &self.reached[..count] {
            let column = column as usize;
            if self.state[column] == DONE && column != end {
                let slack = base - self.distance[column];
                self.row_dual[self.row_of[column] as usize] += slack;
                self.column_dual[column] -= slack;
            }
            self.state[column] = UNSEEN;
        }
        let mut column = end as u32;
        loop {
            let row = self.from[column as usize] as usize;
            self.row_of[column as usize] = row as u32;
            core::mem::swap(&mut self.column_of[row], &mut column);
            if row == source {
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random;
    use std::{vec, vec::Vec};

    /// Assigns a dense table, row after row.
    fn dense(values: &[Vec<f64>], columns: usize) -> (Vec<u32>, f64) {
        let (mut row_start, mut column, mut value) = (vec![0], vec![], vec![]);
        for row in values {
            for (c, v) in row.iter().enumerate().filter(|(_, v)| **v > 0.0) {
                column.push(c as u32);
                value.push(*v);
            }
            row_start.push(column.len() as u32);
        }
        let table = Shared { row_start: &row_start, column: &column, value: &value, columns };
        let mut partner = vec![0; values.len()];
        let mut bytes = vec![0; assign_need(values.len(), columns)];
        let sum = assign(&mut partner, &table, Scratch::new(&mut bytes)).unwrap();
        (partner, sum)
    }

    /// The best sum by trying everything.
    fn best(values: &[Vec<f64>], used: &mut Vec<bool>) -> f64 {
        let Some((row, rest)) = values.split_first() else { return 0.0 };
        let mut sum = best(rest, used);
        for c in 0..used.len() {
            if !used[c] {
                used[c] = true;
                sum = f64::max(sum, row[c] + best(rest, used));
                used[c] = false;
            }
        }
        sum
    }

    #[test]
    fn the_greedy_choice_gives_way_to_the_better_sum() {
        // Taking 10 first leaves 1; 9 + 8 is better.
        assert_eq!(dense(&[vec![10.0, 9.0], vec![8.0, 1.0]], 2), (vec![1, 0], 17.0));
    }

    #[test]
    fn rows_and_columns_without_a_partner_stay_alone() {
        assert_eq!(dense(&[vec![0.0, 0.0], vec![0.0, 3.0], vec![0.0, 2.0]], 2), (vec![NONE, 1, NONE], 3.0));
        assert_eq!(dense(&[], 3), (vec![], 0.0));
        assert_eq!(dense(&[vec![]], 0), (vec![NONE], 0.0));
    }

    #[test]
    fn random_tables_reach_the_sum_of_trying_everything() {
        for seed in 0..300u64 {
            let draw = |i: u64| random::hash(seed, 1, i);
            let (rows, columns) = (1 + draw(0) as usize % 5, 1 + draw(1) as usize % 5);
            let value = |r: usize, c: usize| (draw((10 * r + c + 2) as u64) % 7).saturating_sub(2) as f64;
            let values: Vec<Vec<f64>> = (0..rows).map(|r| (0..columns).map(|c| value(r, c)).collect()).collect();
            let (partner, sum) = dense(&values, columns);
            // Whole numbers below 2^53: sums are exact.
            assert_eq!(sum, best(&values, &mut vec![false; columns]), "{values:?}");
            let mut taken: Vec<u32> = partner.into_iter().filter(|c| *c != NONE).collect();
            let matched = taken.len();
            taken.sort_unstable();
            taken.dedup();
            assert_eq!(taken.len(), matched, "a column twice: {values:?}");
        }
    }

    #[test]
    fn too_little_memory_is_an_error() {
        let table = Shared { row_start: &[0, 1], column: &[0], value: &[1.0], columns: 1 };
        let mut partner = [7];
        let need = assign_need(1, 1);
        let mut bytes = vec![0; need - 1];
        let result = assign(&mut partner, &table, Scratch::new(&mut bytes));
        assert_eq!((result, partner), (Err(ScratchTooSmall { need, given: need - 1 }), [7]));
    }
}
