//! Local refinement of parameters that a grid has found.

use super::cost::{Cost, Term};
use super::grid::{place, place_of};
use super::tried::{Spec, plateau_step, specs};
use softdock_physics::optimise::{lowest_valley, nelder_mead};

/// Improves the parameters of terms, starting from their present values.
pub(super) fn refined(terms: Vec<Term>, logs: &Cost<'_>) -> Vec<Term> {
    improved(terms, logs, &|terms| logs.of(terms))
}

/// The same with a cost of its own.
pub(super) fn improved(
    terms: Vec<Term>,
    logs: &Cost<'_>,
    cost: &dyn Fn(&[Term]) -> f64,
) -> Vec<Term> {
    /// Fewest steps of the simplex.
    const FEWEST_STEPS: usize = 60;
    /// Steps of the simplex for each parameter, if there are many.
    const STEPS_EACH: usize = 20;
    let on_grid = OnGrid {
        specs: terms
            .iter()
            .map(|t| specs(t.stage, &logs.scale(&t.axes)))
            .collect(),
        terms: &terms,
    };
    let width: Vec<f64> = on_grid
        .specs()
        .map(|s| 1.0 / (s.grid.max(2) - 1) as f64)
        .collect();
    let start = on_grid.places();
    let best = if let [at] = start[..] {
        let (low, high) = ((at - width[0]).max(0.0), (at + width[0]).min(1.0));
        vec![bottom(low, high, |at| cost(&on_grid.at(&[at]))).0]
    } else {
        let scale: Vec<f64> = width.iter().map(|w| 0.4 * w).collect();
        let steps = FEWEST_STEPS.max(STEPS_EACH * start.len());
        nelder_mead(&start, &scale, steps, |places| {
            let outside: f64 = places.iter().map(|p| (p - p.clamp(0.0, 1.0)).abs()).sum();
            cost(&on_grid.at(places)) * (1.0 + outside)
        })
        .0
    };
    let found = on_grid.at(&best);
    let found = if cost(&found) <= cost(&terms) {
        found
    } else {
        terms
    };
    middle_of_plateaus(found, logs, cost)
}

/// Terms whose parameters are expressed as places in their ranges, 0 to 1.
struct OnGrid<'a> {
    terms: &'a [Term],
    /// Ranges of the parameters of each term.
    specs: Vec<Vec<Spec>>,
}

impl OnGrid<'_> {
    fn specs(&self) -> impl Iterator<Item = &Spec> {
        self.specs.iter().flatten()
    }

    /// The places of the present values.
    fn places(&self) -> Vec<f64> {
        let values = self.terms.iter().flat_map(|t| t.values.iter());
        values
            .zip(self.specs())
            .map(|(value, spec)| place_of(spec, *value).clamp(0.0, 1.0))
            .collect()
    }

    /// The terms at other places.
    fn at(&self, places: &[f64]) -> Vec<Term> {
        let mut places = places.iter();
        let term = |(term, specs): (&Term, &Vec<Spec>)| Term {
            values: specs
                .iter()
                .zip(places.by_ref())
                .map(|(spec, at)| place(spec, at.clamp(0.0, 1.0)))
                .collect(),
            ..term.clone()
        };
        self.terms.iter().zip(&self.specs).map(term).collect()
    }
}

/// Minimum of a cost in some cells of a grid: its place and its value. A finer grid comes first, as there may be several valleys.
pub(super) fn bottom(low: f64, high: f64, cost: impl FnMut(f64) -> f64) -> (f64, f64) {
    /// Cells of the finer grid.
    const CELLS: u32 = 10;
    /// Precision of the place.
    const TOLERANCE: f64 = 2e-4;
    lowest_valley((low, high), CELLS, TOLERANCE, cost)
}

/// Where the cost is flat around its minimum, the middle of the flat is the estimate.
fn middle_of_plateaus(
    mut terms: Vec<Term>,
    logs: &Cost<'_>,
    cost: &dyn Fn(&[Term]) -> f64,
) -> Vec<Term> {
    for i in 0..terms.len() {
        let centre = terms[i].values[0];
        let Some(step) = plateau_step(terms[i].stage, centre, logs.cycle_s()) else {
            continue;
        };
        let tried = specs(terms[i].stage, &logs.scale(&terms[i].axes));
        let highest = tried.first().map_or(f64::INFINITY, |spec| spec.high);
        let mut scanned: Vec<(f64, f64)> = Vec::new();
        for k in -12..=12 {
            let value = (centre + f64::from(k) * step).clamp(step, highest.max(step));
            let mut shifted = terms.clone();
            shifted[i].values[0] = value;
            scanned.push((value, cost(&shifted)));
        }
        let least = scanned.iter().map(|s| s.1).fold(f64::INFINITY, f64::min);
        // A rise of χ² by one is one standard deviation.
        let flat: Vec<f64> = scanned
            .iter()
            .filter(|s| s.1 <= least + 1.0)
            .map(|s| s.0)
            .collect();
        if let (Some(first), Some(last)) = (flat.first(), flat.last()) {
            let mut middle = terms.clone();
            middle[i].values[0] = 0.5 * (first + last);
            if cost(&middle) <= least + 4.0 {
                terms = middle;
            }
        }
    }
    terms
}
