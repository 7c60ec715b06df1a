//! The search on the reading, with the motion that the sensor felt: the measured or the simulated one.

use super::finding::WrenchFinding;
use super::sampling::Sampling;
use super::search;
use super::{Ask, Joint, Memo, PreparedLog, SearchResult, exchanged, scene};
use crate::diagnose::actuator::{self, ActuatorFinding, Cost, Term};
use crate::diagnose::catalogue::is_general_curve;
use crate::diagnose::evidence::NAMED;
use crate::diagnose::logs::Logs;
use crate::diagnose::noise::structure::LEVEL;
use crate::diagnose::question::Question;
use rayon::prelude::*;
use softdock_physics::effects::by_id;
use softdock_physics::model::Model;
use softdock_physics::model::log::Log;
use std::sync::Arc;

/// The simulated motion is trusted if the rms residual of the velocity is below this many times the noise. Its misfit is then
/// three quarters of the noise that a measured velocity would bring into the load.
const TRUSTED: f64 = 1.25;

/// The motion of the tool, as the search on the reading needs it.
pub(crate) struct Motion<'a> {
    pub(crate) logs: &'a Logs<Log>,
    pub(crate) cost: &'a Cost<'a>,
    pub(crate) intervals: &'a Logs<Vec<f64>>,
    pub(crate) actuator: Option<&'a ActuatorFinding>,
    /// Fits that earlier searches have computed.
    pub(crate) memo: Arc<Memo>,
}

impl Motion<'_> {
    /// The logs with the load on their sensor. The motion is the simulated one if its misfit is below [`TRUSTED`], and the
    /// measured one from [`LEVEL`] on. Between the two it is the one whose load leaves less noise in the reading: the error of a
    /// motion, differentiated and multiplied by the mass of the tool, appears there as noise.
    fn prepared_logs(&self, model: &Model, sampling: &mut Logs<Sampling>) -> Vec<PreparedLog> {
        let terms: &[Term] = self.actuator.map_or(&[], |a| a.search.terms());
        let mut with = |simulated: bool| -> Vec<PreparedLog> {
            let each = self.logs.all.par_iter().zip(&self.intervals.all);
            let each = each.zip(&mut sampling.all);
            let prepared = each.map(|((log, intervals), sampling)| {
                let scene = scene(model, log, self.cost, terms, simulated, intervals);
                PreparedLog::new(model, log, scene, sampling)
            });
            prepared.collect()
        };
        let Some(actuator) = self.actuator else {
            return with(false);
        };
        let misfit = actuator::level(actuator.search.reached(), self.cost);
        if misfit < TRUSTED {
            return with(true);
        }
        let measured = with(false);
        if misfit >= LEVEL {
            return measured;
        }
        let simulated = with(true);
        match noise_likelihood(&simulated) > noise_likelihood(&measured) + NAMED {
            true => simulated,
            false => measured,
        }
    }
}

/// 2 ln of the likelihood of the readings, of which only the noise level differs: −2 ln σ for each row and recorded axis.
fn noise_likelihood(logs: &[PreparedLog]) -> f64 {
    let of_log = |log: &PreparedLog| {
        let rows = log.fresh.iter().filter(|fresh| **fresh).count() as f64;
        let axes = log.noise_model.iter().zip(&log.residual.0);
        let recorded = axes.filter(|(_, residual)| !residual.is_empty());
        let of_axis = recorded.map(|(noise, _)| -2.0 * noise.sigma.ln());
        rows * of_axis.sum::<f64>()
    };
    logs.iter().map(of_log).sum()
}

/// Searches the reading. `None` where a log has no reading, or the load of all logs is one constant and the user asks for no
/// effect.
pub(crate) fn wrench_stage(
    model: &Model,
    motion: &Motion<'_>,
    sampling: &mut Logs<Sampling>,
    question: &Question<'_>,
) -> Option<WrenchFinding> {
    let logs = motion.logs;
    let measured = |log: &Log| log.measured().contains(&true);
    let tells = question.is_asked() || !logs.have_one_load();
    if !tells || !logs.all.iter().all(measured) {
        return None;
    }
    let mut prepared = Joint::new(
        motion.prepared_logs(model, sampling),
        logs.fitted,
        &motion.memo,
    );
    if let Some(smooth) = question.beside {
        prepared.add_remainder(smooth);
    }
    let placed = question.is_asked() || !logs.have_own_origins();
    let turns = model.bearing().is_some();
    let by_position = |id: &str| by_id(id).is_some_and(|effect| effect.acts_by_position(turns));
    let acts_anywhere = |id: &str| placed || !by_position(id);
    let excluded = |id: &str| {
        let is_tried = question.tries(model, id) && acts_anywhere(id);
        !is_tried || (is_general_curve(id) && !question.tries_general_curves())
    };
    let is_whole = question.among.is_none() && question.only.is_none();
    let tell_amounts = prepared.logs.iter().all(|log| log.scene.tells_amounts());
    let ask = Ask {
        excluded: &excluded,
        forced: question.forced,
        each_log: is_whole && tell_amounts && question.beside.is_none() && !question.of_one_log,
        watch: question.watch,
    };
    let mut found = match question.in_place_of {
        Some(answer) => SearchResult {
            ranked: exchanged(&prepared, answer, &ask),
            ..SearchResult::default()
        },
        None => search(&mut prepared, &ask),
    };
    if let Some(smooth) = question.beside {
        prepared.remove_remainder(smooth);
        found.accepted = found.accepted.map(|accepted| prepared.valued(accepted));
    }
    Some(WrenchFinding {
        found,
        prepared,
        beside: question.beside.cloned(),
        earlier: (Vec::new(), Vec::new()),
        beside_remainder: None,
    })
}
