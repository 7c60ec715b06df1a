//! The notes beside an answer: what the logs lack, what was refused and why, and what to know about the numbers.

use super::ranking;
use super::sentence::small_share;
use super::unaccounted::Unaccounted;
use super::verdict::{of_a_rig, untested};
use crate::compare::TOLERATED_NOISE;
use crate::compare::sentence::listed;
use crate::diagnose::actuator::{Candidate, Search};
use crate::diagnose::evidence::{NAMED, RISES};
use crate::diagnose::finding::{Equivalent, NoiseFloor, Verdict};
use crate::diagnose::named::NamedEffect;
use crate::diagnose::noise::autoregressive::LEAST;
use crate::diagnose::noise::structure::SLOW_HZ;
use crate::diagnose::prediction_error::error_reduction::{ErrorReduction, Refused};
use crate::diagnose::prediction_error::log_to_log::LogToLog;
use crate::diagnose::prediction_error::noise_of_motion::Drowned;
use crate::diagnose::stages::Stages;
use crate::diagnose::wrench::{self, AfterMotion, AmountByLog, Disagreement, PreparedLog, Ripple};
use softdock_physics::effects::CATALOGUE;
use softdock_physics::model::load::effects::LoadEffect;
use softdock_physics::model::load::{Column, Scene};
use softdock_physics::model::{Channel, EffectModel, Model, WrenchMeaning};
use softdock_report::number;
use softdock_statistics::dot;

/// All that the notes are made from.
pub(crate) struct Answer<'a> {
    /// The model that was asked about.
    pub model: &'a Model,
    /// What the stages found.
    pub stages: &'a Stages,
    /// Number of logs of the fit.
    pub fitted: usize,
    /// The verdict.
    pub verdict: Verdict,
    /// What is named, with its parameters, and what is refused.
    pub reduction: &'a ErrorReduction,
    /// A parameter that differs from log to log, if there is one.
    pub log_to_log: Option<LogToLog>,
    /// What is left without a name.
    pub rest: &'a Unaccounted,
    /// Effects that are equivalent to named ones.
    pub equivalent: Option<&'a Equivalent>,
}

