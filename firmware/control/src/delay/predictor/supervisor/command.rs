//! Which law commands, and along which reference.

use super::Supervisor;
use crate::delay::predictor::V6;
use crate::delay::predictor::axis_map::AxisMap;
use crate::delay::predictor::command::Command;
use crate::delay::predictor::contact::Contact;
use crate::delay::predictor::contact_estimator::Estimate;
use crate::delay::predictor::control_problem::ControlProblem;
use crate::delay::predictor::observer::Observer;
use crate::delay::predictor::reference::Reference;
use crate::delay::predictor::tuning::*;
use crate::delay::status::{ConfidenceLevel, LawFlags};
use crate::delay::{LawInput, LawOutput};
use crate::scalar::Scalar;

impl Supervisor {
    /// The command of this cycle.
    #[inline(never)]
    pub(in super::super) fn command<S: Scalar>(
        &mut self,
        observer: &mut Observer,
        contact: Option<&mut Contact>,
        input: &LawInput<'_, S>,
    ) -> LawOutput<S> {
        let velocity = observer.map.velocity(&input.model_end);
        let cycle_s = self.model.cycle_s;
        let robot = observer.robot_at_force(&self.model, self.latency);
        if input.released {
            self.released = self.released.saturating_add(1);
        }
        // Until the approach is identified, the model's position is set to that of the robot, so that both are in phase.
        if contact.is_none() && !self.has_started() {
            observer.model = robot.position + velocity * cycle_s;
            return self.output(LawOutput::of(input.model_end));
        }
        let (reference, estimate) = self.aim(contact.as_deref(), observer, &velocity);
        let problem = ControlProblem {
            cycle: observer.cycle,
            model: &self.model,
            commands: &observer.commands,
            matrix: &self.matrix,
            latency: self.latency,
            robot,
            velocity,
            reference,
            contact: estimate,
            reversals: self.reversals,
            latest: self.latest(contact.as_deref()),
            curve: contact
                .as_ref()
                .and_then(|contact| contact.curve(self.latency)),
        };
        let trusted = self.confidence != ConfidenceLevel::Fallback;
        let command = self.fallback.command(&problem, contact.is_some(), trusted);
        if let Some(contact) = contact {
            contact.preload = problem.reference.preload;
            contact.preload.advance(command.preload_rate * cycle_s);
        }
        if self.fallback.trust <= 0.0 {
            observer.model = robot.position;
        }
        observer.model += velocity * cycle_s;
        self.given(&command, &observer.map)
    }

    /// The reference, and the contact that is going on or expected.
    fn aim(
        &mut self,
        contact: Option<&Contact>,
        observer: &Observer,
        velocity: &V6,
    ) -> (Reference, Option<Estimate>) {
        let (reference, estimate) = match contact {
            Some(contact) => (
                self.reference(contact, observer, velocity),
                Some(*contact.estimate(self.latency)),
            ),
            None => self.reference_ahead(observer, velocity),
        };
        if estimate.is_none() {
            self.matrix.prepare();
        }
        (reference, estimate)
    }

    /// The output with a command; records its reversals and whether it was limited.
    fn given<S: Scalar>(&mut self, command: &Command, map: &AxisMap) -> LawOutput<S> {
        self.reversals = command.reversals;
        if command.at_speed_limit {
            self.flags.set(LawFlags::SPEED_LIMIT);
        }
        let mut output = LawOutput::of(map.twist(&command.velocity));
        output.parts[0] = map.twist(&command.tracking);
        output.parts[1] = map.twist(&command.preload);
        self.output(output)
    }

    /// The largest latency that the pose may have, cycles: in a contact the largest that is not refuted; the believed one without
    /// a contact, or if the latency is known or was settled in an earlier contact.
    fn latest(&self, contact: Option<&Contact>) -> usize {
        match contact {
            Some(contact) if !self.latency_known && !self.latency_found => contact.estimator.latest,
            _ => self.latency,
        }
    }

    /// The reference in a contact: along it the identified motion plus the preload so far, across it the motion of the model,
    /// which friction may have turned.
    ///
    /// For a robot that responds after a dead time the preload is taken back, as its motion is then known beforehand. In a
    /// contact with much damping it stays, as taking it back would change the load of the damper.
    pub(super) fn reference(
        &self,
        contact: &Contact,
        observer: &Observer,
        velocity: &V6,
    ) -> Reference {
        let (cycle, cycle_s) = (observer.cycle as f64, self.model.cycle_s);
        let gradient = &contact.estimate(self.latency).gradient;
        let mut reference = contact.reference(self.latency).across(
            gradient,
            cycle,
            (&observer.model, velocity),
            cycle_s,
        );
        let executed = cycle + self.model.execution_delay(self.latency);
        let has_dead_time = self.model.linear.whole > self.latency;
        let (zeta, end) = (reference.damping_ratio(), reference.end(cycle_s));
        let end = if contact.first_latency == self.latency {
            let taken_back = has_dead_time && zeta <= FREE_REVERSAL_DAMPING;
            taken_back.then_some(end + TAKEN_BACK_LATER)
        } else {
            // Commands that were computed with another latency have delayed the robot: the preload has to end in time.
            let taken_back = self.model.linear.is_dead_time && zeta <= FREE_REVERSAL_DAMPING;
            taken_back.then_some(end)
        };
        reference.preload = contact.preload.planned(executed, end);
        reference
    }

