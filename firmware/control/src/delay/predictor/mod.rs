//! The default law: model predictive control of a robot with delay, such that it executes each motion at the time at which the
//! two spacecraft would.
//!
//! The model of the two spacecraft is moved by the measured force. The robot that presses the mechanism is late, so this law
//! commands it ahead of time:
//!
//! - A **robot model** with dead time (lag, servo and pause at a reversal behind it) follows the sent commands
//!   and predicts where they will bring the robot: dead-time compensation by an internal model, as in Smith's
//!   predictor (Smith, "Closer control of loops with dead time", Chem. Eng. Prog. 53, 1957). Its delay is
//!   identified on the approach and tracked from contact to contact.
//! - A **contact estimator** identifies each contact while it lasts as a Kelvin-Voigt model, by regularised
//!   recursive least squares; one for each possible latency of the reported pose (multiple models: Magill,
//!   "Optimal adaptive estimation of sampled stochastic processes", IEEE Trans. Autom. Control 10, 1965).
//! - A **reference** is the motion that two spacecraft with such a contact would have, one delay ahead.
//! - **Dynamic matrix control** (Cutler and Ramaker, "Dynamic matrix control: a computer control algorithm", Joint Automatic
//!   Control Conference, 1980) moves the robot along it: the free response by the robot model, the moves by least squares with
//!   move suppression, the first one sent. It differs from the textbook in three points: the moves are velocities on top of the
//!   reference's own; the prediction is not shifted by its last error, because an observer corrects the model's position; and it
//!   has no constraints: the speed limit and the reversals are applied to its result.
//! - **Impulse matching** adds a preload along the contact, so that the impulse still to come is that of the
//!   rebound. It is no part of dynamic matrix control and has no counterpart in the literature that is known to
//!   us.
//! - A **supervisor** compares what is identified with what happens: an interlock before the first contact, a guard on the
//!   restitution, a confidence level that leads to a fallback law (second-order lead).
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
//! | `control_problem`, `command` | what a command depends on; the command and its parts |
//! | `free_response`, `dynamic_matrix` | where the robot will be with what was sent, and the moves that bring it to the reference |
//! | `impulse_matching` | the preload |
//! | `reversals` | what holds an axis from turning twice |
//! | `fallback` | the command without an identified contact |
//! | `supervisor` | what is believed, what the model feels, which law commands |
//! | `batch`, `bounce`, `oblique`, `scene` | in the tests alone: exact contacts, and what is expected by a slower way of computing |
//!
//! It computes in f64 whatever the scalar type of the cycle is.

mod approach;
mod axis_map;
#[cfg(test)]
mod batch;
#[cfg(test)]
mod bounce;
mod command;
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
#[cfg(test)]
mod tests;
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
/// Observer and contact are kept beside the supervisor, which works on both. Neither is ever moved, which on a microcontroller
/// would cost more stack than the rest of the cycle. For the same reason the steps of a cycle are not inlined into each other.
#[derive(Clone, Debug)]
pub struct Predictor {
    supervisor: Supervisor,
    /// `None` before the first cycle.
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

    /// Resets the law to its initial state, in place.
    #[inline(never)]
    pub fn restart(&mut self, settings: &DelaySettings, cycle_s: f64) {
        self.supervisor = Supervisor::new(settings, cycle_s);
        self.observer = None;
        self.contact = None;
    }

    /// The wrench that the model feels, at M in axes of M: zero in free flight, and in a contact the mean of the last two
    /// measured ones, corrected for the parts of its beginning and end that lie between samples.
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

    /// One cycle: the velocity that the robot is commanded.
    pub fn step<S: Scalar>(&mut self, input: &LawInput<'_, S>) -> LawOutput<S> {
        self.observe(input);
        self.supervisor.observed = false;
        let Some(observer) = &mut self.observer else {
            return LawOutput::of(input.model_end);
        };
        if !input.released {
            // During the ramp the sensor's noise is measured, before any load may move the model.
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
