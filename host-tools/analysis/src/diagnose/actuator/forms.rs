//! Forms of an effect: the same effect at another place of the chain, or with another begin or end; or the effect that continues
//! it with the same equation beyond the end of its range.

use super::candidate::{Candidate, rings};
use super::cost::{Cost, Term};
use super::refine::refined;
use super::tried::{at_an_end, specs};
use rayon::prelude::*;
use softdock_physics::model::stage::Stage;

/// The same effects in other forms, one effect changed at a time, each refined. The form that is best for an effect alone need
/// not be the best beside others.
pub(super) fn other_forms(
    candidate: &Candidate,
    cost: &Cost<'_>,
    excluded: &dyn Fn(&str) -> bool,
) -> Vec<Candidate> {
    let mut others: Vec<Vec<Term>> = Vec::new();
    for term in &candidate.terms {
        let from = term.stage;
        let forms = Stage::ALL.iter().filter(|to| to.id() == from.id());
        let beyond = goes_on_as(term, cost).filter(|to| !excluded(to.id()));
        for to in forms.chain(&beyond).filter(|to| **to != from) {
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
        .filter(rings)
        .collect()
}

/// The stage with the same equation beyond the damping at which a search ends; `None` if the damping is not at such an end.
fn goes_on_as(term: &Term, cost: &Cost<'_>) -> Option<Stage> {
    let damping = specs(term.stage, &cost.scale(&term.axes)).get(1).copied()?;
    let ends = at_an_end(term.stage, &damping, *term.values.get(1)?);
    match (term.stage, ends) {
        (Stage::Servo | Stage::ServoForLag, [true, _]) => Some(Stage::Resonance),
        (Stage::Resonance, [_, true]) => Some(Stage::Servo),
        _ => None,
    }
}

fn exchange(term: &Term, from: Stage, to: Stage) -> Term {
    Term {
        stage: if term.stage == from { to } else { term.stage },
        ..term.clone()
    }
}