    /// Whether the approach is identified and the robot has the velocity of the model.
    fn has_started(&self) -> bool {
        let start_up = START_UP_DELAYS * self.model.linear.mean_delay + START_UP_CYCLES;
        self.approach.is_over() && f64::from(self.released) > start_up
    }

    /// The reference in free flight: straight on, or into a remembered contact.
    fn reference_ahead(
        &mut self,
        observer: &Observer,
        velocity: &V6,
    ) -> (Reference, Option<Estimate>) {
        let horizon = PREDICTION_HORIZON as f64 - CONTROL_HORIZON as f64;
        let flight = (observer.cycle, &observer.model, velocity);
        if let Some((reference, estimate)) = self.memory.ahead(flight, horizon, self.model.cycle_s)
        {
            self.flags.set(LawFlags::MEMORY);
            return (reference, Some(estimate));
        }
        let straight = Reference::straight(observer.cycle, observer.model, *velocity);
        (straight, None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::DelaySettings;
    use crate::delay::predictor::approach::Approach;
    use crate::delay::predictor::bounce::{Bounce, assert_near, x};
    use crate::delay::predictor::scene::robots;
    use crate::delay::predictor::supervisor::tests::supervisor;
    use crate::delay::spacecraft::CYCLE_S;

    /// Three mean delays and eight cycles after the ramp, once the approach is known.
    #[test]
    fn it_begins_when_robot_and_model_have_the_same_velocity() {
        let mut supervisor = supervisor(0.0);
        for (released, started) in [(32, false), (33, true)] {
            supervisor.released = released;
            assert_eq!(supervisor.has_started(), started, "{released}");
        }
        supervisor.approach = Approach::new(V6::zeros(), &x(0.005));
        assert!(!supervisor.has_started());
    }

    /// The end of a preload, cycles after the end of the contact; `None`: it stays.
    #[test]
    fn a_preload_is_taken_back_by_a_robot_with_a_dead_time_in_a_contact_that_is_not_damped() {
        let [dead_time, _, lag, mixed, _] = robots();
        for (actuator, zeta, first_latency, expected) in [
            (&dead_time, 0.0, 0, Some(5.0)),
            (&dead_time, 0.2, 0, Some(5.0)),
            (&dead_time, 0.3, 0, None),
            (&mixed, 0.0, 0, Some(5.0)),
            (&lag, 0.0, 0, None),
            // Commands before were computed with another latency.
            (&dead_time, 0.0, 1, Some(0.0)),
            (&dead_time, 0.3, 1, None),
            (&mixed, 0.0, 1, None),
        ] {
            let settings = DelaySettings {
                actuator: actuator.clone(),
                ..DelaySettings::default()
            };
            let supervisor = Supervisor::new(&settings, CYCLE_S);
            let bounce = Bounce {
                zeta,
                ..Bounce::spring(0.5)
            };
            let mut contact = bounce.followed(0.01, 25);
            contact.first_latency = first_latency;
            (0..10).for_each(|_| contact.preload.advance(1e-6));
            let mut observer = bounce.observer(75);
            observer.model = observer.at_force.position[0];
            let reference = supervisor.reference(&contact, &observer, &contact.velocity);
            let executed = 75.0 + supervisor.model.execution_delay(0);
            let end = reference.end(CYCLE_S);
            let of = |cycle: f64| reference.preload.remaining_fraction(cycle);
            assert_eq!(of(executed), 1.0);
            match expected {
                None => assert_eq!(of(1e3), 1.0, "{actuator:?} {zeta}"),
                Some(later) => {
                    let gone = end + later;
                    assert_near(of(0.5 * (executed + gone)), 0.5, 1e-9);
                    assert_eq!(of(gone), 0.0);
                }
            }
        }
    }

    /// In a contact: along it as before, across it as the model moves; a delay ahead as commanded.
    #[test]
    fn what_is_executed_is_a_delay_ahead() {
        let supervisor = supervisor(0.0);
        let contact = Bounce::spring(0.5).followed(0.01, 25);
        let mut observer = Bounce::spring(0.5).observer(75);
        observer.model = observer.at_force.position[0] + V6::new(0.0, 1e-3, 0.0, 0.0, 0.0, 0.0);
        let velocity = V6::new(-0.002, 1e-3, 0.0, 0.0, 0.0, 0.0);
        let reference = supervisor.reference(&contact, &observer, &velocity);
        let at = |cycle: usize| reference.position_at(cycle as f64, CYCLE_S);
        let along = contact.reference(0);
        for cycle in [75, 90] {
            assert!((at(cycle)[0] - along.position_at(cycle as f64, CYCLE_S)[0]).abs() < 1e-9);
            let across = 1e-3 + 1e-3 * (cycle as f64 - 75.0) * CYCLE_S;
            assert!((at(cycle)[1] - across).abs() < 1e-9, "{}", at(cycle));
        }
    }

    #[test]
    fn a_latency_that_is_known_or_was_found_is_not_doubted() {
        let contact = Bounce::spring(0.5).followed(0.01, 2);
        assert_eq!(contact.estimator.latest, LATENCIES - 1);
        for (known, found, in_contact, latest) in [
            (false, false, true, LATENCIES - 1),
            (true, false, true, 2),
            (false, true, true, 2),
            (false, false, false, 2),
        ] {
            let mut supervisor = supervisor(0.0);
            (
                supervisor.latency,
                supervisor.latency_known,
                supervisor.latency_found,
            ) = (2, known, found);
            let asked = supervisor.latest(in_contact.then_some(&contact));
            assert_eq!(asked, latest, "{known} {found} {in_contact}");
        }
    }
}
