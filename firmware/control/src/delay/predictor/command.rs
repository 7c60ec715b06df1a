//! The command of a cycle: where the robot will be with what was sent, where it should be, and what
//! impulse is still to come.

use super::balance::Balance;
use super::identify::Estimate;
use super::reference::{Lag, Reference};
use super::solver::{Line, Solver};
use super::turn::Turns;
use super::twin::{Axes, Commands, Plan};
use super::{HORIZON, V6};

/// Fastest command, in units of the closing velocity.
const FASTEST: f64 = 4.0;
/// It is at least that of this velocity, m/s.
const SLOW: f64 = 2e-4;

/// What a command depends on.
pub(super) struct Situation<'a> {
    pub(super) cycle: usize,
    pub(super) plan: &'a Plan,
    pub(super) commands: &'a Commands,
    pub(super) solver: &'a Solver,
    pub(super) latency: usize,
    /// The robot at the time of the force.
    pub(super) axes: Axes,
    /// Velocity of the model.
    pub(super) velocity: V6,
    pub(super) reference: Reference,
    /// The contact that is going on or expected.
    pub(super) contact: Option<Estimate>,
    /// Way that the commands have leaned into it so far, m.
    pub(super) leaned: f64,
    /// Axes that have turned in it.
    pub(super) turns: Turns,
}

/// The answer.
pub(super) struct Decision {
    pub(super) command: V6,
    /// The part that tracks the reference, and the one that leans into the contact.
    pub(super) tracking: V6,
    pub(super) leaning: V6,
    /// The same along the contact, m/s.
    pub(super) lean: f64,
    pub(super) turns: Turns,
    pub(super) at_speed_limit: bool,
}

/// The first moves that track the reference, and what happens along the contact on the horizon.
struct Ahead {
    first_move: V6,
    error: Line,
    place: Line,
}

