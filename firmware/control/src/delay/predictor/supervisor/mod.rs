//! The supervisor: it keeps what is identified of robot and contact, and decides which load the model feels ([`felt_load`]) and
//! which law commands ([`command`]).

mod command;
mod felt_load;

use super::V6;
use super::approach::Approach;
use super::contact_memory::ContactMemory;
use super::delay_tracker::DelayTracker;
use super::dynamic_matrix::DynamicMatrix;
use super::fallback::Fallback;
use super::latency_estimator::told_apart;
use super::noise::LoadNoise;
use super::observer::{Feedback, Observer};
use super::reversals::Reversals;
use super::robot_model::RobotModel;
use super::tuning::*;
use crate::delay::status::{ConfidenceLevel, LawFlags, LawStatus};
use crate::delay::{DelaySettings, LawOutput};
use crate::fault::{Fault, FaultCode};
use crate::scalar::Scalar;

/// State of the supervisor.
#[derive(Clone, Debug)]
pub(super) struct Supervisor {
    settings: PredictorSettings,
    pub(super) model: RobotModel,
    matrix: DynamicMatrix,
    /// Believed latency of the pose, cycles, and whether the settings say that it is known.
    pub(super) latency: usize,
    latency_known: bool,
    /// The latency was settled in an earlier contact.
    latency_found: bool,
    /// The observer has already been updated in this cycle.
    pub(super) observed: bool,
    pub(super) approach: Approach,
    pub(super) tracker: DelayTracker,
    pub(super) noise: LoadNoise,
    memory: ContactMemory,
    reversals: Reversals,
    confidence: ConfidenceLevel,
    fallback: Fallback,
    /// Cycles until the delay can be tracked after the last contact.
    settling: u32,
    /// Stiffness and damping of the last contact, N/m and N·s/m.
    identified: [f64; 2],
    misfit: f64,
    /// Cycles since the start ramp.
    released: u32,
    pub(super) flags: LawFlags,
    fault: Option<Fault>,
}

impl Supervisor {
    #[inline(always)] // or each level would hold a copy of it on the stack
    pub(super) fn new(settings: &DelaySettings, cycle_s: f64) -> Self {
        let actuator = &settings.actuator;
        // Commissioning measures the delay up to the reported pose, which includes the latency.
        let reported = usize::from(actuator.feedback_latency_cycles);
        let latency = told_apart(reported);
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

    /// Gain of the observer: the larger the noise relative to the displacement in a delay, the smaller.
    fn observer_gain(&self, velocity: &V6) -> f64 {
        let noise = self.approach.findings.noise_m;
        OBSERVER_GAIN / (1.0 + OBSERVER_NOISE_WEIGHT * noise / self.delayed(velocity.norm()))
    }

    /// Displacement in a mean delay at a speed (m/s), m.
    fn delayed(&self, speed: f64) -> f64 {
        (speed * self.model.linear.mean_delay * self.model.cycle_s).max(1e-9)
    }

    /// Free flight: tracks the delay. On the approach to the first contact, raises a fault if the robot does not behave as the
    /// settings say (interlock).
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
        let most = INTERLOCK_MISFIT + findings.noise_m / self.delayed(self.approach.speed);
        self.misfit = findings.misfit;
        if findings.at_bound {
            self.flags.set(LawFlags::DELAY_AT_BOUND);
            // No delay within the range fits the robot: the misfit is then never below the limit.
            let beyond = findings.beyond() / self.model.linear.mean_delay.max(1.0);
            self.misfit = self.misfit.max(most + beyond);
        }
        if findings.complete {
            if self.misfit <= most {
                self.confidence = ConfidenceLevel::Verified;
            } else if self.settings.interlock {
                let code = FaultCode::ActuatorUnlike;
                self.fault = Some(Fault::new(code, most, self.misfit));
            }
        }
    }

    /// Tracks the delay in free flight, once after each contact.
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

    /// Changes the delay of the robot model by `later` cycles.
    fn change_delay(&mut self, observer: &mut Observer, later: f64) {
        self.model.linear.shift(later);
        // The motion has been straight for a while, so that the position of the model changes by that displacement.
        let behind = observer.robot.velocity * (-later * self.model.cycle_s);
        observer.robot.position += behind;
        self.matrix = DynamicMatrix::new(&self.model, self.latency);
    }

    /// Completes an output with status and fault.
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
    use crate::delay::predictor::bounce::{assert_near, x};
    use crate::delay::spacecraft::{CYCLE_S, Spacecraft};
    use crate::frames::Wrench;

    /// The supervisor of a robot with a delay of 32 ms whose approach has shown this noise of a position, m.
    pub(super) fn supervisor(noise_m: f64) -> Supervisor {
        let mut supervisor = Supervisor::new(&DelaySettings::default(), CYCLE_S);
        supervisor.approach.findings.noise_m = noise_m;
        supervisor
    }

    /// The displacement in a delay is 160 µm at 5 mm/s; 112 times the noise equals that at 1.43 µm.
    #[test]
    fn a_noisy_position_is_followed_less_the_less_it_moves_in_a_delay() {
        for (noise_m, speed, gain) in [
            (0.0, 0.005, 0.3),
            (160e-6 / 112.0, 0.005, 0.15),
            (160e-6 / 112.0, 0.0025, 0.1),
            (1e-9, 0.0, 0.3 / 113.0),
        ] {
            assert_near(supervisor(noise_m).observer_gain(&x(speed)), gain, 1e-9);
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
            assert_near(feedback.gain, 0.15, 1e-9);
            assert_near(feedback.noise_m, 160e-6 / 112.0, 1e-9);
        }
    }

    /// At most four cycles, the largest latency that has a hypothesis.
    #[test]
    fn a_latency_that_is_set_is_the_first_that_is_believed() {
        for (set, first) in [(0, 0), (3, 3), (4, 4), (8, 4)] {
            let mut settings = DelaySettings::default();
            settings.actuator.feedback_latency_cycles = set;
            let supervisor = Supervisor::new(&settings, CYCLE_S);
            assert_eq!(supervisor.latency, first);
            // The delay up to the reported pose.
            assert_near(
                supervisor.model.linear.mean_delay,
                8.0 + f64::from(set),
                1e-9,
            );
        }
    }

    /// The position of the model is set back by the displacement, and the controller is that of the new delay.
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
        let before = observer.robot.position[0];
        supervisor.change_delay(&mut observer, 1.5);
        assert_near(
            before - observer.robot.position[0],
            1.5 * 0.005 * CYCLE_S,
            1e-9,
        );
        assert_near(supervisor.model.linear.mean_delay, 9.5, 1e-9);
    }
}
