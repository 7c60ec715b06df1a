//! Minimisation without derivatives, for costs that are not smooth everywhere.

/// Ratio of the golden section.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Minimum of `cost` in `low..high` by golden sections; `steps` evaluations after two.
pub(crate) fn golden(low: f64, high: f64, steps: usize, mut cost: impl FnMut(f64) -> f64) -> f64 {
    let (mut a, mut b) = (low, high);
    let mut left = b - GOLDEN * (b - a);
    let mut right = a + GOLDEN * (b - a);
    let (mut at_left, mut at_right) = (cost(left), cost(right));
    for _ in 0..steps {
        if at_left < at_right {
            b = right;
            (right, at_right) = (left, at_left);
            left = b - GOLDEN * (b - a);
            at_left = cost(left);
        } else {
            a = left;
            (left, at_left) = (right, at_right);
            right = a + GOLDEN * (b - a);
            at_right = cost(right);
        }
    }
    if at_left < at_right { left } else { right }
}

/// Minimum of `cost` near `start` by the simplex of Nelder and Mead (1965), with its usual
/// coefficients; `scale` is the first step in each direction.
pub(crate) fn nelder_mead(
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
    fn golden_finds_the_bottom_of_a_parabola() {
        let x = golden(-1.0, 4.0, 40, |x| (x - 1.25).powi(2));
        assert!((x - 1.25).abs() < 1e-6, "{x}");
    }

    #[test]
    fn the_simplex_walks_down_the_valley_of_rosenbrock() {
        let (x, value) = nelder_mead(&[-1.2, 1.0], &[0.5, 0.5], 200, |x| {
            (1.0 - x[0]).powi(2) + 100.0 * (x[1] - x[0] * x[0]).powi(2)
        });
        assert!(value < 1e-8 && (x[0] - 1.0).abs() < 1e-3, "{x:?} {value}");
    }
}
