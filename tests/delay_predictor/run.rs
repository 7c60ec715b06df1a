//! A run with the predictor, and what came of it.

use softdock_app::record::CycleRecord;
use softdock_control::delay::LawName;
use softdock_control::delay::status::LawFlags;
use softdock_control::modes::Mode;
use softdock_control::settings::Settings;
use softdock_delay_plants::{Log, PlantSettings};
use softdock_tests::closed_loop::ClosedLoop;

/// Settings with the predictor, a passive spacecraft of 500 kg and one that does not move.
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
    let mut rig = ClosedLoop::<f64>::started(settings, plant);
    let mut records = Vec::new();
    for _ in 0..(duration_s / settings.robot.cycle_s) as usize {
        let record = rig.step();
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
        log: rig.plant.log().clone(),
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
