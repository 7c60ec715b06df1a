//! The default law: model predictive control of a late robot, so that it is where the two spacecraft would be,
//! when it is there.
//!
//! The model of the two spacecraft is moved by the measured force. The robot that presses the mechanism is
//! late; this law leads it:
//!
//! - A **robot model** with dead time (lag, servo and pause at a reversal behind it) follows the sent commands
//!   and predicts where they will bring the robot: dead-time compensation by an internal model, as in Smith's
//!   predictor (Smith, "Closer control of loops with dead time", Chem. Eng. Prog. 53, 1957). Its delay is
//!   identified on the approach and tracked from contact to contact.
//! - A **contact estimator** identifies each contact while it lasts as a Kelvin-Voigt model, by regularised
//!   recursive least squares; one for each possible latency of the reported pose (multiple models: Magill,
//!   "Optimal adaptive estimation of sampled stochastic processes", IEEE Trans. Autom. Control 10, 1965).
//! - A **reference** is the motion that two spacecraft with such a contact would have, one delay ahead.
//! - **Dynamic matrix control** (Cutler and Ramaker, "Dynamic matrix control: a computer control algorithm",
//!   Joint Automatic Control Conference, 1980) moves the robot along it: the free response by the robot model,
//!   the moves by least squares with move suppression, the first one sent. It differs from the textbook in
//!   three points: the moves are velocities on top of the reference's own; the prediction is not shifted by its
//!   last error, because an observer corrects the model's position; and there are no constraints in it: speed
//!   limit and reversals are bounded after it.
//! - **Impulse matching** adds a preload along the contact, so that the impulse still to come is that of the
//!   rebound. It is no part of dynamic matrix control and has no counterpart in the literature that is known to
//!   us.
//! - A **supervisor** compares what it believes with what happens: an interlock before the first contact, a
//!   guard on the restitution, a confidence level that leads to a fallback law (second-order lead).
//!
//! There is no proof of stability: robustness is shown by tests over wrong delays, structures, contacts and
//! noise. The page `docs/delay/predictor.md` follows the law through with its equations, limits and numbers.
//!
//! | file | what |
//! |---|---|
//! | `tuning` | settings, and all fixed numbers (`NAMES_LIKE_THIS`) with unit and reason |
//! | `robot_model` | where what is sent brings the six axes: `command_history`, `linear_dynamics` (dead time, lag, servo), `pause` |
//! | `axis_map` | the robot's axes, in which all of it works |
//! | `observer`, `noise` | robot, load and model; noise of positions and loads |
//! | `approach` | delay, noise and structure of the robot, from the approach to the first contact |
//! | `delay_tracker` | its delay, from its reversals |
//! | `contact_estimator`, `least_squares` | stiffness, damping, direction and surface of a contact |
//! | `latency_estimator` | the same for each latency of the pose, and which of them is believed |
//! | `stiffening` | a contact that is no spring: a parabola through its loads |
//! | `contact`, `contact_memory` | the course of a contact, and what is remembered of it |
//! | `restitution`, `guard` | what noise hides of a rebound, and what it is held to |
//! | `reference`, `kelvin_voigt`, `preload` | the motion that is wanted: that of a spring and a damper, and what is pressed deeper |
//! | `control_problem` | the command: what it depends on, and its parts |
//! | `free_response`, `dynamic_matrix` | where the robot will be with what was sent, and the moves that bring it to the reference |
//! | `impulse_matching` | the preload |
//! | `reversals` | what holds an axis from turning twice |
//! | `fallback` | the command without an identified contact |
//! | `supervisor` | what is believed, what the model feels, which law commands |
//!
//! It computes in f64 whatever the scalar of the cycle is.

mod approach;
mod axis_map;
#[cfg(test)]
mod batch;
#[cfg(test)]
mod bounce;
mod command_history;
mod contact;
mod contact_estimator;
mod contact_memory;
mod control_problem;
mod delay_tracker;
mod dynamic_matrix;
mod fallback;
mod free_response;
mod guard;
mod impulse_matching;
mod kelvin_voigt;
mod latency_estimator;
mod least_squares;
mod linear_dynamics;
mod noise;
#[cfg(test)]
mod oblique;
mod observer;
mod pause;
mod preload;
mod reference;
mod restitution;
mod reversals;
mod robot_model;
#[cfg(test)]
mod scene;
mod stiffening;
mod supervisor;
mod tuning;

