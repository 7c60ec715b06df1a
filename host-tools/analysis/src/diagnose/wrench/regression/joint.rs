//! All logs together in one regression.

use super::fitted::Fitted;
use super::gram;
use super::memo::Memo;
use super::nuisance;
use super::prepared_log::PreparedLog;
use super::problem::{Problem, Segment, subtract};
use super::tested::{SAME_NOISE, TestedHypothesis};
use crate::diagnose::evidence::{self, strained};
use nalgebra::DVector;
use softdock_physics::model::load::effects::{LoadEffect, Pace, Sign};
use softdock_physics::model::load::loaded::contribution;
use softdock_physics::model::load::{Column, Scene};
use softdock_physics::model::{Axis, WrenchMeaning};
use softdock_statistics::dot;
use std::collections::BTreeSet;
use std::sync::Arc;

/// χ² beyond the noise, per value, that is more than errors of an effect's form.
const MUCH: f64 = 0.05;

/// A smooth remainder as the search uses it: functions whose amplitudes have Gaussian priors.
#[derive(Clone, Debug)]
pub(crate) struct Smooth {
    /// The functions of each log, each scaled by the prior standard deviation of its amplitude.
    pub functions: Vec<Vec<Column>>,
    /// Axes on which the remainder acts.
    pub axes: Vec<Axis>,
    /// Number of values on these axes that count as one independent value.
    pub kappa: f64,
}

/// A nominal parameter as the logs estimate it.
#[derive(Clone, Debug)]
pub(crate) struct NominalEstimate {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Standard deviation of the value.
    pub sigma: f64,
    /// By how many tolerances the value is off.
    pub tolerances: f64,
}

/// All logs with one regression.
pub(crate) struct Joint {
    /// The logs; the first ones are those of the fit.
    pub logs: Vec<PreparedLog>,
    /// Number of logs of the fit.
    pub fitted: usize,
    /// The regression of all.
    pub problem: Problem,
    /// By how much χ² falls with the effects that the model has already. Their form may be as wrong as that of effects that are
    /// looked for.
    pub known: f64,
    /// By how much χ² would fall with a constant on each axis: instead of the known effects, and, beside the nominal parameters
    /// within their tolerances, instead of new effects. A constant has no form that could be wrong.
    levels: [f64; 2],
    /// Indices of nominal parameters that are held at their values, because they would have to move further than their tolerances
    /// allow.
    held: Vec<usize>,
    /// A smooth remainder is among the columns of the tolerances.
    pub(crate) has_remainder: bool,
    /// Fits and columns that the searches of this diagnosis have computed.
    pub(crate) memo: Arc<Memo>,
}

/// Maximum of the parabola through the origin that has the values `up` at 1 and `down` at -1; 0 if it has none.
fn top(up: f64, down: f64) -> f64 {
    let (slope, bend) = (0.5 * (up - down), -(up + down));
    if bend > 0.0 {
        0.5 * slope * slope / bend
    } else {
        0.0
    }
}

impl Joint {
    /// The longest sampling period, the largest rms speed and the shortest duration of the logs.
    pub(crate) fn pace(&self) -> Pace {
        let most = |of: fn(&Scene) -> f64| {
            let each = self.logs.iter().map(|log| of(&log.scene));
            each.fold(0.0, f64::max)
        };
        Pace {
            cycle_s: most(|scene| scene.cycle_s),
            speed: most(Scene::rms_speed),
            shortest_s: self
                .logs
                .iter()
                .map(|log| log.scene.cycle_s * log.fresh.len() as f64)
                .fold(f64::INFINITY, f64::min),
        }
    }

    /// Prepares the regression of all logs. `memo` is shared by all searches of the diagnosis.
    pub(crate) fn new(logs: Vec<PreparedLog>, fitted: usize, memo: &Arc<Memo>) -> Self {
        let problem = problem(&logs, &[], |_, _| true);
        let joint = Self {
            logs,
            fitted,
            problem,
            known: 0.0,
            levels: [0.0; 2],
            held: Vec::new(),
            has_remainder: false,
            memo: Arc::clone(memo),
        };
        let mut known: Vec<Column> = joint
            .logs
            .iter()
            .map(|log| log.scene.change_by_known_effects())
            .collect();
        known.iter_mut().for_each(|column| column.scale(-1.0));
        let nothing = joint.problem.whitened(&known.iter().collect::<Vec<_>>());
        let (before, now) = (joint.squares(&nothing), joint.squares(&Column::default()));
        Self {
            known: (before - now).max(0.0),
            levels: joint.levels_beside(&nothing, before),
            ..joint
        }
    }

