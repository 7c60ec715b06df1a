//! The experiment that tells two effects apart, tried on the simulated rig before it costs an
//! afternoon on the real one.

use super::demo::run;
use super::diagnosis::{self, Part};
use anyhow::Result;
use softdock_analysis::diagnose::{Diagnosis, diagnose};
use softdock_rig::rig::hidden::suggest;

/// Draws the size of the effect and the noise of the rehearsal.
const SEED: u64 = 1;

/// 2 Δ log L between two effects of one channel when the simulated rig hides the first, in a usual size, and
/// carries out the built-in test: slow and fast free motion, contact, both directions.
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

/// Fall of χ² with one effect alone. One that is not reported falls short of all that are.
fn gain(diagnosis: &Diagnosis, effect: &str) -> f64 {
    let own = diagnosis.ranked.iter().find(|r| r.effects == [effect]);
    let least = diagnosis.ranked.iter().map(|r| r.gain_train);
    own.map(|r| r.gain_train)
        .or_else(|| least.min_by(f64::total_cmp))
        .unwrap_or(0.0)
}
