//! The simulated rig: a robot with its controller, a docking mechanism and a force/torque sensor.
//!
//! The plant runs in sub-millisecond steps, independent of the board's own integrator; its physics
//! are the effects of `softdock_physics::effects`. The rig speaks plain SI values; codecs wrap them
//! elsewhere. It is a function of its settings, its seed and the answers: the same run repeats bit
//! for bit.
//!
//! ```text
//!  begin_cycle() ---- telegram n ----> board        every cycle, on the robot's clock
//!  answer(correction)  <-- answer n -- board        within the same cycle, else it is late
//!  advance_to(t), gauges()                          sensor readings at any instant in between
//! ```
//!
//! The correction of cycle n over the cycle time is a velocity. It is commanded for one cycle that
//! begins at telegram n, and executed after the actuator's delay.

mod checks;
mod controller;
pub mod drive;
mod feedback;
mod gauge_quantisation;
mod guide;
pub mod hidden;
mod instants;
mod jitter;
mod load;
mod mechanism;
mod reading;
mod sensor;
pub mod settings;
mod spring_rod;
mod stage;
mod wall;

pub use controller::RsiStopped;
pub use hidden::Hidden;
pub use sensor::SensorSampleSim;
pub use settings::RigSettings;
pub use spring_rod::MAX_WALLS;

use anyhow::Result;
use checks::{check, check_all};
use controller::Controller;
use drive::{Axes, Drive, pose};
use feedback::Feedback;
use instants::Instants;
use jitter::Jitter;
use load::Load;
use mechanism::{Contact, Mechanism};
use sensor::Sensor;
use softdock_control::frames::{Pose, Twist, Wrench, vector};
use softdock_mechanism::{EnergyBalance, Loads};
use softdock_statistics::RandomStream;

/// Longest history of twists: integration steps per cycle.
const MAX_SUBSTEPS: usize = 64;

/// What a telegram carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotReport {
    /// RIst: X Y Z (m) and A B C (rad, A and C in ±π) as the controller measures them.
    pub actual_pose: [f64; 6],
    /// RSol: the same without any correction.
    pub setpoint_pose: [f64; 6],
    /// Delay D: answers that were late or rejected so far.
    pub late_answers: u32,
    /// Stat of POSCORR: bit 0 active, 1 to 3 lower limit of X Y Z, 4 to 6 upper limit, 7 rotation.
    pub poscorr_stat: u32,
}

/// True state at the present instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Time, s.
    pub time_s: f64,
    /// C_from_M.
    pub pose: Pose<f64>,
    /// Executed velocity, mean over the last integration step: linear in C, angular in M.
    pub twist: Twist<f64>,
    /// Contact with walls and docking mechanisms at M, in M axes; the guide's force is not part of it.
    pub contact: Wrench<f64>,
    /// Penetration of each wall, m; negative is the distance to it, unused walls are 0.
    pub penetration_m: [f64; MAX_WALLS],
}

/// The simulated rig.
#[derive(Clone, Debug)]
pub struct Rig {
    cycle_us: u64,
    substep_us: u64,
    /// Time of the plant, and by how much the observer is ahead of it, µs.
    time_us: u64,
    ahead_us: u64,
    next_telegram_us: u64,
    cycle: u64,
    start: Axes,
    controller: Controller,
    drive: Drive,
    mechanism: Mechanism,
    captured_s: Option<f64>,
    stops_at_capture: bool,
    sensor: Sensor,
    feedback: Feedback,
    jitter: Jitter,
    instants: Instants,
    /// Twists at the last integration steps, a ring over one cycle.
    twists: [Twist<f64>; MAX_SUBSTEPS],
}

/// Whether a rig can begin at C_from_M as X Y Z (m) and A B C (rad).
///
/// # Errors
/// A number is beyond its range.
pub fn check_start_pose(start_pose: &[f64; 6]) -> Result<()> {
    check_all("start pose", start_pose, -1e3, 1e3)
}

