//! Pairs of stages, searched together: the best values of each alone need not be those of the best pair.

use super::candidate::{Candidate, is_a_cause};
use super::cost::{Cost, Term};
use super::grid::grid;
use super::refine::refined;
use super::tried::specs;
use rayon::prelude::*;

/// Single stages from which pairs are formed.
const PAIRED: usize = 7;
/// Pairs that are evaluated on the whole grid of both stages.
const GRIDDED: usize = 8;
/// Pairs that are refined.
const REFINED: usize = 4;

/// The best pair of different stages, both searched together.
pub(super) fn best_pair(singles: &[Candidate], cost: &Cost<'_>) -> Option<Candidate> {
    let mut blocks: Vec<&[Term]> = Vec::new();
    for candidate in singles.iter().filter(|c| is_a_cause(c, cost)) {
        let id = |terms: &[Term]| terms.first().map(|t| t.stage.id());
        let new = blocks.iter().all(|b| id(b) != id(&candidate.terms));
        if blocks.len() < PAIRED && new {
            blocks.push(&candidate.terms);
        }
    }
    let pairs: Vec<(&[Term], &[Term])> = (0..blocks.len())
        .flat_map(|i| (i + 1..blocks.len()).map(move |k| (i, k)))
        .map(|(i, k)| (blocks[i], blocks[k]))
        .filter(|(a, b)| {
            a.iter()
                .all(|term| b.iter().all(|other| other.stage.id() != term.stage.id()))
        })
        .collect();
    let mut grids: Vec<(f64, PairGrid<'_>)> = pairs
        .par_iter()
        .map(|(a, b)| {
            let grid = PairGrid::new(a, b, cost);
            (grid.best_line().0, grid)
        })
        .collect();
    grids.sort_by(|a, b| a.0.total_cmp(&b.0));
    grids.truncate(GRIDDED);
    let mut coarse: Vec<(f64, Vec<Term>)> =
        grids.into_par_iter().map(|(_, grid)| grid.best()).collect();
    coarse.sort_by(|a, b| a.0.total_cmp(&b.0));
    let refined: Vec<Candidate> = coarse
        .into_par_iter()
        .take(REFINED)
        .map(|(_, terms)| {
            let terms = refined(terms, cost);
            Candidate::new(terms, cost)
        })
        .collect();
    refined
        .into_iter()
        .min_by(|a, b| a.priced(cost).total_cmp(&b.priced(cost)))
}

/// Values around the best ones of a block alone, one parameter moved over its grid at a time.
fn around(block: &[Term], cost: &Cost<'_>) -> Vec<Vec<Term>> {
    let mut all = vec![block.to_vec()];
    for (i, term) in block.iter().enumerate() {
        for (k, spec) in specs(term.stage, &cost.scale(&term.axes))
            .iter()
            .enumerate()
        {
            for value in grid(spec).into_iter().step_by(2) {
                let mut moved = block.to_vec();
                moved[i].values[k] = value;
                all.push(moved);
            }
        }
    }
    all
}

/// A coarse grid around the best values of each of two stages alone.
struct PairGrid<'a> {
    cost: &'a Cost<'a>,
    variants: [Vec<Vec<Term>>; 2],
}

impl<'a> PairGrid<'a> {
    fn new(a: &[Term], b: &[Term], cost: &'a Cost<'a>) -> Self {
        Self {
            cost,
            variants: [around(a, cost), around(b, cost)],
        }
    }

    /// Terms of both stages at these places of the grid.
    fn terms(&self, i: usize, k: usize) -> Vec<Term> {
        [&self.variants[0][i][..], &self.variants[1][k]].concat()
    }

    /// Best cost with at least one of the two as it is best alone.
    fn best_line(&self) -> (f64, Vec<Term>) {
        let (rows, columns) = (self.variants[0].len(), self.variants[1].len());
        let along_first = (0..rows).map(|i| (i, 0));
        self.best_of(along_first.chain((1..columns).map(|k| (0, k))))
    }

    /// Best point of the whole grid.
    fn best(&self) -> (f64, Vec<Term>) {
        let (rows, columns) = (self.variants[0].len(), self.variants[1].len());
        self.best_of((0..rows).flat_map(|i| (0..columns).map(move |k| (i, k))))
    }

    fn best_of(&self, points: impl Iterator<Item = (usize, usize)>) -> (f64, Vec<Term>) {
        let mut best = (f64::INFINITY, (0, 0));
        for (i, k) in points {
            let chi2 = self.cost.of(&self.terms(i, k));
            if chi2 < best.0 {
                best = (chi2, (i, k));
            }
        }
        let (chi2, (i, k)) = best;
        (chi2, self.terms(i, k))
    }
}
