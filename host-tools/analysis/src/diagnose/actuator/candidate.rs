//! A hypothesis of the search over stages of the actuator, and what the search found.

use super::cost::{Cost, Term};
use crate::diagnose::evidence::{self, Support};
use crate::diagnose::finding::Trial;
use softdock_physics::model::Channel;
use softdock_physics::model::stage::Stage;

/// Ratio of rms residual to noise below which nothing is left to explain.
pub(super) const AT_NOISE: f64 = 1.03;

/// A hypothesis with its best parameters.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    /// Its stages with their values.
    pub terms: Vec<Term>,
    /// χ² over all logs.
    pub chi2: f64,
    /// χ² of each log.
    pub each: Vec<f64>,
}

impl Candidate {
    /// With these terms.
    pub(super) fn new(terms: Vec<Term>, cost: &Cost<'_>) -> Self {
        Self {
            chi2: cost.of(&terms),
            each: cost.of_each(&terms),
            terms,
        }
    }

    /// Number of parameters.
    pub(crate) fn parameters(&self) -> usize {
        self.terms.iter().map(|t| t.values.len()).sum()
    }

    pub(super) fn trial(&self, nominal: &Self) -> Trial {
        Trial {
            effects: self.ids().into_iter().map(str::to_owned).collect(),
            channel: Channel::ExecutedVelocity,
            gain: nominal.chi2 - self.chi2,
        }
    }

    /// Ids of its effects, each once.
    pub(crate) fn ids(&self) -> Vec<&'static str> {
        let mut ids: Vec<&str> = self.terms.iter().map(|t| t.stage.id()).collect();
        ids.sort_unstable();
        ids.dedup();
        ids
    }

    /// Number of its effects; the gains of what lies beyond a dead zone belong to the zone.
    pub(super) fn causes(&self) -> usize {
        let of_zone = |term: &&Term| self.has(Stage::DeadZone) && is_a_gain(term.stage);
        let own = self.terms.iter().filter(|term| !of_zone(term));
        let own = Self {
            terms: own.cloned().collect(),
            ..self.clone()
        };
        own.ids().len()
    }

    /// Whether it has this stage.
    pub(super) fn has(&self, stage: Stage) -> bool {
        self.terms.iter().any(|term| term.stage == stage)
    }

    /// χ² with the price of the parameters and the prior odds of the effects.
    pub(super) fn priced(&self, cost: &Cost<'_>) -> f64 {
        let price = evidence::price(cost.count());
        self.chi2 + price * self.parameters() as f64 + evidence::prior() * self.ids().len() as f64
    }
}

/// Result of the search.
#[derive(Clone, Debug)]
pub(crate) struct Search {
    /// The nominal actuator.
    pub nominal: Candidate,
    /// Stages alone, best first.
    pub singles: Vec<Candidate>,
    /// The accepted hypothesis, if any. Its parameters are those of the logs of the fit.
    pub accepted: Option<Candidate>,
    /// Id of each accepted effect, and its support.
    pub support: Vec<(&'static str, Support)>,
    /// The accepted terms fitted to each log alone, if the logs disagree about them. One entry per log.
    pub apart: Option<Vec<Vec<Term>>>,
    /// Other forms of the accepted effects that explain the logs as well.
    pub equal_forms: Vec<Candidate>,
}

impl Search {
    /// Lowers the noise of the logs to what the best hypotheses leave. Returns whether it was higher before.
    pub(crate) fn quieten(&self, cost: &mut Cost<'_>) -> bool {
        /// Single stages whose residual is considered.
        const BEST: usize = 3;
        let accepted = self.accepted.iter();
        let best = accepted.chain(self.singles.iter().take(BEST));
        cost.quieten(best.map(|c| &c.terms[..]))
    }

    /// The largest evidence of any stage alone; `None` if none can be a cause.
    pub(crate) fn strongest(&self, cost: &Cost<'_>) -> Option<f64> {
        let nominal = self.nominal.priced(cost);
        let causes = self.singles.iter().filter(|c| is_a_cause(c, cost));
        causes
            .map(|c| nominal - c.priced(cost))
            .max_by(f64::total_cmp)
    }

    /// The accepted terms; empty if there are none.
    pub(crate) fn terms(&self) -> &[Term] {
        self.accepted.as_ref().map_or(&[], |c| &c.terms)
    }

    /// χ² with the accepted terms.
    pub(crate) fn reached(&self) -> f64 {
        self.accepted.as_ref().unwrap_or(&self.nominal).chi2
    }
}

/// Ratio of rms residual to noise for a given χ².
pub(crate) fn level(chi2: f64, cost: &Cost<'_>) -> f64 {
    (chi2 / cost.count().max(1) as f64).sqrt()
}

/// Whether a stage is a gain, of both directions or of each.
pub(super) fn is_a_gain(stage: Stage) -> bool {
    matches!(stage, Stage::Gain | Stage::Direction)
}

/// Whether it is a servo, a damped second order, and nothing else.
pub(super) fn is_a_servo(candidate: &Candidate) -> bool {
    let mut stages = candidate.terms.iter().map(|term| term.stage);
    stages.all(|stage| matches!(stage, Stage::Servo | Stage::ServoForLag))
}

/// Whether a candidate can be a cause. A damped second order imitates delay, lag and limits together, so it is one only where it
/// leaves nothing but noise. A mode of a structure has to ring.
pub(super) fn is_a_cause(candidate: &Candidate, cost: &Cost<'_>) -> bool {
    let is_servo = |term: &Term| matches!(term.stage, Stage::Servo | Stage::ServoForLag);
    let servo = candidate.terms.iter().any(is_servo);
    rings(candidate) && (!servo || level(candidate.chi2, cost) < AT_NOISE)
}

/// Whether all modes of a candidate ring; true if it has none.
pub(super) fn rings(candidate: &Candidate) -> bool {
    /// Damping ratio up to which a mode rings.
    const RINGS: f64 = 0.25;
    let mut modes = candidate.terms.iter();
    modes.all(|term| {
        term.stage != Stage::Resonance || term.values.get(1).is_some_and(|damping| *damping < RINGS)
    })
}
