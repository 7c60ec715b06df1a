//! p-values: probabilities of a statistic at least as large by chance.

use statrs::function::{beta, erf, gamma};

/// Standard deviations on either side of the mean that contain 95 % of a normal variable.
pub const DEVIATIONS_95: f64 = 1.959_963_984_540_054;

/// p-value of a chi-square variable with `freedom` degrees of freedom; 1 where it is not defined.
pub fn chi_square_p(statistic: f64, freedom: f64) -> f64 {
    if statistic.is_infinite() && statistic > 0.0 {
        return 0.0;
    }
    defined(gamma::checked_gamma_ur(0.5 * freedom, 0.5 * statistic).ok())
}

/// p-value of an F variable with these degrees of freedom; 1 where it is not defined.
///
/// `P(F > f) = I(d₂ / (d₂ + d₁ f); d₂/2, d₁/2)`.
pub fn f_p(statistic: f64, numerator: f64, denominator: f64) -> f64 {
    if statistic.is_infinite() && statistic > 0.0 {
        return 0.0;
    }
    let x = denominator / (denominator + numerator * statistic);
    defined(beta::checked_beta_reg(0.5 * denominator, 0.5 * numerator, x).ok())
}

/// Two-sided p-value of a standard normal variable.
pub fn normal_p(z: f64) -> f64 {
    erf::erfc(z.abs() / std::f64::consts::SQRT_2)
}

/// A p-value that cannot be computed counts as no evidence: 1.
fn defined(p: Option<f64>) -> f64 {
    p.filter(|p| p.is_finite()).unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_of_textbooks_are_met() {
        // 1 % points: chi-square(25), F(5, 100), normal.
        assert!((chi_square_p(44.314, 25.0) - 0.01).abs() < 1e-5);
        assert!((f_p(3.2059, 5.0, 100.0) - 0.01).abs() < 1e-5);
        assert!((normal_p(2.575_829) - 0.01).abs() < 1e-6);
    }

    #[test]
    fn what_is_not_defined_is_no_evidence() {
        for value in [f64::NAN, -1.0] {
            assert_eq!(chi_square_p(value, 3.0), 1.0);
            assert_eq!(f_p(value, 3.0, f64::NAN), 1.0);
        }
        assert_eq!(f_p(1.0, 0.0, 10.0), 1.0);
        assert_eq!(f_p(f64::INFINITY, 2.0, 10.0), 0.0);
        assert_eq!(chi_square_p(f64::INFINITY, 2.0), 0.0);
    }
}