    /// Sum of squares that a whitened column leaves with all nominal parameters at their values: the uncertainties of the known
    /// effects are among these, and must not stand in for the effects.
    fn squares(&self, white: &Column) -> f64 {
        let at_rest = DVector::zeros(self.all_tolerances());
        let rest = self.problem.rest(white, &at_rest);
        rest.0.iter().flatten().map(|r| r * r).sum()
    }

    /// Computes [`Self::levels`]. `nothing` is the whitened contribution that undoes the known effects, `before` the sum of
    /// squares without them.
    fn levels_beside(&self, nothing: &Column, before: f64) -> [f64; 2] {
        let constant = |axis: &Axis| {
            let of = |log: &PreparedLog| {
                let mut constant = Column::default();
                constant.0[axis.index()] = vec![1.0; log.fresh.len()];
                constant
            };
            let of_logs: Vec<Column> = self.logs.iter().map(of).collect();
            self.problem.whitened(&of_logs.iter().collect::<Vec<_>>())
        };
        let constants: Vec<Column> = Axis::ALL.iter().map(constant).collect();
        let beside_known = |constant: &Column| {
            let with = |amount: f64| {
                let mut both = nothing.clone();
                subtract(&mut both, constant, -amount);
                before - self.squares(&both)
            };
            top(with(1.0), with(-1.0))
        };
        let beside_tolerances = |constant: &Column| {
            let with = |amount: f64| {
                let mut constant = constant.clone();
                constant.scale(amount);
                self.problem.gain_of(&constant)
            };
            top(with(1.0), with(-1.0))
        };
        [
            constants.iter().map(beside_known).sum(),
            constants.iter().map(beside_tolerances).sum(),
        ]
    }

    /// Adds a smooth remainder: its functions join the columns of the tolerances, with priors as these, and the noise on its axes
    /// is raised.
    pub(crate) fn add_remainder(&mut self, smooth: &Smooth) {
        for (log, functions) in self.logs.iter_mut().zip(&smooth.functions) {
            log.tolerances.extend(functions.iter().cloned());
            for axis in &smooth.axes {
                log.noise_model[axis.index()].sigma *= smooth.kappa.sqrt();
            }
        }
        self.problem = self.of_rows(|_, _| true);
        self.has_remainder = true;
    }

    /// Removes the smooth remainder again.
    pub(crate) fn remove_remainder(&mut self, smooth: &Smooth) {
        let kept = self.all_tolerances() - smooth.functions.first().map_or(0, Vec::len);
        for log in &mut self.logs {
            log.tolerances.truncate(kept);
            for axis in &smooth.axes {
                log.noise_model[axis.index()].sigma /= smooth.kappa.sqrt();
            }
        }
        self.held.retain(|k| *k < kept);
        self.problem = self.of_rows(|_, _| true);
        self.has_remainder = false;
    }

    /// By how much χ² of each log, before any new effect, is larger than in another regression with the same noise. `None` where
    /// both hold the same nominal parameters, or the noise differs.
    pub(crate) fn more_to_explain_than(&self, other: &Self) -> Option<Vec<f64>> {
        let held = |joint: &Self| joint.held.iter().copied().collect::<BTreeSet<usize>>();
        let noise = |joint: &Self| -> Vec<f64> {
            let each = joint.logs.iter().flat_map(|log| &log.noise_model);
            each.map(|noise| noise.sigma).collect()
        };
        let is_same = |(own, other): (f64, f64)| (own - other).abs() <= SAME_NOISE * other;
        let mut noises = noise(self).into_iter().zip(noise(other));
        if held(self) == held(other) || !noises.all(is_same) {
            return None;
        }
        let [own, others] = [self, other].map(|joint| joint.problem.chi2_of_logs.iter());
        Some(own.zip(others).map(|(own, other)| own - other).collect())
    }

