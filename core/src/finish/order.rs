//! Charts numbered by part, so that a grid gives the same part of similar shapes the same cell.

use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::Slices;
use crate::base::sort;

/// Renumbers charts 0..count by part: the largest chart of each part in the order of the parts, then what is left, again in
/// that order. A part in one chart has its own number as the chart's, and with it its cell of a grid, as long as no part
/// before it is missing. `part` and `area` are those of a face. Needs 28 bytes a chart.
pub fn order_charts(
    chart: &mut [u32], // (f)
    count: usize,
    part: impl Fn(usize) -> u32,
    area: impl Fn(usize) -> f64,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let areas = scratch.take::<f64>(count)?;
    let part_of = scratch.take::<u32>(count)?;
    let order = scratch.take::<u32>(count)?;
    let turn = scratch.take::<u32>(count)?; // how many charts of its part are larger
    for (f, k) in chart.iter().enumerate() {
        areas[*k as usize] += area(f);
        part_of[*k as usize] = part(f);
    }
    order.iter_mut().enumerate().for_each(|(i, k)| *k = i as u32);
    let by_area = |a: &u32, b: &u32| areas[*b as usize].total_cmp(&areas[*a as usize]).then(a.cmp(b));
    sort::by(order, |a, b| part_of[*a as usize].cmp(&part_of[*b as usize]).then_with(|| by_area(a, b)));
    for charts in order.runs(|a, b| part_of[*a as usize] == part_of[*b as usize]) {
        charts.iter().enumerate().for_each(|(i, k)| turn[*k as usize] = i as u32);
    }
    sort::by_key(order, |k| (turn[*k as usize], part_of[*k as usize]));
    let number = part_of; // not needed any more
    order.iter().enumerate().for_each(|(i, k)| number[*k as usize] = i as u32);
    chart.iter_mut().for_each(|k| *k = number[*k as usize]);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;

    #[test]
    fn the_main_chart_of_each_part_comes_first() {
        let part = [1, 1, 0, 0, 1, 2];
        let area = [1.0, 5.0, 2.0, 2.0, 4.0, 1.0];
        let mut chart = vec![0, 1, 2, 2, 1, 3];
        let mut bytes = vec![0; 1000];
        order_charts(&mut chart, 4, |f| part[f], |f| area[f], Scratch::new(&mut bytes)).unwrap();
        assert_eq!(chart, [3, 1, 0, 0, 1, 2]);
        let small = order_charts(&mut chart, 4, |f| part[f], |f| area[f], Scratch::new(&mut bytes[..40]));
        assert!(small.is_err());
    }
}
