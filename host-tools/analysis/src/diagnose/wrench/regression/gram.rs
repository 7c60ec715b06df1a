//! Inner products of columns, which are most of what a search has to calculate.

use nalgebra::DMatrix;
use ndarray::{Array2, Axis};
use rayon::prelude::*;
use softdock_physics::model::load::Column;
use std::borrow::Borrow;

/// Rows that are multiplied at a time. Blocks in which a column is 0 are skipped, as of a load that acts in contacts only.
const ROWS: usize = 256;
/// Columns that are multiplied at a time, with all columns before them: the matrix is symmetric.
const TILE: usize = 64;

/// Gram matrix of columns. The order of summation does not depend on the number of threads.
pub(crate) fn gram(columns: &[impl Borrow<Column> + Sync]) -> DMatrix<f64> {
    let of_axis = |axis: usize| {
        let series = columns.iter().map(|c| c.borrow().0[axis].as_slice());
        gram_of(&series.collect::<Vec<_>>())
    };
    let axes: Vec<DMatrix<f64>> = (0..6).into_par_iter().map(of_axis).collect();
    let mut sum: DMatrix<f64> = axes.iter().sum();
    sum.fill_lower_triangle_with_upper_triangle();
    sum
}

/// Upper triangle of the Gram matrix of the series of one axis, of which some are empty.
fn gram_of(series: &[&[f64]]) -> DMatrix<f64> {
    let mut sums = DMatrix::zeros(series.len(), series.len());
    let rows = series.iter().map(|s| s.len()).max().unwrap_or(0);
    for from in (0..rows).step_by(ROWS) {
        let to = (from + ROWS).min(rows);
        let not_zero = |i: &usize| series[*i].iter().take(to).skip(from).any(|v| *v != 0.0);
        let places: Vec<usize> = (0..series.len()).filter(not_zero).collect();
        let block = Array2::from_shape_fn((places.len(), to - from), |(i, n)| {
            series[places[i]][from + n]
        });
        for first in (0..places.len()).step_by(TILE) {
            let end = (first + TILE).min(places.len());
            let rows = |range: std::ops::Range<usize>| block.slice_axis(Axis(0), range.into());
            let products = rows(0..end).dot(&rows(first..end).t());
            for ((i, k), product) in products.indexed_iter() {
                sums[(places[i], places[first + k])] += product;
            }
        }
    }
    sums
}

/// Inner product of two columns; an axis without values adds nothing.
pub(crate) fn dot(a: &Column, b: &Column) -> f64 {
    let axes = a.0.iter().zip(&b.0);
    axes.map(|(a, b)| softdock_statistics::dot(a, b)).sum()
}
