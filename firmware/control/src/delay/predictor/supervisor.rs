//! The supervisor: what is believed of robot and contact, which load the model feels, and which law commands.

use super::V6;
use super::approach::Approach;
use super::contact::{Contact, Onset};
use super::contact_estimator::{Estimate, direction};
use super::contact_memory::ContactMemory;
use super::control_problem::ControlProblem;
use super::delay_tracker::DelayTracker;
use super::dynamic_matrix::DynamicMatrix;
use super::fallback::Fallback;
use super::noise::LoadNoise;
use super::observer::{Feedback, Observer};
use super::reference::Reference;
use super::reversals::Reversals;
use super::robot_model::RobotModel;
use super::tuning::*;
use crate::delay::actuator::ActuatorSettings;
use crate::delay::status::{ConfidenceLevel, LawFlags, LawStatus};
use crate::delay::{DelaySettings, LawInput, LawOutput};
use crate::modes::{Fault, FaultCode};
use crate::scalar::Scalar;
use nalgebra::ComplexField;

/// What is believed and decided.
#[derive(Clone, Debug)]
pub(super) struct Supervisor {
    settings: PredictorSettings,
    pub(super) model: RobotModel,
    matrix: DynamicMatrix,
    /// Latency that is believed, and whether it is known.
    pub(super) latency: usize,
    latency_known: bool,
    /// It was beyond doubt in an earlier contact.
    latency_found: bool,
    /// This cycle was observed already.
    pub(super) observed: bool,
    pub(super) approach: Approach,
    pub(super) tracker: DelayTracker,
    pub(super) noise: LoadNoise,
    memory: ContactMemory,
    reversals: Reversals,
    confidence: ConfidenceLevel,
    fallback: Fallback,
    /// Cycles until the delay after the last contact is known.
    settling: u32,
    /// Stiffness and damping of the last contact, N/m and N·s/m.
    identified: [f64; 2],
    misfit: f64,
    /// Cycles since the start ramp.
    released: u32,
    pub(super) flags: LawFlags,
    fault: Option<Fault>,
}

/// The latency to begin with.
fn first_latency(actuator: &ActuatorSettings) -> usize {
    usize::from(actuator.feedback_latency_cycles).min(LATENCIES - 1)
}

impl Supervisor {
    #[inline(always)] // or each level would hold a copy of it on the stack
    pub(super) fn new(settings: &DelaySettings, cycle_s: f64) -> Self {
        let actuator = &settings.actuator;
        let latency = first_latency(actuator);
        // Commissioning sees the delay up to the reported pose, of which the latency is a part.
        let reported = usize::from(actuator.feedback_latency_cycles);
        let model = RobotModel::new(actuator, cycle_s, reported as f64);
        Self {
            matrix: DynamicMatrix::new(&model, latency),
            noise: LoadNoise::new(settings.predictor.force_noise_n),
            settings: settings.predictor.clone(),
            model,
            latency,
            latency_known: actuator.feedback_latency_known,
            latency_found: false,
            observed: false,
            approach: Approach::new(V6::zeros(), &V6::zeros()),
            tracker: DelayTracker::default(),
            memory: ContactMemory::default(),
            reversals: Reversals::default(),
            confidence: ConfidenceLevel::Unverified,
            fallback: Fallback::new(),
            settling: 0,
            identified: [0.0; 2],
            misfit: 0.0,
            released: 0,
            flags: LawFlags::default(),
            fault: None,
        }
    }

    /// Feedback of the observer.
    pub(super) fn feedback(&self, velocity: &V6, in_contact: bool) -> Feedback {
        Feedback {
            gain: self.observer_gain(velocity),
            noise_m: self.approach.findings.noise_m,
            in_flight: !in_contact && self.approach.is_over(),
        }
    }

    /// Gain of the observer: noise against the displacement in a delay.
    fn observer_gain(&self, velocity: &V6) -> f64 {
        let noise = self.approach.findings.noise_m;
        OBSERVER_GAIN / (1.0 + OBSERVER_NOISE_WEIGHT * noise / self.delayed(velocity.norm()))
    }

    /// Displacement in a mean delay at a speed (m/s), m.
    fn delayed(&self, speed: f64) -> f64 {
        (speed * self.model.linear.mean_delay * self.model.cycle_s).max(1e-9)
    }