    /// A hypothesis with its gain and evidence in this regression, its parameters unchanged.
    pub(crate) fn valued(&self, tested: TestedHypothesis) -> TestedHypothesis {
        let white = self.white_part(Some(&tested));
        let gains = self.problem.gains(&white);
        let gain = self.problem.gain_of(&white);
        TestedHypothesis {
            evidence: tested.evidence - tested.gain + gain,
            to_explain: self.problem.chi2,
            gain,
            gains,
            ..tested
        }
    }

    /// χ² that laws explain: the known effects, and new ones with this gain. 0 beside a remainder, which covers the errors of
    /// their form.
    pub(crate) fn explained(&self, gain: f64) -> f64 {
        if self.has_remainder {
            return 0.0;
        }
        (self.known + gain - self.levels[0]).max(0.0)
    }

    /// The same without what constants would explain, as the tolerance of a sensor's zero takes that where it is not looked for.
    pub(crate) fn explained_beyond_zeros(&self, gain: f64) -> f64 {
        let beyond = |gain: f64, level: f64| (gain - level).max(0.0);
        beyond(self.known, self.levels[0]) + beyond(gain, self.levels[1])
    }

    /// Evidence that an effect needs beside others with this gain.
    pub(crate) fn threshold(&self, gain: f64) -> f64 {
        evidence::threshold(self.explained(gain))
    }

    /// The same for one effect. In a free swing the energy shows what brakes, whatever the form of the law that stores it, so a
    /// dissipative effect needs no more than without others.
    pub(crate) fn threshold_of(&self, id: &str, gain: f64) -> f64 {
        let model = self.logs.first().map(|log| &log.scene.model);
        let swings = model.filter(|model| model.sensor.wrench == WrenchMeaning::Free);
        let effect = swings.and_then(|model| LoadEffect::find(model, id));
        match effect.is_some_and(LoadEffect::dissipates) {
            true => evidence::threshold(0.0),
            false => self.threshold(gain),
        }
    }

    /// The regression of those rows for which `keeps`, called with log and row, is true.
    pub(crate) fn of_rows(&self, keeps: impl Fn(usize, usize) -> bool) -> Problem {
        problem(&self.logs, &self.held, keeps)
    }

    /// The regression of the logs of the fit.
    pub(crate) fn of_fit(&self) -> Problem {
        self.of_rows(|log, _| log < self.fitted)
    }

    /// The regression of the first `logs` without one of `of` pieces of equal length into which all their rows are cut. A piece
    /// mostly lies in one log, so differences between logs show as well.
    pub(crate) fn without(&self, piece: usize, of: usize, logs: usize) -> Problem {
        let counts = self.logs.iter().take(logs).map(|log| log.fresh.len());
        let counts: Vec<usize> = counts.collect();
        let before: Vec<usize> = (0..counts.len())
            .map(|k| counts[..k].iter().sum())
            .collect();
        let rows = counts.iter().sum::<usize>().max(1);
        self.of_rows(|log, n| log < logs && (before[log] + n) * of / rows != piece)
    }

    /// Holds nominal parameters at their values that would have to move too far beside a hypothesis. Returns whether there are
    /// any.
    pub(crate) fn hold_strained(&mut self, tested: Option<&TestedHypothesis>) -> bool {
        let taken = self.problem.tolerances_with(&self.white_part(tested));
        let open: Vec<usize> = self.open_tolerances().collect();
        let strained = strained(taken.as_slice(), self.problem.informed());
        let strained: Vec<usize> = strained.iter().map(|k| open[*k]).collect();
        let any = !strained.is_empty();
        if any {
            self.held.extend(strained);
            self.problem = self.of_rows(|_, _| true);
        }
        any
    }

    /// Number of nominal parameters that have a tolerance.
    pub(crate) fn all_tolerances(&self) -> usize {
        self.logs.first().map_or(0, |log| log.tolerances.len())
    }

    /// Indices of those that may move within their tolerance.
    pub(crate) fn open_tolerances(&self) -> impl Iterator<Item = usize> {
        (0..self.all_tolerances()).filter(|i| !self.held.contains(i))
    }

