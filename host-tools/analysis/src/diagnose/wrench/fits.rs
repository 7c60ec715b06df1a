//! Hypotheses that were fitted before: the searches of one diagnosis come upon the same ones again and again.

use super::problem::Problem;
use super::refined::Care;
use super::search::Hypothesis;
use super::tested::Tested;
use super::variants::Library;
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

/// Fits of one diagnosis.
#[derive(Default)]
pub(crate) struct Fits(Mutex<HashMap<Vec<u64>, Tested>>);

impl Fits {
    /// A fit that was made before, or is made now. All that it follows from is in its key, the logs by what is left of them in every
    /// bit: those of another problem agree in none of it.
    pub(super) fn known_or(&self, key: Vec<u64>, fit: impl FnOnce() -> Tested) -> Tested {
        let fits = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = fits().get(&key).cloned();
        known.unwrap_or_else(|| {
            let fit = fit();
            fits().insert(key, fit.clone());
            fit
        })
    }
}

/// What a fit to a problem follows from, beside a regression of all logs.
pub(super) fn key(
    [problem, of_all]: [&Problem; 2],
    library: &Library,
    hypothesis: &Hypothesis,
    care: Care,
) -> Vec<u64> {
    let mut key = vec![u64::from(care == Care::Estimating)];
    for problem in [problem, of_all] {
        key.extend(problem.fingerprint());
    }
    for part in &hypothesis.parts {
        let variant = &library.variants[part.variant];
        // Each entry of a catalogue stands in one place of memory.
        key.push(std::ptr::from_ref(variant.effect).addr() as u64);
        key.extend(variant.shapes.iter().map(|shape| shape.to_bits()));
        key.push(part.used.len() as u64);
        key.extend(part.used.iter().map(|place| *place as u64));
    }
    let start = &hypothesis.solution;
    let numbers = [start.gain, hypothesis.evidence].into_iter();
    let numbers = numbers.chain(start.coefficients.iter().copied());
    key.extend(numbers.map(f64::to_bits));
    key.push(hypothesis.parameters as u64);
    key
}
