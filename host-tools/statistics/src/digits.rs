//! Decimal resolution to which numbers were rounded.

/// Largest power of ten, from 1000 to 1e-9, of which all values are multiples; 1e-10 if there is none.
pub fn digit_of(values: &[f64]) -> f64 {
    let is_multiple = |value: f64, digit: f64| {
        let cells = (value / digit).round();
        (value / digit - cells).abs() < 1e-4 && (cells != 0.0 || value == 0.0)
    };
    (-3..=9)
        .map(|digits| 10.0_f64.powi(-digits))
        .find(|digit| values.iter().all(|v| is_multiple(*v, *digit)))
        .unwrap_or(1e-10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_values_have_small_digits() {
        assert_eq!(digit_of(&[0.0, 0.02, 0.0301]), 1e-4);
        assert_eq!(digit_of(&[2.0e-5, 3.1e-5]), 1e-6);
        assert_eq!(digit_of(&[1.0 / 3.0]), 1e-10);
    }
}
