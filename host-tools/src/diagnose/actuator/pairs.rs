//! Two stages at once, searched together: the best of each alone need not be the best pair.

use super::cost::{Cost, Term};
use super::grid::grid;
use super::refine::refined;
use super::search::{Candidate, is_a_cause, penalised};
use super::tried::specs;
use rayon::prelude::*;

/// Rivals that are taken into the search for pairs.
const PAIRED: usize = 7;

/// The best pair of different stages, both searched together.
pub(super) fn best_pair(
    singles: &[Candidate],
    train: &Cost<'_>,
    test: &Cost<'_>,
) -> Option<Candidate> {
    let mut blocks: Vec<&[Term]> = Vec::new();
    for candidate in singles.iter().filter(|c| is_a_cause(c)) {
        let id = |terms: &[Term]| terms.first().map(|t| t.stage.id());
        let new = blocks.iter().all(|b| id(b) != id(&candidate.terms));
        if blocks.len() < PAIRED && new {
            blocks.push(&candidate.terms);
        }
    }
    let pairs: Vec<(&[Term], &[Term])> = (0..blocks.len())
        .flat_map(|i| (i + 1..blocks.len()).map(move |k| (i, k)))
        .map(|(i, k)| (blocks[i], blocks[k]))
        .collect();
    let mut coarse: Vec<(f64, Vec<Term>)> = pairs
        .par_iter()
        .filter_map(|(a, b)| coarse_pair(a, b, train))
        .collect();
    coarse.sort_by(|a, b| a.0.total_cmp(&b.0));
    let refined: Vec<Candidate> = coarse
        .into_par_iter()
        .take(4)
        .map(|(_, terms)| {
            let terms = refined(terms, train);
            Candidate {
                train: train.of(&terms),
                test: test.of(&terms),
                terms,
            }
        })
        .collect();
    refined
        .into_iter()
        .min_by(|a, b| penalised(a).total_cmp(&penalised(b)))
}

/// Values around the best ones of a block alone, one parameter moved at a time.
fn around(block: &[Term], train: &Cost<'_>) -> Vec<Vec<Term>> {
    let mut all = vec![block.to_vec()];
    for (i, term) in block.iter().enumerate() {
        for (k, spec) in specs(term.stage, &train.scale(&term.axes))
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

/// Best point of a coarse grid around the best values of both alone.
fn coarse_pair(a: &[Term], b: &[Term], train: &Cost<'_>) -> Option<(f64, Vec<Term>)> {
    let (first, second) = (around(a, train), around(b, train));
    let all = first.iter().flat_map(|a| {
        second.iter().map(move |b| {
            let mut terms = a.clone();
            terms.extend(b.iter().cloned());
            terms
        })
    });
    all.map(|terms| (train.of(&terms), terms))
        .min_by(|a, b| a.0.total_cmp(&b.0))
}