impl Rig {
    /// A rig at rest at `start_pose`: C_from_M as X Y Z (m) and A B C (rad).
    ///
    /// # Errors
    /// A value outside its range: the error names the field, the value and the range.
    pub fn new(settings: &RigSettings, start_pose: [f64; 6], seed: u64) -> Result<Self> {
        check_steps(settings)?;
        check_start_pose(&start_pose)?;
        hidden::validate(settings)?;
        let mut rig = Self {
            cycle_us: settings.cycle_us.into(),
            substep_us: settings.substep_us.into(),
            time_us: 0,
            ahead_us: 0,
            next_telegram_us: 0,
            cycle: 0,
            start: start_pose,
            controller: Controller::new(settings)?,
            drive: Drive::new(settings, start_pose)?,
            mechanism: Mechanism::new(
                &settings.mechanism,
                &settings.hidden,
                &start_pose,
                vector(&settings.sensor.position_m),
            )?,
            captured_s: None,
            stops_at_capture: !settings.mechanism.runs_on_after_capture,
            sensor: Sensor::new(
                settings,
                RandomStream::new(seed, 0),
                RandomStream::new(seed, 3),
            )?,
            feedback: Feedback::new(settings, start_pose, RandomStream::new(seed, 1))?,
            jitter: Jitter::new(settings, RandomStream::new(seed, 2))?,
            instants: Instants::new(settings, &RandomStream::new(seed, 4)),
            twists: [Twist::zero(); MAX_SUBSTEPS],
        };
        let load = rig.load(0.0).1;
        rig.sensor.settle(&load);
        Ok(rig)
    }

    /// Integrates up to `time_us`. The plant does not pass the next telegram before
    /// [`Self::begin_cycle`] sends it, unless the robot has stopped: then time just goes on. Between
    /// integration steps the pose is extrapolated.
    pub fn advance_to(&mut self, time_us: u64) {
        while self.time_us + self.substep_us <= time_us {
            if self.time_us >= self.next_telegram_us {
                if self.controller.stopped().is_none() {
                    break;
                }
                self.start_cycle([0.0; 6]); // a stopped robot needs nobody to go on standing
            }
            self.substep();
        }
        self.ahead_us = time_us
            .min(self.next_telegram_us)
            .saturating_sub(self.time_us);
    }

    /// Sends the next telegram, at its instant (the plant catches up if it is behind). An
    /// unanswered previous telegram counts as late here.
    ///
    /// `None`: the robot has stopped, see [`Self::stopped`].
    pub fn begin_cycle(&mut self) -> Option<RobotReport> {
        self.advance_to(self.next_telegram_us);
        let velocity = match self.controller.begin_cycle() {
            Ok(velocity) => velocity,
            Err(_) => {
                self.drive.replace_newest([0.0; 6]);
                return None;
            }
        };
        let poscorr_stat = self.controller.poscorr_stat();
        self.start_cycle(velocity);
        let position = self.instants.position(&self.drive, self.jitter.now_s);
        let actual_pose = self.feedback.measure(position, self.cycle);
        Some(RobotReport {
            actual_pose,
            setpoint_pose: self.start,
            late_answers: self.controller.late_answers(),
            poscorr_stat,
        })
    }

    /// The answer to the last telegram: RKorr of this cycle, X Y Z (m) and A B C (rad), and whether
    /// to stop. Only the first finite answer of a cycle counts.
    pub fn answer(&mut self, correction: [f64; 6], stop: bool) {
        if let Some(velocity) = self.controller.answer(correction, stop) {
            self.drive.replace_newest(velocity);
        }
    }

    /// The gauges at the present instant. Each call draws new noise.
    pub fn gauges(&mut self) -> SensorSampleSim {
        let (_, load) = self.load(self.ahead_s() + self.instants.jitter_s());
        self.sensor.read(&load, self.time_s())
    }

    /// Status word that the sensor reports from now on: a fault to be noticed.
    pub fn set_sensor_status(&mut self, status: u16) {
        self.sensor.status = status;
    }

    /// True state at the present instant.
    pub fn truth(&self) -> Truth {
        let (contact, load) = self.load(self.ahead_s());
        Truth {
            time_s: self.time_s(),
            pose: load.c_from_m,
            twist: load.twist,
            contact: contact.wrench,
            penetration_m: contact.penetration_m,
        }
    }