    /// Nominal parameters beside a hypothesis. Parameters of which the logs say nothing are left out. The amounts of the hypothesis, and of the `earlier` effects that
    /// the residual is already without, are estimated together with them, so that a parameter for which an effect stands is left
    /// out, too.
    pub(crate) fn nominal(
        &self,
        earlier: &[Fitted],
        tested: Option<&TestedHypothesis>,
    ) -> Vec<NominalEstimate> {
        /// By this share the logs have to reduce the standard deviation of a parameter to say something of it.
        const SAYS: f64 = 0.05;
        let Some(first) = self.logs.first() else {
            return Vec::new();
        };
        let model = &first.scene.model;
        let nothing = TestedHypothesis::default();
        let accepted = tested.unwrap_or(&nothing);
        let effects = earlier.iter().chain(&accepted.effects);
        let terms = effects.flat_map(|one| one.terms(model));
        let terms = terms.map(|term| self.white_part_of(accepted, &term));
        let terms: Vec<Column> = terms.filter(|column| !column.is_zero()).collect();
        let after = self
            .problem
            .tolerances_beside(&self.white_part(tested), &terms);
        let all = nuisance::all(model);
        let each = self.open_tolerances().enumerate().filter_map(|(k, i)| {
            let nuisance = all.get(i)?;
            let [off, sigma] = after[k];
            let says = sigma < 1.0 - SAYS;
            says.then(|| NominalEstimate {
                name: nuisance.name.clone(),
                value: nuisance.value + off * nuisance.tolerance,
                sigma: sigma * nuisance.tolerance,
                tolerances: off,
            })
        });
        each.collect()
    }

    /// What a hypothesis contributes to the reading of each log.
    pub(crate) fn parts(&self, tested: Option<&TestedHypothesis>) -> Vec<Column> {
        let of = |log: &PreparedLog| tested.map(|t| t.contribution(&log.scene));
        self.logs
            .iter()
            .map(|log| of(log).unwrap_or_default())
            .collect()
    }

    /// Rms error of a hypothesis on the logs that no fit has seen (on all logs if there are none), in units of the data sheet's
    /// noise.
    pub(crate) fn error_on_unseen(&self, tested: &TestedHypothesis) -> f64 {
        self.errors(tested)[1]
    }

    /// The same error on the logs of the fit, and on those that no fit has seen.
    pub(crate) fn errors(&self, tested: &TestedHypothesis) -> [f64; 2] {
        let first = if self.fitted < self.logs.len() {
            self.fitted
        } else {
            0
        };
        let of_logs = |logs: &[PreparedLog]| {
            let each = logs.iter().map(|log| log.chi2_left(tested));
            let (squares, rows) = each.fold((0.0, 0), |sum, of| (sum.0 + of.0, sum.1 + of.1));
            (squares / rows.max(1) as f64).sqrt()
        };
        [
            of_logs(&self.logs[..self.fitted]),
            of_logs(&self.logs[first..]),
        ]
    }

    /// Whether a hypothesis leaves more of some log than the noise of the model.
    pub(crate) fn exceeds_noise(&self, tested: &TestedHypothesis) -> bool {
        let mut of_logs = self.logs.iter().map(|log| log.chi2_left(tested));
        of_logs.any(|(squares, rows)| squares > (self.problem.axes * rows) as f64)
    }

    /// A message if an effect is so large that errors of its form alone would be as large as the reading, or as what the model
    /// lacks of it: other effects would have to cancel it more exactly than laws hold.
    pub(crate) fn oversized(&self, effect: &Fitted) -> Option<String> {
        let power = |log: &PreparedLog, of: &Column| -> f64 {
            let axes = of.0.iter().zip(log.sheet_sigma);
            axes.map(|(series, sigma)| dot(series, series) / (sigma * sigma))
                .sum()
        };
        let (mut own, mut there) = (0.0, 0.0);
        for log in &self.logs {
            let valued = effect
                .valued(&log.scene)
                .filter(|(effect, _)| !effect.is_late())?;
            own += power(log, &contribution(&log.scene, &[valued]));
            let mut reading = log.residual.clone();
            reading.add(&log.scene.reading.0);
            there += f64::max(power(log, &reading), power(log, &log.residual));
        }
        /// Beyond so many times the reading an amount is no estimate.
        const OPEN: f64 = 1e3;
        let times = (own / there).sqrt();
        let times = match times > OPEN {
            true => format!("more than {OPEN}"),
            false => format!("{times:.0}"),
        };
        (evidence::LAW * own > there).then(|| format!("{} of {times} times the reading", effect.id))
    }