pub use tuning::PredictorSettings;

use super::status::LawFlags;
use super::{DelaySettings, LawInput, LawOutput};
use crate::frames::Wrench;
use crate::scalar::Scalar;
use approach::Approach;
use contact::Contact;
use nalgebra::{SMatrix, SVector};
use observer::Observer;
use supervisor::Supervisor;

type V6 = SVector<f64, 6>;
type M6 = SMatrix<f64, 6, 6>;

/// The law and its state.
///
/// Observer and contact are kept beside the supervisor, which works on both: neither is ever moved, which on a
/// microcontroller would cost more stack than the rest of the cycle. For the same reason the steps of
/// a cycle are not inlined into each other.
#[derive(Clone, Debug)]
pub struct Predictor {
    supervisor: Supervisor,
    /// None before the first cycle.
    observer: Option<Observer>,
    contact: Option<Contact>,
}

impl Predictor {
    /// Before the first cycle; `cycle_s` in s.
    #[inline(always)] // or each level would hold a copy of the law on the stack
    pub fn new(settings: &DelaySettings, cycle_s: f64) -> Self {
        Self {
            supervisor: Supervisor::new(settings, cycle_s),
            observer: None,
            contact: None,
        }
    }

    /// The same as a new one.
    #[inline(never)]
    pub fn restart(&mut self, settings: &DelaySettings, cycle_s: f64) {
        self.supervisor = Supervisor::new(settings, cycle_s);
        self.observer = None;
        self.contact = None;
    }

    /// The wrench that the model feels, at M in axes of M: none in free flight, and in a contact the
    /// mean of the last two measured ones, with what the samples cannot see of its beginning.
    pub fn condition<S: Scalar>(&mut self, input: &LawInput<'_, S>) -> Wrench<S> {
        self.observe(input);
        let Some(observer) = &mut self.observer else {
            return *input.wrench;
        };
        let velocity = observer.map.velocity(&input.model_end);
        observer.take_load(input.wrench);
        let contact = &mut self.contact;
        let felt = self
            .supervisor
            .felt_load(observer, contact, input, &velocity);
        observer.map.wrench(&felt)
    }

    /// One cycle: the velocity that the robot is told.
    pub fn step<S: Scalar>(&mut self, input: &LawInput<'_, S>) -> LawOutput<S> {
        self.observe(input);
        self.supervisor.observed = false;
        let Some(observer) = &mut self.observer else {
            return LawOutput::of(input.model_end);
        };
        if !input.released {
            // The ramp shows the sensor's noise before any load may move the model.
            observer.take_load(input.wrench);
            self.supervisor.noise.add(&observer.load);
        }
        self.supervisor
            .command(observer, self.contact.as_mut(), input)
    }

