//! Recomputes a recording: the control cycle is a function of settings and inputs, so the same
//! inputs must give the same correction, bit for bit, on the board and on the host.

use crate::recording::{Comparison, Difference, Recording};
use anyhow::{Context, bail, ensure};
use serde::Serialize;
use softdock_app::robot_cycle::RobotCycle;
use softdock_control::settings::Settings;

/// Result of a replay.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ReplayReport {
    /// Whether every number of every cycle was reproduced bit for bit.
    pub identical: bool,
    /// Cycles that were recomputed: all of them, or those up to the first difference.
    pub cycles: u64,
    /// The first number that differs.
    pub first_difference: Option<FirstDifference>,
}

/// A number that the replay did not reproduce.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FirstDifference {
    /// Number of the cycle.
    pub cycle: u64,
    /// Name of the number, with its unit; the same as that of its CSV column.
    pub quantity: String,
    /// Its text in the recording.
    pub recorded: String,
    /// Its text in the replay.
    pub recomputed: String,
    /// The bits of both, hexadecimal.
    pub recorded_bits: String,
    /// See `recorded_bits`.
    pub recomputed_bits: String,
}

impl core::fmt::Display for ReplayReport {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let cycles = self.cycles;
        let Some(first) = &self.first_difference else {
            return write!(
                f,
                "All {cycles} cycles were recomputed; every number is identical, bit for bit."
            );
        };
        write!(
            f,
            "Cycle {} differs: `{}` is {} in the recording and {} in the replay ({} and {}).",
            first.cycle,
            first.quantity,
            first.recorded,
            first.recomputed,
            first.recorded_bits,
            first.recomputed_bits
        )
    }
}

/// A replay file by file: the controller's state carries over from one file to the next.
#[derive(Default)]
pub struct Replay {
    controller: Option<(RobotCycle<f64>, Settings)>,
    /// Number of cycles that were reproduced.
    cycles: u64,
}

/// Recomputes every cycle of one recording; see [`Replay::take`].
pub fn replay(recording: &Recording) -> anyhow::Result<ReplayReport> {
    Replay::default().take(recording)
}

impl Replay {
    /// Recomputes every cycle of the next recording and compares the correction, the stop request and every number of the
    /// trace. The report covers all files so far.
    ///
    /// # Errors
    /// The first recording does not begin with the board's first cycle (the controller's state is not recorded), a later one
    /// does not begin where the one before ended, or the settings cannot be read.
    pub fn take(&mut self, recording: &Recording) -> anyhow::Result<ReplayReport> {
        self.check_cycles(recording)?;
        let settings = recording.header.control_settings()?;
        let (controller, known) = match &mut self.controller {
            Some(running) => running,
            none => {
                let controller = RobotCycle::new(&settings)
                    .context("the settings in the recording are not valid")?;
                none.insert((controller, settings.clone()))
            }
        };
        ensure!(
            *known == settings,
            "the settings of this recording are others than those of the one before"
        );
        let mut comparison = Comparison::default();
        for (place, recorded) in recording.cycles.iter().enumerate() {
            self.cycles += 1;
            let recomputed = controller.step(&recorded.inputs);
            let cycles = [recorded, &recomputed];
            let found = match recording.rounded {
                Some(rounded) if rounded.place <= place => {
                    comparison.first_difference_rounded(cycles, rounded)
                }
                _ => comparison.first_difference(cycles),
            };
            if let Some(found) = found {
                return Ok(ReplayReport {
                    identical: false,
                    cycles: self.cycles,
                    first_difference: Some(first_difference(recorded.trace.cycle, found)),
                });
            }
        }
        Ok(ReplayReport {
            identical: true,
            cycles: self.cycles,
            first_difference: None,
        })
    }

    fn check_cycles(&self, recording: &Recording) -> anyhow::Result<()> {
        match recording.cycles.first().map(|first| first.trace.cycle) {
            Some(first) if first == self.cycles => {}
            Some(first) if self.cycles > 0 => bail!(
                "the recording begins with cycle {first}, the one before ended with cycle {}; expected \
                 are the files of one run in their order, without a gap",
                self.cycles - 1
            ),
            Some(first) => bail!(
                "the recording begins with cycle {first}; only a recording that begins with cycle \
                 0, at the start of the board, can be replayed, or one behind the files before it"
            ),
            None => bail!("the recording holds no whole cycle"),
        }
        let gap = recording
            .cycles
            .windows(2)
            .find(|pair| pair[1].trace.cycle != pair[0].trace.cycle + 1);
        if let Some([before, after]) = gap {
            bail!(
                "the recorder lost the cycles between {} and {}; what follows cannot be recomputed",
                before.trace.cycle,
                after.trace.cycle
            );
        }
        Ok(())
    }
}

fn first_difference(cycle: u64, difference: Difference) -> FirstDifference {
    let Difference {
        quantity,
        texts: [recorded, recomputed],
        bits: [recorded_bits, recomputed_bits],
    } = difference;
    FirstDifference {
        cycle,
        quantity,
        recorded,
        recomputed,
        recorded_bits,
        recomputed_bits,
    }
}
