//! Tries the experiment that distinguishes two effects on the simulated rig, before it costs an afternoon on the real one.

use super::demo::run;
use super::diagnosis::{self, Part};
use anyhow::Result;
use softdock_analysis::diagnose::{Diagnosis, diagnose};
use softdock_rig::rig::hidden::suggest;

/// Seed of the effect's size and of the noise.
const SEED: u64 = 1;

/// 2 Δ log L between two effects of one channel. The simulated rig hides `winner` in a usual size and runs the built-in test:
/// slow and fast free motion, contact, both directions.
///
/// # Errors
/// An effect that the simulated rig cannot hide.
pub fn separation(winner: &str, rival: &str, progress: &dyn Fn(f64, &str)) -> Result<f64> {
    let hidden = [suggest(winner, SEED)?];
    let (train, test) = (
        run(Part::Train, &hidden, SEED)?,
        run(Part::Test, &hidden, SEED)?,
    );
    let model = diagnosis::model()?;
    let report = diagnose(&model, &[&train.recording], &[&test.recording], progress)?;
    Ok(gain(&report.diagnosis, winner) - gain(&report.diagnosis, rival))
}

/// Fall of χ² with one effect alone. An effect that is not reported gets the smallest fall of all that are.
fn gain(diagnosis: &Diagnosis, effect: &str) -> f64 {
    let own = diagnosis.ranked.iter().find(|r| r.effects == [effect]);
    let least = diagnosis.ranked.iter().map(|r| r.gain_train);
    own.map(|r| r.gain_train)
        .or_else(|| least.min_by(f64::total_cmp))
        .unwrap_or(0.0)
}