impl Answer<'_> {
    /// All notes. `unexplained`: structure is left without a name. `in_sample`: there are no unseen data.
    pub(crate) fn all(&self, unexplained: bool, in_sample: bool) -> Vec<String> {
        let mut notes = self.stages.before.shown().notes.clone();
        notes.extend(self.of_logs(in_sample));
        notes.extend(self.of_search());
        notes.extend(
            self.stages
                .noise
                .iter()
                .filter_map(|floor| of_noise(floor, self.stages)),
        );
        if self.rest.remainder.share > 0.0 && !unexplained {
            notes.push(format!(
                "Of the error {} is left with structure: {}.",
                small_share(self.rest.remainder.share),
                self.rest.remainder.follows
            ));
        }
        let hypothesis = self.rest.ripples.iter().find_map(Ripple::hypothesis);
        notes.extend(hypothesis.map(|hypothesis| {
            format!(
                "An own hypothesis can say what repeats along the axis, one for each period: {hypothesis} (docs/own-hypothesis.md)."
            )
        }));
        notes.extend(self.of_each_log());
        notes.extend(self.of_refused());
        notes.extend(self.of_parameters());
        notes
    }

    /// Notes about what the logs lack.
    fn of_logs(&self, in_sample: bool) -> Vec<String> {
        let Self { model, stages, .. } = self;
        let mut notes: Vec<String> = untested(stages).map(str::to_owned).collect();
        let is_loaded = !model.sensor.at_rest && model.sensor.wrench != WrenchMeaning::Free;
        if stages.wrench.is_some() && is_loaded && stages.logs.have_constant_loads() {
            let what = match model.sensor.wrench.is_commanded() {
                true => "When the load was told",
                false => "Whether the reading is late",
            };
            notes.push(format!(
                "{what} is not tested: the load is the same from beginning to end of each log."
            ));
        }
        notes.extend(self.after_motion());
        notes.extend(self.in_proportion());
        notes.extend(self.without_gravity());
        notes.extend(self.without_inertia());
        notes.extend(self.smooths());
        if stages.logs.have_own_origins() {
            let turns = model.bearing().is_some();
            let by_position = CATALOGUE.iter().filter(|e| e.acts_by_position(turns));
            let ids: Vec<&str> = by_position.map(|effect| effect.id).collect();
            notes.push(format!(
            "Not tested: {}. The logs hold velocities and no positions, so that each has an origin of its own; map the \
             position.",
            ids.join(", ")
        ));
        }
        if in_sample {
            notes.push(
            "There is no unseen data: the end of the log holds too little motion to judge on, so \
             the effects are judged on the data that they were fitted on. Give a second log with \
             --test."
                .to_owned(),
        );
        }
        notes
    }

    /// A note if a load that is said to be commanded comes after the motion, which only a measured load may do.
    fn after_motion(&self) -> Option<String> {
        let found = self.stages.wrench.as_ref()?;
        let found = found
            .remaining_structure()
            .is_structured()
            .then_some(found)?;
        let accepted = found.found.accepted.as_ref()?;
        let AfterMotion { late_s, share } = wrench::after_motion(&found.prepared, accepted)?;
        Some(format!(
            "The recorded load comes some {} ms after the motion, which explains {} of the squared error that is left. A command cannot \
             come after the motion that it causes: if the load was measured, write wrench = \"measured\" into [sensor] of the model.",
            number::significant(1e3 * late_s, 2),
            small_share(share),
        ))
    }

    /// A note about the mass or inertia to which all forces are proportional in a free motion.
    fn in_proportion(&self) -> Option<String> {
        let Model { tool, sensor, .. } = self.model;
        let (of, value, unit) = match self.model.bearing() {
            Some(_) => (
                "moment of inertia",
                self.model.inertia_about_bearing(),
                "kg·m²",
            ),
            None => ("mass", tool.mass_kg, "kg"),
        };
        let named = self
            .reduction
            .named
            .iter()
            .map(|(named, _)| named.effect.id.as_str());
        let mut laws = named.filter_map(|id| LoadEffect::find(self.model, id));
        let is_loaded = laws.any(|law| !law.acts_on_reading());
        (sensor.wrench == WrenchMeaning::Free && is_loaded).then(|| {
            let value = number::significant(value, 3);
            format!(
                "Nothing drives what moves: forces, torques and their errors are in proportion to its {of} in the model, {value} \
                 {unit}."
            )
        })
    }

    /// Notes about what the search could not decide.
    fn of_search(&self) -> Vec<String> {
        let stages = self.stages;
        let mut notes = Vec::new();
        for id in stages.actuator.iter().flat_map(|a| undecided(&a.search)) {
            notes.push(format!(
            "The log does not tell which form of {id} it is; the interval spans all that fit as well."
        ));
        }
        if let Some(steps) = stages.wrench.as_ref().and_then(|w| w.found.ended_after) {
            notes.push(format!(
            "The search for effects on the wrench was ended after {steps} steps, each with more \
             evidence than the one before: no few effects explain this log; check its units and the \
             model file."
        ));
        }
        let beside = stages
            .wrench
            .iter()
            .filter_map(|w| w.beside_remainder.as_ref());
        let mut logs = stages.wrench.iter().flat_map(|w| &w.prepared.logs);
        let touches = logs.any(|log| log.scene.touches_anything());
        for one in beside.flat_map(|beside| &beside.imitated) {
            let reason = match one.evidence < NAMED {
                true => format!(
                    "the evidence for it is {:.0}, {NAMED:.0} are needed",
                    one.evidence
                ),
                false => "its 95 % interval holds 0".to_owned(),
            };
            notes.push(format!(
                "{} is not told from a smooth remainder, functions of position, velocity, \
             acceleration{} and time in its place: {reason}.",
                one.id,
                if touches { ", contact depth" } else { "" }
            ));
        }
        let in_place = stages.wrench.iter();
        for id in in_place.flat_map(|w| &w.found.curve_in_place_of) {
            notes.push(format!(
            "{id} would explain more, and is not told from a curve that fits many mechanisms in its place."
        ));
        }
        notes
    }

    /// Notes about what differs from log to log.
    fn of_each_log(&self) -> Vec<String> {
        match self.verdict {
            Verdict::LogsDisagree => {
                let actuator = self.stages.actuator.iter().flat_map(|a| &a.disagreeing);
                let wrench = self.stages.wrench.iter().flat_map(|w| &w.found.disagreeing);
                let all = actuator.chain(wrench);
                all.flat_map(|one| amounts_of_logs(one, self.fitted))
                    .collect()
            }
            Verdict::Named => self.log_to_log.iter().map(from_log_to_log).collect(),
            _ => Vec::new(),
        }
    }

    /// Notes about what is not named, and why.
    fn of_refused(&self) -> Vec<String> {
        let reduction = self.reduction;
        let curves = self.rest.curves.iter().map(|id| {
            let ids = ranking::with_general_curve(self.stages, id);
            let others = if ids.len() > 1 { " with what it needs beside it" } else { "" };
            format!(
                "{id} is a curve that fits many mechanisms, and is not named; `softdock add MODEL {} --fit LOG` adds it{others}.",
                ids.join(" ")
            )
        });
        let same = self.equivalent.iter().map(|same| same.sentence.clone());
        let undetermined = reduction.undetermined.iter().map(|id| {
            format!("{id} is not named: the 95 % intervals of all its parameters hold 0.")
        });
        let done_without = reduction.done_without.iter().map(|id| {
            let with = reduction
                .late
                .as_deref()
                .unwrap_or("a friction that turns round over a speed");
            format!("{id} is not named: {with} foretells unseen data better without it.")
        });
        let refused = reduction.refused.iter().map(|refused| {
            let Refused {
                ids,
                errors,
                of_fit,
            } = refused;
            let [without, with] = errors;
            let (are, them, it) = match ids.len() {
                1 => ("is", "it", "it"),
                _ => ("are", "them together", "them"),
            };
            let [before, after] = [without, with].map(|error| format!("{error:.2}"));
            let goes = match before == after {
                true => format!("stays at {before}"),
                false => format!("goes from {before} to {after}"),
            };
            let why = match (of_fit, with < without) {
                (true, _) => "the 95 % intervals of its amounts hold 0".to_owned(),
                (false, true) if RISES * with > *without => {
                    format!("the logs of the fit are explained as well without {it}")
                }
                (false, true) => {
                    "a fall of less than a tenth may be an error of the form of others".to_owned()
                }
                (false, false) if before == after => "they are predicted no better".to_owned(),
                (false, false) => "something of another form is there".to_owned(),
            };
            let data = match of_fit {
                true => "the logs of the fit",
                false => "unseen data",
            };
            format!(
                "{} {are} not named: with {them} the error on {data} {goes}; {why}.",
                listed(ids)
            )
        });
        let drowned = reduction.drowned.iter().map(|(id, why)| {
            let why = match why {
                Drowned::Noise(share) => format!(
                    "up to {} of the squared acceleration is noise of the recorded motion",
                    small_share(*share)
                ),
                Drowned::RunsOff(off) => {
                    let [without, with] = off.map(|off| number::significant(off, 2));
                    format!("simulated forward the motion is off by {with} times itself with it, by {without} times without")
                }
            };
            format!(
                "{id} is not named: {why}. Noise of the acceleration makes a mass or an inertia look smaller than it is; if that is the cause, a \
                 [filter] in the mapping of the import with a lower cutoff keeps it down."
            )
        });
        let left_out = reduction.left_out.iter().map(|(id, name, [with, without])| {
            let [with, without] = [with, without].map(|error| number::significant(*error, 3));
            format!(
                "{name} of {id} is left out: without it the error on unseen data falls from {with} to {without}."
            )
        });
        curves
            .chain(same)
            .chain(drowned)
            .chain(left_out)
            .chain(undetermined)
            .chain(done_without)
            .chain(refused)
            .collect()
    }

    /// Notes about how the parameters of named effects were found.
    fn of_parameters(&self) -> Vec<String> {
        let reduction = self.reduction;
        let late = reduction.late.iter().map(|late| {
            format!(
                "{late} was found by least squares, which leave less of the logs of the fit and of unseen data with it and a friction that turns round over a speed. \
                 The likelihood that weighs errors as the noise has them prefers a sharper reversal, beside which nothing looks late."
            )
        });
        let braking = reduction.braking.iter().filter_map(|braking| {
            let [without, with] = braking.factors.map(|factor| number::significant(factor, 3));
            let id = &braking.named.last()?.effect.id;
            Some(format!(
                "{id} was found by the swing of the unseen data: simulated forward its amplitude is wrong by a factor of {with} with it, and of \
                 {without} without. At each instant it does less than the noise of the acceleration, so the likelihood does not pay for it."
            ))
        });
        let wrench = self.stages.wrench.as_ref();
        let in_rounds = wrench.is_some_and(|found| !found.earlier.0.is_empty());
        let intervals = match in_rounds || reduction.late.is_some() {
            true => "",
            false => " The intervals hold both.",
        };
        let refitted = reduction.refitted.iter().map(|[before, after]| {
            format!(
                "The parameters are those of least squares, which foretell unseen data {:.1} % better than those of the likelihood that decides on \
                 names: that one weighs errors by the noise, and holds what it has found first. Where the two differ, the form of a law is not quite that of \
                 the machine.{intervals}",
                100.0 * (1.0 - after / before)
            )
        });
        /// Share of noise in the squared acceleration from which it is mentioned.
        const MENTIONED: f64 = 0.05;
        let noisy = reduction.noisy.iter().filter(|noisy| noisy.1 > MENTIONED);
        let noisy = noisy.map(|(id, share)| {
            format!(
                "Up to {} of the squared acceleration is noise of the recorded motion. The mass or inertia that {id} corrects may be too small by as \
                 much: the interval reaches up to what it would be without the noise.",
                small_share(*share)
            )
        });
        let mut notes: Vec<String> = late.chain(braking).chain(refitted).chain(noisy).collect();
        let named = || reduction.named.iter().map(|(named, _)| named);
        if !matches!(self.verdict, Verdict::Unexplained | Verdict::LogsDisagree) {
            notes.extend(named().filter_map(|one| one.choice(of_a_rig(self.stages))));
        }
        if self.verdict != Verdict::LogsDisagree {
            let wrench = self.stages.wrench.iter();
            notes.extend(
                wrench.flat_map(|found| named().filter_map(|one| one.at_its_end(&found.prepared))),
            );
            let actuator = self.stages.actuator.iter();
            notes.extend(actuator.flat_map(|found| found.at_their_ends.clone()));
            notes.extend(self.cancelling());
        }
        notes
    }

    /// Notes about pairs of amounts that nearly cancel.
    fn cancelling(&self) -> Vec<String> {
        /// A pair is noted if each part alone is this many times what both are together: each amount is then that much less
        /// certain than their sum. Set by hand.
        const CANCELS: f64 = 5.0;
        let wrench = self.stages.wrench.as_ref();
        let Some(log) = wrench.and_then(|found| found.prepared.logs.first()) else {
            return Vec::new();
        };
        let named = self.reduction.named.iter();
        let parts = named.flat_map(|(named, _)| terms(named, &log.scene));
        let parts: Vec<(String, Column)> = parts.collect();
        let size = |column: &Column| {
            let axes = column.0.iter().zip(log.sheet_sigma);
            let squares = axes.map(|(series, sigma)| dot(series, series) / (sigma * sigma));
            squares.sum::<f64>().sqrt()
        };
        let pairs = (0..parts.len()).flat_map(|one| (0..one).map(move |other| (other, one)));
        let said = pairs.filter_map(|(one, other)| {
            let [(one, part), (other, counter)] = [&parts[one], &parts[other]];
            let mut both = part.clone();
            both.add(&counter.0);
            let times = size(part).min(size(counter)) / size(&both);
            (times > CANCELS).then(|| {
                format!(
                    "{one} and {other} nearly cancel: each alone is {times:.0} times or more what both are together on the log of the fit, so that their sum is known much \
                     better than either; elsewhere, or at larger angles and displacements, they may not cancel."
                )
            })
        });
        said.collect()
    }
}

