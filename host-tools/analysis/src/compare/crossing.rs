//! Changes of sign of a noisy signal.

use std::ops::Range;

/// Each change of sign: from the last value beyond `still` on one side to the first on the other.
pub(super) fn sign_changes(values: &[f64], still: f64) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut last: Option<(usize, bool)> = None;
    for (n, value) in values.iter().enumerate() {
        if value.is_nan() || value.abs() <= still {
            continue;
        }
        let positive = *value > 0.0;
        if let Some((from, was_positive)) = last
            && was_positive != positive
        {
            found.push(from..n + 1);
        }
        last = Some((n, positive));
    }
    found
}

/// Each change of sign, from the first value that is no longer on the old side. Errors of a reversal, such as a pause, begin
/// there.
pub(super) fn after_sign_changes(values: &[f64], still: f64) -> Vec<Range<usize>> {
    sign_changes(values, still)
        .into_iter()
        .map(|change| {
            let old_side = values[change.start];
            let left = change.clone().find(|n| values[*n] * old_side <= 0.0);
            left.unwrap_or(change.start)..change.end
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_about_zero_is_no_crossing() {
        let values = [
            3.0,
            1.0,
            0.1,
            -0.1,
            0.1,
            -0.1,
            -2.0,
            -0.1,
            -3.0,
            0.2,
            -1.0,
            f64::NAN,
            2.0,
        ];
        assert_eq!(sign_changes(&values, 0.5), vec![1..7, 10..13]);
    }

    #[test]
    fn what_follows_begins_where_the_old_side_is_left() {
        let values = [3.0, 1.0, 0.4, -0.1, 0.0, 0.1, -2.0, -3.0];
        assert_eq!(sign_changes(&values, 0.5), vec![1..7]);
        assert_eq!(after_sign_changes(&values, 0.5), vec![3..7]);
    }
}
