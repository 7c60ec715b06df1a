//! Minimisation without derivatives, for costs that are not smooth everywhere.

/// Ratio of the golden section.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Minimum of a `cost` with several valleys in `low..=high`; returns its place and its value. The cost is evaluated at the ends
/// of `cells` equal cells; [`brent`] then searches the two cells beside the best one, to a `tolerance` in cells.
pub fn lowest_valley(
    (low, high): (f64, f64),
    cells: u32,
    tolerance: f64,
    mut cost: impl FnMut(f64) -> f64,
) -> (f64, f64) {
    let cell = (high - low) / f64::from(cells);
    let ends = (0..=cells).map(|k| low + f64::from(k) * cell);
    let best = ends
        .map(|at| (cost(at), at))
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let (_, best) = best.unwrap_or((f64::INFINITY, low));
    let beside = ((best - cell).max(low), best, (best + cell).min(high));
    brent(beside, tolerance * cell, cost)
}

/// Minimum of a smooth `cost` in `low..high`; returns its place and its value. Parabolas through the three best places, golden
/// sections where these do not shrink the range (Brent 1973, chapter 5). `start` lies inside; the place is accurate to
/// `tolerance`.
pub fn brent(
    (low, start, high): (f64, f64, f64),
    tolerance: f64,
    mut cost: impl FnMut(f64) -> f64,
) -> (f64, f64) {
    /// More steps than golden sections need for a millionth of the range.
    const MOST: usize = 30;
    let (mut a, mut b) = (low, high);
    // The best place, the one before it, and the one before that.
    let mut best = (start, cost(start));
    let (mut second, mut third) = (best, best);
    let (mut step, mut before) = (0.0_f64, 0.0_f64);
    for _ in 0..MOST {
        let middle = 0.5 * (a + b);
        if (best.0 - middle).abs() <= 2.0 * tolerance - 0.5 * (b - a) {
            break;
        }
        let parabola = vertex(best, second, third).filter(|vertex| {
            let inside = vertex - a >= 2.0 * tolerance && b - vertex >= 2.0 * tolerance;
            inside && (vertex - best.0).abs() < 0.5 * before.abs()
        });
        (before, step) = match parabola {
            Some(vertex) => (step, vertex - best.0),
            None => {
                let wider = if best.0 < middle { b } else { a } - best.0;
                (wider, (1.0 - GOLDEN) * wider)
            }
        };
        let at = best.0 + step.abs().max(tolerance).copysign(step);
        let new = (at, cost(at));
        if new.1 <= best.1 {
            *(if at < best.0 { &mut b } else { &mut a }) = best.0;
            (third, second, best) = (second, best, new);
        } else {
            *(if at < best.0 { &mut a } else { &mut b }) = at;
            if new.1 <= second.1 || second.0 == best.0 {
                (third, second) = (second, new);
            } else if new.1 <= third.1 || third.0 == best.0 || third.0 == second.0 {
                third = new;
            }
        }
    }
    best
}

/// Place of the extremum of the parabola through three points; `None` if they do not determine one.
fn vertex(a: (f64, f64), b: (f64, f64), c: (f64, f64)) -> Option<f64> {
    let left = (a.0 - b.0) * (a.1 - c.1);
    let right = (a.0 - c.0) * (a.1 - b.1);
    let below = 2.0 * (left - right);
    let at = a.0 - ((a.0 - b.0) * left - (a.0 - c.0) * right) / below;
    at.is_finite().then_some(at)
}

/// Minimum of `cost` near `start` by the simplex of Nelder and Mead (1965), with its usual coefficients; returns its place and
/// its value. `scale` is the first step in each direction.
pub fn nelder_mead(
    start: &[f64],
    scale: &[f64],
    steps: usize,
    mut cost: impl FnMut(&[f64]) -> f64,
) -> (Vec<f64>, f64) {
    let mut simplex: Vec<(Vec<f64>, f64)> = Vec::with_capacity(start.len() + 1);
    simplex.push((start.to_vec(), cost(start)));
    for (i, step) in scale.iter().enumerate() {
        let mut corner = start.to_vec();
        corner[i] += step;
        let value = cost(&corner);
        simplex.push((corner, value));
    }
    for _ in 0..steps {
        simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
        improve(&mut simplex, &mut cost);
    }
    simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
    simplex.swap_remove(0)
}