    /// Takes in what was sent and where the robot is, once in a cycle.
    #[inline(never)]
    fn observe<S: Scalar>(&mut self, input: &LawInput<'_, S>) {
        let supervisor = &mut self.supervisor;
        if core::mem::replace(&mut supervisor.observed, true) {
            return;
        }
        supervisor.flags = LawFlags::default();
        let Some(observer) = &mut self.observer else {
            let observer = self.observer.insert(Observer::new(input));
            let velocity = observer.map.velocity(&input.model_end);
            supervisor.approach = Approach::new(observer.measured, &velocity);
            return;
        };
        let velocity = observer.map.velocity(&input.model_end);
        let feedback = supervisor.feedback(&velocity, self.contact.is_some());
        let command = observer.advance(input, &supervisor.model, &feedback);
        if supervisor.approach.is_over() {
            let (error, robot) = (&observer.open_loop_error, &observer.robot);
            let cycle_s = supervisor.model.cycle_s;
            supervisor.tracker.add(error, robot, cycle_s);
        }
        if self.contact.is_none() {
            supervisor.fly(observer, &command);
        }
        observer.carry_on(&supervisor.model, supervisor.latency);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::docking::{Docking, STIFFNESS, believed, between_walls, robot};
    use crate::delay::status::ConfidenceLevel;
    use crate::delay::{Law, LawName};
    use crate::modes::FaultCode;
    use softdock_delay_plants::truth::Bounce;
    use softdock_delay_plants::{Actuator, DelayChange, Dynamics, ForceLaw, Measurement, Wall};

    fn predictor(docking: &Docking) -> &Predictor {
        match &docking.law {
            Law::Predictor(law) => law,
            _ => panic!("another law"),
        }
    }

    fn observer(docking: &Docking) -> &Observer {
        predictor(docking).observer.as_ref().unwrap()
    }

    /// 36 cycles before it is felt: the horizon less the moves that there are to make.
    #[test]
    fn a_contact_that_is_remembered_is_expected_before_it_is_felt() {
        let plant = between_walls(robot(), 0.0, Measurement::default());
        let mut docking = Docking::new(&believed(LawName::Predictor, &robot()), &plant, 0.005);
        docking.bounce();
        docking.bounce();
        let expected = LawFlags::MEMORY;
        let mut waited = 0;
        while !docking.status.flags.has(LawFlags::CONTACT) {
            waited += usize::from(docking.status.flags.has(expected));
            docking.step();
        }
        assert!((35..=37).contains(&waited), "{waited}");
    }

    #[test]
    fn a_law_that_is_restarted_knows_nothing_of_the_robot() {
        let actuator = Actuator {
            delay_s: 0.036,
            ..robot()
        };
        let settings = believed(LawName::Predictor, &robot());
        let plant = between_walls(actuator, 0.0, Measurement::default());
        let mut docking = Docking::new(&settings, &plant, 0.005);
        docking.bounce();
        assert!((docking.status.delay_s - 0.036).abs() < 1e-4);
        docking
            .law
            .restart(&settings, crate::delay::spacecraft::CYCLE_S);
        docking.step();
        assert_eq!(docking.status.delay_s, 0.032);
        assert_eq!(docking.status.confidence, ConfidenceLevel::Unverified);
    }

    /// What is found out about a contact: stiffness and damping to a part, N/m and N·s/m.
    fn assert_found(docking: &Docking, damping: f64, part: f64) {
        let status = docking.status;
        assert!(
            (status.stiffness_n_per_m / STIFFNESS - 1.0).abs() < part,
            "{status:?}"
        );
        let apart = (status.damping_n_s_per_m - damping).abs();
        assert!(apart <= part * damping, "{status:?}");
        assert_eq!(status.confidence, ConfidenceLevel::Verified);
    }

    /// The robot is 32 ms late; without a law it would gain a half in each.
    #[test]
    fn elastic_contacts_give_back_the_speed_that_came() {
        let plant = between_walls(robot(), 0.0, Measurement::default());
        let mut docking = Docking::new(&believed(LawName::Predictor, &robot()), &plant, 0.005);
        for n in 0..4 {
            docking.seen = LawFlags::default();
            let restitution = docking.bounce();
            assert!((restitution - 1.0).abs() < 2e-4, "{n}: {restitution}");
            assert_found(&docking, 0.0, 2e-4);
            assert!(docking.status.misfit < 2e-3);
            assert_eq!(
                (docking.status.delay_s, docking.status.latency_cycles),
                (0.032, 0)
            );
            // The first time at each of the two walls it is not known.
            assert_eq!(docking.seen.has(LawFlags::MEMORY), n >= 2);
            let others = docking.seen.without(LawFlags::MEMORY);
            assert_eq!(others, LawFlags::CONTACT, "{n}");
        }
        let half_a_period = core::f64::consts::PI / 21.0;
        for contact in &docking.plant.log().contacts {
            let duration = contact.duration_s().unwrap();
            assert!((duration / half_a_period - 1.0).abs() < 7e-3, "{duration}");
        }
    }

    #[test]
    fn damped_contacts_give_back_what_the_damper_leaves() {
        let plant = between_walls(robot(), 2100.0, Measurement::default());
        let mut docking = Docking::new(&believed(LawName::Predictor, &robot()), &plant, 0.005);
        let expected = Bounce::new(500.0, STIFFNESS, 0.1, 0.005).restitution;
        for n in 0..4 {
            let restitution = docking.bounce();
            assert!(
                (restitution / expected - 1.0).abs() < 8e-3,
                "{n}: {restitution} {expected}"
            );
            assert_found(&docking, 2100.0, 2e-4);
        }
    }

    /// The robot's delay is known to a hundredth of a cycle then.
    #[test]
    fn a_damping_is_found_in_noise() {
        let noise = Measurement {
            position_noise_m: 1e-6,
            force_noise_n: 0.05,
            ..Measurement::default()
        };
        let plant = between_walls(robot(), 2100.0, noise);
        let mut docking = Docking::new(&believed(LawName::Predictor, &robot()), &plant, 0.005);
        docking.bounce();
        assert_found(&docking, 2100.0, 0.05);
    }

    #[test]
    fn noise_neither_opens_contacts_nor_adds_speed() {
        let noise = Measurement {
            position_noise_m: 5e-6,
            force_noise_n: 0.05,
            ..Measurement::default()
        };
        let mut docking = Docking::new(
            &believed(LawName::Predictor, &robot()),
            &between_walls(robot(), 0.0, noise),
            0.005,
        );
        docking.run(200);
        assert!(!docking.seen.has(LawFlags::CONTACT));
        assert_eq!(docking.speed(), 0.005);
        for n in 0..4 {
            let restitution = docking.bounce();
            assert!((restitution - 1.0).abs() < 1e-3, "{n}: {restitution}");
            assert_found(&docking, 0.0, 3e-3);
            assert!(docking.seen.has(LawFlags::DAMPING_IN_NOISE));
        }
    }

    /// Two cycles older than the force.
    #[test]
    fn the_age_of_the_pose_is_found_in_the_first_contact() {
        let late = Measurement {
            pose_latency_cycles: 2,
            ..Measurement::default()
        };
        let mut docking = Docking::new(
            &believed(LawName::Predictor, &robot()),
            &between_walls(robot(), 0.0, late),
            0.005,
        );
        let restitution = docking.bounce();
        assert!((restitution - 1.0).abs() < 3e-3, "{restitution}");
        assert_eq!(docking.status.latency_cycles, 2);
        assert!((docking.status.delay_s - 0.032).abs() < 1e-6);
    }

    #[test]
    fn a_robot_that_is_later_than_believed_is_noticed_on_the_approach() {
        for delay_s in [0.0372, 0.026, 0.044] {
            let actuator = Actuator { delay_s, ..robot() };
            let plant = between_walls(actuator, 0.0, Measurement::default());
            let mut docking = Docking::new(&believed(LawName::Predictor, &robot()), &plant, 0.005);
            docking.run(100);
            assert!(
                (docking.status.delay_s - delay_s).abs() < 1e-5,
                "{:?}",
                docking.status
            );
            let observer = observer(&docking);
            let apart = observer.robot.position()[0]
                - docking.plant.log().moments[docking.cycle - 2].position[0];
            assert!(apart.abs() < 1e-9, "{apart}");
            let restitution = docking.bounce();
            assert!((restitution - 1.0).abs() < 2e-3, "{delay_s}: {restitution}");
        }
    }

    #[test]
    fn a_delay_that_changes_is_followed_from_contact_to_contact() {
        let change = DelayChange {
            at_s: 0.6,
            cycles: 2,
        };
        let actuator = Actuator {
            delay_change: Some(change),
            ..robot()
        };
        let plant = between_walls(actuator, 0.0, Measurement::default());
        let mut docking = Docking::new(&believed(LawName::Predictor, &robot()), &plant, 0.005);
        // Each shows some more of what is left.
        let mut left = 0.008;
        for _ in 0..4 {
            docking.bounce();
            let apart = (docking.status.delay_s - 0.040).abs();
            assert!(apart < 0.6 * left, "{:?}", docking.status);
            left = apart;
        }
        assert!(docking.seen.has(LawFlags::DELAY_FOLLOWED));
    }

    #[test]
    fn a_robot_that_is_none_of_those_believed_does_not_get_into_a_contact() {
        let servo = Dynamics::Servo {
            hz: 10.0,
            damping: 0.7,
        };
        for (delay_s, dynamics, at_bound) in [(0.0097, servo, false), (0.1, Dynamics::None, true)] {
            let actuator = Actuator {
                delay_s,
                dynamics,
                ..robot()
            };
            let plant = between_walls(actuator, 0.0, Measurement::default());
            let mut docking = Docking::new(&believed(LawName::Predictor, &robot()), &plant, 0.005);
            docking.run(150);
            let fault = docking.fault.expect("a fault");
            assert!(fault.received > fault.expected && fault.received == docking.status.misfit);
            // Of the displacement in a delay, and what noise adds to it.
            let law = predictor(&docking);
            let model = &law.supervisor.model;
            let displacement = 0.005 * model.linear.mean_delay * model.cycle_s;
            let noise = law.supervisor.approach.findings.noise_m / displacement;
            assert!((fault.expected - 0.0035 - noise).abs() < 1e-9, "{fault:?}");
            assert_eq!(docking.seen.has(LawFlags::DELAY_AT_BOUND), at_bound);
            assert_eq!(fault.code, FaultCode::ActuatorUnlike);
            let mut settings = believed(LawName::Predictor, &robot());
            settings.predictor.interlock = false;
            let mut docking = Docking::new(&settings, &plant, 0.005);
            docking.run(150);
            assert!(docking.fault.is_none());
        }
    }

    /// Pushed from behind by 5 N, and by less than is significant.
    #[test]
    fn a_load_that_is_no_contact_moves_nothing() {
        for (force, spurious) in [(5.0, true), (0.005, false), (-0.005, false)] {
            let plant = between_walls(robot(), 0.0, Measurement::default());
            let mut docking = Docking::new(&believed(LawName::Predictor, &robot()), &plant, 0.005);
            docking.run(150);
            for _ in 0..10 {
                docking.sample.wrench[0] = force;
                docking.step();
            }
            assert_eq!(
                docking.seen.has(LawFlags::SPURIOUS_LOAD),
                spurious,
                "{force}"
            );
            assert!(!docking.seen.has(LawFlags::CONTACT));
            assert_eq!(docking.speed(), 0.005);
        }
    }

    /// A load that grows with the square of the depth.
    #[test]
    fn a_contact_that_is_not_understood_is_kept_passive_and_the_next_led_by_the_fallback() {
        let law = ForceLaw {
            exponent: 2.0,
            ..ForceLaw::linear(STIFFNESS / 2.4e-4, 0.0)
        };
        let wall = |x: f64| Wall {
            point: [x, 0.0, 0.0],
            normal: [-x.signum(), 0.0, 0.0],
            law,
        };
        for guard in [true, false] {
            let mut plant = between_walls(robot(), 0.0, Measurement::default());
            plant.contact.surfaces = [0.0045, -0.003].map(|x| wall(x).into()).to_vec();
            let mut settings = believed(LawName::Predictor, &robot());
            settings.predictor.guard = guard;
            let mut docking = Docking::new(&settings, &plant, 0.005);
            for n in 0..3 {
                docking.seen = LawFlags::default();
                let restitution = docking.bounce();
                assert_eq!(docking.status.confidence, ConfidenceLevel::Fallback);
                assert_eq!(docking.seen.has(LawFlags::GUARD_PASSIVE), guard);
                // A robot that is led by the model's acceleration alone comes back too fast.
                let speed = if guard { 1.0..=1.0 } else { 1.005..=1.5 };
                assert!(speed.contains(&restitution), "{guard} {n}: {restitution}");
                // It was not where the model is; from now on the model is where it is.
                let observer = observer(&docking);
                let apart = observer.model - observer.robot.position();
                assert!(n == 0 || apart[0].abs() < 2e-4, "{n}: {apart}");
                assert!(!docking.seen.has(LawFlags::MEMORY));
            }
        }
    }
}