/// For each amount of an effect that is not late: its name, and its contribution to the reading of a log.
fn terms(named: &NamedEffect, scene: &Scene) -> Vec<(String, Column)> {
    let EffectModel { id, parameters, .. } = &named.effect;
    let effect = LoadEffect::find(&scene.model, id).filter(|effect| !effect.is_late());
    let Some(effect) = effect else {
        return Vec::new();
    };
    let amounts = || effect.coefficients.iter().map(|one| one.name);
    let own: Vec<&str> = amounts()
        .filter(|name| parameters.contains_key(*name))
        .collect();
    let alone = |name: &&str| {
        let mut one = parameters.clone();
        one.retain(|other, _| other == name || amounts().all(|amount| amount != other));
        let said = match own.len() {
            1 => format!("`{id}`"),
            _ => format!("`{name}` of `{id}`"),
        };
        (said, effect.contribution(scene, &one))
    };
    own.iter().map(alone).collect()
}

/// A note if the noise of a channel differs from that of the model file.
fn of_noise(floor: &NoiseFloor, stages: &Stages) -> Option<String> {
    let ratio = floor.measured / floor.data_sheet;
    // Nothing in a log is faster than the cutoff of the import's filter, or than half of the sampling rate.
    let filter = stages.wrench.iter().flat_map(|w| &w.prepared.logs);
    let mut filters = filter.filter_map(|log| log.scene.model.sensor.filter);
    let has_none = floor.channel == Channel::Wrench && filters.any(|f| f.cutoff_hz <= SLOW_HZ);
    let is_slow = 0.5 / stages.logs.shown().cycle_s <= SLOW_HZ;
    if ratio < 1.0 / TOLERATED_NOISE {
        let noise = match has_none || is_slow {
            true => "the noise that the log shows".to_owned(),
            false => format!("what is faster than {SLOW_HZ} Hz"),
        };
        // The noise of a log is estimated with a lower limit, a share of the noise of the model file.
        let at_most = if ratio < 1.01 * LEAST { "at most " } else { "" };
        return Some(format!(
            "{} {}: {noise} is {at_most}{ratio:.2} times the noise of the model file, which is too large: errors in its units look small. Evidence and intervals take the noise from the log.",
            floor.channel, floor.axis
        ));
    }
    if has_none || is_slow || ratio <= TOLERATED_NOISE {
        return None;
    }
    let filter = match floor.channel {
        Channel::Wrench if differentiates(stages) => {
            " If that is the acceleration of differentiated positions, what follows from it is not told from \
             noise, nor is a delay: a [filter] in the mapping of the import keeps the motion and cuts the rest."
        }
        _ => "",
    };
    Some(format!(
        "{} {}: what is faster than {SLOW_HZ} Hz is {ratio:.2} times the noise of the model file: noise, or a fast error of \
         the model.{filter}",
        floor.channel, floor.axis
    ))
}