impl Situation<'_> {
    /// Delay from a command to its execution, at the time of the force, cycles.
    pub(super) fn delay(&self) -> f64 {
        (self.plan.chain.mean - self.latency as f64).max(0.0)
    }

    #[inline(never)]
    pub(super) fn decide(&self) -> Decision {
        let cycle_s = self.plan.cycle_s;
        let now = self.cycle as f64;
        let lags = self.reference.lags::<{ HORIZON + 1 }>(now, cycle_s);
        let lead = self
            .reference
            .lags::<{ HORIZON + 1 }>(now + self.delay(), cycle_s);
        let sluggish = self.contact.map_or(0.0, |contact| {
            contact.damping / (contact.stiffness * cycle_s)
        });
        let step = self.solver.step(sluggish);
        let gradient = self.contact.map_or(V6::zeros(), |contact| contact.gradient);
        let ahead = self.look_ahead(&lags, &lead, &gradient, step.first());
        let tracking = ahead.first_move / cycle_s;
        let lean = self.contact.map_or(0.0, |contact| {
            let during = self.during();
            if self.solver.authority(&during) < 1.0 {
                return 0.0;
            }
            let tracked = step.tracked(&ahead.error);
            let depth: Line = core::array::from_fn(|t| ahead.place[t] + tracked[t] - contact.wall);
            let balance = Balance {
                depth: &depth,
                lean: &self.solver.lean(),
                stiffness: contact.stiffness,
                damping: contact.damping,
                inverse_mass: 1.0 / contact.mass,
                velocity: gradient.dot(&self.velocity),
                target: self.reference.closing - lags[HORIZON].velocity,
                cycle_s,
            };
            balance.solve(FASTEST * self.reference.closing.max(SLOW))
        });
        let leaning = self.reference.push * lean;
        let base = self.base(&lead);
        let (mut command, at_speed_limit) =
            limited(base + tracking + leaning, &self.reference.velocity);
        let mut turns = self.turns;
        if self.contact.is_some() && self.plan.pause > 0.0 && self.plan.chain.is_pure() {
            let ahead = now + self.delay() + 0.5 * self.plan.pause;
            let [then] = self.reference.lags::<1>(ahead, cycle_s);
            let since = now - self.reference.touch;
            command = turns.allow(&command, &self.reference, &then, since, cycle_s);
        }
        Decision {
            command,
            tracking: base + tracking - self.velocity,
            leaning,
            lean,
            turns,
            at_speed_limit,
        }
    }

    /// Velocity of the reference, a delay ahead of this cycle.
    fn base(&self, lead: &[Lag; HORIZON + 1]) -> V6 {
        let change = (lead[1].way - lead[0].way) / self.plan.cycle_s;
        self.reference.velocity - self.reference.push * change
    }

    /// Follows the robot through the commands that were sent, then the reference's.
    ///
    /// The reference is straight but for what the contact takes away along its push, so that only the
    /// robot's own path needs all six axes at each time.
    #[inline(never)]
    fn look_ahead(
        &self,
        lags: &[Lag; HORIZON + 1],
        lead: &[Lag; HORIZON + 1],
        gradient: &V6,
        first: &Line,
    ) -> Ahead {
        let Reference {
            velocity, ref push, ..
        } = self.reference;
        let per_cycle = velocity * self.plan.cycle_s;
        // What was leaned stays: to take it back would take its impulse back.
        let start = self.reference.position
            + per_cycle * (self.cycle as f64 - self.reference.touch)
            + push * self.leaned;
        let (mut sum, mut later, mut taken) = (0.0, 0.0, 0.0);
        for (t, (first, lag)) in first.iter().zip(lags).enumerate() {
            sum += first;
            later += first * t as f64;
            taken += first * lag.way;
        }
        let mut ahead = Ahead {
            first_move: start * sum + per_cycle * later - push * taken,
            error: [0.0; HORIZON + 1],
            place: [0.0; HORIZON + 1],
        };
        let mut axes = self.axes;
        let changes = self.changes(lead);
        let mut commands = [0.0; HORIZON + 2];
        for (i, axis) in axes.0.iter_mut().enumerate() {
            self.executed(i, &changes, &mut commands);
            let (mut moved, gradient) = (0.0, gradient[i]);
            let [mut older, ref newer @ ..] = commands;
            let along = first.iter().zip(&mut ahead.place);
            for ((first, place), newer) in along.zip(newer) {
                moved += first * axis.position;
                *place += gradient * axis.position;
                axis.step(self.plan, older, *newer);
                older = *newer;
            }
            ahead.first_move[i] -= moved;
        }
        let (start, rate, push) = (
            gradient.dot(&start),
            gradient.dot(&per_cycle),
            gradient.dot(push),
        );
        for (t, (error, place)) in ahead.error.iter_mut().zip(&ahead.place).enumerate() {
            *error = start + rate * t as f64 - push * lags[t].way - place;
        }
        ahead
    }

    /// What the contact takes away of the velocity of the reference, a delay ahead of each cycle of the
    /// horizon.
    fn changes(&self, lead: &[Lag; HORIZON + 1]) -> Line {
        let per_way = 1.0 / self.plan.cycle_s;
        let mut changes = [lead[HORIZON].velocity; HORIZON + 1];
        for (change, pair) in changes.iter_mut().zip(lead.windows(2)) {
            if let [now, next] = pair {
                *change = (next.way - now.way) * per_way;
            }
        }
        changes
    }

    /// The commands that an axis executes: each cycle of the horizon begins with one of them and ends
    /// with the next. First those that are sent, then the reference.
    fn executed(&self, axis: usize, changes: &Line, commands: &mut [f64; HORIZON + 2]) {
        let (velocity, push) = (self.reference.velocity[axis], self.reference.push[axis]);
        let before = self.plan.chain.whole as isize + 1 - self.latency as isize;
        let (sent, later) = (before.max(0) as usize, (-before).max(0) as usize);
        let sent = sent.min(commands.len());
        let (old, new) = commands.split_at_mut(sent);
        for (t, command) in old.iter_mut().enumerate() {
            let cycle = (self.cycle + t).checked_add_signed(-before);
            *command = cycle.map_or(0.0, |cycle| self.commands.of_axis(cycle, axis));
        }
        let [.., last] = *changes;
        let changes = changes.iter().copied().skip(later);
        for (command, change) in new.iter_mut().zip(changes.chain(core::iter::repeat(last))) {
            *command = velocity - push * change;
        }
    }

    /// 1 while the contact lasts.
    fn during(&self) -> Line {
        let (from, to) = (self.reference.touch, self.reference.end(self.plan.cycle_s));
        core::array::from_fn(|t| {
            let cycle = (self.cycle + t) as f64;
            if cycle >= from && cycle <= to {
                1.0
            } else {
                0.0
            }
        })
    }
}

/// A command that is no faster than a multiple of the velocity before the contact, and whether it was.
pub(super) fn limited(command: V6, before: &V6) -> (V6, bool) {
    let most = FASTEST * before.norm().max(SLOW);
    let size = command.norm();
    if size > most {
        (command * (most / size), true)
    } else {
        (command, false)
    }
}
