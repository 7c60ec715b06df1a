//! The control cycle in closed loop with a plant that shares no code with it.

#[path = "../shared/angles.rs"]
mod angles;

use angles::Commanded;
use softdock_control::cycle::Cycle;
use softdock_control::delay::LawName;
use softdock_control::delay::status::LawFlags;
use softdock_control::io::{Inputs, Sequence, Trace};
use softdock_control::modes::{Command, Mode};
use softdock_control::settings::Settings;
use softdock_delay_plants::{Log, Plant, PlantSettings};

/// Settings with the predictor, a passive craft of 500 kg and one that does not move.
pub(crate) fn settings() -> Settings {
    let mut settings = Settings::default();
    settings.delay.law = LawName::Predictor;
    settings.body_q.fixed = true;
    settings.sensor.frozen_after_cycles = 0;
    settings
}

/// A run: every cycle in which the loop was closed, and what really happened.
pub(crate) struct Run {
    pub(crate) records: Vec<Trace>,
    pub(crate) log: Log,
}

/// Runs for a time with the loop closed, or to the first fault.
pub(crate) fn run(settings: &Settings, plant: &PlantSettings, duration_s: f64) -> Run {
    let cycle_s = settings.robot.cycle_s;
    let mut cycle = Cycle::<f64>::new(settings, &angles::interface(cycle_s)).unwrap();
    let mut commanded = Commanded::default();
    let mut plant = Plant::new(plant);
    let mut sample = plant.first_sample();
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
        inputs.robot.sequence = if n == 0 {
            Sequence::NewRun
        } else {
            Sequence::Next
        };
        inputs.robot.pose = angles::pose(sample.position);
        inputs.sensor.counter += 1;
        inputs.sensor.counts[5] ^= 1;
        inputs.sensor.wrench = sample.wrench;
        inputs.command = commands.get(n).copied().flatten();
        let (output, record) = cycle.step(&inputs);
        sample = plant.step(commanded.velocity(&output, sample.position, cycle_s));
        match record.mode {
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
        let v = |r: Option<&Trace>| r.map_or(f64::NAN, |r| r.body_k.velocity[0]);
        (v(self.records.first()), v(self.records.last()))
    }

    /// Speed after over speed before, along x.
    pub(crate) fn restitution(&self) -> f64 {
        let (before, after) = self.speeds();
        -after / before
    }

    /// Sum of the impulses along x that were not measured, N·s.
    pub(crate) fn unaccounted(&self) -> f64 {
        let impulse = |r: &Trace| r.unaccounted_impulse[0];
        self.records.iter().map(impulse).sum()
    }

    /// Whether the guard acted.
    pub(crate) fn guarded(&self) -> bool {
        let guard = |r: &Trace| {
            let flags = r.law_status.flags;
            flags.has(LawFlags::GUARD_IDENTIFIED) || flags.has(LawFlags::GUARD_PASSIVE)
        };
        self.records.iter().any(guard)
    }
}
