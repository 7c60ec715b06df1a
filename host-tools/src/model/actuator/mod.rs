//! From the velocity that was sent to the velocity that is executed, with any actuator effects.
//!
//! A sent velocity is held for a cycle, arrives after the transport delay, and passes in this
//! order: gain, planner limits, lag, extra lag, resonance, drive limits, pause, lost motion. One
//! axis at a time; every axis has the same [`Chain`] unless a caller gives it another.
//!
//! The linear stages are solved exactly for an input that is constant between two instants; a
//! cycle is cut at the instant at which a command arrives and, where a stage is not linear, into
//! eight equal parts besides.

mod chain;
mod cut;
mod nonlinear;
mod stage;
#[cfg(test)]
mod tests;

pub use chain::{Chain, Limits, PauseTrigger, Resonance};
pub use cut::Timing;
pub use stage::Stage;

use cut::Cut;
use nonlinear::{Backlash, Drive, PauseGate, planned};

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
    let planned = chain
        .planner
        .any()
        .then(|| planned(&chain.planner, sent, timing.cycle_s));
    let sent = planned.as_deref().unwrap_or(sent);
    let mut cut = Cut::new(chain.delay_s, chain.parts(), timing);
    let mut drive = Drive::new(chain);
    let mut gate = PauseGate::new(chain);
    let mut backlash = Backlash::new(chain.backlash_m);
    let mut out = Vec::with_capacity(sent.len());
    if !sent.is_empty() {
        out.push(0.0);
    }
    for n in 1..sent.len() {
        let (mut mean, mut end) = (0.0, 0.0);
        let duration_s = timing.interval(n);
        for part in cut.parts(n) {
            let command = part.command.and_then(|k| sent.get(k)).copied();
            let command = chain.shaped(command.unwrap_or(0.0));
            let moved = drive.follow(command, part.duration_s);
            let moved = gate.pass(moved, command, part.duration_s, &mut drive);
            let moved = backlash.pass(moved, part.duration_s);
            mean += moved.mean * part.duration_s;
            end = moved.end;
        }
        out.push(match reading {
            Reading::AtEnd => end,
            Reading::Mean => mean / duration_s,
        });
    }
    out
}