    fn white_part(&self, tested: Option<&TestedHypothesis>) -> Column {
        let parts = self.parts(tested);
        self.problem.whitened(&parts.iter().collect::<Vec<_>>())
    }

    /// Sum of squares of what a hypothesis leaves of all readings, nominal parameters at their values. To be used where one axis
    /// is recorded, as forces and torques have different units.
    pub(crate) fn squares_left(&self, tested: &TestedHypothesis) -> f64 {
        let rests = self.rests(Some(tested), &[]);
        let all = rests.iter().flat_map(|rest| &rest.exact.0).flatten();
        all.map(|left| left * left).sum()
    }

    /// What one effect of a hypothesis contributes to all logs, whitened.
    pub(crate) fn white_part_of(&self, tested: &TestedHypothesis, one: &Fitted) -> Column {
        let logs = self.logs.iter();
        let parts: Vec<Column> = logs.map(|log| tested.part(&log.scene, one)).collect();
        self.problem.whitened(&parts.iter().collect::<Vec<_>>())
    }

    /// What a hypothesis and a smooth remainder leave of each log: whitened, and of the readings with the nominal parameters
    /// fitted and without.
    pub(crate) fn rests(&self, tested: Option<&TestedHypothesis>, smooth: &[Column]) -> Vec<Rest> {
        let mut parts = self.parts(tested);
        for (part, smooth) in parts.iter_mut().zip(smooth) {
            part.add(&smooth.0);
        }
        let white = self.problem.whitened(&parts.iter().collect::<Vec<_>>());
        let taken = self.problem.tolerances_with(&white);
        let rest = self.problem.rest(&white, &taken);
        let open: Vec<usize> = self.open_tolerances().collect();
        let of = |(k, (log, part)): (usize, (&PreparedLog, &Column))| {
            let mut exact = log.residual.clone();
            subtract(&mut exact, part, 1.0);
            let mut raw = exact.clone();
            for (i, taken) in open.iter().zip(&taken) {
                subtract(&mut raw, &log.tolerances[*i], *taken);
            }
            Rest {
                white: self.problem.part(&rest, k),
                raw,
                exact,
            }
        };
        self.logs.iter().zip(&parts).enumerate().map(of).collect()
    }

    /// Columns of an effect at some of its coefficients over all logs, whitened by `problem`. `around`: coefficients around which
    /// the effect is linearised. `None` where no log has anything for it to act on.
    pub(crate) fn columns(
        &self,
        problem: &Problem,
        effect: &LoadEffect,
        shapes: &[f64],
        places: &[usize],
        around: &[f64],
    ) -> Option<Vec<Column>> {
        let is_none = |log: &PreparedLog| effect.never_reaches_its_level(&log.scene, shapes);
        if self.logs.iter().all(is_none) {
            return None;
        }
        let build = |(k, log): (usize, &PreparedLog)| {
            let counts = problem.counts(k);
            counts.then(|| effect.columns_at(&log.scene, shapes, places, around))?
        };
        let of_logs: Vec<Option<Vec<Column>>> = self.logs.iter().enumerate().map(build).collect();
        if of_logs.iter().all(Option::is_none) {
            return None;
        }
        let nothing = Column::default();
        let column = |k: usize| {
            let each = of_logs.iter();
            let each = each.map(|c| c.as_ref().map_or(&nothing, |c| &c[k]));
            problem.whitened(&each.collect::<Vec<_>>())
        };
        Some((0..places.len()).map(column).collect())
    }

    /// Whether readings of any log are visibly rounded.
    pub(crate) fn is_rounded(&self) -> bool {
        let mut half_steps = self.logs.iter().flat_map(|log| log.half_step);
        half_steps.any(|half| half > 0.0)
    }

