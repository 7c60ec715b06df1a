//! The control cycle in closed loop with a plant that shares no code with it.

use softdock_app::record::{CycleRecord, Inputs};
use softdock_app::robot_cycle::RobotCycle;
use softdock_control::io::Sequence;
use softdock_control::modes::Command;
use softdock_control::scalar::Scalar;
use softdock_control::settings::Settings;
use softdock_delay_plants::{Axes, Plant, PlantSettings};

/// Commands that start a test, one a cycle.
const START: [Command; 3] = [Command::Hold, Command::Arm, Command::Start];

/// Cycle and plant.
pub struct ClosedLoop<S: Scalar> {
    /// The board.
    pub cycle: RobotCycle<S>,
    /// Robot and contact.
    pub plant: Plant,
    inputs: Inputs,
    /// m/s and rad/s per count of a correction.
    units: [f64; 2],
    /// Cycles before the first command.
    idle: usize,
    /// Cycles that have run.
    pub cycles: usize,
}

impl<S: Scalar> ClosedLoop<S> {
    /// Before its first cycle.
    pub fn new(settings: &Settings, plant: &PlantSettings, idle: usize) -> Self {
        let mut plant = Plant::new(plant);
        let sample = plant.first_sample();
        let mut inputs = Inputs::default();
        inputs.robot.pose = Some(sample.position);
        inputs.robot.sequence = Sequence::NewRun;
        inputs.sensor.wrench = sample.wrench;
        let digit = 0.1_f64.powi(settings.robot.correction_decimals.into());
        let cycle_s = settings.robot.cycle_s;
        Self {
            cycle: RobotCycle::new(settings).unwrap(),
            plant,
            inputs,
            units: [digit * 1e-3, digit.to_radians()].map(|unit| unit / cycle_s),
            idle,
            cycles: 0,
        }
    }

    /// One cycle of both: idle, hold, arm and start first, then the test.
    pub fn step(&mut self) -> CycleRecord {
        self.inputs.robot.counter += 4;
        self.inputs.sensor.counter += 1;
        self.inputs.sensor.counts[5] ^= 1;
        let command = self.cycles.checked_sub(self.idle);
        self.inputs.command = command.and_then(|n| START.get(n).copied());
        let record = self.cycle.step(&self.inputs);
        let counts = record.output.correction;
        let velocity: Axes = core::array::from_fn(|i| counts[i] as f64 * self.units[i / 3]);
        let sample = self.plant.step(velocity);
        self.inputs.robot.pose = Some(sample.position);
        self.inputs.robot.sequence = Sequence::Next;
        self.inputs.sensor.wrench = sample.wrench;
        self.cycles += 1;
        record
    }
}