    /// Free flight: follows the delay, and does not let a robot into a first contact that is not as
    /// believed.
    #[inline(never)]
    pub(super) fn fly(&mut self, observer: &mut Observer, command: &V6) {
        if self.approach.is_over() {
            self.track_delay(observer);
            return;
        }
        if let Some(later) = self.approach.take(&observer.measured, command, &self.model) {
            self.change_delay(observer, later);
        }
        let findings = &self.approach.findings;
        self.misfit = findings.misfit;
        if findings.at_bound {
            self.flags.set(LawFlags::DELAY_AT_BOUND);
        }
        if findings.complete {
            self.confidence = ConfidenceLevel::Verified;
            let most = INTERLOCK_MISFIT + findings.noise_m / self.delayed(self.approach.speed);
            if self.settings.interlock && (findings.misfit > most || findings.at_bound) {
                let code = FaultCode::ActuatorUnlike;
                self.fault = Some(Fault::new(code, most, findings.misfit));
            }
        }
    }

    /// Follows the delay in free flight, once after each contact.
    fn track_delay(&mut self, observer: &mut Observer) {
        if self.settling == 0 {
            return;
        }
        self.settling -= 1;
        if self.settling > 0 {
            return;
        }
        if let Some(later) = self.tracker.later(self.approach.findings.noise_m) {
            let within = self.approach.bounded_change(later);
            self.change_delay(observer, within);
            self.tracker.shift(within);
            self.flags.set(LawFlags::DELAY_FOLLOWED);
            if self.approach.findings.at_bound {
                self.flags.set(LawFlags::DELAY_AT_BOUND);
            }
        }
    }

    /// A robot that is so many cycles later than believed.
    fn change_delay(&mut self, observer: &mut Observer, later: f64) {
        self.model.linear.shift(later);
        // The robot has gone straight for a while: its model is so much further behind.
        let behind = observer.robot.velocity() * (-later * self.model.cycle_s);
        observer.robot.shift(&behind);
        self.matrix = DynamicMatrix::new(&self.model, self.latency);
    }

    /// The load that the model feels, N: in a contact the mean of the last two measured ones, with what the
    /// samples cannot see of its beginning and end, and with what noise or the guard add at its end.
    #[inline(never)]
    pub(super) fn felt_load<S: Scalar>(
        &mut self,
        observer: &mut Observer,
        going_on: &mut Option<Contact>,
        input: &LawInput<'_, S>,
        velocity: &V6,
    ) -> V6 {
        let threshold = self.noise.threshold();
        if going_on.is_none() {
            if !self.is_onset(observer, velocity, threshold) {
                return V6::zeros();
            }
            observer.previous_load = V6::zeros();
            self.begin_contact(observer, going_on, input, velocity, threshold);
        }
        let Some(contact) = going_on else {
            return V6::zeros();
        };
        self.flags.set(LawFlags::CONTACT);
        let only = self.latency_known.then_some(self.latency);
        let at_force = &observer.at_force;
        contact.add(&observer.load, at_force, threshold, self.latency, only);
        self.choose_latency(contact);
        let cycle_s = self.model.cycle_s;
        let added = contact.onset_correction(self.latency)
            + contact.release_correction(&at_force.velocity[self.latency], self.latency);
        let (h, _) = contact.direction();
        let mut felt = (observer.load + observer.previous_load) * 0.5 - h * (added / cycle_s);
        let estimate = contact.estimate(self.latency);
        self.misfit = estimate.misfit;
        self.identified = [estimate.stiffness, estimate.damping];
        let reference = contact.reference(self.latency);
        let delay = self.model.execution_delay(self.latency);
        if contact.is_over(observer.cycle, &reference, delay) {
            felt += self.end_contact(observer, contact, &reference, velocity, &felt);
            *going_on = None;
        }
        felt
    }

    /// Whether a contact begins: a significant load against the motion. Another one is noise, or spurious.
    fn is_onset(&mut self, observer: &Observer, velocity: &V6, threshold: f64) -> bool {
        let load = &observer.load;
        let pair = (load + observer.previous_load).norm();
        let significant = load.norm() > threshold || pair > threshold * core::f64::consts::SQRT_2;
        if !significant {
            self.noise.add(load);
            return false;
        }
        let against_motion = load.dot(velocity) < 0.0;
        if !against_motion {
            self.flags.set(LawFlags::SPURIOUS_LOAD);
        }
        against_motion
    }

