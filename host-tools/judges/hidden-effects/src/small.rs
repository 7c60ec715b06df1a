//! The size factor at which an effect leaves a wanted small share of the noise.

/// Largest number of corrections of the factor; each takes two simulations.
const STEPS: usize = 6;
/// Accepted relative error of the share.
const CLOSE: f64 = 0.1;
/// Smallest factor: below it, rounding dominates.
const LEAST: f64 = 1e-3;

/// Factor f with `excess(f)` within a tenth of `wanted`, or as close as [`STEPS`] corrections come. The excess is about
/// proportional to the factor, so the factor is corrected by their ratio.
pub(crate) fn factor(wanted: f64, excess: impl Fn(f64) -> f64) -> f64 {
    let mut factor = wanted;
    for _ in 0..STEPS {
        let ratio = wanted / excess(factor).max(1e-3);
        if (ratio - 1.0).abs() < CLOSE {
            break;
        }
        factor = (factor * ratio.clamp(0.1, 10.0)).max(LEAST);
    }
    factor
}

#[cfg(test)]
mod tests {
    use super::factor;

    #[test]
    fn the_factor_is_found_where_the_excess_is_a_power_of_it() {
        for power in [0.5, 1.0, 1.5] {
            let excess = |f: f64| 4.0 * f.powf(power);
            let found = excess(factor(0.2, excess));
            assert!((found / 0.2 - 1.0).abs() < 0.11, "{power}: {found}");
        }
    }
}
