//! The atlas: areas of charts, texel density and its spread.
//!
//! Texel density of a chart is sqrt(UV area / area in space), in UV units a unit of length: times the texture's side it
//! is texels a unit. An even atlas has one density. Charts without area in space have none and are left out.

use super::input::Areas;
use super::wedges::UvTopology;
use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use crate::mesh::view::NONE;
use bytemuck::{Pod, Zeroable};

/// One chart.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ChartArea {
    /// Area in space.
    pub solid: f64,
    /// UV area, sum of the faces' unsigned ones.
    pub uv: f64,
}

impl ChartArea {
    /// sqrt(UV area / area in space); NaN or infinite without area in space.
    pub fn texel_density(&self) -> f64 {
        sqrt(self.uv / self.solid)
    }
}

/// Statistics over charts; NaN where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Atlas {
    /// Sum of all faces' unsigned UV areas: the utilisation of the unit square, for a valid atlas inside it.
    pub uv_area: f64,
    /// UV area of the smallest chart.
    pub smallest_chart: f64,
    /// UV area of the largest chart.
    pub largest_chart: f64,
    /// Lowest texel density of a chart.
    pub density_min: f64,
    /// Median over charts.
    pub density_median: f64,
    /// Highest.
    pub density_max: f64,
    /// Standard deviation over mean, both weighted by area in space: crumbs do not count much. 0 is even.
    pub density_variation: f64,
}

/// Bytes that [`atlas`] needs.
pub const fn atlas_need(chart_count: usize) -> usize {
    bytes_for::<ChartArea>(chart_count) + bytes_for::<f64>(chart_count)
}

/// Fills `out`, one entry a chart.
pub fn chart_areas(out: &mut [ChartArea], topology: &UvTopology, areas: Areas) {
    out.fill(ChartArea::default());
    for (f, c) in topology.chart.iter().enumerate().filter(|(_, c)| **c != NONE) {
        out[*c as usize].solid += areas.solid[f];
        out[*c as usize].uv += areas.uv[f].abs();
    }
}

/// Statistics over the charts.
pub fn atlas(topology: &UvTopology, areas: Areas, mut scratch: Scratch) -> Result<Atlas, ScratchTooSmall> {
    scratch.require(atlas_need(topology.chart_count))?;
    let charts = scratch.take::<ChartArea>(topology.chart_count)?;
    let density = scratch.take::<f64>(topology.chart_count)?;
    chart_areas(charts, topology, areas);
    let mut count = 0;
    for chart in charts.iter().filter(|c| c.texel_density().is_finite()) {
        density[count] = chart.texel_density();
        count += 1;
    }
    let density = &mut density[..count];
    sort::by(density, f64::total_cmp);
    let extreme = |pick: fn(f64, f64) -> f64| charts.iter().fold(f64::NAN, |x, c| pick(x, c.uv));
    Ok(Atlas {
        uv_area: charts.iter().fold(0.0, |sum, c| sum + c.uv),
        smallest_chart: extreme(f64::min),
        largest_chart: extreme(f64::max),
        density_min: density.first().copied().unwrap_or(f64::NAN),
        density_median: median(density),
        density_max: density.last().copied().unwrap_or(f64::NAN),
        density_variation: variation(charts),
    })
}

fn median(sorted: &[f64]) -> f64 {
    let half = sorted.len() / 2;
    match sorted.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => sorted[half],
        _ => 0.5 * (sorted[half - 1] + sorted[half]),
    }
}

fn variation(charts: &[ChartArea]) -> f64 {
    let sum = |of: &dyn Fn(&ChartArea) -> f64| {
        charts.iter().filter(|c| c.texel_density().is_finite()).fold(0.0, |sum, c| sum + c.solid * of(c))
    };
    let mean = sum(&|c| c.texel_density()) / sum(&|_| 1.0);
    let square = |c: &ChartArea| (c.texel_density() - mean) * (c.texel_density() - mean);
    sqrt(sum(&square) / sum(&|_| 1.0)) / mean
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;

    fn judge(charts: &[(f64, f64)]) -> Atlas {
        let solid: vec::Vec<f64> = charts.iter().map(|c| c.0).collect();
        let uv: vec::Vec<f64> = charts.iter().map(|c| c.1).collect();
        let chart: vec::Vec<u32> = (0..charts.len() as u32).collect();
        let topology = UvTopology {
            welded: &[],
            vertex_count: 0,
            wedge: &[],
            wedge_count: 0,
            chart: &chart,
            chart_count: charts.len(),
            edges: &[],
            seam_sides: &[],
            euler: &[],
            loops: &[],
        };
        let mut bytes = vec![0; atlas_need(charts.len())];
        let areas = Areas { solid: &solid, uv: &uv };
        let short = bytes.len() - 1;
        assert!(atlas(&topology, areas, Scratch::new(&mut bytes[..short])).is_err());
        atlas(&topology, areas, Scratch::new(&mut bytes)).unwrap()
    }

    #[test]
    fn charts_of_one_density_have_no_variation() {
        let a = judge(&[(4.0, 1.0), (16.0, -4.0)]);
        assert_eq!((a.density_min, a.density_median, a.density_max, a.density_variation), (0.5, 0.5, 0.5, 0.0));
        assert_eq!((a.uv_area, a.smallest_chart, a.largest_chart), (5.0, 1.0, 4.0));
    }

    #[test]
    fn variation_is_weighted_by_area() {
        // Densities 1 and 3 on equal areas: mean 2, deviation 1. A chart without area in space does not count.
        let a = judge(&[(1.0, 1.0), (1.0, 9.0), (0.0, 5.0)]);
        assert_eq!((a.density_variation, a.density_median, a.density_max), (0.5, 2.0, 3.0));
    }

    #[test]
    fn no_chart_has_no_figures() {
        let a = judge(&[]);
        assert!(a.uv_area == 0.0 && a.density_median.is_nan() && a.density_variation.is_nan());
    }
}