    #[inline(never)]
    fn begin_contact<S: Scalar>(
        &self,
        observer: &Observer,
        contact: &mut Option<Contact>,
        input: &LawInput<'_, S>,
        velocity: &V6,
        threshold: f64,
    ) {
        let mobility = observer.mobility(input);
        let load = -observer.load;
        let (h, bh) = direction(&load, &mobility);
        let onset = Onset {
            velocity: *velocity,
            mobility,
            noise: self.noise.sigma(),
            threshold,
            stiffness: self.expected_stiffness(h.dot(&bh)),
            delay_sigma_s: self.approach.findings.deviation * self.model.cycle_s,
            remembered: self.memory.of(&load),
            latency: self.latency,
            cycle_s: self.model.cycle_s,
        };
        *contact = Some(Contact::new(observer, &onset));
    }

    /// Stiffness that is expected along a direction, N/m.
    fn expected_stiffness(&self, inverse_mass: f64) -> f64 {
        if self.settings.contact_stiffness_n_per_m > 0.0 {
            return self.settings.contact_stiffness_n_per_m;
        }
        let delay = self.model.execution_delay(self.latency).max(1.0);
        let omega = PRIOR_PHASE / (delay * self.model.cycle_s);
        omega * omega / inverse_mass.max(1e-9)
    }

    fn choose_latency(&mut self, contact: &mut Contact) {
        if self.latency_known {
            return;
        }
        let closing = contact
            .estimate(self.latency)
            .gradient
            .dot(&contact.velocity);
        let noise = (self.noise.sigma(), self.approach.findings.noise_m);
        let best = contact.estimator.choose(self.latency, noise, closing);
        if best != self.latency {
            self.latency = best;
            self.matrix = DynamicMatrix::new(&self.model, best);
        }
    }

    /// Ends a contact. The load that noise has hidden, or that the guard adds, N.
    #[inline(never)]
    fn end_contact(
        &mut self,
        observer: &mut Observer,
        contact: &Contact,
        reference: &Reference,
        velocity: &V6,
        felt: &V6,
    ) -> V6 {
        let (latency, cycle_s) = (self.latency, self.model.cycle_s);
        let after = velocity + contact.mobility * felt * cycle_s;
        let noise = self.noise_against_model(contact);
        let outcome = contact.outcome(latency, reference, &after, noise);
        self.latency_found |= contact.estimator.settled;
        self.confidence = if outcome.fits() {
            self.memory.keep(contact, latency);
            ConfidenceLevel::Verified
        } else {
            ConfidenceLevel::Fallback
        };
        // The model goes on from where the two spacecraft would be, or the robot is, if it was not led there.
        observer.model = if self.fallback.trust < 1.0 {
            observer.at_force.position[latency]
        } else {
            let reference = self.reference(contact, observer, &after);
            reference.position_at(observer.cycle as f64, cycle_s)
        };
        // The robot's reversal can be seen a delay from now.
        self.settling = (self.model.linear.mean_delay + TRACKING_SETTLES) as u32;
        observer.load = V6::zeros();
        self.reversals = Reversals::default();
        let missing = if let Some((missing, flag)) = outcome.guard().filter(|_| self.settings.guard)
        {
            self.flags.set(flag);
            missing
        } else if outcome.fits() {
            let estimate = contact.restitution(latency, &after, noise);
            if estimate.hides_damping {
                self.flags.set(LawFlags::DAMPING_IN_NOISE);
            }
            estimate.hidden(&outcome)
        } else {
            0.0
        };
        let (h, _) = contact.direction();
        h * (missing * contact.estimate(latency).mass / cycle_s)
    }

    /// Noise of a load against that of the identified contact where the robot is believed to be: of the sensor, and
    /// of the position as the observer leaves it; N.
    fn noise_against_model(&self, contact: &Contact) -> f64 {
        let gain = self.observer_gain(&contact.velocity);
        let position = self.approach.findings.noise_m * ComplexField::sqrt(gain / (2.0 - gain));
        let (load, apart) = (
            self.noise.sigma(),
            contact.estimate(self.latency).stiffness * position,
        );
        ComplexField::sqrt(load * load + apart * apart)
    }

