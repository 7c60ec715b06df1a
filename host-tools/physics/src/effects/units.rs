//! Units as products of metre, second and newton.

/// Exponents of metre, second and newton.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Dimension([i32; 3]);

impl Dimension {
    /// Dimension of a unit such as `N·s/m^2`; `None` if the unit is not known.
    pub(super) fn of(unit: &str) -> Option<Self> {
        let mut sum = [0; 3];
        for (place, part) in unit.split('/').enumerate() {
            let sign = if place == 0 { 1 } else { -1 };
            for factor in part.split(['·', '*', ' ']).filter(|f| !f.is_empty()) {
                let (name, power) = factor.split_once('^').unwrap_or((factor, "1"));
                let power: i32 = power.parse().ok()?;
                let of = match name {
                    "m" => [1, 0, 0],
                    "s" => [0, 1, 0],
                    "N" => [0, 0, 1],
                    "kg" => [-1, 2, 1],
                    "Hz" => [0, -1, 0],
                    "-" | "1" | "rad" => [0, 0, 0],
                    _ => return None,
                };
                for (sum, of) in sum.iter_mut().zip(of) {
                    *sum += sign * power * of;
                }
            }
        }
        Some(Self(sum))
    }

    /// Factor by which a quantity changes when the base units are scaled.
    pub(super) fn factor(self, scale: [f64; 3]) -> f64 {
        let factors = scale.iter().zip(self.0);
        factors.map(|(scale, power)| scale.powi(power)).product()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_products() {
        assert_eq!(Dimension::of("N·s/m"), Some(Dimension([-1, 1, 1])));
        assert_eq!(Dimension::of("kg·m/s^2"), Dimension::of("N"));
        assert_eq!(Dimension::of("1/m"), Some(Dimension([-1, 0, 0])));
        assert_eq!(Dimension::of("lbf"), None);
    }
}
