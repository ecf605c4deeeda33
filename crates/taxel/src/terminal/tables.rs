//! Tables and shapes as people read them.

use taxel::base::{Align, Grid};

/// Returns rows under a ruled header; columns in `right` are aligned to the right.
pub fn table(header: &[&str], rows: &[Vec<String>], right: &[usize]) -> String {
    let align = |column| if right.contains(&column) { Align::Right } else { Align::Left };
    let columns = header.iter().enumerate();
    let mut grid = columns.fold(Grid::new(), |grid, (at, head)| grid.column(*head, align(at))).ruled();
    rows.iter().for_each(|row| grid.row(row.clone()));
    grid.to_string()
}

/// Returns the sizes of a shape: `5×50`, `3×50×50`.
#[cfg(feature = "lab")]
pub fn shape(sizes: &[usize]) -> String {
    sizes.iter().map(usize::to_string).collect::<Vec<_>>().join("×")
}
