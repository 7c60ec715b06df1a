//! Jitter of the control cycle.

use crate::effects::{Effect, Group, Law, Naming, Parameter};
use softdock_control::range::{SettingsError, in_range};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "clock_jitter",
    title: "Jitter of the cycle",
    summary: "the real instants of the cycles scatter about the nominal ones",
    group: Group::Body,
    naming: Naming::Cause,
    equation: "t_n = n step + jitter_s x_n, x_n: independent standard normal",
    source: "textbook (sampling jitter); real-time behaviour of controllers",
    signature: "increments of the pose scatter in proportion to the velocity, and not at standstill",
    typical: "0.01 to 1 ms on a computer without real-time kernel",
    parameters: &[Parameter::new("jitter_s", "s", 0.0, 0.02)
        .hidden(1.5e-4, 4e-4)
        .pictured(0.0004)],
    confused_with: &["clock_rate", "clock_offset", "ft_dropout"],
    tell_apart: "jog at two constant speeds: the scatter of the pose increments grows with speed, noise of the \
                 measurement does not",
    law: Law::Clock,
    ..Effect::PLAIN
};

/// Instants that scatter.
#[derive(Clone, Copy, Debug)]
pub struct ClockJitter {
    jitter_s: f64,
}

impl ClockJitter {
    /// `jitter_s` (standard deviation) 0 to 1 s.
    pub fn new(jitter_s: f64) -> Result<Self, SettingsError> {
        in_range("jitter_s", jitter_s, 0.0, 1.0)?;
        Ok(Self { jitter_s })
    }

    /// The real instant (s) of a nominal one; `draw` is a standard normal number of the caller.
    pub fn instant(&self, nominal_s: f64, draw: f64) -> f64 {
        nominal_s + self.jitter_s * draw
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_scatters_by_its_deviation() {
        let clock = ClockJitter::new(0.25).unwrap();
        assert_eq!(
            [-1.0, 0.0, 2.0].map(|x| clock.instant(4.0, x)),
            [3.75, 4.0, 4.5]
        );
    }
}
