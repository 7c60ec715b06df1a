//! Dynamic matrix control of the six axes: where the robot will be with what was sent, where it should be, and
//! the moves that bring it there.
//!
//! Over the prediction horizon the positions of an axis are x = x₀ + G U, with x₀ the free response (commands
//! that are sent, then those of the reference one mean delay ahead; pauses included) and G the dynamic matrix
//! from the robot model's response to one command. The moves that track the reference r with the least
//!
//! ```text
//! ‖r − x‖² + ρ ‖U‖²        are        U = H⁻¹ Gᵀ (r − x₀),        H = Gᵀ G + ρ I
//! ```
//!
//! (Cutler and Ramaker, "Dynamic matrix control: a computer control algorithm", Joint Automatic Control
//! Conference, 1980), and the first of them is sent. There are no constraints in it; the sum is limited
//! afterwards. On top of the moves comes a preload along the contact ([`ImpulseMatching`]).

use super::V6;
use super::command_history::CommandHistory;
use super::contact_estimator::Estimate;
use super::impulse_matching::{ImpulseMatching, Reversals};
use super::least_squares::Ldlt;
use super::preload::Preload;
use super::reference::{Deviation, Reference};
use super::robot_model::{RobotModel, RobotState};
use super::stiffening::Curve;
use super::tuning::*;
use nalgebra::{SMatrix, SVector};

type Moves = SVector<f64, CONTROL_HORIZON>;
/// A quantity along the horizon: now, and after 1, 2 ... cycles.
pub(super) type Trajectory = [f64; PREDICTION_HORIZON + 1];
type Deviations = [Deviation; PREDICTION_HORIZON + 1];

/// What depends on the robot model alone.
#[derive(Clone, Debug)]
pub(super) struct DynamicMatrix {
    /// Displacement after j cycles of a command that lasts for the first one, cycles.
    response: Trajectory,
    /// Cycles at its beginning in which nothing moves.
    dead: usize,
    /// Gᵀ G, lower triangle.
    gram: SMatrix<f64, CONTROL_HORIZON, CONTROL_HORIZON>,
}

/// The tracking law with the move suppression of this cycle.
struct Tracking<'a> {
    matrix: &'a DynamicMatrix,
    factor: Ldlt<CONTROL_HORIZON>,
    /// What the first move takes of an error at each time of the horizon, per cycle.
    first_row: Trajectory,
}

impl DynamicMatrix {
    /// Of a robot whose pose has a latency.
    pub(super) fn new(model: &RobotModel, latency: usize) -> Self {
        let response: Trajectory = model.linear.pulse_response(latency);
        let dead = response.iter().take_while(|x| **x == 0.0).count();
        let mut gram = SMatrix::zeros();
        for lag in 0..CONTROL_HORIZON {
            let products = response.iter().zip(&response[lag..]);
            gram[(lag, 0)] = products.map(|(a, b)| a * b).sum();
        }
        // One move later, the sum ends one cycle earlier.
        for j in 1..CONTROL_HORIZON {
            for i in j..CONTROL_HORIZON {
                let last =
                    response[PREDICTION_HORIZON + 1 - i] * response[PREDICTION_HORIZON + 1 - j];
                gram[(i, j)] = gram[(i - 1, j - 1)] - last;
            }
        }
        Self {
            response,
            dead,
            gram,
        }
    }

