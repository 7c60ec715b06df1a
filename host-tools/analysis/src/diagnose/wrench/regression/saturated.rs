//! The residual from which the noise model is estimated: what no combination of effects explains.
//!
//! A noise model that is estimated from the plain residual contains the missing effect, and whitening with it removes what is
//! looked for.

use super::gram::dot;
use super::problem::{Problem, Segment};
use crate::diagnose::noise::autoregressive::AutoregressiveNoise;
use rayon::prelude::*;
use softdock_physics::model::load::effects::{LoadEffect, Shape};
use softdock_physics::model::load::{Column, Scene};

/// The prior of each column is weak: its standard deviation is the noise of the whole log times this.
const WEAK: f64 = 1e3;

/// The residual, in units of `sigma`, without what all effects and nuisance parameters together explain.
pub(crate) fn residual(
    scene: &Scene,
    residual: &Column,
    tolerances: &[Column],
    sigma: &[f64; 6],
    fresh: &[bool],
) -> Column {
    let noise_model = sigma.map(AutoregressiveNoise::white);
    let mut columns: Vec<Column> = tolerances.to_vec();
    let built: Vec<Column> = LoadEffect::all(&scene.model)
        .collect::<Vec<_>>()
        .par_iter()
        .flat_map_iter(|effect| {
            some_shapes(&effect.shapes)
                .into_iter()
                .filter_map(|shapes| effect.columns(scene, &shapes, &effect.places()))
                .flatten()
        })
        .filter(|column| !column.is_zero())
        .collect();
    columns.extend(built);
    for column in &mut columns {
        for (series, sigma) in column.0.iter_mut().zip(sigma) {
            series.iter_mut().for_each(|v| *v /= sigma);
        }
        let size = dot(column, column).sqrt().max(1e-12);
        for (series, sigma) in column.0.iter_mut().zip(sigma) {
            series.iter_mut().for_each(|v| *v *= WEAK * sigma / size);
        }
    }
    let segment = Segment {
        noise_model,
        fresh: fresh.to_vec(),
    };
    let problem = Problem::new(vec![segment], &[residual], &[&columns]);
    let nothing = Column::default();
    problem.rest(&nothing, &problem.tolerances_with(&nothing))
}

/// Shapes at which an effect is taken: all at the middle of their grids, then each in turn at its first and its last value.
fn some_shapes(shapes: &[Shape]) -> Vec<Vec<f64>> {
    let middle: Vec<f64> = shapes.iter().map(|s| s.tried[s.tried.len() / 2]).collect();
    let mut all = vec![middle.clone()];
    for (k, shape) in shapes.iter().enumerate() {
        for value in [shape.tried.first(), shape.tried.last()]
            .into_iter()
            .flatten()
        {
            let mut other = middle.clone();
            other[k] = *value;
            if !all.contains(&other) {
                all.push(other);
            }
        }
    }
    all
}
