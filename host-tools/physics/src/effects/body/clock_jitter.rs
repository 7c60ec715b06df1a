//! Jitter of the control cycle.

use crate::effects::{Clock, Effect, Group, Law, Naming, Parameter};
use std::collections::BTreeMap;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "clock_jitter",
    title: "Jitter of the cycle",
    summary: "the real instants of the cycles scatter about the nominal ones",
    group: Group::Body,
    naming: Naming::Cause,
    equation: "t_n = n step + jitter_s x_n; of_intervals: t_n = t_(n-1) + step + jitter_s x_n; x_n: independent standard \
               normal",
    source: "textbook (sampling jitter); real-time behaviour of controllers",
    signature: "increments of the pose scatter in proportion to the velocity, and not at standstill",
    typical: "0.01 to 1 ms on a computer without real-time kernel",
    parameters: &[
        Parameter::new("jitter_s", "s", 0.0, 0.02)
            .hidden(1.5e-4, 4e-4)
            .pictured(0.0004),
        OF_INTERVALS,
    ],
    confused_with: &["clock_rate", "clock_offset", "ft_dropout"],
    tell_apart: "jog at two constant speeds: the scatter of the pose increments grows with speed, noise of the \
                 measurement does not",
    law: Law::Clock(Clock::Scatter(|p, draw| p[0] * draw)),
    ..Effect::PLAIN
};

/// Whether the durations of the cycles scatter independently (the instants are then their sum), or the instants do.
const OF_INTERVALS: Parameter =
    Parameter::choice("of_intervals", &["of the instants", "of the durations"]);

/// How the instants of a log scatter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// Standard deviation of the instants, s, or of the durations of the cycles if `of_intervals`.
    pub jitter_s: f64,
    /// The durations of the cycles scatter independently, not the instants.
    pub of_intervals: bool,
}

impl Scatter {
    /// From the parameters of a model file; `None` without a jitter.
    pub fn of(parameters: &BTreeMap<String, f64>) -> Option<Self> {
        let given = |name: &str| parameters.get(name).copied().unwrap_or(0.0);
        let jitter_s = given("jitter_s");
        (jitter_s > 0.0).then(|| Self {
            jitter_s,
            of_intervals: given(OF_INTERVALS.name) > 0.5,
        })
    }

    /// The same as parameters.
    pub fn parameters(&self) -> BTreeMap<String, f64> {
        let of_intervals = f64::from(u8::from(self.of_intervals));
        let all = [
            ("jitter_s", self.jitter_s),
            (OF_INTERVALS.name, of_intervals),
        ];
        all.map(|(name, value)| (name.to_owned(), value)).into()
    }

    /// From the standard deviation of the durations, s.
    pub fn of_durations(duration_s: f64, of_intervals: bool) -> Self {
        // A duration is the difference of two independent instants, so its standard deviation is √2 times theirs.
        let instants_s = duration_s * std::f64::consts::FRAC_1_SQRT_2;
        Self {
            jitter_s: if of_intervals { duration_s } else { instants_s },
            of_intervals,
        }
    }

    /// Standard deviation of the duration of a cycle, s.
    pub fn duration_s(&self) -> f64 {
        match self.of_intervals {
            true => self.jitter_s,
            false => std::f64::consts::SQRT_2 * self.jitter_s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_scatter_more_than_the_instants_between_them() {
        for of_intervals in [false, true] {
            let scatter = Scatter::of_durations(2e-4, of_intervals);
            assert!((scatter.duration_s() - 2e-4).abs() < 1e-12);
            assert_eq!(Scatter::of(&scatter.parameters()), Some(scatter));
        }
        assert!(Scatter::of_durations(2e-4, false).jitter_s < 1.5e-4);
    }

    #[test]
    fn an_instant_scatters_by_its_deviation() {
        let Law::Clock(Clock::Scatter(law)) = EFFECT.law else {
            panic!("a scatter");
        };
        let instants = [-1.0, 0.0, 2.0].map(|x| 4.0 + law(&[0.25, 0.0], x));
        assert_eq!(instants, [3.75, 4.0, 4.5]);
    }
}