    /// For a contact of this damping over stiffness, in cycles.
    #[inline(never)]
    fn tracking(&self, damping_cycles: f64) -> Tracking<'_> {
        let rho = MOVE_SUPPRESSION + DAMPED_MOVE_SUPPRESSION * damping_cycles * damping_cycles;
        let mut h = self.gram;
        for i in 0..CONTROL_HORIZON {
            h[(i, i)] += rho;
        }
        let factor = Ldlt::new(h);
        let first_row = self.positions(&factor.solve(&Moves::ith(0, 1.0)));
        Tracking {
            matrix: self,
            factor,
            first_row,
        }
    }

    /// G U.
    fn positions(&self, moves: &Moves) -> Trajectory {
        let mut positions = [0.0; PREDICTION_HORIZON + 1];
        for (i, by) in moves.iter().enumerate() {
            let moved = positions.get_mut(i + self.dead..).unwrap_or_default();
            for (position, displacement) in moved.iter_mut().zip(self.alive()) {
                *position += displacement * by;
            }
        }
        positions
    }

    /// Gᵀ e.
    fn gathered(&self, error: &Trajectory) -> Moves {
        Moves::from_fn(|i, _| {
            let errors = error.get(i + self.dead..).unwrap_or_default();
            let products = errors.iter().zip(self.alive());
            products.map(|(e, displacement)| e * displacement).sum()
        })
    }

    /// The response from where something moves.
    fn alive(&self) -> &[f64] {
        self.response.get(self.dead..).unwrap_or_default()
    }

    /// Displacement by a preload whose first move is 1, and which goes as planned from a cycle on, cycles.
    fn preload(&self, cycle: usize, plan: &Preload) -> Trajectory {
        let mut displacement = 0.0;
        core::array::from_fn(|t| {
            displacement = PRELOAD_DECAY * displacement + self.response[t];
            displacement * plan.left((cycle + t) as f64)
        })
    }

    /// Displacement by a command of one cycle within the times for which `during` is 1.
    fn authority(&self, during: &Trajectory) -> f64 {
        (0..=PREDICTION_HORIZON)
            .map(|t| self.response[t] * during[t])
            .sum()
    }
}

impl Tracking<'_> {
    /// The positions that all tracking moves make.
    #[inline(never)]
    fn tracked(&self, error: &Trajectory) -> Trajectory {
        self.matrix
            .positions(&self.factor.solve(&self.matrix.gathered(error)))
    }
}

/// What a command depends on.
pub(super) struct ControlProblem<'a> {
    pub(super) cycle: usize,
    pub(super) model: &'a RobotModel,
    pub(super) commands: &'a CommandHistory,
    pub(super) matrix: &'a DynamicMatrix,
    pub(super) latency: usize,
    /// The robot at the time of the force.
    pub(super) robot: RobotState,
    /// Velocity of the model of the two spacecraft.
    pub(super) velocity: V6,
    pub(super) reference: Reference,
    /// The contact that is going on or expected.
    pub(super) contact: Option<Estimate>,
    /// Axes that have reversed in it.
    pub(super) reversals: Reversals,
    /// The largest latency that the pose may have, cycles.
    pub(super) latest: usize,
    /// Its load over depth, where it is no spring.
    pub(super) curve: Option<Curve>,
}

/// The answer.
pub(super) struct Command {
    pub(super) velocity: V6,
    /// Its parts beside the model's velocity: what tracks the reference, and the preload.
    pub(super) tracking: V6,
    pub(super) preload: V6,
    /// The preload along the contact, m/s.
    pub(super) preload_rate: f64,
    pub(super) reversals: Reversals,
    pub(super) at_speed_limit: bool,
}

/// The free response: the first tracking moves for it, m, and along the contact its error and position, m.
struct FreeResponse {
    first_move: V6,
    error: Trajectory,
    position: Trajectory,
}

