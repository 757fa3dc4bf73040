//! Figures of files as a table for people.

use super::cells::{align, number};
use super::record::AtlasRecord;
use comfy_table::{Table, presets};

/// Records as an aligned table, one row a file and a row of means under several.
pub fn table(records: &[AtlasRecord]) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(COLUMNS.iter().map(|c| c.head));
    table.add_rows(records.iter().map(|r| {
        COLUMNS.iter().map(|c| match c.value {
            Cell::Name => r.obj.clone(),
            Cell::Count(of) => of(r).to_string(),
            Cell::Real(digits, of) => number(of(r), digits),
        })
    }));
    if records.len() > 1 {
        table.add_row(COLUMNS.iter().map(|c| match c.value {
            Cell::Name => "mean".to_string(),
            Cell::Count(of) => number(mean(records, |r| of(r) as f64), 1),
            Cell::Real(digits, of) => number(mean(records, of), digits),
        }));
    }
    align(table)
}

/// What a cell shows.
#[derive(Clone, Copy)]
enum Cell {
    Name,
    Count(fn(&AtlasRecord) -> usize),
    /// Digits behind the point, and the figure.
    Real(usize, fn(&AtlasRecord) -> f64),
}

struct Column {
    head: &'static str,
    value: Cell,
}

const fn column(head: &'static str, value: Cell) -> Column {
    Column { head, value }
}

const COLUMNS: &[Column] = &[
    column("file", Cell::Name),
    column("triangles", Cell::Count(|r| r.faces)),
    column("no uv", Cell::Count(|r| r.faces_without_vt)),
    column("charts", Cell::Count(|r| r.charts)),
    column("no disk", Cell::Count(|r| r.non_disk_charts)),
    column("no plane", Cell::Count(|r| r.closed_or_handled_charts)),
    column("mirrored", Cell::Count(|r| r.mirrored_charts)),
    column("flipped", Cell::Count(|r| r.exact_flipped_faces)),
    column("overlapping", Cell::Count(|r| r.overlapping_faces)),
    column("stacked", Cell::Count(|r| r.stacked_charts)),
    column("conf", Cell::Real(3, |r| r.conformality)),
    column("equi", Cell::Real(3, |r| r.equiareality)),
    column("sd/4", Cell::Real(4, |r| r.symmetric_dirichlet / 4.0)),
    column("stretch", Cell::Real(3, |r| r.stretch_l2)),
    column("fill", Cell::Real(3, |r| r.utilisation)),
    column("density +-", Cell::Real(3, |r| r.texel_density_variation)),
    column("seam", Cell::Real(2, |r| r.seam_len_norm)),
    column("visible", Cell::Real(2, |r| r.exposure.map_or(f64::NAN, |e| e.visible_seam_len_norm))),
    column("noticed", Cell::Real(2, |r| r.exposure.map_or(f64::NAN, |e| e.noticed_seam_len_norm))),
    column("flat", Cell::Real(2, |r| r.seam_flat_share)),
    column("sharp", Cell::Real(2, |r| r.seam_sharp_share)),
    column("ratio", Cell::Real(2, |r| r.exposure.map_or(f64::NAN, |e| e.seam_ao_ratio))),
];

/// Mean over the records that have the figure.
fn mean(records: &[AtlasRecord], of: impl Fn(&AtlasRecord) -> f64) -> f64 {
    let values: Vec<f64> = records.iter().map(of).filter(|x| !x.is_nan()).collect();
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::super::measure::tests::judge;
    use super::*;

    #[test]
    fn columns_of_the_table_line_up_and_several_files_have_a_mean() {
        let text = table(&[judge(true).unwrap(), judge(false).unwrap()]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 4, "{text}");
        assert!(lines[3].starts_with("mean") && lines[0].contains("visible  noticed  flat  sharp"), "{text}");
        let end = |line: &str, word: &str| line.find(word).map(|i| i + word.len());
        assert_eq!(end(lines[0], "sd/4"), end(lines[1], "1.0000"), "{text}");
        assert_eq!(table(&[judge(true).unwrap()]).lines().count(), 2);
    }
}
