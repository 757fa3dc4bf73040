//! Cells of the tables for people.

use comfy_table::{CellAlignment, Table};

/// The text of a table whose first column names things and whose others are numbers.
pub(super) fn align(mut table: Table) -> String {
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    for column in table.column_iter_mut() {
        column.set_padding((0, 2));
    }
    table.trim_fmt()
}

/// A figure with fixed digits; a dash where there is none.
pub(super) fn number(x: f64, digits: usize) -> String {
    if x.is_nan() { "-".to_string() } else { format!("{x:.digits$}") }
}