impl ControlProblem<'_> {
    /// Delay from a command to its execution, at the time of the force, cycles.
    pub(super) fn delay(&self) -> f64 {
        self.model.execution_delay(self.latency)
    }

    #[inline(never)]
    pub(super) fn solve(&self) -> Command {
        let cycle_s = self.model.cycle_s;
        let now = self.cycle as f64;
        let taken: Deviations = self.reference.deviations(now, cycle_s);
        let ahead: Deviations = self.reference.deviations(now + self.delay(), cycle_s);
        let damping_cycles = self.contact.map_or(0.0, |contact| {
            contact.damping / (contact.stiffness * cycle_s)
        });
        let tracking = self.matrix.tracking(damping_cycles);
        let gradient = self.contact.map_or(V6::zeros(), |contact| contact.gradient);
        let free = self.free_response(&taken, &ahead, &gradient, &tracking.first_row);
        let moves = free.first_move / cycle_s;
        let preload_rate = self.contact.map_or(0.0, |contact| {
            self.preload_rate(&contact, &free, &tracking, &taken)
        });
        let preload = self.reference.push * preload_rate;
        let base = self.base(&ahead);
        let (mut velocity, at_speed_limit) =
            limited(base + moves + preload, &self.reference.velocity);
        let mut reversals = self.reversals;
        if self.contact.is_some() && self.model.pause > 0.0 && self.model.linear.is_dead_time {
            let soonest = self.soonest(&free);
            let answered = now + soonest + 0.5 * self.model.pause;
            let [then] = self.reference.deviations(answered, cycle_s);
            let since = now - self.reference.onset;
            let known = (since, soonest >= self.delay());
            velocity = reversals.allow(&velocity, &self.reference, &then, known, cycle_s);
        }
        Command {
            velocity,
            tracking: base + moves - self.velocity,
            preload,
            preload_rate,
            reversals,
            at_speed_limit,
        }
    }

    /// The preload for which the impulse to come is that of the rebound, m/s along the contact; none where no
    /// command can reach the rest of the contact.
    fn preload_rate(
        &self,
        contact: &Estimate,
        free: &FreeResponse,
        tracking: &Tracking<'_>,
        taken: &Deviations,
    ) -> f64 {
        if self.matrix.authority(&self.during()) < LEAST_AUTHORITY {
            return 0.0;
        }
        let tracked = tracking.tracked(&free.error);
        let straight = Curve {
            surface: contact.surface,
            stiffness: contact.stiffness,
            stiffening: 0.0,
        };
        let curve = self.curve.unwrap_or(straight);
        let depth: Trajectory =
            core::array::from_fn(|t| free.position[t] + tracked[t] - curve.surface);
        let matching = ImpulseMatching {
            depth: &depth,
            preload: &self.matrix.preload(self.cycle, &self.reference.preload),
            stiffness: curve.stiffness,
            stiffening: curve.stiffening,
            damping: contact.damping,
            inverse_mass: 1.0 / contact.mass,
            velocity: contact.gradient.dot(&self.velocity),
            target: self.reference.closing - taken[PREDICTION_HORIZON].velocity,
            cycle_s: self.model.cycle_s,
        };
        matching.solve(SPEED_LIMIT * self.reference.closing.max(SPEED_LIMIT_BASE))
    }

    /// Delay after which the robot may answer at the soonest, cycles: of a pose that may be older than believed.
    ///
    /// Turning too early costs a pause and the rest of the contact, turning late only what the robot goes meanwhile. So a
    /// reversal waits for what is not refuted, as long as the contact bears it: as long as a robot that goes on until then,
    /// stands for a pause, and retreats as fast as it came, gets no more than a part of the rebound.
    fn soonest(&self, free: &FreeResponse) -> f64 {
        let latest = self.latest.min(self.latency + OLDER_POSE);
        let soonest = self.model.execution_delay(latest.max(self.latency));
        let Some(contact) = self.contact.filter(|_| soonest < self.delay()) else {
            return self.delay();
        };
        let depth =
            |t: usize| (free.position[t.min(PREDICTION_HORIZON)] - contact.surface).max(0.0);
        let (now, then) = (depth(0), depth(soonest as usize));
        let (cycle_s, closing) = (self.model.cycle_s, self.reference.closing);
        let waited = (0.5 * (now + then) * soonest + then * self.model.pause) * cycle_s;
        let retreat = 0.5 * then * then / closing.max(f64::MIN_POSITIVE);
        let impulse = contact.stiffness * (waited + retreat) - contact.damping * now;
        let left = contact.gradient.dot(&self.velocity) - impulse / contact.mass;
        if left > -WAITING_TAKES * self.reference.restitution() * closing {
            soonest
        } else {
            self.delay()
        }
    }

    /// Velocity of the reference, a delay ahead of this cycle.
    fn base(&self, ahead: &Deviations) -> V6 {
        let change = (ahead[1].displacement - ahead[0].displacement) / self.model.cycle_s;
        self.reference.velocity - self.reference.push * change
    }

    /// Follows the robot through the commands that were sent, then the reference's.
    ///
    /// The reference is straight but for what the contact takes away along its push, so that only the
    /// robot's own path needs all six axes at each time.
    #[inline(never)]
    fn free_response(
        &self,
        taken: &Deviations,
        ahead: &Deviations,
        gradient: &V6,
        first_row: &Trajectory,
    ) -> FreeResponse {
        let Reference {
            velocity, ref push, ..
        } = self.reference;
        let per_cycle = velocity * self.model.cycle_s;
        let start =
            self.reference.position + per_cycle * (self.cycle as f64 - self.reference.onset);
        let (mut sum, mut later, mut lost) = (0.0, 0.0, 0.0);
        for (t, (first, taken)) in first_row.iter().zip(taken).enumerate() {
            sum += first;
            later += first * t as f64;
            lost += first * taken.displacement;
        }
        let mut free = FreeResponse {
            first_move: start * sum + per_cycle * later - push * lost,
            error: [0.0; PREDICTION_HORIZON + 1],
            position: [0.0; PREDICTION_HORIZON + 1],
        };
        let mut robot = self.robot;
        let changes = self.changes(ahead);
        let mut commands = [0.0; PREDICTION_HORIZON + 1];
        for (i, axis) in robot.0.iter_mut().enumerate() {
            self.executed(i, &changes, &mut commands);
            let mut path = [axis.position; PREDICTION_HORIZON + 1];
            let [_, ahead @ ..] = &mut path;
            axis.follow(self.model, &commands, ahead);
            let (mut moved, gradient) = (0.0, gradient[i]);
            for ((first, position), at) in first_row.iter().zip(&mut free.position).zip(path) {
                moved += first * at;
                *position += gradient * at;
            }
            free.first_move[i] -= moved;
        }
        let (start, rate, push) = (
            gradient.dot(&start),
            gradient.dot(&per_cycle),
            gradient.dot(push),
        );
        for (t, (error, position)) in free.error.iter_mut().zip(&free.position).enumerate() {
            *error = start + rate * t as f64 - push * taken[t].displacement - position;
        }
        free
    }

    /// What the contact takes away of the velocity of the reference, a delay ahead of each cycle of the
    /// horizon.
    fn changes(&self, ahead: &Deviations) -> Trajectory {
        let per_displacement = 1.0 / self.model.cycle_s;
        let mut changes = [ahead[PREDICTION_HORIZON].velocity; PREDICTION_HORIZON + 1];
        for (change, pair) in changes.iter_mut().zip(ahead.windows(2)) {
            if let [now, next] = pair {
                *change = (next.displacement - now.displacement) * per_displacement;
            }
        }
        changes
    }

    /// The commands that an axis executes: each cycle of the horizon begins with one of them and ends
    /// with the next. First those that are sent, then the reference.
    fn executed(&self, axis: usize, changes: &Trajectory, commands: &mut Trajectory) {
        let (velocity, push) = (self.reference.velocity[axis], self.reference.push[axis]);
        let before = self.model.linear.whole as isize + 1 - self.latency as isize;
        let (sent, later) = (before.max(0) as usize, (-before).max(0) as usize);
        let sent = sent.min(commands.len());
        let (old, new) = commands.split_at_mut(sent);
        for (t, command) in old.iter_mut().enumerate() {
            let cycle = (self.cycle + t).checked_add_signed(-before);
            *command = cycle.map_or(0.0, |cycle| self.commands.of_axis(cycle, axis));
        }
        let [.., last] = changes;
        for (t, command) in new.iter_mut().enumerate() {
            *command = velocity - push * changes.get(later + t).unwrap_or(last);
        }
    }

    /// 1 while the contact lasts.
    fn during(&self) -> Trajectory {
        let contact = self.reference.onset..=self.reference.end(self.model.cycle_s);
        core::array::from_fn(|t| {
            let within = contact.contains(&((self.cycle + t) as f64));
            if within { 1.0 } else { 0.0 }
        })
    }
}

