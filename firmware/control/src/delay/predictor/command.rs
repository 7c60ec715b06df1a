//! The command of a cycle: the tracking moves that bring the robot along the reference, a preload on top of them along the
//! contact, and the limits on their sum.

use super::V6;
use super::contact_estimator::Estimate;
use super::control_problem::ControlProblem;
use super::dynamic_matrix::{Tracking, Trajectory};
use super::free_response::FreeResponse;
use super::impulse_matching::ImpulseMatching;
use super::reference::Deviations;
use super::reversals::Reversals;
use super::stiffening::Curve;
use super::tuning::*;

/// What is sent, and its parts.
pub(super) struct Command {
    pub(super) velocity: V6,
    /// Its parts besides the model's velocity: the tracking of the reference, and the preload.
    pub(super) tracking: V6,
    pub(super) preload: V6,
    /// The preload along the contact, m/s.
    pub(super) preload_rate: f64,
    pub(super) reversals: Reversals,
    pub(super) at_speed_limit: bool,
}

impl ControlProblem<'_> {
    #[inline(never)]
    pub(super) fn solve(&self) -> Command {
        let cycle_s = self.model.cycle_s;
        let now = self.cycle as f64;
        let deviations_now: Deviations = self.reference.deviations(now, cycle_s);
        let deviations_at_execution: Deviations =
            self.reference.deviations(now + self.delay(), cycle_s);
        let tracked = self.contact.map(|contact| {
            let damping_cycles = contact.damping / (contact.stiffness * cycle_s);
            (contact, self.matrix.tracking(damping_cycles))
        });
        let first_row = match &tracked {
            Some((_, tracking)) => tracking.first_row,
            None => self.matrix.undamped_row(),
        };
        let free = FreeResponse::new(self, &deviations_now, &deviations_at_execution, &first_row);
        let moves = free.first_move / cycle_s;
        let preload_rate = tracked.as_ref().map_or(0.0, |(contact, tracking)| {
            self.preload_rate(contact, &free, tracking, &deviations_now)
        });
        let preload = self.reference.push * preload_rate;
        let base = self.base(&deviations_at_execution);
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

    /// The preload with which the impulse to come leaves the model with the velocity of the rebound, m/s along the contact; 0
    /// where no command can take effect within the rest of the contact.
    fn preload_rate(
        &self,
        contact: &Estimate,
        free: &FreeResponse,
        tracking: &Tracking<'_>,
        deviations_now: &Deviations,
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
        let preload = self.matrix.preload(self.cycle, &self.reference.preload);
        let linear = &self.model.linear;
        let sampled = linear.sampled(&tracked);
        let matching = ImpulseMatching {
            depth: &depth,
            sampled: &core::array::from_fn(|t| free.sampled[t] + sampled[t]),
            preload: &preload,
            sampled_preload: &linear.sampled(&preload),
            stiffness: curve.stiffness,
            stiffening: curve.stiffening,
            damping: contact.damping,
            inverse_mass: 1.0 / contact.mass,
            velocity: contact.gradient.dot(&self.velocity),
            target: self.reference.closing - deviations_now[PREDICTION_HORIZON].velocity,
            cycle_s: self.model.cycle_s,
        };
        matching.solve(SPEED_LIMIT * self.reference.closing.max(SPEED_LIMIT_BASE))
    }

    /// Earliest time after which the robot may respond to a command, cycles: the pose may be older than believed.
    ///
    /// Reversing too early costs a pause and the rest of the contact; reversing too late costs only the displacement until then.
    /// So a reversal waits for every latency that is not refuted, as long as the contact allows it: a robot that goes on until
    /// then, stands for a pause, and retreats as fast as it came, must not get more than a part of the rebound back
    /// ([`LARGEST_REBOUND_WHILE_WAITING`]).
    fn soonest(&self, free: &FreeResponse) -> f64 {
        let latest = self.latest.min(self.latency + DOUBTED_LATENCY_CYCLES);
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
        if left > -LARGEST_REBOUND_WHILE_WAITING * self.reference.restitution() * closing {
            soonest
        } else {
            self.delay()
        }
    }

    /// Velocity of the reference over the cycle in which the robot executes this command.
    fn base(&self, deviations_at_execution: &Deviations) -> V6 {
        let change = (deviations_at_execution[1].displacement
            - deviations_at_execution[0].displacement)
            / self.model.cycle_s;
        self.reference.velocity - self.reference.push * change
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

/// The command limited to a multiple of the velocity before the contact, and whether it was limited.
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
    use crate::delay::predictor::command_history::CommandHistory;
    use crate::delay::predictor::dynamic_matrix::DynamicMatrix;
    use crate::delay::predictor::kelvin_voigt::KelvinVoigt;
    use crate::delay::predictor::reference::Reference;
    use crate::delay::predictor::robot_model::{RobotModel, RobotState};
    use crate::delay::predictor::scene::{CYCLE, Scene, robot, robots};
    use crate::delay::spacecraft::CYCLE_S;

    const LATENCY: usize = 1;
    /// Cycles from a command to its execution if the pose is as old as believed, and cycles of a pause.
    const DELAY: f64 = 8.0;
    const PAUSE: f64 = 4.0;
    /// Position at which the spring of the contact is unloaded, m.
    const SURFACE: f64 = 0.3;

    fn model() -> RobotModel {
        RobotModel::new(&robot(DELAY, PAUSE, 0.0, 0.0), CYCLE_S, LATENCY as f64)
    }

    /// A case: when may the robot respond? A contact (k, c, m), the depth of the robot and its change per cycle (m), the velocity
    /// of the model and its closing velocity (m/s).
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
            let along = V6::ith(0, 1.0);
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
                sampled: [0.0; PREDICTION_HORIZON + 1],
            })
        }
    }

    /// A soft contact at its beginning.
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

    /// Velocity that the contact takes from the model if the robot goes on until it responds, stands for its pause and retreats
    /// as fast as it came; in a thousand steps each.
    fn velocity_taken(
        (k, c, m): (f64, f64, f64),
        (depth, per_cycle): (f64, f64),
        closing: f64,
    ) -> f64 {
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
            let least = velocity_taken(contact, depth, closing) - half;
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

    /// The robot has not touched when it could respond, and the model still closes in.
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

    /// Velocity along the contact at the end of the horizon if these commands are added, with a contact that never pulls, in 200
    /// steps of each cycle; the damper moves by the trapezoidal sum of its sampled velocities.
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
        let motion = scene.motion(more);
        let along = |(x, v): &(V6, V6)| (gradient.dot(x) - curve.surface, gradient.dot(v));
        let mut impulse = 0.0;
        for pair in motion.windows(2) {
            let ((before, old), (now, new)) = (along(&pair[0]), along(&pair[1]));
            let rate = 0.5 * (old + new);
            for n in 0..200 {
                let depth = before + (now - before) * (f64::from(n) + 0.5) / 200.0;
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
                let [deviation] = scene.reference.deviations(end, CYCLE_S);
                let target = scene.reference.closing - deviation.velocity;
                let excess = left(&scene, &more) - target;
                let bound = if stiffening > 0.0 { 1e-3 } else { 2e-5 } * scene.reference.closing;
                assert!(
                    excess.abs() < bound,
                    "{actuator:?} {latency} {since}: {excess:e}"
                );
            }
        }
    }

    /// The robot responds after 8 cycles and has moved after 9; the contact ends before or after that.
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

    /// A robot that is too deep and is to come back at once: it may do so half a pause and a delay before the reference reverses,
    /// which is a quarter of a period after the onset. Without a pause, or without a pure dead time, it is not held.
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
                scene.robot.position += V6::repeat(1e-3);
                let command = scene.ask(|problem| problem.solve());
                let sum = scene.velocity + command.tracking + command.preload;
                let (mut expected, _) = limited(sum, &scene.reference.velocity);
                assert!(expected[0] < 0.0);
                if held && since < quarter - 10.0 {
                    // The slowest velocity at which it may go on.
                    expected[0] = 0.005 * 0.005;
                }
                let apart = command.velocity - expected;
                assert!(apart.amax() < 1e-15, "{actuator:?} {since}: {apart}");
            }
        }
    }

    /// In a damped contact, and, if it is a clear retreat, after a quarter of a contact of 60 cycles: the reference reverses much
    /// later.
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
            scene.robot.position += V6::repeat(1e-3);
            let velocity = scene.ask(|problem| problem.solve().velocity);
            assert_eq!(velocity[0] < 0.0, turns, "{contact:?} {since}: {velocity}");
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
            // The limit is that of 0.2 mm/s, where the motion was slower.
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
