//! One plant: a robot, its contact, and the measurement.

use crate::Axes;
use crate::actuator::{Actuator, Formulation, Robot};
use crate::contact::{Contact, Load};
use crate::log::{Log, Moment};
use crate::measurement::{Feedback, Measurement};
use crate::pose::RobotPose;

/// Settings of a plant.
#[derive(Clone, Debug, PartialEq)]
pub struct PlantSettings {
    /// Cycle, s.
    pub cycle_s: f64,
    /// X Y Z A B C at the start, m and rad.
    pub start: Axes,
    /// The robot.
    pub actuator: Actuator,
    /// Formulation of its motion.
    pub formulation: Formulation,
    /// The docking mechanism.
    pub contact: Contact,
    /// Errors of the feedback.
    pub measurement: Measurement,
    /// Seed of noise and jitter.
    pub seed: u64,
}

impl Default for PlantSettings {
    fn default() -> Self {
        Self {
            cycle_s: 0.004,
            start: [0.0; 6],
            actuator: Actuator::ideal(),
            formulation: Formulation::Exact,
            contact: Contact::default(),
            measurement: Measurement::default(),
            seed: 1,
        }
    }
}

/// The measurement at the end of a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Measured X Y Z A B C, m and rad.
    pub position: Axes,
    /// Measured wrench on the flange about M in axes of M, N and N·m.
    pub wrench: Axes,
}

/// A plant and its state.
#[derive(Clone, Debug)]
pub struct Plant {
    robot: Robot,
    contact: Contact,
    feedback: Feedback,
    log: Log,
    start: Axes,
}

impl Plant {
    /// A plant at rest.
    pub fn new(settings: &PlantSettings) -> Self {
        let PlantSettings {
            cycle_s,
            start,
            seed,
            ..
        } = *settings;
        let mut log = Log::default();
        log.begin(&settings.contact.load(&RobotPose::new(&start, &[0.0; 6])));
        Self {
            robot: Robot::new(
                &settings.actuator,
                settings.formulation,
                cycle_s,
                start,
                seed,
            ),
            contact: settings.contact.clone(),
            feedback: Feedback::new(&settings.measurement, start, seed),
            log,
            start,
        }
    }

    /// The measurement before the first cycle.
    pub fn first_sample(&mut self) -> Sample {
        let pose = RobotPose::new(&self.start, &[0.0; 6]);
        let load = self.contact.load(&pose);
        Sample {
            position: self.feedback.pose(self.start),
            wrench: self.feedback.wrench(in_flange(&pose, &load)),
        }
    }

    /// Runs one cycle with a commanded velocity of X Y Z A B C (m/s, rad/s). Returns the measurement at its end; all
    /// quantities are of the same instant, except for the latency of the pose.
    pub fn step(&mut self, command: Axes) -> Sample {
        let Self {
            robot,
            contact,
            log,
            ..
        } = self;
        let mut end = Moment {
            time_s: 0.0,
            position: [0.0; 6],
            velocity: [0.0; 6],
            wrench: [0.0; 6],
        };
        robot.cycle(command, |motion| {
            let pose = RobotPose::new(&motion.position, &motion.velocity);
            let load = contact.load(&pose);
            log.add_sample(motion.time_s, &load);
            end = Moment {
                time_s: motion.time_s,
                position: motion.position,
                velocity: motion.velocity,
                wrench: in_flange(&pose, &load),
            };
        });
        self.log.moments.push(end);
        Sample {
            position: self.feedback.pose(end.position),
            wrench: self.feedback.wrench(end.wrench),
        }
    }

    /// The true course of the run so far.
    pub fn log(&self) -> &Log {
        &self.log
    }
}

/// The load in axes of the flange.
fn in_flange(pose: &RobotPose, load: &Load) -> Axes {
    let back = pose.rotation.inverse();
    let (force, torque) = (back * load.force, back * load.torque);
    [force.x, force.y, force.z, torque.x, torque.y, torque.z]
}
