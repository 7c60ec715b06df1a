//! Phases of a docking test, found from the recording. Every cycle belongs to exactly one.

use super::contact::{Contact, Contacts, noise_of_steps};
use super::crossing::{after_sign_changes, sign_changes};
use nalgebra::Vector3;
use serde::Serialize;
use softdock_physics::model::prediction::signals::Signals;
use softdock_physics::model::{Axis, Model};
use std::ops::Range;

/// Part of a docking test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// Nothing touches, or the loop is open.
    FreeFlight,
    /// The first contact of the closed loop.
    FirstContact,
    /// Around the reversal in a contact: where the model velocity along the force changes its sign, or, if it does not, at the
    /// deepest penetration. The robot's own reversal, which follows later, is a zero crossing.
    TurningPoint,
    /// Around a change of sign of the executed velocity; outside of contacts also of the
    /// velocity that is sent.
    ZeroCrossing,
    /// After a contact, until the robot follows what is sent.
    Rebound,
    /// Any contact after the first.
    FurtherContact,
}

impl Phase {
    /// All phases in the order of a test.
    pub const ALL: [Self; 6] = [
        Self::FreeFlight,
        Self::FirstContact,
        Self::TurningPoint,
        Self::ZeroCrossing,
        Self::Rebound,
        Self::FurtherContact,
    ];

    /// Name in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::FreeFlight => "free_flight",
            Self::FirstContact => "first_contact",
            Self::TurningPoint => "turning_point",
            Self::ZeroCrossing => "zero_crossing",
            Self::Rebound => "rebound",
            Self::FurtherContact => "further_contact",
        }
    }

    /// Name in sentences, tables and plots.
    pub fn words(self) -> String {
        match self {
            // "Free motion" suits any machine.
            Self::FreeFlight => "free motion".to_owned(),
            _ => self.name().replace('_', " "),
        }
    }
}

/// Cycles that still belong to a zero crossing before and after it; a robot that pauses jumps
/// when it resumes.
const CROSSING_MARGIN: (usize, usize) = (1, 2);
/// Longest time that counts as one crossing, s. A robot that stands longer has stopped.
const LONGEST_CROSSING_S: f64 = 0.1;
/// Shortest and longest half width of a turning point, cycles.
const TURNING_CYCLES: (usize, usize) = (3, 15);
/// Half width of a turning point, as a fraction of the contact: one over this.
const TURNING_SHARE: usize = 8;
/// Cycles in which the robot has to follow for a rebound to be over.
const SETTLED_CYCLES: usize = 5;
/// Longest rebound, s: that of a robot that never follows ends there.
const LONGEST_REBOUND_S: f64 = 0.5;
/// Axes whose fastest velocity is below this share of the fastest axis of their kind have no crossings.
const MOVING_SHARE: f64 = 0.2;
/// Velocities below this share of an axis' fastest are taken for zero.
const STILL_SHARE: f64 = 0.02;
/// Velocities below this multiple of their noise count as zero.
const STILL_NOISE: f64 = 5.0;

/// The phase of each cycle.
pub fn of_cycles(model: &Model, signals: &Signals<'_>, contacts: &Contacts) -> Vec<Phase> {
    let mut phases = vec![Phase::FreeFlight; signals.len()];
    let speeds = Speeds::new(model, signals);
    for (i, contact) in contacts.list.iter().enumerate() {
        let next = contacts.list.get(i + 1).map_or(signals.len(), |c| c.from);
        let end = speeds.settled(signals, contact.to, next);
        paint(&mut phases, contact.to..end, Phase::Rebound);
    }
    let executed = |n: usize, axis: usize| signals.cycles[n].trace.executed_velocity[axis];
    let sent = |n: usize, axis: usize| signals.cycles[n].trace.sent_velocity[axis];
    for crossing in speeds.crossings(sent, sign_changes) {
        paint(&mut phases, crossing, Phase::ZeroCrossing);
    }
    for crossing in speeds.crossings(executed, sign_changes) {
        paint(&mut phases, crossing, Phase::ZeroCrossing);
    }
    for (i, contact) in contacts.list.iter().enumerate() {
        let phase = if i == 0 {
            Phase::FirstContact
        } else {
            Phase::FurtherContact
        };
        paint(&mut phases, contact.from..contact.to, phase);
        let turning = turning_point(signals, contact);
        paint(&mut phases, turning, Phase::TurningPoint);
    }
    // In a contact the cycles before the reversal belong to the turning point, those after it to the zero crossing.
    for crossing in speeds.crossings(executed, after_sign_changes) {
        paint(&mut phases, crossing, Phase::ZeroCrossing);
    }
    phases
}

fn paint(phases: &mut [Phase], cycles: Range<usize>, phase: Phase) {
    let end = cycles.end.min(phases.len());
    if let Some(part) = phases.get_mut(cycles.start..end) {
        part.fill(phase);
    }
}

