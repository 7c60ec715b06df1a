//! The supervisor: what is believed of robot and contact, which load the model feels, and which law commands.

use super::V6;
use super::contact::{Contact, ContactMemory, Onset};
use super::contact_estimator::{Estimate, direction};
use super::delay_estimator::{Approach, DelayTracker};
use super::dynamic_matrix::{ControlProblem, DynamicMatrix};
use super::fallback::Fallback;
use super::impulse_matching::Reversals;
use super::observer::{Feedback, LoadNoise, Observer};
use super::reference::Reference;
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
            outcome.hidden(&estimate)
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
            latest: match &contact {
                Some(contact) if !self.latency_known && !self.latency_found => {
                    contact.estimator.latest
                }
                _ => self.latency,
            },
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

    /// The reference in a contact: along it with the preload so far, across it as the model moves, which friction may
    /// have turned.
    ///
    /// A robot that answers after a dead time takes the preload back: what it will do is known beforehand. Where the
    /// contact is damped much it stays, because the load that goes with the velocity would change.
    fn reference(&self, contact: &Contact, observer: &Observer, velocity: &V6) -> Reference {
        let (cycle, cycle_s) = (observer.cycle as f64, self.model.cycle_s);
        let gradient = &contact.estimate(self.latency).gradient;
        let reference = contact.reference(self.latency).across(
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
        reference.pressed(&contact.preload, executed, end)
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
