//! How well a model foretells: the reading at each measured instant, and a whole motion in free-run simulation.

use super::for_prediction::Errors;
use crate::compare::free_simulation::{RUN_OFF, simulate};
use crate::diagnose::evidence::{DRIVES_AWAY, FORETELLS, MOVES, RISES, RUNS_OFF, STAYS};
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use softdock_physics::model::prediction::signals::Signals;
use std::cell::OnceCell;

/// A model with its errors on logs.
pub(crate) struct Foresight<'a> {
    model: &'a Model,
    errors: Errors,
    unseen: &'a [&'a Recording],
    /// Result of [`Self::simulated`], once it was asked for.
    simulated: OnceCell<Option<f64>>,
}

impl<'a> Foresight<'a> {
    /// From a model and its errors at each instant; `unseen` are the logs on which it may be simulated.
    pub(crate) const fn new(model: &'a Model, errors: Errors, unseen: &'a [&'a Recording]) -> Self {
        Self {
            model,
            errors,
            unseen,
            simulated: OnceCell::new(),
        }
    }

    /// Error on unseen data at each instant.
    pub(crate) const fn unseen(&self) -> f64 {
        self.errors.unseen
    }

    /// Whether it is better: its simulated motion is ([`Self::moves_better_than`]), or, where neither motion is, its error at
    /// each instant.
    pub(crate) fn is_better_than(&self, other: &Self) -> bool {
        self.moves_better_than(other)
            || (self.foretells_better_than(other) && !other.moves_better_than(self))
    }

    /// Whether it foretells each instant of unseen data better, and explains the logs of the fit not much worse.
    pub(crate) fn foretells_better_than(&self, other: &Self) -> bool {
        let [own, others] = [self, other].map(|one| &one.errors);
        own.unseen * RISES < others.unseen && own.of_fit < FORETELLS * others.of_fit
    }

    /// Whether its simulated motion is better: off by less than the motion itself, and by less than [`MOVES`] of the other one's
    /// error (squared), while neither error at each instant is much larger. At a measured instant a spring that acts late equals
    /// a damper; in a simulated motion it does not.
    pub(crate) fn moves_better_than(&self, other: &Self) -> bool {
        let is_less = |own: f64| {
            other
                .off_by()
                .is_some_and(|other| own.powi(2) < MOVES * other.powi(2))
        };
        let moves = || self.off_by().is_some_and(|own| own < 1.0 && is_less(own));
        self.is_as_good_as(other, FORETELLS) && moves()
    }

    /// Whether the simulated motion of the other one [runs off](RUNS_OFF), its own is [closer](STAYS), and its error at each instant
    /// is hardly larger. A controller that makes the command from the position looks like a force by position, of the sign that
    /// drives away what is there.
    pub(crate) fn stays_where_runs_off(&self, other: &Self) -> bool {
        let stays = |own: f64, other: f64| other > RUNS_OFF && own * STAYS < other;
        let is_closer = || Some(stays(self.off_by()?, other.off_by()?));
        self.is_as_good_as(other, DRIVES_AWAY) && is_closer() == Some(true)
    }

    /// Whether neither error at each instant is larger than the other one's by this factor.
    fn is_as_good_as(&self, other: &Self, factor: f64) -> bool {
        let [own, others] = [self, other].map(|one| &one.errors);
        own.unseen < factor * others.unseen && own.of_fit < factor * others.of_fit
    }

    /// See [`off_by`].
    pub(crate) fn off_by(&self) -> Option<f64> {
        *self
            .simulated
            .get_or_init(|| off_by(self.model, self.unseen))
    }
}

/// Rms error of the simulated motion on some logs, relative to the rms motion. [`RUN_OFF`] if a simulation runs away; `None` if no
/// recorded force drives a single axis, or an effect cannot be simulated.
pub(crate) fn off_by(model: &Model, recordings: &[&Recording]) -> Option<f64> {
    let square = |recording: &&Recording| {
        let signals = Signals::new(recording).ok()?;
        match simulate(model, &signals)? {
            Ok(free) => Some(free.relative.powi(2)),
            Err(none) => none.runs_away.then_some(RUN_OFF.powi(2)),
        }
    };
    let each: Option<Vec<f64>> = recordings.iter().map(square).collect();
    let each = each.filter(|each| !each.is_empty())?;
    Some((each.iter().sum::<f64>() / each.len() as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_app::record::CycleRecord;

    /// A cart of 2 kg on a spring of 1000 N/m with a damper of 20 N·s/m, driven near its resonance.
    fn cart() -> Recording {
        let cycle = |n: usize| {
            let t = 0.005 * n as f64;
            let [mut x, mut v, mut a] = [0.0; 3];
            for (size, rate) in [(0.004, 22.0_f64), (0.003, 5.0)] {
                x += size * (rate * t).sin();
                v += size * rate * (rate * t).cos();
                a -= size * rate.powi(2) * (rate * t).sin();
            }
            let mut cycle = CycleRecord::default();
            (cycle.trace.cycle, cycle.trace.time_s) = (n as u64, t);
            cycle.trace.pose = [x, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
            cycle.trace.executed_velocity[0] = v;
            cycle.inputs.sensor.wrench = [0.0; 6];
            cycle.inputs.sensor.wrench[0] = -(2.0 * a + 20.0 * v + 1000.0 * x);
            cycle
        };
        Recording {
            cycles: (0..2000).map(cycle).collect(),
            ..Recording::default()
        }
    }

    fn model(effect: &str) -> Model {
        let text = format!(
            "[rig]\nactive_axes = [\"x\"]\n[tool]\nmass_kg = 2.0\ndynamic_compensation = true\n\
             [sensor]\nwrench = \"commanded\"\ngravity_m_s2 = [0.0, 0.0, 0.0]\n\
             [[effect]]\nid = \"cable_stiffness\"\nparameters = {{ stiffness_n_per_m = 1000.0 }}\n\
             [[effect]]\n{effect}"
        );
        Model::from_toml(&text, "model.toml").unwrap()
    }

    /// At each instant the delay may even leave a little less.
    #[test]
    fn a_delay_is_no_damper_of_a_motion() {
        let log = cart();
        let unseen = [&log];
        let [damped, late] = [
            model("id = \"guide_viscous\"\nparameters = { damping_n_s_per_m = 20.0 }"),
            model("id = \"actuation_delay\"\nparameters = { extra_delay_s = 0.02 }"),
        ];
        let of = |model, unseen_error| {
            let errors = Errors {
                of_fit: 1.0,
                unseen: unseen_error,
            };
            Foresight::new(model, errors, &unseen)
        };
        let answer = of(&late, 1.0);
        assert!(of(&damped, 1.05).is_better_than(&answer));
        assert!(!answer.is_better_than(&of(&damped, 1.05)));
        assert!(answer.is_better_than(&of(&damped, 1.2)), "too much worse");
        assert!(
            of(&late, 0.95).is_better_than(&answer),
            "of equals the better"
        );
    }
}