/// A command that is no faster than a multiple of the velocity before the contact, and whether it was.
pub(super) fn limited(command: V6, before: &V6) -> (V6, bool) {
    let most = SPEED_LIMIT * before.norm().max(SPEED_LIMIT_BASE);
    let size = command.norm();
    if size > most {
        (command * (most / size), true)
    } else {
        (command, false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::actuator::ActuatorSettings;
    use crate::delay::predictor::kelvin_voigt::KelvinVoigt;
    use crate::delay::predictor::scene::{CYCLE, Scene, robots};
    use crate::delay::spacecraft::CYCLE_S;

    const LATENCY: usize = 1;
    /// Cycles from a command to its execution if the pose is as old as believed, and of a pause.
    const DELAY: f64 = 8.0;
    const PAUSE: f64 = 4.0;
    /// Where the contact's spring is free, m.
    const SURFACE: f64 = 0.3;

    fn model() -> RobotModel {
        let actuator = ActuatorSettings {
            delay_s: DELAY * CYCLE_S,
            pause_s: PAUSE * CYCLE_S,
            ..ActuatorSettings::default()
        };
        RobotModel::new(&actuator, CYCLE_S, LATENCY as f64)
    }

    /// What is asked: when the robot may answer, in a contact (k, c, m) into which the robot goes on (depth, and per cycle, m)
    /// with the model at a velocity after a closing velocity, m/s.
    struct Question {
        contact: Option<(f64, f64, f64)>,
        depth: (f64, f64),
        velocity: f64,
        closing: f64,
        latest: usize,
    }

    impl Question {
        fn answer(&self) -> f64 {
            let model = model();
            let along = V6::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.0);
            let mut reference = Reference::straight(0, V6::zeros(), along * self.closing);
            reference.closing = self.closing;
            reference.contact = self.contact.map(|(k, c, m)| KelvinVoigt::new(k, c, m));
            let contact = self.contact.map(|(k, c, m)| {
                let mut contact = Estimate::exact(k, c, m);
                contact.surface = SURFACE;
                contact
            });
            let problem = ControlProblem {
                cycle: 0,
                model: &model,
                commands: &CommandHistory::new(),
                matrix: &DynamicMatrix::new(&model, LATENCY),
                latency: LATENCY,
                robot: RobotState::default(),
                velocity: along * self.velocity,
                reference,
                contact,
                reversals: Reversals::default(),
                latest: self.latest,
                curve: None,
            };
            let (depth, per_cycle) = self.depth;
            problem.soonest(&FreeResponse {
                first_move: V6::zeros(),
                error: [0.0; PREDICTION_HORIZON + 1],
                position: core::array::from_fn(|t| SURFACE + depth + per_cycle * t as f64),
            })
        }
    }

    /// A soft contact that has hardly begun.
    fn soft(latest: usize) -> Question {
        Question {
            contact: Some((10_000.0, 0.0, 500.0)),
            depth: (2e-5, 2e-5),
            velocity: 0.005,
            closing: 0.005,
            latest,
        }
    }

    #[test]
    fn a_reversal_waits_for_poses_up_to_two_cycles_older_that_are_not_refuted() {
        for (latest, answered) in [(0, 8.0), (1, 8.0), (2, 7.0), (3, 6.0), (4, 6.0)] {
            let soonest = soft(latest).answer();
            assert!((soonest - answered).abs() < 1e-9, "{latest}: {soonest}");
        }
    }

    #[test]
    fn without_a_contact_the_robot_answers_after_its_delay() {
        let mut flight = soft(4);
        flight.contact = None;
        assert!((flight.answer() - DELAY).abs() < 1e-9);
    }

    /// Velocity that the contact takes from the model if the robot goes on until the answer, stands for its pause and retreats
    /// as fast as it came, in a thousand steps each.
    fn taken((k, c, m): (f64, f64, f64), (depth, per_cycle): (f64, f64), closing: f64) -> f64 {
        let answer = DELAY - 2.0;
        let deepest = depth + per_cycle * answer;
        let mut impulse = 0.0;
        for (from, to, duration) in [
            (depth, deepest, answer * CYCLE_S),
            (deepest, deepest, PAUSE * CYCLE_S),
            (deepest, 0.0, deepest / closing),
        ] {
            let rate = (to - from) / duration;
            for n in 0..1000 {
                let at = from + (to - from) * (f64::from(n) + 0.5) / 1000.0;
                impulse += (k * at + c * rate) * duration / 1000.0;
            }
        }
        impulse / m
    }

    /// To a micrometre per second.
    #[test]
    fn a_reversal_waits_as_long_as_the_contact_gives_back_no_more_than_half_of_the_rebound() {
        for (contact, depth, closing) in [
            ((220_500.0, 2100.0, 500.0), (2e-5, 2e-5), 0.005),
            ((220_500.0, 0.0, 500.0), (0.0, 2e-5), 0.005),
            ((100_000.0, 4000.0, 200.0), (1e-4, 1e-5), 0.01),
            ((500_000.0, 1000.0, 800.0), (8e-5, -5e-6), 0.002),
        ] {
            let (k, c, m) = contact;
            let half = 0.5 * KelvinVoigt::new(k, c, m).restitution * closing;
            let least = taken(contact, depth, closing) - half;
            for (velocity, answered) in [(least + 1e-6, DELAY - 2.0), (least - 1e-6, DELAY)] {
                let question = Question {
                    contact: Some(contact),
                    depth,
                    velocity,
                    closing,
                    latest: 4,
                };
                let soonest = question.answer();
                assert!((soonest - answered).abs() < 1e-9, "{contact:?}: {soonest}");
            }
        }
    }

    /// It has not yet touched when it could answer, and the model still closes.
    #[test]
    fn a_robot_outside_of_the_contact_takes_nothing() {
        let mut question = soft(4);
        question.contact = Some((1e8, 1e5, 500.0));
        question.depth = (-1e-3, 2e-5);
        question.velocity = 1e-9;
        assert!((question.answer() - (DELAY - 2.0)).abs() < 1e-9);
    }

    #[test]
    fn the_first_tracking_move_is_that_of_the_least_squares() {
        for actuator in robots() {
            for (latency, zeta, since) in [(0, 0.0, 3.3), (2, 0.4, -4.6), (1, 0.0, 30.2)] {
                let scene = Scene::new(&actuator, latency, zeta, since);
                let expected = scene.base(0) + scene.moves()[0] - scene.velocity;
                let found = scene.ask(|problem| problem.solve().tracking);
                let error = (found - expected).amax();
                assert!(
                    error < 1e-9,
                    "{actuator:?} {latency} {since}: {found} {expected}"
                );
            }
        }
    }

    /// Velocity along the contact that is left after the horizon of what the robot does with these commands more, by a contact
    /// that never pulls, in 200 steps of each cycle.
    fn left(scene: &Scene, more: &[V6]) -> f64 {
        let Estimate {
            stiffness,
            damping,
            gradient,
            mass,
            ..
        } = scene.contact;
        let straight = Curve {
            surface: scene.contact.surface,
            stiffness,
            stiffening: 0.0,
        };
        let curve = scene.curve.unwrap_or(straight);
        let depths = scene.positions(more).into_iter();
        let depths: Vec<f64> = depths.map(|x| gradient.dot(&x) - curve.surface).collect();
        let mut impulse = 0.0;
        for pair in depths.windows(2) {
            for n in 0..200 {
                let depth = pair[0] + (pair[1] - pair[0]) * (f64::from(n) + 0.5) / 200.0;
                let rate = (pair[1] - pair[0]) / CYCLE_S;
                if depth > 0.0 {
                    let spring = (curve.stiffness + curve.stiffening * depth) * depth;
                    impulse += (spring + damping * rate).max(0.0) * CYCLE_S / 200.0;
                }
            }
        }
        gradient.dot(&scene.velocity) - impulse / mass
    }

    #[test]
    fn the_preload_leaves_the_model_with_the_velocity_of_the_rebound() {
        for actuator in robots() {
            for (latency, zeta, since, stiffening) in [
                (0, 0.0, 3.3, 0.0),
                (2, 0.2, 1.6, 0.0),
                (1, 0.0, 5.2, 2e7),
                (1, 0.0, -4.5, 0.0),
            ] {
                let mut scene = Scene::new(&actuator, latency, zeta, since);
                if stiffening > 0.0 {
                    scene.curve = Some(Curve {
                        surface: scene.contact.surface + 1e-5,
                        stiffness: scene.contact.stiffness * 1.05,
                        stiffening,
                    });
                }
                let rate = scene.ask(|problem| problem.solve().preload_rate);
                assert!(rate.abs() > 1e-3 * scene.reference.closing);
                let mut more = scene.moves();
                more.resize(PREDICTION_HORIZON + 1, V6::zeros());
                for (t, more) in more.iter_mut().enumerate() {
                    *more += scene.contact.push * (rate * 0.5_f64.powi(t as i32));
                }
                let end = (CYCLE + PREDICTION_HORIZON) as f64;
                let [taken] = scene.reference.deviations(end, CYCLE_S);
                let target = scene.reference.closing - taken.velocity;
                let excess = left(&scene, &more) - target;
                let bound = if stiffening > 0.0 { 1e-3 } else { 2e-5 } * scene.reference.closing;
                assert!(
                    excess.abs() < bound,
                    "{actuator:?} {latency} {since}: {excess:e}"
                );
            }
        }
    }

    /// The robot answers after 8 cycles and has moved after 9; the contact ends before or after that.
    #[test]
    fn there_is_no_preload_for_a_contact_that_no_command_reaches() {
        let [actuator, ..] = robots();
        let contact = core::f64::consts::PI / 21.0 / CYCLE_S;
        for (left, reached) in [(8.9, false), (9.1, true)] {
            let scene = Scene::new(&actuator, 1, 0.0, contact - left);
            let command = scene.ask(|problem| problem.solve());
            assert_eq!(command.preload_rate != 0.0, reached, "{left}");
            assert_eq!(command.preload, scene.contact.push * command.preload_rate);
            let sum = scene.velocity + command.tracking + command.preload;
            let (expected, at_limit) = limited(sum, &scene.reference.velocity);
            assert_eq!(command.at_speed_limit, at_limit);
            assert!((command.velocity - expected).amax() < 1e-15, "{expected}");
        }
    }

    /// Four times the velocity of the approach, or of 0.2 mm/s.
    #[test]
    fn a_preload_is_no_faster_than_the_speed_limit() {
        let [actuator, ..] = robots();
        for (closing, most) in [(0.005, 0.02), (1e-4, 8e-4)] {
            for (velocity, sign) in [(1.0, 1.0), (-1.0, -1.0)] {
                let mut scene = Scene::straight(&actuator, (21.0, 0.0), 4.3);
                scene.reference.closing = closing;
                scene.velocity[0] = velocity;
                let rate = scene.ask(|problem| problem.solve().preload_rate);
                assert!((rate - sign * most).abs() < 1e-12, "{closing}: {rate}");
            }
        }
    }

    /// Of a robot that is too deep and is to come back at once: half a pause and a delay before the reference turns, which is a
    /// quarter of a period after the onset. Without a pause, or without a dead time, there is nothing to hold.
    #[test]
    fn an_axis_turns_no_sooner_than_half_a_pause_and_a_delay_before_the_reference() {
        let [dead_time, _, lag, _, servo] = robots();
        let quarter = core::f64::consts::FRAC_PI_2 / 21.0 / CYCLE_S;
        for (robot, pause_s) in [
            (&dead_time, 0.016),
            (&dead_time, 0.0),
            (&lag, 0.016),
            (&servo, 0.016),
        ] {
            let held = pause_s > 0.0 && core::ptr::eq(robot, &dead_time);
            for since in (0..13).map(|n| 0.7 * f64::from(n) + 0.4) {
                let actuator = ActuatorSettings {
                    pause_s,
                    ..robot.clone()
                };
                let mut scene = Scene::straight(&actuator, (21.0, 0.0), since);
                scene.robot.shift(&V6::repeat(1e-3));
                let command = scene.ask(|problem| problem.solve());
                let sum = scene.velocity + command.tracking + command.preload;
                let (mut expected, _) = limited(sum, &scene.reference.velocity);
                assert!(expected[0] < 0.0);
                if held && since < quarter - 10.0 {
                    // As slowly as it may go on.
                    expected[0] = 0.005 * 0.005;
                }
                let apart = command.velocity - expected;
                assert!(apart.amax() < 1e-15, "{actuator:?} {since}: {apart}");
            }
        }
    }

    /// In a damped contact, and after a quarter of a contact of 60 cycles if it is a clear retreat: the reference turns much later.
    #[test]
    fn an_axis_may_turn_early_where_that_is_meant() {
        let [mut actuator, ..] = robots();
        actuator.pause_s = 0.016;
        for (contact, since, turns) in [
            ((21.0, 0.3), 4.4, true),
            ((21.0, 0.0), 4.4, false),
            ((13.0, 0.0), 14.4, false),
            ((13.0, 0.0), 15.8, true),
        ] {
            let mut scene = Scene::straight(&actuator, contact, since);
            scene.robot.shift(&V6::repeat(1e-3));
            let velocity = scene.ask(|problem| problem.solve().velocity);
            assert_eq!(velocity[0] < 0.0, turns, "{contact:?} {since}: {velocity}");
        }
    }

    /// By moves of 1, ½, ¼ ... each of which the plan takes back from cycle 70 to 80.
    #[test]
    fn a_planned_preload_goes_back_as_planned() {
        let [.., actuator] = robots();
        let scene = Scene::new(&actuator, 1, 0.0, 0.0);
        let matrix = DynamicMatrix::new(&scene.model, 1);
        let found = matrix.preload(CYCLE, &Preload::default().planned(70.0, Some(80.0)));
        let response: Trajectory = scene.model.linear.pulse_response(1);
        for (t, found) in found.iter().enumerate() {
            let way: f64 = (0..=t)
                .map(|i| response[t - i] * 0.5_f64.powi(i as i32))
                .sum();
            let left = (80.0 - (CYCLE + t) as f64).clamp(0.0, 10.0) / 10.0;
            assert!((found - way * left).abs() < 1e-12, "{t}");
        }
    }

    #[test]
    fn a_command_is_at_most_four_times_as_fast_as_the_approach() {
        let before = V6::new(0.003, 0.0, 0.004, 0.0, 0.0, 0.0);
        let command = V6::new(0.0, 3.0, 0.0, 4.0, 0.0, 0.0);
        for (size, before, most) in [
            (0.019, before, None),
            (0.021, before, Some(0.02)),
            (1.0, before, Some(0.02)),
            // Of 0.2 mm/s, where it was slower.
            (0.00079, before * 0.01, None),
            (0.00081, before * 0.01, Some(0.0008)),
        ] {
            let (found, at_limit) = limited(command * (size / 5.0), &before);
            assert_eq!(at_limit, most.is_some(), "{size}");
            let expected = command * (most.unwrap_or(size) / 5.0);
            assert!((found - expected).amax() < 1e-15, "{size}");
        }
    }
}
