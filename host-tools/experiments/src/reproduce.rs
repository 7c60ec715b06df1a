//! The paper's experiment: the spring-rod test with and without the paper's compensation.
//!
//! Figures 4 to 9 of the paper come from its own rig and simulation; the ones here come from the simulated rig with the
//! firmware in the loop.

use super::impacts::{self, Impact};
use super::run::record;
use super::spring_rod::{TOUCH, one_stop, two_stops};
use anyhow::{Context, Result};
use rayon::prelude::*;
use serde::Serialize;
use softdock_control::delay::LawName;
use softdock_io::recording::Recording;

/// Speeds of the table, mm/s.
pub const SPEEDS_MM_S: [f64; 8] = [1.0, 2.0, 3.0, 5.0, 8.0, 10.0, 12.0, 15.0];
/// Further instants of the touch within a cycle.
const TOUCH_INSTANTS: [f64; 3] = [0.0, 0.25, 0.5];
/// Speed of the repeated bounces, m/s.
const BOUNCE_SPEED_M_S: f64 = 0.005;
/// Length of the repeated bounces, s.
const BOUNCE_S: f64 = 12.0;

/// One line of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Delay law.
    pub law: LawName,
    /// Nominal closing speed, mm/s.
    pub speed_mm_s: f64,
    /// The impact at one instant of the touch within a cycle.
    #[serde(flatten)]
    pub impact: Impact,
    /// Smallest restitution over all instants of the touch within a cycle.
    pub restitution_low: f64,
    /// Largest restitution over these instants.
    pub restitution_high: f64,
    /// Remaining offset of the compensation half a second after the contact: command less model velocity, divided by the
    /// nominal speed.
    pub offset_after: f64,
}

/// Repeated bounces between two stops.
#[derive(Clone, Debug, Serialize)]
pub struct Bounces {
    /// Name of the variant.
    pub name: String,
    /// All impacts up to the end or to the fault.
    pub impacts: Vec<Impact>,
    /// The fault that ended the run.
    pub fault: Option<String>,
    /// Recording of the run.
    #[serde(skip)]
    pub recording: Recording,
}

/// A run at one speed with one law.
#[derive(Clone, Debug)]
pub struct Flight {
    /// Row of the table.
    pub row: Row,
    /// Every cycle.
    pub recording: Recording,
}

/// Content of the page.
#[derive(Clone, Debug)]
pub struct Reproduction {
    /// All speeds without, then all speeds with the law of the paper.
    pub flights: Vec<Flight>,
    /// Without the law, with the literal law, and with its sums gated and reset.
    pub bounces: Vec<Bounces>,
}

/// Names of the repeated bounces.
const BOUNCES: [&str; 3] = [
    "without compensation",
    "seed law, literal",
    "seed law, gated and reset",
];
/// Number of times that [`reproduce`] calls `done`.
pub const DONE: u64 = (2 * SPEEDS_MM_S.len() + BOUNCES.len()) as u64;

/// Runs everything, in parallel; `done` is called [`DONE`] times.
pub fn reproduce(done: &(dyn Fn() + Sync)) -> Result<Reproduction> {
    let cases: Vec<_> = [LawName::None, LawName::Seed]
        .into_iter()
        .flat_map(|law| SPEEDS_MM_S.map(|speed| (law, speed)))
        .collect();
    let flights = cases
        .par_iter()
        .map(|(law, speed)| flight(*law, *speed).inspect(|_| done()))
        .collect::<Result<_>>()?;
    let bounces = BOUNCES
        .par_iter()
        .map(|name| bounce(name).inspect(|_| done()))
        .collect::<Result<_>>()?;
    Ok(Reproduction { flights, bounces })
}

fn flight(law: LawName, speed_mm_s: f64) -> Result<Flight> {
    let (impact, recording) = touch(law, speed_mm_s, TOUCH)?;
    let (mut low, mut high) = (impact.restitution, impact.restitution);
    for touch_instant in TOUCH_INSTANTS {
        let restitution = touch(law, speed_mm_s, touch_instant)?.0.restitution;
        (low, high) = (low.min(restitution), high.max(restitution));
    }
    let row = Row {
        law,
        speed_mm_s,
        impact,
        restitution_low: low,
        restitution_high: high,
        offset_after: offset_after(&recording, speed_mm_s * 1e-3),
    };
    Ok(Flight { row, recording })
}

/// One flight onto the stop. Returns its impact and the recording.
fn touch(law: LawName, speed_mm_s: f64, touch_instant: f64) -> Result<(Impact, Recording)> {
    let scenario = one_stop(law, speed_mm_s * 1e-3, touch_instant)?;
    let (recording, _) = record(&scenario)?;
    let impact = impacts::find(&scenario, &recording).into_iter().next();
    Ok((
        impact.context("the spacecraft never touched the stop")?,
        recording,
    ))
}

/// Command less model velocity at the end of a run, divided by the speed.
fn offset_after(recording: &Recording, speed_m_s: f64) -> f64 {
    recording.cycles.last().map_or(f64::NAN, |cycle| {
        (cycle.trace.law_velocity[0] - cycle.trace.model_velocity[0]) / speed_m_s
    })
}

fn bounce(name: &str) -> Result<Bounces> {
    let law = if name.starts_with("seed") {
        LawName::Seed
    } else {
        LawName::None
    };
    let mut scenario = two_stops(law, BOUNCE_SPEED_M_S, BOUNCE_S)?;
    if name.ends_with("reset") {
        let seed = &mut scenario.board.control.delay.seed;
        seed.gate_sums = true;
        seed.reset_after_quiet_cycles = 25;
    }
    let (recording, _) = record(&scenario)?;
    let impacts = impacts::find(&scenario, &recording);
    let fault = recording.cycles.last().and_then(|cycle| cycle.trace.fault);
    // A fault's name is part of the format.
    let fault = fault.map(|f| {
        format!(
            "{:?}: limit {}, value {:.1}",
            f.code, f.expected, f.received
        )
    });
    Ok(Bounces {
        name: name.to_owned(),
        impacts,
        fault,
        recording,
    })
}
