//! The results of the stages for one assumption about the clock.

use crate::diagnose::actuator::{ActuatorFinding, Cost, actuator_stage};
use crate::diagnose::clock::timed_logs::TimedLogs;
use crate::diagnose::clock::{self, CommonDelay, PoseScatter};
use crate::diagnose::finding::NoiseFloor;
use crate::diagnose::logs::Logs;
use crate::diagnose::question::Question;
use crate::diagnose::wrench::beside::Asking;
use crate::diagnose::wrench::felt_motion::{Motion, wrench_stage};
use crate::diagnose::wrench::finding::WrenchFinding;
use crate::diagnose::wrench::rounds::wrench_rounds;
use crate::diagnose::wrench::sampling::Sampling;
use crate::diagnose::wrench::{NominalEstimate, sheet_sigma};
use softdock_physics::model::{Axis, Channel, Model};
use std::sync::Arc;

/// Results for one assumption about the clock of the logs.
pub(crate) struct StageResults {
    /// The logs, read with this clock.
    pub timed: TimedLogs,
    /// The actuator; `None` where nothing was commanded.
    pub actuator: Option<ActuatorFinding>,
    /// Scatter of the instants of the poses that is left in each log; all 0 in logs whose velocity was measured.
    pub scatter: Vec<PoseScatter>,
    /// A common delay of all velocities; None where nothing speaks for it.
    pub common_delay: Option<CommonDelay>,
    /// A common factor of all velocities, less 1, and its standard deviation.
    pub proportion: (f64, f64),
    /// Sampling of the sensor.
    pub sampling: Logs<Sampling>,
    /// The effects on the reading; `None` where there is none to search.
    pub wrench: Option<WrenchFinding>,
    /// Noise floors on the first log.
    pub noise: Vec<NoiseFloor>,
    /// Nominal parameters beside the effects on the reading.
    pub nominal: Vec<NominalEstimate>,
}

/// Reports a search. As the number of searches is not known, the share that is done approaches 0.9 more and more slowly.
fn tell_search(number: i32, progress: &dyn Fn(f64, &str)) {
    let share = 0.9 - 0.4 * 0.9_f64.powi(number - 1);
    progress(share, &format!("explaining the wrench, search {number}"));
}

impl StageResults {
    /// Searches for effects of the actuator and on the reading.
    pub(crate) fn of(
        timed: TimedLogs,
        question: &Question<'_>,
        progress: &dyn Fn(f64, &str),
    ) -> Self {
        let (model, logs, intervals) = (&timed.model, &timed.logs, &timed.intervals);
        progress(0.15, "simulating actuators");
        let mut cost = Cost::new(model, &logs.all, &intervals.all);
        let jitters = timed.clock.jitter.is_some();
        let actuator = actuator_stage(model, logs, &mut cost, jitters, question);
        let terms = actuator.as_ref().map_or(&[][..], |a| a.search.terms());
        let of_log = |log| clock::scatter(&cost, log, terms);
        let scatter = cost.logs.iter().map(of_log).collect();
        let mut sampling = logs.map(|log| Sampling::of(log, model));
        let plain = timed.without_offset();
        let moved = match &timed.aligned {
            // The tool moves as the actuator really moves it, and not as late poses show it.
            Some(aligned) => Cost::new(&plain, &aligned.all, &intervals.all),
            None => cost.clone(),
        };
        let motion = Motion {
            logs: timed.aligned(),
            cost: &moved,
            intervals,
            actuator: actuator.as_ref(),
            memo: Arc::default(),
        };
        let mut searches = 0;
        let mut search = |model: &Model, question: &Question<'_>| {
            searches += 1;
            tell_search(searches, progress);
            wrench_stage(model, &motion, &mut sampling, question)
        };
        let mut wrench = wrench_rounds(&mut Asking {
            model,
            question,
            search: &mut search,
        });
        let nominal = wrench.as_mut().map_or(Vec::new(), WrenchFinding::nominal);
        Self {
            actuator,
            scatter,
            common_delay: clock::common_delay(&cost),
            proportion: clock::proportion(&cost),
            sampling,
            noise: noise_floors(model, &cost, wrench.as_ref()),
            wrench,
            nominal,
            timed,
        }
    }
}

fn noise_floors(model: &Model, cost: &Cost<'_>, wrench: Option<&WrenchFinding>) -> Vec<NoiseFloor> {
    let mut all = Vec::new();
    let first = cost.logs.iter().take(1);
    for log in first {
        let moving = Axis::ALL.into_iter().filter(|a| cost.active[a.index()]);
        all.extend(moving.map(|axis| NoiseFloor {
            channel: Channel::ExecutedVelocity,
            axis,
            measured: log.sigma[axis.index()],
            data_sheet: log.sheet_sigma[axis.index()],
        }));
    }
    let sheet = sheet_sigma(model);
    for log in wrench.iter().flat_map(|found| found.prepared.logs.first()) {
        let recorded = |axis: &Axis| !log.residual.0[axis.index()].is_empty();
        let axes = Axis::ALL.into_iter().filter(recorded);
        all.extend(axes.map(|axis| NoiseFloor {
            channel: Channel::Wrench,
            axis,
            measured: log.noise_model[axis.index()].level,
            data_sheet: sheet[axis.index()],
        }));
    }
    all
}