    /// By how much an effect reduces the squared distance of predictions from the intervals of rounded readings, see
    /// [`PreparedLog::gain_beyond_rounding`]; infinite without rounding.
    pub(crate) fn gain_beyond_rounding(&self, tested: &TestedHypothesis) -> f64 {
        if !self.is_rounded() {
            return f64::INFINITY;
        }
        let parts = self.parts(Some(tested));
        let both = self.logs.iter().zip(&parts);
        let each = both.map(|(log, part)| log.gain_beyond_rounding(part));
        // The smallest gain of a log counts for all: what goes beyond the rounding on one log alone is no effect.
        self.logs.len() as f64 * each.fold(f64::INFINITY, f64::min)
    }

    /// For each effect: the largest gain in χ² if one log gets an amount of its own, and χ² of what the common amount does to the
    /// reading. The latter is scaled as if that log and all others weighed the same, as an own amount of a log with little weight
    /// gains little. It is not what the effect gains beside the others, for that may be next to nothing: by logs at one speed each, a
    /// damping and a constant force can hardly be told apart, but neither differs for that.
    pub(crate) fn contrasts(&self, tested: &TestedHypothesis) -> Vec<[f64; 2]> {
        let effects = tested.effects.iter();
        let parts: Vec<Column> = effects.map(|one| self.white_part_of(tested, one)).collect();
        let gain = |columns: &[&Column]| -> f64 {
            let free = vec![Sign::Free; columns.len()];
            let solution = self.problem.solve_whitened(columns, &free);
            solution.map_or(f64::NEG_INFINITY, |s| s.gain)
        };
        let all: Vec<&Column> = parts.iter().collect();
        let common = gain(&all);
        let of = |place: usize| {
            let whole = gram::dot(&parts[place], &parts[place]).max(f64::MIN_POSITIVE);
            let own = |log: usize| {
                let own = self.problem.masked(&parts[place], log);
                let share = gram::dot(&own, &own) / whole;
                let more = gain(&[&all[..], &[&own]].concat()) - common;
                (more, 4.0 * share * (1.0 - share))
            };
            let each = (0..self.logs.len()).map(own);
            let each = each.filter(|(more, _)| more.is_finite());
            let (own, weight) = each.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
            [own, weight * whole]
        };
        (0..parts.len()).map(of).collect()
    }

    /// χ² beyond the number of values that is left after a fall by `gain`.
    pub(crate) fn remaining_chi2(&self, gain: f64) -> f64 {
        self.problem.chi2 - gain - self.problem.count as f64
    }

    /// Whether more is left than errors of an effect's form; always so beside a remainder.
    pub(crate) fn has_much_left(&self, gain: f64) -> bool {
        self.has_remainder || self.remaining_chi2(gain) > MUCH * self.problem.count as f64
    }
}

/// What is left of a log.
pub(crate) struct Rest {
    /// Whitened.
    pub white: Column,
    /// Of the readings, with the nominal parameters fitted within their tolerances.
    pub raw: Column,
    /// Of the readings, with the nominal parameters at their values.
    pub exact: Column,
}

fn problem(logs: &[PreparedLog], held: &[usize], keeps: impl Fn(usize, usize) -> bool) -> Problem {
    let segment = |(k, log): (usize, &PreparedLog)| Segment {
        noise_model: log.noise_model,
        fresh: (0..log.fresh.len())
            .map(|n| log.fresh[n] && keeps(k, n))
            .collect(),
    };
    let segments = logs.iter().enumerate().map(segment).collect();
    let residuals: Vec<&Column> = logs.iter().map(|log| &log.residual).collect();
    let open = |log: &PreparedLog| -> Vec<Column> {
        let all = log.tolerances.iter().enumerate();
        let open = all.filter(|(i, _)| !held.contains(i));
        open.map(|(_, column)| column.clone()).collect()
    };
    let tolerances: Vec<Vec<Column>> = logs.iter().map(open).collect();
    let tolerances: Vec<&[Column]> = tolerances.iter().map(|t| &t[..]).collect();
    let mut problem = Problem::new(segments, &residuals, &tolerances);
    // A reading behind a low-pass has two independent values per period of the cutoff.
    let share = logs.first().map_or(1.0, |log| {
        let filter = log.scene.model.sensor.filter;
        filter.map_or(1.0, |f| (2.0 * f.cutoff_hz * log.scene.cycle_s).min(1.0))
    });
    problem.count = (share * problem.count as f64) as usize;
    problem
}