/// A sentence about a parameter that differs between the logs of the fit and the unseen ones.
fn from_log_to_log(one: &LogToLog) -> String {
    let digits = |value: &f64| number::significant(*value, 3);
    let unit = match one.parameter.1 {
        "-" => String::new(),
        unit => format!(" {unit}"),
    };
    let [with, own] = one.errors;
    let unseen: Vec<String> = one.unseen.iter().map(digits).collect();
    format!(
        "Most of what is left of the unseen data is as if {} differed from log to log: with {} = {}{unit} instead of {}{unit} the error of the \
         wrench there would be {own:.2} units of noise, and is {with:.2}.",
        one.effect,
        one.parameter.0,
        listed(&unseen),
        digits(&one.fitted),
    )
}

/// Sentences with the amounts of an effect in each log, for logs that disagree about it.
fn amounts_of_logs(one: &Disagreement, fitted: usize) -> impl Iterator<Item = String> {
    one.amounts.iter().map(move |amount| {
        let AmountByLog { name, unit, values } = amount;
        let values: Vec<String> = values.iter().map(|v| number::significant(*v, 3)).collect();
        let unseen = match values.get(fitted..) {
            Some(unseen @ [_, ..]) => format!("; those of --test {}", listed(unseen)),
            _ => String::new(),
        };
        let of_fit = listed(&values[..fitted.min(values.len())]);
        let unit = match *unit {
            "-" => String::new(),
            unit => format!(" in {unit}"),
        };
        format!(
            "{} {name}{unit}, each log alone: those of the fit {of_fit}{unseen}.",
            one.id
        )
    })
}

