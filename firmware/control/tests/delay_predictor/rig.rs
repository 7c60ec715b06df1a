//! The control cycle in closed loop with a plant that shares no code with it.

use softdock_control::cycle::Cycle;
use softdock_control::delay::LawName;
use softdock_control::delay::status::LawFlags;
use softdock_control::io::{CycleRecord, Inputs, Sequence};
use softdock_control::modes::{Command, Mode};
use softdock_control::settings::Settings;
use softdock_delay_plants::{Axes, Log, Plant, PlantSettings};

/// Settings with the predictor, a passive craft of 500 kg and one that does not move.
pub(crate) fn settings() -> Settings {
    let mut settings = Settings::default();
    settings.delay.law = LawName::Predictor;
    settings.body_q.fixed = true;
    settings.sensor.frozen_after_cycles = 0;
    settings.robot.correction_decimals = 6;
    settings
}

/// A run: every cycle in which the loop was closed, and what really happened.
pub(crate) struct Run {
    pub(crate) records: Vec<CycleRecord>,
    pub(crate) log: Log,
}

/// Runs for a time with the loop closed, or to the first fault.
pub(crate) fn run(settings: &Settings, plant: &PlantSettings, duration_s: f64) -> Run {
    let mut cycle = Cycle::<f64>::new(settings).unwrap();
    let mut plant = Plant::new(plant);
    let mut sample = plant.first_sample();
    let digit = 0.1_f64.powi(settings.robot.correction_decimals.into());
    let units = [digit * 1e-3, digit.to_radians()];
    let cycle_s = settings.robot.cycle_s;
    let mut inputs = Inputs::default();
    let mut records = Vec::new();
    let commands = [
        None,
        Some(Command::Hold),
        Some(Command::Arm),
        Some(Command::Start),
    ];
    let cycles = (duration_s / cycle_s) as usize;
    for n in 0..cycles {
        inputs.robot.ipoc += 4;
        inputs.robot.sequence = if n == 0 {
            Sequence::NewRun
        } else {
            Sequence::Next
        };
        inputs.robot.pose = Some(sample.position);
        inputs.sensor.counter += 1;
        inputs.sensor.words[5] ^= 1;
        inputs.sensor.wrench = sample.wrench;
        inputs.command = commands.get(n).copied().flatten();
        let record = cycle.step(&inputs);
        let counts = record.output.correction;
        let velocity: Axes = core::array::from_fn(|i| counts[i] as f64 * units[i / 3] / cycle_s);
        sample = plant.step(velocity);
        match record.trace.mode {
            Mode::Running => records.push(record),
            Mode::Fault => {
                records.push(record);
                break;
            }
            _ => {}
        }
    }
    Run {
        records,
        log: plant.log().clone(),
    }
}

impl Run {
    /// Velocity of K along x before, and at the end.
    pub(crate) fn speeds(&self) -> (f64, f64) {
        let v = |r: Option<&CycleRecord>| r.map_or(f64::NAN, |r| r.trace.body_k.velocity[0]);
        (v(self.records.first()), v(self.records.last()))
    }

    /// Speed after over speed before, along x.
    pub(crate) fn restitution(&self) -> f64 {
        let (before, after) = self.speeds();
        -after / before
    }

    /// Sum of the impulses along x that were not measured, N·s.
    pub(crate) fn unaccounted(&self) -> f64 {
        let impulse = |r: &CycleRecord| r.trace.unaccounted_impulse[0];
        self.records.iter().map(impulse).sum()
    }

    /// Whether the guard acted.
    pub(crate) fn guarded(&self) -> bool {
        let guard = |r: &CycleRecord| {
            let flags = r.trace.law_status.flags;
            flags.has(LawFlags::GUARD_IDENTIFIED) || flags.has(LawFlags::GUARD_PASSIVE)
        };
        self.records.iter().any(guard)
    }
}
