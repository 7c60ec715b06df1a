//! Simulation of one contact: the board's own cycle and law, the late robot, one mass on one wall.

use super::rig_file::Rig;
use crate::one_contact::Contact;
use anyhow::{Result, anyhow};
use softdock_control::delay::LawName;
use softdock_control::modes::{Command, Fault, Mode};
use softdock_control::settings::{BodySettings, RobotSettings, SensorSettings, Settings};
use softdock_rig::board::cycle_driver::CycleDriver;
use softdock_rig::rig::drive::Drive;
use std::collections::VecDeque;

/// Number of instants of the touch within a cycle: the restitution of a damped contact is a saw-tooth function of it.
const TOUCH_INSTANTS: u32 = 8;
/// Cycles in which the robot stands still before the start, as with an operator.
const REST_CYCLES: u32 = 40;
/// Free flight at full speed before the touch, cycles: what an adaptive law learns from.
const FLIGHT_CYCLES: f64 = 150.0;
/// Cycles that are simulated after the contact is over.
const AFTER_CYCLES: u32 = 60;
/// Duration, in multiples of the contact time, after which a contact counts as one that does not end.
const LONGEST_CONTACTS: f64 = 12.0;
/// Integration steps per cycle; the robot is exact at whole steps of its delay.
const SUB_STEPS: u32 = 20;
/// Decimals of a correction in mm and degrees: fine enough for rounding to have no effect.
const DECIMALS: u8 = 6;

/// One contact.
#[derive(Clone, Copy, Debug, Default)]
struct Bounce {
    /// Speed after over speed before; None if the contact does not end.
    restitution: Option<f64>,
    peak_force_n: f64,
    contact_s: f64,
    /// Impulse on the model that was not measured, divided by 2 m v.
    unaccounted: f64,
    fault: Option<Fault>,
}

/// Contacts at several instants of the touch within a cycle.
pub(super) struct Bounces(Vec<Bounce>);

impl Bounces {
    /// Simulates the contacts with a law.
    pub(super) fn new(law: LawName, settings: &Settings, rig: &Rig) -> Result<Self> {
        let settings = alone(law, settings, rig);
        let touch_instant = |n: u32| (f64::from(n) + 0.5) / f64::from(TOUCH_INSTANTS);
        let bounces = (0..TOUCH_INSTANTS)
            .map(|n| Ok(Test::new(&settings, rig, touch_instant(n))?.run()))
            .collect::<Result<_>>()?;
        Ok(Self(bounces))
    }

    fn restitutions(&self) -> Option<Vec<f64>> {
        self.0.iter().map(|bounce| bounce.restitution).collect()
    }

    /// Mean restitution; None if a contact does not end.
    pub(super) fn mean(&self) -> Option<f64> {
        let all = self.restitutions()?;
        Some(all.iter().sum::<f64>() / all.len() as f64)
    }

    /// Smallest and largest restitution; None if a contact does not end.
    pub(super) fn range(&self) -> Option<(f64, f64)> {
        let all = self.restitutions()?;
        let low = all.iter().copied().fold(f64::INFINITY, f64::min);
        let high = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Some((low, high))
    }

    /// The first fault in any of the contacts.
    pub(super) fn fault(&self) -> Option<Fault> {
        self.0.iter().find_map(|bounce| bounce.fault)
    }

    /// Largest force of all contacts over that of the contact itself, less 1.
    pub(super) fn peak_force_error(&self, contact: &Contact, speed_m_s: f64) -> f64 {
        let forces = self.0.iter().map(|bounce| bounce.peak_force_n);
        forces.fold(0.0, f64::max) / contact.peak_force_n(speed_m_s) - 1.0
    }

    /// Mean time in contact over that of the contact itself, less 1; None if a contact does not end.
    pub(super) fn contact_time_error(&self, contact: &Contact) -> Option<f64> {
        self.restitutions()?;
        let sum: f64 = self.0.iter().map(|bounce| bounce.contact_s).sum();
        Some(sum / self.0.len() as f64 / contact.contact_time_s() - 1.0)
    }

    /// Mean impulse that was not measured.
    pub(super) fn impulse_unaccounted(&self) -> f64 {
        let sum: f64 = self.0.iter().map(|bounce| bounce.unaccounted).sum();
        sum / self.0.len() as f64
    }
}

/// The settings with one mass that flies along x in place of the two spacecraft, an ideal sensor and a wide box. Limits of
/// speed, acceleration and force stay.
fn alone(law: LawName, settings: &Settings, rig: &Rig) -> Settings {
    let mut alone = settings.clone();
    alone.delay.law = law;
    alone.body_k = BodySettings {
        mass_kg: rig.contact.mass_kg,
        velocity_m_s: [rig.approach_speed_m_s, 0.0, 0.0],
        ..BodySettings::default()
    };
    alone.body_q = BodySettings {
        fixed: true,
        ..BodySettings::default()
    };
    alone.sensor = SensorSettings {
        frozen_after_cycles: 0,
        ..SensorSettings::default()
    };
    alone.robot = RobotSettings {
        cycle_s: settings.robot.cycle_s,
        correction_decimals: DECIMALS,
        ..RobotSettings::default()
    };
    alone.limits.box_m = [5.0; 3];
    alone
}