    /// The command of this cycle.
    #[inline(never)]
    pub(super) fn command<S: Scalar>(
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
        // Until the approach is known the model is where the robot is: both are in phase.
        if contact.is_none() && !self.has_started() {
            observer.model = robot.position() + velocity * cycle_s;
            return self.output(LawOutput::of(input.model_end));
        }
        let (reference, estimate) = match &contact {
            Some(contact) => (
                self.reference(contact, observer, &velocity),
                Some(*contact.estimate(self.latency)),
            ),
            None => self.reference_ahead(observer, &velocity),
        };
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
        self.reversals = command.reversals;
        if command.at_speed_limit {
            self.flags.set(LawFlags::SPEED_LIMIT);
        }
        if let Some(contact) = contact {
            contact.preload = problem.reference.preload;
            contact.preload.advance(command.preload_rate * cycle_s);
        }
        if self.fallback.trust <= 0.0 {
            observer.model = robot.position();
        }
        observer.model += velocity * cycle_s;
        let mut output = LawOutput::of(observer.map.twist(&command.velocity));
        output.parts[0] = observer.map.twist(&command.tracking);
        output.parts[1] = observer.map.twist(&command.preload);
        self.output(output)
    }

    /// The largest latency that the pose may have, cycles: what is known, or was beyond doubt, is not doubted again.
    fn latest(&self, contact: Option<&Contact>) -> usize {
        match contact {
            Some(contact) if !self.latency_known && !self.latency_found => contact.estimator.latest,
            _ => self.latency,
        }
    }

