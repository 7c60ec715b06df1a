//! Products of columns with each other, which are most of what a search has to calculate.

use nalgebra::DMatrix;
use rayon::prelude::*;
use softdock_physics::model::load::Column;
use std::borrow::Borrow;

/// Rows that are multiplied at a time: of hundreds of columns so many stay in a processor's own
/// cache, and a load that acts in a contact alone has blocks without any value.
const ROWS: usize = 128;
/// Columns of a tile, which are multiplied with all others while these are in the cache.
const TILE: usize = 16;

/// Columns that are not zero in a block of rows, with their values there.
type Block<'a> = Vec<(usize, &'a [f64])>;

/// Products of columns with each other. The order of summation does not depend on the number of
/// threads.
pub(super) fn gram(columns: &[impl Borrow<Column> + Sync]) -> DMatrix<f64> {
    let size = columns.len();
    let blocks = blocks(columns);
    let tile = |number: usize| {
        let from = number * TILE;
        let to = (from + TILE).min(size);
        let mut sums = DMatrix::<f64>::zeros(to, to - from);
        for block in &blocks {
            let until = |end: usize| block.partition_point(|(i, _)| *i < end);
            for (n, (i, one)) in block.iter().enumerate().take(until(to)).skip(until(from)) {
                let mut sums = sums.column_mut(i - from);
                for (k, other) in &block[..=n] {
                    sums[*k] += softdock_statistics::dot(one, other);
                }
            }
        }
        sums
    };
    let tiles: Vec<DMatrix<f64>> = (0..size.div_ceil(TILE)).into_par_iter().map(tile).collect();
    DMatrix::from_fn(size, size, |i, k| {
        let (low, high) = (i.min(k), i.max(k));
        tiles[high / TILE][(low, high % TILE)]
    })
}

fn blocks<C: Borrow<Column>>(columns: &[C]) -> Vec<Block<'_>> {
    let lengths = columns
        .iter()
        .flat_map(|c| c.borrow().0.iter().map(Vec::len));
    let of_axis = lengths.max().unwrap_or(0).div_ceil(ROWS);
    let mut blocks = vec![Block::new(); 6 * of_axis];
    for (i, column) in columns.iter().enumerate() {
        for (axis, series) in column.borrow().0.iter().enumerate() {
            for (at, values) in series.chunks(ROWS).enumerate() {
                if values.iter().any(|v| *v != 0.0) {
                    blocks[axis * of_axis + at].push((i, values));
                }
            }
        }
    }
    blocks
}

/// Product of two columns; an axis without values adds nothing.
pub(crate) fn dot(a: &Column, b: &Column) -> f64 {
    let axes = a.0.iter().zip(&b.0);
    axes.map(|(a, b)| softdock_statistics::dot(a, b)).sum()
}