/// A running test.
struct Test<'a> {
    rig: &'a Rig,
    board: CycleDriver<f64>,
    drive: Drive,
    wall_m: f64,
    /// Positions that are not reported yet, m.
    reports: VecDeque<f64>,
    bounce: Bounce,
    touched: bool,
}

impl<'a> Test<'a> {
    fn new(settings: &Settings, rig: &'a Rig, touch_instant: f64) -> Result<Self> {
        let cycle_s = settings.robot.cycle_s;
        let mut robot = rig.settings();
        robot.cycle_us = (cycle_s * 1e6).round() as u32;
        robot.substep_us = robot.cycle_us / SUB_STEPS;
        let start = &settings.start;
        // During the ramp the spacecraft flies half as far as at full speed.
        let ramp = f64::from(start.zero_cycles) + 0.5 * f64::from(start.ramp_cycles);
        let flight_s = (ramp + FLIGHT_CYCLES + touch_instant) * cycle_s;
        let mut test = Self {
            rig,
            board: CycleDriver::new(settings)?,
            drive: Drive::new(&robot, [0.0; 6])?,
            wall_m: rig.approach_speed_m_s * flight_s,
            reports: VecDeque::from(vec![0.0; rig.feedback_latency_cycles.into()]),
            bounce: Bounce::default(),
            touched: false,
        };
        test.step(Some(Command::Hold));
        test.step(Some(Command::Arm));
        for _ in 0..REST_CYCLES {
            test.step(None);
        }
        test.step(Some(Command::Start));
        if test.board.cycle.mode() == Mode::Running {
            Ok(test)
        } else {
            Err(anyhow!(
                "the board does not start in this computation: it is in {:?}",
                test.board.cycle.mode()
            ))
        }
    }

    fn run(mut self) -> Bounce {
        let contact = &self.rig.contact;
        let longest_s = LONGEST_CONTACTS * (contact.contact_time_s() + self.rig.mean_delay_s());
        let flight_s = self.wall_m / self.rig.approach_speed_m_s;
        let cycles = ((2.0 * flight_s + longest_s) / self.board.cycle_s()) as u32 + AFTER_CYCLES;
        let mut after = 0;
        for _ in 0..cycles {
            let velocity = self.step(None);
            if self.board.cycle.fault().is_some() {
                break;
            }
            let clear = self.touched && self.force() == 0.0;
            after = if clear { after + 1 } else { 0 };
            if after > AFTER_CYCLES {
                let speed = self.rig.approach_speed_m_s;
                self.bounce.restitution = Some(-velocity / speed);
                break;
            }
        }
        self.bounce.fault = self.board.cycle.fault();
        self.bounce
    }

    /// Runs one cycle. Returns the model's velocity after it, m/s.
    fn step(&mut self, command: Option<Command>) -> f64 {
        let x = self.drive.position(0.0)[0];
        self.reports.push_back(x);
        let reported = self.reports.pop_front().unwrap_or(x);
        let force_n = self.force();
        let record = self.board.step_with(|inputs| {
            inputs.robot.pose = Some([reported, 0.0, 0.0, 0.0, 0.0, 0.0]);
            inputs.sensor.wrench[0] = -force_n;
            inputs.command = command;
        });
        let impulse = record.trace.unaccounted_impulse[0];
        let momentum = 2.0 * self.rig.contact.mass_kg * self.rig.approach_speed_m_s;
        self.bounce.unaccounted += impulse / momentum;
        self.move_robot(self.board.velocity(&record.output.correction)[0]);
        record.trace.body_k.velocity[0]
    }

    fn move_robot(&mut self, velocity_m_s: f64) {
        self.drive.push([velocity_m_s, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let step_s = self.board.cycle_s() / f64::from(SUB_STEPS);
        for step in 0..SUB_STEPS {
            self.drive.advance(f64::from(step) * step_s, 0.0);
            let force = self.force();
            if force > 0.0 {
                self.touched = true;
                self.bounce.contact_s += step_s;
                self.bounce.peak_force_n = self.bounce.peak_force_n.max(force);
            }
        }
    }

    /// Force of the wall, N: k x + b v, never pulling.
    fn force(&self) -> f64 {
        let depth_m = self.drive.position(0.0)[0] - self.wall_m;
        if depth_m <= 0.0 {
            return 0.0;
        }
        let contact = &self.rig.contact;
        let velocity_m_s = self.drive.twist().linear.x;
        let force = contact.stiffness_n_per_m * depth_m + contact.damping_n_s_per_m * velocity_m_s;
        force.max(0.0)
    }
}
