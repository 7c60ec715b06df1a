//! All laws on all cases, in parallel.

use super::case::{CYCLE_S, Case};
use super::ideal::Ideal;
use super::limits::Limits;
use super::measure::{Numbers, measure};
use super::row::Row;
use super::trial::{self, Setup};
use anyhow::{Context, Result};
use rayon::prelude::*;
use softdock_control::delay::LawName;

/// Runs the laws on the cases, in parallel; `done` is called after each row.
///
/// # Errors
/// The board refuses a case: a mistake in its entry.
pub fn run(
    cases: &[Case],
    laws: &[LawName],
    seed: u64,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<Row>> {
    let jobs: Vec<(&Case, f64, LawName)> = cases
        .iter()
        .flat_map(|case| case.speeds_mm_s.iter().map(move |speed| (case, *speed)))
        .flat_map(|(case, speed)| laws.iter().map(move |law| (case, speed, *law)))
        .collect();
    jobs.par_iter()
        .map(|(case, speed_mm_s, law)| row(case, *speed_mm_s, *law, seed).inspect(|_| done()))
        .collect()
}

/// Number of rows that [`run`] returns.
pub fn rows(cases: &[Case], laws: &[LawName]) -> usize {
    cases.iter().map(|c| c.speeds_mm_s.len()).sum::<usize>() * laws.len()
}

/// Computes one row.
///
/// # Errors
/// Those of [`run`].
pub fn row(case: &Case, speed_mm_s: f64, law: LawName, seed: u64) -> Result<Row> {
    let speed_m_s = speed_mm_s * 1e-3;
    let one = |touch: usize| -> Result<(f64, Numbers)> {
        let touch_instant = (touch as f64 + 0.5) / case.touches as f64;
        let case = &case.of_touch(touch);
        let setup = Setup {
            case,
            law,
            speed_m_s,
            touch_instant,
            seed: seed.wrapping_mul(1000).wrapping_add(touch as u64),
        };
        let ideal = Ideal::new(case, speed_m_s, trial::flight_s(touch_instant, CYCLE_S));
        let trial = trial::run(&setup)?;
        Ok((ideal.restitution, measure(case, speed_m_s, &ideal, &trial)))
    };
    let runs = (0..case.touches)
        .map(one)
        .collect::<Result<Vec<_>>>()
        .with_context(|| format!("case {}, law {}", case.name, law.name()))?;
    let expected = runs.iter().map(|r| r.0).sum::<f64>() / runs.len().max(1) as f64;
    let numbers: Vec<Numbers> = runs.into_iter().map(|r| r.1).collect();
    let limits = Limits::new(case, CYCLE_S);
    Ok(Row::new(case, law, speed_mm_s, expected, limits, &numbers))
}
