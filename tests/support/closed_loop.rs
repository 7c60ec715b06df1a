//! The control cycle in closed loop with a plant that shares no code with it.

use crate::driver::{CycleDriver, idle};
use softdock_app::record::{CycleRecord, Inputs};
use softdock_control::modes::{Command, Mode};
use softdock_control::scalar::Scalar;
use softdock_control::settings::Settings;
use softdock_delay_plants::{Plant, PlantSettings, Sample};

/// Commands that start a test, one per cycle.
const START: [Command; 3] = [Command::Hold, Command::Arm, Command::Start];

/// Cycle and plant.
#[derive(Clone, Debug)]
pub struct ClosedLoop<S: Scalar> {
    /// The board.
    pub driver: CycleDriver<S>,
    /// Robot and contact.
    pub plant: Plant,
    /// Cycles that have run.
    pub cycles: usize,
}

impl<S: Scalar> ClosedLoop<S> {
    /// Cycle and plant before their first cycle.
    ///
    /// # Panics
    /// If the settings are not valid.
    pub fn new(settings: &Settings, plant: &PlantSettings) -> Self {
        let mut plant = Plant::new(plant);
        let sample = plant.first_sample();
        let mut closed = Self {
            driver: idle(settings),
            plant,
            cycles: 0,
        };
        closed.measure(&sample);
        closed
    }

    /// Cycle and plant after hold, arm and start, one per cycle: the next step is the first of the start ramp.
    ///
    /// # Panics
    /// If the settings are not valid, or the board does not start.
    pub fn started(settings: &Settings, plant: &PlantSettings) -> Self {
        let mut closed = Self::new(settings, plant);
        let last = START.map(|word| closed.step_with(|inputs| inputs.command = Some(word)))[2];
        assert_eq!(last.trace.mode, Mode::Running, "{:?}", last.trace);
        closed
    }

    /// Runs one cycle of the board and the plant.
    pub fn step(&mut self) -> CycleRecord {
        self.step_with(|_| {})
    }

    /// Runs one cycle whose inputs are changed by `change`.
    pub fn step_with(&mut self, change: impl FnOnce(&mut Inputs)) -> CycleRecord {
        let record = self.driver.step_with(change);
        let sample = self
            .plant
            .step(self.driver.velocity(&record.output.correction));
        self.measure(&sample);
        self.cycles += 1;
        record
    }

    fn measure(&mut self, sample: &Sample) {
        self.driver.inputs.robot.pose = Some(sample.position);
        self.driver.inputs.sensor.wrench = sample.wrench;
    }
}