/// One step: reflect the worst corner, and expand, contract or shrink.
fn improve(simplex: &mut [(Vec<f64>, f64)], cost: &mut impl FnMut(&[f64]) -> f64) {
    let last = simplex.len() - 1;
    let (best, second_worst, worst) = (simplex[0].1, simplex[last - 1].1, simplex[last].1);
    let centre: Vec<f64> = (0..last)
        .map(|i| simplex[..last].iter().map(|c| c.0[i]).sum::<f64>() / last as f64)
        .collect();
    let mut along = |factor: f64, simplex: &[(Vec<f64>, f64)]| {
        let corner: Vec<f64> = centre
            .iter()
            .zip(&simplex[last].0)
            .map(|(c, w)| c + factor * (c - w))
            .collect();
        let value = cost(&corner);
        (corner, value)
    };
    let reflected = along(1.0, simplex);
    if reflected.1 < best {
        let expanded = along(2.0, simplex);
        simplex[last] = if expanded.1 < reflected.1 {
            expanded
        } else {
            reflected
        };
        return;
    }
    if reflected.1 < second_worst {
        simplex[last] = reflected;
        return;
    }
    let contracted = along(-0.5, simplex);
    if contracted.1 < worst {
        simplex[last] = contracted;
        return;
    }
    let anchor = simplex[0].0.clone();
    for corner in simplex.iter_mut().skip(1) {
        corner
            .0
            .iter_mut()
            .zip(&anchor)
            .for_each(|(x, a)| *x = 0.5 * (*x + a));
        corner.1 = cost(&corner.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_several_valleys_the_lowest_is_found() {
        let (x, value) = lowest_valley((-4.0, 4.0), 16, 1e-4, |x| (5.0 * x).cos() + 0.1 * x);
        // cos has its minima at odd multiples of π/5; the slope moves them by 0.1/25.
        let bottom = -std::f64::consts::PI - 0.004;
        assert!((x - bottom).abs() < 1e-4, "{x}");
        assert!(
            (value + 1.0 + 0.1 * std::f64::consts::PI).abs() < 1e-3,
            "{value}"
        );
    }

    #[test]
    fn parabolas_find_a_smooth_bottom_in_half_the_evaluations() {
        let mut count = 0;
        let (x, value) = brent((-1.0, 0.0, 4.0), 1e-6, |x| {
            count += 1;
            (x - 1.25).exp() - x
        });
        assert!((x - 1.25).abs() < 3e-6, "{x}");
        assert!((value + 0.25).abs() < 1e-9, "{value}");
        assert!(count <= 16, "{count}");
    }

    #[test]
    fn parabolas_give_way_to_sections_where_nothing_is_smooth() {
        for bottom in [-0.999, 0.0, 0.3, 3.999] {
            let (x, _) = brent((-1.0, 0.1, 4.0), 1e-4, |x| (x - bottom).abs().sqrt());
            assert!((x - bottom).abs() < 1e-2, "{x} for {bottom}");
        }
        let (x, value) = brent((0.0, 0.5, 1.0), 1e-4, |_| f64::INFINITY);
        assert!((0.0..=1.0).contains(&x) && value == f64::INFINITY);
    }

    #[test]
    fn the_simplex_walks_down_the_valley_of_rosenbrock() {
        let (x, value) = nelder_mead(&[-1.2, 1.0], &[0.5, 0.5], 200, |x| {
            (1.0 - x[0]).powi(2) + 100.0 * (x[1] - x[0] * x[0]).powi(2)
        });
        assert!(value < 1e-8 && (x[0] - 1.0).abs() < 1e-3, "{x:?} {value}");
    }
}
