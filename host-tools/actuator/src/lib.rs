//! From the velocity that was sent to the velocity that is executed, with any actuator effects.
//!
//! A sent velocity is held for a cycle, arrives after the transport delay, and passes in this
//! order: rounding, dead zone, gain by direction, planner limits, gain, lag, extra lag, resonance, drive limits, pause, lost motion. One
//! axis at a time; every axis has the same [`Chain`] unless a caller gives it another.
//!
//! The linear stages are solved exactly for an input that is constant between two instants. A cycle is cut at the instant at
//! which a command arrives, and, if a stage is not linear, into eight equal parts as well. Where none of these stages acts, the
//! segment up to the next command is taken in one step.

mod chain;
mod cut;
mod linear;
mod moving;
mod nonlinear;
#[cfg(test)]
mod tests;

pub use chain::{Chain, Limits, PauseKind, PauseTrigger, Resonance};
pub use cut::Timing;

use cut::Cut;
use moving::Moving;
use nonlinear::planned;

/// What a recorded velocity is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// The velocity at the instant of the cycle.
    AtEnd,
    /// The mean over the cycle that ends there.
    Mean,
}

/// Executed velocity of one axis for the velocities that were sent in each cycle.
///
/// Entry n belongs to the instant of cycle n; a command that was sent in cycle n moves the robot
/// after it. Units are those of `sent`. The robot rests before the first cycle.
pub fn simulate(chain: &Chain, sent: &[f64], timing: &Timing<'_>, reading: Reading) -> Vec<f64> {
    simulated(chain, sent, timing, reading, true)
}

/// The same. `steps_exactly`: segments in which only the linear stages act are taken in one step.
fn simulated(
    chain: &Chain,
    sent: &[f64],
    timing: &Timing<'_>,
    reading: Reading,
    steps_exactly: bool,
) -> Vec<f64> {
    let understood = chain.understood(sent);
    let sent = understood.as_deref().unwrap_or(sent);
    let planned = chain
        .planner
        .any()
        .then(|| planned(&chain.planner, sent, timing.cycle_s));
    let sent = planned.as_deref().unwrap_or(sent);
    let mut cut = Cut::new(chain.delay_s, chain.parts(), timing);
    let alike = cut.cycles_are_alike();
    let mut axis = Moving::new(chain);
    let mut out = Vec::with_capacity(sent.len());
    if !sent.is_empty() {
        out.push(0.0);
    }
    for n in 1..sent.len() {
        let (mut mean, mut end) = (0.0, 0.0);
        for segment in cut.segments(n) {
            let command = segment.command.and_then(|k| sent.get(k)).copied();
            let command = chain.gain * command.unwrap_or(0.0);
            if steps_exactly && axis.can_step_exactly(command) {
                let moved = axis.exact_step(command, segment.duration_s, !alike);
                mean += moved.mean * segment.duration_s;
                end = moved.end;
                continue;
            }
            for duration_s in segment.parts_s() {
                let moved = axis.step(command, duration_s);
                mean += moved.mean * duration_s;
                end = moved.end;
            }
        }
        out.push(match reading {
            Reading::AtEnd => end,
            Reading::Mean => mean / timing.interval(n),
        });
    }
    out
}
