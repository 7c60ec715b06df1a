//! Note on a filter and a shift in time that counteract each other: together they smooth what is predicted from the motion.

use super::notes::Answer;
use softdock_physics::effects::Law;
use softdock_report::number;

/// A named effect by the time that it takes, s.
struct InTime<'a> {
    id: &'a str,
    seconds: f64,
}

impl Answer<'_> {
    /// Note that a reading is named as filtered, and the clocks as apart by about the filter's delay. A wrench that is predicted from
    /// differentiated positions has their noise, of which such a pair takes a part away without any delay.
    pub(super) fn smooths(&self) -> Option<String> {
        let (filter, shift) = (self.in_time(lag_s)?, self.in_time(offset_s)?);
        counteract(filter.seconds, shift.seconds).then(|| {
            let ms = |of: &InTime<'_>| number::significant(1e3 * of.seconds, 2);
            format!(
                "{} delays the reading by {} ms, and {} shifts it back by {} ms: noise of a differentiated motion can produce such a pair, \
                 which smooths the prediction. See whether both go with a smaller `cutoff_hz` in the [filter] of an import.",
                filter.id,
                ms(&filter),
                shift.id,
                ms(&shift),
            )
        })
    }

    /// The named effect whose law takes time, by `of`.
    fn in_time(&self, of: impl Fn(&Law, &[f64]) -> Option<f64>) -> Option<InTime<'_>> {
        let mut named = self.reduction.named.iter();
        named.find_map(|(named, _)| {
            let effect = self.model.effect(&named.effect.id).ok()?;
            let seconds = of(&effect.law, &effect.values(&named.effect.parameters))?;
            Some(InTime {
                id: &named.effect.id,
                seconds,
            })
        })
    }
}

/// Time constant of a reading that is filtered.
fn lag_s(law: &Law, values: &[f64]) -> Option<f64> {
    match law {
        Law::ReadingDelay(law) => Some(law(values).lag_s).filter(|lag_s| *lag_s > 0.0),
        _ => None,
    }
}

/// Time by which the poses are late.
fn offset_s(law: &Law, values: &[f64]) -> Option<f64> {
    match law {
        Law::ClockOffset(law) => Some(law(values)),
        _ => None,
    }
}

/// Whether a shift takes back between half and one and a half of the delay of a filter.
fn counteract(lag_s: f64, offset_s: f64) -> bool {
    (lag_s - offset_s).abs() < 0.5 * lag_s
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shift_counteracts_a_filter_that_it_nearly_undoes() {
        for (lag_s, offset_s, expected) in [
            (0.077, 0.065, true),
            (0.077, 0.1, true),
            (0.077, 0.03, false),
            (0.077, -0.065, false),
            (0.077, 0.12, false),
        ] {
            assert_eq!(counteract(lag_s, offset_s), expected, "{offset_s}");
        }
    }
}