fn turning_point(signals: &Signals<'_>, contact: &Contact) -> Range<usize> {
    let cycles = contact.from..contact.to;
    let along = |values: &[f64]| Vector3::from_row_slice(&values[..3]).dot(&contact.direction);
    let model: Vec<f64> = cycles
        .clone()
        .map(|n| along(&signals.cycles[n].trace.model_velocity))
        .collect();
    let fastest = model.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let turned = sign_changes(&model, STILL_SHARE * fastest)
        .first()
        .map(|c| (c.start + c.end) / 2);
    let deepest = || {
        let depth = |n: &usize| -along(&signals.cycles[*n].trace.pose);
        cycles.clone().max_by(|a, b| depth(a).total_cmp(&depth(b)))
    };
    let middle = match turned {
        Some(offset) => contact.from + offset,
        None => deepest().unwrap_or(contact.from),
    };
    let half = (cycles.len() / TURNING_SHARE).clamp(TURNING_CYCLES.0, TURNING_CYCLES.1);
    middle.saturating_sub(half).max(contact.from)..(middle + half + 1).min(contact.to)
}

/// What counts as moving, per axis.
struct Speeds {
    /// Velocity below which the axis stands; None for an axis that does not move.
    still: [Option<f64>; 6],
    cycles: usize,
    cycle_s: f64,
}

impl Speeds {
    fn new(model: &Model, signals: &Signals<'_>) -> Self {
        let sigma = signals.velocity_sigma(model);
        let executed = |axis: usize| {
            let values = signals
                .cycles
                .iter()
                .map(move |c| c.trace.executed_velocity[axis]);
            values.map(|v| if v.is_finite() { v } else { 0.0 })
        };
        let sent = |axis: usize| {
            signals
                .cycles
                .iter()
                .map(move |c| c.trace.sent_velocity[axis])
        };
        let mut noise = [0.0; 6];
        let mut fastest = [0.0_f64; 6];
        for axis in &model.rig.active_axes {
            let i = axis.index();
            noise[i] = noise_of_steps(executed(i)).max(sigma[i]);
            let fastest_of = |velocities: &mut dyn Iterator<Item = f64>| {
                let finite = velocities.filter(|v| v.is_finite());
                finite.fold(0.0, |m: f64, v| m.max(v.abs()))
            };
            // A sent velocity has no noise, and an axis to which none is sent does not move. Machines without a robot are sent
            // nothing.
            fastest[i] = match signals.is_commanded() {
                true => fastest_of(&mut sent(i)),
                false => fastest_of(&mut executed(i)),
            };
        }
        let of_kind = [0..3, 3..6].map(|kind| fastest[kind].iter().copied().fold(0.0, f64::max));
        let still = Axis::ALL.map(|axis| {
            let i = axis.index();
            let moves = fastest[i] > MOVING_SHARE * of_kind[usize::from(axis.is_rotation())];
            let still = (STILL_SHARE * fastest[i]).max(STILL_NOISE * noise[i]);
            (moves && fastest[i] > still).then_some(still)
        });
        Self {
            still,
            cycles: signals.len(),
            cycle_s: signals.cycle_s,
        }
    }

    /// Zero crossings of all moving axes by the given definition, with their margins.
    fn crossings(
        &self,
        value: impl Fn(usize, usize) -> f64,
        definition: impl Fn(&[f64], f64) -> Vec<Range<usize>>,
    ) -> Vec<Range<usize>> {
        let longest = (LONGEST_CROSSING_S / self.cycle_s) as usize;
        let mut all = Vec::new();
        for (axis, still) in self.still.iter().enumerate() {
            let Some(still) = still else { continue };
            let values: Vec<f64> = (0..self.cycles).map(|n| value(n, axis)).collect();
            all.extend(definition(&values, *still).into_iter().map(|c| {
                let from = c.start.max(c.end.saturating_sub(longest));
                from.saturating_sub(CROSSING_MARGIN.0)..c.end + CROSSING_MARGIN.1
            }));
        }
        all
    }

    /// End of the rebound that begins with cycle `from`: the cycle from which the robot follows the sent velocity, or `limit`, or
    /// the end of the longest rebound.
    fn settled(&self, signals: &Signals<'_>, from: usize, limit: usize) -> usize {
        let longest = from + (LONGEST_REBOUND_S / self.cycle_s) as usize;
        let limit = limit.min(longest);
        let mut followed = 0;
        for n in from..limit {
            let trace = &signals.cycles[n].trace;
            let follows = self.still.iter().enumerate().all(|(i, still)| {
                let late = trace.executed_velocity[i] - trace.sent_velocity[i];
                still.is_none_or(|still| late.abs() <= still)
            });
            followed = if follows { followed + 1 } else { 0 };
            if followed == SETTLED_CYCLES {
                return n + 1;
            }
        }
        limit
    }
}