    /// When the mechanism's latches caught the spacecraft, s.
    pub fn captured_s(&self) -> Option<f64> {
        self.captured_s
    }

    /// Whether the capture switch asks the board to stop.
    pub fn asks_to_stop(&self) -> bool {
        self.stops_at_capture && self.captured_s.is_some()
    }

    /// The largest loads of the docking mechanisms so far, in their order.
    pub fn loads(&self) -> impl Iterator<Item = Loads> {
        self.mechanism.loads()
    }

    /// Work that the robot did on the mechanism, and where the energy went.
    pub fn energy(&self) -> EnergyBalance {
        self.mechanism.balance()
    }

    /// Why the robot stopped, if it did.
    pub fn stopped(&self) -> Option<RsiStopped> {
        self.controller.stopped()
    }

    /// Time of the observer, s.
    fn time_s(&self) -> f64 {
        (self.time_us + self.ahead_us) as f64 * 1e-6
    }

    fn ahead_s(&self) -> f64 {
        self.ahead_us as f64 * 1e-6
    }

    fn start_cycle(&mut self, velocity: Axes) {
        self.drive.push(velocity);
        self.jitter.draw();
        self.instants.draw();
        self.next_telegram_us += self.cycle_us;
        self.cycle += 1;
    }

    fn substep(&mut self) {
        let since_cycle_us = self.time_us + self.cycle_us - self.next_telegram_us;
        self.instants.remember(self.drive.position(0.0));
        self.drive
            .advance(since_cycle_us as f64 * 1e-6, self.jitter.now_s);
        self.time_us += self.substep_us;
        let (c_from_m, twist) = (pose(&self.drive.position(0.0)), self.drive.twist());
        self.mechanism
            .advance(&c_from_m, &twist, self.substep_us as f64 * 1e-6);
        if self.captured_s.is_none() && self.mechanism.captured() {
            self.captured_s = Some(self.time_us as f64 * 1e-6);
        }
        if self.sensor.feels_inertia() {
            let slot = self.twist_slot(0);
            self.twists[slot] = self.drive.twist();
        }
        if self.sensor.has_memory() {
            let (_, load) = self.load(0.0);
            self.sensor.advance(&load);
        }
    }

    /// Index in `twists` of the twist `back` integration steps ago.
    fn twist_slot(&self, back: u64) -> usize {
        let steps = self.time_us / self.substep_us + MAX_SUBSTEPS as u64;
        ((steps - back) % MAX_SUBSTEPS as u64) as usize
    }

    /// Contact and load, `ahead_s` after the last integration step.
    fn load(&self, ahead_s: f64) -> (Contact, Load) {
        let (c_from_m, twist) = (pose(&self.drive.position(ahead_s)), self.drive.twist());
        let contact = self.mechanism.evaluate(&c_from_m, &twist);
        let acceleration = self.acceleration();
        (
            contact,
            Load {
                c_from_m,
                contact: contact.wrench + contact.guide,
                twist,
                acceleration,
            },
        )
    }

    /// Mean acceleration over the last cycle. The commanded velocity is a staircase whose edges a
    /// real drive smooths; over one cycle the mean does not depend on how.
    fn acceleration(&self) -> Twist<f64> {
        if !self.sensor.feels_inertia() {
            return Twist::zero();
        }
        let then = self.twists[self.twist_slot(self.cycle_us / self.substep_us)];
        (self.drive.twist() - then) * (1e6 / self.cycle_us as f64)
    }
}

fn check_steps(settings: &RigSettings) -> Result<()> {
    let (cycle, step) = (settings.cycle_us, settings.substep_us);
    check("rig.cycle_us", f64::from(cycle), 1000.0, 100_000.0)?;
    let shortest = cycle.div_ceil(MAX_SUBSTEPS as u32);
    check(
        "rig.substep_us",
        f64::from(step),
        f64::from(shortest),
        f64::from(cycle),
    )?;
    anyhow::ensure!(
        cycle % step == 0,
        "rig.substep_us = {step}: it must divide rig.cycle_us = {cycle} without remainder"
    );
    Ok(())
}

#[cfg(test)]
mod sensor_tests;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod validation_tests;