    /// The reference in a contact: along it with the preload so far, across it as the model moves, which friction may
    /// have turned.
    ///
    /// A robot that answers after a dead time takes the preload back: what it will do is known beforehand. Where the
    /// contact is damped much it stays, because the load that goes with the velocity would change.
    fn reference(&self, contact: &Contact, observer: &Observer, velocity: &V6) -> Reference {
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
            // What it was told with another latency makes it late: it is to end in time.
            let taken_back = self.model.linear.is_dead_time && zeta <= FREE_REVERSAL_DAMPING;
            taken_back.then_some(end)
        };
        reference.preload = contact.preload.planned(executed, end);
        reference
    }

    /// Whether the approach is known and the robot has the velocity of the model.
    fn has_started(&self) -> bool {
        let start_up = START_UP_DELAYS * self.model.linear.mean_delay + START_UP_CYCLES;
        self.approach.is_over() && f64::from(self.released) > start_up
    }

    /// Straight on, or into a contact that is remembered.
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

    /// An output with status and fault.
    fn output<S: Scalar>(&mut self, mut output: LawOutput<S>) -> LawOutput<S> {
        output.fault = self.fault.take();
        output.status = LawStatus {
            confidence: self.confidence,
            flags: self.flags,
            stiffness_n_per_m: self.identified[0],
            damping_n_s_per_m: self.identified[1],
            delay_s: (self.model.linear.mean_delay - self.latency as f64) * self.model.cycle_s,
            latency_cycles: self.latency as u16,
            misfit: self.misfit,
        };
        output
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::docking::{Docking, believed, between_walls, robot};
    use crate::delay::predictor::bounce::{Bounce, CLOSING, MASS, STIFFNESS, x};
    use crate::delay::predictor::scene::robots;
    use crate::delay::spacecraft::{CYCLE_S, Spacecraft};
    use crate::delay::{Law, LawName};
    use crate::frames::Wrench;
    use softdock_delay_plants::Measurement;

    /// Of a robot of 32 ms whose approach has shown this noise of a position, m.
    fn supervisor(noise_m: f64) -> Supervisor {
        let mut supervisor = Supervisor::new(&DelaySettings::default(), CYCLE_S);
        supervisor.approach.findings.noise_m = noise_m;
        supervisor
    }

    fn assert_near(found: f64, expected: f64) {
        let apart = (found - expected).abs();
        assert!(apart <= 1e-9 * expected.abs(), "{found} {expected}");
    }

    /// 160 µm at 5 mm/s: 112 times the noise is as much at 1.43 µm.
    #[test]
    fn a_noisy_position_is_followed_less_the_less_it_moves_in_a_delay() {
        for (noise_m, speed, gain) in [
            (0.0, 0.005, 0.3),
            (160e-6 / 112.0, 0.005, 0.15),
            (160e-6 / 112.0, 0.0025, 0.1),
            (1e-9, 0.0, 0.3 / 113.0),
        ] {
            assert_near(supervisor(noise_m).observer_gain(&x(speed)), gain);
        }
        let mut noisy = supervisor(160e-6 / 112.0);
        for (in_contact, over, in_flight) in [
            (false, true, true),
            (true, true, false),
            (false, false, false),
        ] {
            noisy.approach = Approach::new(V6::zeros(), &x(if over { 0.0 } else { 0.005 }));
            noisy.approach.findings.noise_m = 160e-6 / 112.0;
            let feedback = noisy.feedback(&x(0.005), in_contact);
            assert_eq!(feedback.in_flight, in_flight);
            assert_near(feedback.gain, 0.15);
            assert_near(feedback.noise_m, 160e-6 / 112.0);
        }
    }

    /// ω τ = 0.6 for the effective mass, or what is set.
    #[test]
    fn a_contact_is_expected_to_last_five_delays() {
        let mut supervisor = supervisor(0.0);
        let omega = 0.6 / 0.032;
        assert_near(
            supervisor.expected_stiffness(1.0 / 500.0),
            500.0 * omega * omega,
        );
        assert_near(supervisor.expected_stiffness(0.0), 1e9 * omega * omega);
        supervisor.latency = 4;
        let later = 0.6 / 0.016;
        assert_near(
            supervisor.expected_stiffness(1.0 / 500.0),
            500.0 * later * later,
        );
        // A robot that is hardly late is taken for one of a cycle.
        supervisor.model.linear.mean_delay = 0.0;
        let soonest = 0.6 / CYCLE_S;
        assert_near(supervisor.expected_stiffness(1.0), soonest * soonest);
        supervisor.settings.contact_stiffness_n_per_m = 3e5;
        assert_near(supervisor.expected_stiffness(1.0), 3e5);
    }

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

    /// At most four cycles, of which the predictor has a hypothesis.
    #[test]
    fn a_latency_that_is_set_is_the_first_that_is_believed() {
        for (set, first) in [(0, 0), (3, 3), (4, 4), (8, 4)] {
            let mut settings = DelaySettings::default();
            settings.actuator.feedback_latency_cycles = set;
            let supervisor = Supervisor::new(&settings, CYCLE_S);
            assert_eq!(supervisor.latency, first);
            // The delay up to the reported pose.
            assert_near(supervisor.model.linear.mean_delay, 8.0 + f64::from(set));
        }
    }

    /// The model was that much ahead of the robot: it is set back, and the control is that of the new delay.
    #[test]
    fn a_robot_that_is_later_is_so_much_behind_its_model() {
        let mut supervisor = supervisor(0.0);
        let (spacecraft, wrench) = (Spacecraft::before_a_wall([0.0; 3]), Wrench::zero());
        let mut observer = Observer::new(&spacecraft.input(&wrench));
        for cycle in 0..20 {
            observer.commands.push(&x(0.005));
            observer
                .robot
                .step_sent(&supervisor.model, &observer.commands, cycle);
        }
        let before = observer.robot.position()[0];
        supervisor.change_delay(&mut observer, 1.5);
        assert_near(before - observer.robot.position()[0], 1.5 * 0.005 * CYCLE_S);
        assert_near(supervisor.model.linear.mean_delay, 9.5);
    }

    /// Noise of the sensor, and of the position as the observer leaves it: a gain g leaves g/(2 − g) of its variance.
    #[test]
    fn the_noise_of_a_load_is_that_of_the_sensor_and_of_the_position() {
        let contact = Bounce::spring(0.5).followed(0.01, 25);
        for (load, noise_m) in [(0.2, 0.0), (0.0001, 1e-6), (0.2, 1e-6)] {
            let mut supervisor = supervisor(noise_m);
            supervisor.noise = LoadNoise::new(load);
            let gain = supervisor.observer_gain(&contact.velocity);
            let apart = STIFFNESS * noise_m * (gain / (2.0 - gain)).sqrt();
            let found = supervisor.noise_against_model(&contact);
            let expected = (load * load + apart * apart).sqrt();
            assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
        }
    }

    /// Against the motion, and more than a threshold: 4.5 times 0.002 N alone, or √2 of it with the load before.
    #[test]
    fn a_contact_begins_with_a_significant_load_against_the_motion() {
        let (spacecraft, wrench) = (Spacecraft::before_a_wall([0.0; 3]), Wrench::zero());
        let mut observer = Observer::new(&spacecraft.input(&wrench));
        for (load, before, onset, spurious) in [
            (-0.0091, 0.0, true, false),
            (-0.0089, 0.0, false, false),
            (0.0091, 0.0, false, true),
            (-0.0065, -0.0065, true, false),
            (-0.0063, -0.0063, false, false),
            (-0.0089, 0.0089, false, false),
        ] {
            let mut supervisor = supervisor(0.0);
            (observer.load, observer.previous_load) = (x(load), x(before));
            let threshold = supervisor.noise.threshold();
            assert_eq!(
                supervisor.is_onset(&observer, &x(0.005), threshold),
                onset,
                "{load}"
            );
            assert_eq!(
                supervisor.flags.has(LawFlags::SPURIOUS_LOAD),
                spurious,
                "{load}"
            );
        }
        // What is not significant is noise.
        let mut supervisor = supervisor(0.0);
        (observer.load, observer.previous_load) = (x(3.0), V6::zeros());
        (0..20).for_each(|_| {
            supervisor.is_onset(&observer, &x(0.005), 4.0);
        });
        assert_near(supervisor.noise.sigma(), 3.0);
    }

    /// When a preload is gone, cycles after the end of the contact; none: it stays.
    #[test]
    fn a_preload_is_taken_back_by_a_robot_with_a_dead_time_in_a_contact_that_is_not_damped() {
        let [dead_time, _, lag, mixed, _] = robots();
        for (actuator, zeta, first_latency, expected) in [
            (&dead_time, 0.0, 0, Some(5.0)),
            (&dead_time, 0.2, 0, Some(5.0)),
            (&dead_time, 0.3, 0, None),
            (&mixed, 0.0, 0, Some(5.0)),
            (&lag, 0.0, 0, None),
            // It was told with another latency.
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
            let of = |cycle: f64| reference.preload.left(cycle);
            assert_eq!(of(executed), 1.0);
            match expected {
                None => assert_eq!(of(1e3), 1.0, "{actuator:?} {zeta}"),
                Some(later) => {
                    let gone = end + later;
                    assert_near(of(0.5 * (executed + gone)), 0.5);
                    assert_eq!(of(gone), 0.0);
                }
            }
        }
    }

    /// In a contact along it as before, across it as the model; a delay ahead what it is told.
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

    #[test]
    fn a_latency_that_was_found_stays_so() {
        let plant = between_walls(robot(), 0.0, Measurement::default());
        let mut docking = Docking::new(&believed(LawName::Predictor, &robot()), &plant, 0.005);
        for found in [false, true, true, true] {
            let Law::Predictor(law) = &docking.law else {
                panic!("another law");
            };
            assert_eq!(law.supervisor.latency_found, found);
            docking.bounce();
        }
    }

    /// The two spacecraft go on from where they would be, or from where the robot is if it was not led there.
    #[test]
    fn after_a_contact_the_model_goes_on_from_the_reference_or_from_the_robot() {
        for (trust, led) in [(1.0, true), (0.5, false), (0.0, false)] {
            let mut supervisor = supervisor(0.0);
            supervisor.fallback.trust = trust;
            let contact = Bounce::spring(0.5).followed(0.01, 36);
            let mut observer = Bounce::spring(0.5).observer(95);
            observer.model = observer.at_force.position[0];
            let exact = observer.model;
            observer.at_force.position[0] += x(1e-3);
            let reference = contact.reference(0);
            let ended = (x(-CLOSING), V6::zeros());
            supervisor.end_contact(&mut observer, &contact, &reference, &ended.0, &ended.1);
            let robot = observer.at_force.position[0];
            let expected = if led { exact } else { robot };
            assert!(
                (observer.model - expected).amax() < 1e-6,
                "{trust}: {}",
                observer.model
            );
        }
    }

    /// The guard looks at the velocity that the last load leaves: 0.4 mm/s more.
    #[test]
    fn the_rebound_is_the_velocity_after_the_last_load() {
        for (before, held) in [
            (-CLOSING + 4e-4, false),
            (-CLOSING, true),
            (-CLOSING + 8e-4, true),
        ] {
            let mut supervisor = supervisor(0.0);
            let contact = Bounce::spring(0.5).followed(0.01, 36);
            let mut observer = Bounce::spring(0.5).observer(95);
            let reference = contact.reference(0);
            let load = x(-50.0);
            let added =
                supervisor.end_contact(&mut observer, &contact, &reference, &x(before), &load);
            assert_eq!(
                supervisor.flags.has(LawFlags::GUARD_IDENTIFIED),
                held,
                "{before}"
            );
            let after = before + (load + added)[0] / MASS * CYCLE_S;
            assert!((after + CLOSING).abs() < 1e-5, "{before}: {after}");
        }
    }
}
