//! Values on the grid of a search.

use super::tried::Spec;

/// The grid of a parameter.
pub(super) fn grid(spec: &Spec) -> Vec<f64> {
    let last = spec.grid.max(2) - 1;
    (0..=last)
        .map(|i| place(spec, i as f64 / last as f64))
        .collect()
}

/// Value at a place in the range of a parameter, from 0 (lowest) to 1 (highest).
pub(super) fn place(spec: &Spec, at: f64) -> f64 {
    match spec.ratio_from {
        Some(from) => {
            let [low, high] = [spec.low - from, spec.high - from];
            from + low * (high / low).powf(at)
        }
        None => spec.low + (spec.high - spec.low) * at,
    }
}

/// Place of a value in its range, the inverse of [`place`].
pub(super) fn place_of(spec: &Spec, value: f64) -> f64 {
    match spec.ratio_from {
        Some(from) => {
            let [low, high] = [spec.low - from, spec.high - from];
            ((value - from) / low).ln() / (high / low).ln()
        }
        None => (value - spec.low) / (spec.high - spec.low),
    }
}

/// All combinations of the grids of a stage.
pub(super) fn combinations(specs: &[Spec]) -> Vec<Vec<f64>> {
    let mut all = vec![Vec::new()];
    for spec in specs {
        let values = grid(spec);
        all = all
            .into_iter()
            .flat_map(|head: Vec<f64>| {
                values.iter().map(move |v| {
                    let mut row = head.clone();
                    row.push(*v);
                    row
                })
            })
            .collect();
    }
    all
}