/// Whether accelerations are differences of recorded positions or velocities, and nothing smooths them.
fn differentiates(stages: &Stages) -> bool {
    let raw = |log: &PreparedLog| log.scene.model.sensor.filter.is_none();
    let mut logs = stages.wrench.iter().flat_map(|w| &w.prepared.logs);
    logs.any(raw) && !stages.logs.all.iter().any(|log| log.is_commanded())
}

/// Ids of effects whose form the log does not determine.
fn undecided(search: &Search) -> Vec<&'static str> {
    let accepted = search.accepted.iter().flat_map(|c| &c.terms);
    let mut ids: Vec<&str> = accepted
        .enumerate()
        .filter(|(i, term)| {
            let differs =
                |form: &Candidate| form.terms.get(*i).is_some_and(|t| t.stage != term.stage);
            search.equal_forms.iter().any(differs)
        })
        .map(|(_, term)| term.stage.id())
        .collect();
    ids.dedup();
    ids
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;
    use softdock_control::frames::{Pose, Twist};
    use softdock_control::wrench::Motion;
    use softdock_physics::model::Axis;

    /// A spring may cancel the sine of a weight while no constant cancels its cosine.
    #[test]
    fn each_amount_of_an_effect_is_compared_by_itself() {
        let mut model = Model::default();
        model.rig.active_axes = vec![Axis::Rz];
        let pose = (0..9).map(|n| {
            let turned = UnitQuaternion::from_euler_angles(0.0, 0.0, 0.1 * f64::from(n));
            Pose::from_parts(nalgebra::Vector3::zeros().into(), turned)
        });
        let motion = Motion {
            velocity: Twist::of(&[0.0, 0.0, 0.0, 0.0, 0.0, 10.0]),
            acceleration: Twist::zero(),
        };
        let time_s = (0..9).map(|n| 0.01 * f64::from(n)).collect();
        let scene = Scene::new(&model, 0.01, time_s, pose.collect(), vec![motion; 9]);
        let weight = NamedEffect::new("bearing_gravity", Vec::new())
            .with("sine_n_m", (2.0, 0.1), "N·m")
            .with("cosine_n_m", (0.5, 0.1), "N·m");
        let terms = terms(&weight, &scene);
        let names: Vec<&str> = terms.iter().map(|(name, _)| name.as_str()).collect();
        assert!(
            names.contains(&"`sine_n_m` of `bearing_gravity`"),
            "{names:?}"
        );
        let both: f64 = terms.iter().map(|(_, part)| part.at(5, 8)).sum();
        let whole = LoadEffect::find(&model, "bearing_gravity").unwrap();
        let whole = whole.contribution(&scene, &weight.effect.parameters);
        assert!(
            (both - whole.at(5, 8)).abs() < 1e-12 && both.abs() > 1.0,
            "{both}"
        );
    }
}
