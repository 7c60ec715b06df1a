//! Forms of an effect: the same one at another place of the chain, or with another begin or end.

use super::candidate::Candidate;
use super::cost::{Cost, Term};
use super::refine::refined;
use rayon::prelude::*;
use softdock_physics::model::stage::Stage;

/// The same effects in other forms, one effect changed at a time; a form that is best for an effect
/// alone need not be the best beside another.
pub(super) fn other_forms(candidate: &Candidate, cost: &Cost<'_>) -> Vec<Candidate> {
    let stages = candidate.terms.iter().map(|t| t.stage);
    let mut others: Vec<Vec<Term>> = Vec::new();
    for from in stages {
        let forms = Stage::ALL.iter().filter(|s| s.id() == from.id());
        for to in forms.filter(|s| **s != from) {
            let terms: Vec<Term> = candidate
                .terms
                .iter()
                .map(|t| exchange(t, from, *to))
                .collect();
            if !others.contains(&terms) {
                others.push(terms);
            }
        }
    }
    others
        .into_par_iter()
        .map(|terms| {
            let terms = refined(terms, cost);
            Candidate::new(terms, cost)
        })
        .collect()
}

fn exchange(term: &Term, from: Stage, to: Stage) -> Term {
    Term {
        stage: if term.stage == from { to } else { term.stage },
        ..term.clone()
    }
}
