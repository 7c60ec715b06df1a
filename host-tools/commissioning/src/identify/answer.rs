//! The answer for one axis: parameters with intervals, wide enough for structures that explain the
//! recording as well.

use super::judge::{Judge, noise_of};
use super::misfit::{DELAY, Fit, Limit, Response, Structure};
use super::outcome::{AxisActuator, Estimate, Evidence};
use super::track::Track;
use nalgebra::{DMatrix, DVector};
use softdock_statistics::{DEVIATIONS_95, rms};

/// What is needed to write the answer.
pub(super) struct Answer<'a> {
    pub(super) track: &'a Track,
    pub(super) judge: &'a Judge,
    pub(super) fits: &'a [Fit],
    pub(super) chosen: &'a Fit,
}

impl Answer<'_> {
    /// The answer.
    pub(super) fn written(&self, pause: Option<String>) -> AxisActuator {
        let (chosen, structure) = (self.chosen, self.chosen.structure);
        let lag = (structure.response == Response::Lag).then_some(1);
        let servo = structure.response == Response::Servo;
        let limit = structure.limit;
        let limited = |of: &[Limit]| of.contains(&limit).then(|| self.of(structure.limit_at()));
        AxisActuator {
            axis: self.track.axis,
            structure: self.words(),
            delay_s: self.with_rivals(Self::delay_of, self.of(DELAY)),
            lag_s: match lag {
                Some(k) => self.of(k),
                None => self.with_rivals(Self::lag_of, Estimate::exactly(0.0)),
            },
            mean_delay_s: self.mean_delay(),
            servo_hz: servo.then(|| self.of(1)),
            servo_damping: servo.then(|| self.of(2)),
            pause_s: structure.pause.map(|_| self.of(structure.pause_at())),
            pause_form: pause,
            max_acceleration: limited(&[Limit::Planned, Limit::Executed]),
            max_velocity: limited(&[Limit::Velocity]),
            tried_acceleration: self.track.largest_step() / self.track.cycle_s,
            tried_velocity: self.track.fastest(),
            residual_rms: rms(&chosen.left),
            noise_rms: noise_of(chosen),
            rivals: self.rivals(),
            feedback_latency: None,
            evidence: Evidence {
                time_s: (self.track.first..self.track.position.len())
                    .map(|n| n as f64 * self.track.cycle_s)
                    .collect(),
                measured: self.track.position[self.track.first..].to_vec(),
                residual: chosen.left.clone(),
                chain: structure.chain(&chosen.values),
            },
        }
    }

    fn covariance(&self, fit: &Fit) -> DMatrix<f64> {
        fit.covariance(self.judge.variance(fit))
    }

    /// A parameter of the chosen structure.
    fn of(&self, k: usize) -> Estimate {
        let sigma = self.covariance(self.chosen)[(k, k)].sqrt();
        Estimate::around(self.chosen.values[k], DEVIATIONS_95 * sigma).at_least(0.0)
    }

    /// An estimate with an interval that includes those of structures that explain the recording as well: a lag that is not
    /// significant may still exist, and the delay be shorter by it.
    fn with_rivals(&self, of: fn(&Self, &Fit) -> Option<Estimate>, own: Estimate) -> Estimate {
        let others = self
            .fits
            .iter()
            .filter(|f| self.judge.as_good(f, self.chosen));
        let limited = others.filter(|f| f.structure.limit == self.chosen.structure.limit);
        limited
            .filter_map(|f| of(self, f))
            .fold(own, |all, other| all.reaching(&other))
    }

    fn delay_of(&self, fit: &Fit) -> Option<Estimate> {
        // A servo shortens the delay in another way than a lag does: it is no rival of the others.
        let same_kind = self.chosen.structure.response == Response::Servo
            || fit.structure.response != Response::Servo;
        same_kind.then(|| {
            let sigma = self.covariance(fit)[(DELAY, DELAY)].sqrt();
            Estimate::around(fit.values[DELAY], DEVIATIONS_95 * sigma).at_least(0.0)
        })
    }

    fn lag_of(&self, fit: &Fit) -> Option<Estimate> {
        (fit.structure.response == Response::Lag).then(|| {
            let sigma = self.covariance(fit)[(1, 1)].sqrt();
            Estimate::around(fit.values[1], DEVIATIONS_95 * sigma).at_least(0.0)
        })
    }

    /// The combination of delay, lag and servo that is known best: their mean delay.
    fn mean_delay(&self) -> Estimate {
        let fit = self.chosen;
        let mean = |values: &[f64]| match fit.structure.response {
            Response::Direct => values[DELAY],
            Response::Lag => values[DELAY] + values[1],
            Response::Servo => values[DELAY] + mean_of_servo(values[1], values[2]),
        };
        let centre = mean(&fit.values);
        let slope = DVector::from_fn(fit.values.len(), |k, _| {
            let mut moved = fit.values.clone();
            let step = 1e-6 * moved[k].abs().max(1e-6);
            moved[k] += step;
            (mean(&moved) - centre) / step
        });
        let variance = slope.dot(&(self.covariance(fit) * &slope));
        Estimate::around(centre, DEVIATIONS_95 * variance.max(0.0).sqrt()).at_least(0.0)
    }

    fn words(&self) -> String {
        words(&self.chosen.structure)
    }

    /// Other structures that explain the recording as well.
    fn rivals(&self) -> Vec<String> {
        self.fits
            .iter()
            .filter(|f| f.structure.response != self.chosen.structure.response)
            .filter(|f| f.structure.limit == self.chosen.structure.limit)
            .filter(|f| self.judge.as_good(f, self.chosen))
            .map(|f| words(&f.structure))
            .collect()
    }
}

fn words(structure: &Structure) -> String {
    let mut parts = vec!["delay"];
    match structure.limit {
        Limit::Planned => parts.push("acceleration limit"),
        Limit::Velocity => parts.push("velocity limit"),
        Limit::None | Limit::Executed => {}
    }
    match structure.response {
        Response::Direct => {}
        Response::Lag => parts.push("lag"),
        Response::Servo => parts.push("servo"),
    }
    if structure.limit == Limit::Executed {
        parts.push("acceleration limit");
    }
    parts.join(" + ")
}

/// Mean delay of a servo, s: 2ζ/ω.
pub(super) fn mean_of_servo(frequency_hz: f64, damping: f64) -> f64 {
    2.0 * damping / (std::f64::consts::TAU * frequency_hz)
}
