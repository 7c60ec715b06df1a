//! Transport delay: the robot executes a held command later, unchanged.

use crate::effects::{
    Actuator, DelayAndLag, Effect, Group, Kind, Law, Naming, Parameter, check_step,
};
use softdock_control::range::{SettingsError, in_range};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "actuation_delay",
    title: "Transport delay",
    summary: "the robot executes the command later than nominal, unchanged",
    group: Group::Actuator,
    naming: Naming::Cause,
    equation: "v(t) = u(t - nominal delay - extra_delay_s), u held for one cycle",
    source: "seed paper section 4.3 (32 ms in its simulation of a KUKA robot); textbook (dead time)",
    signature: "executed velocity is a shifted copy of the command: the error is the delay times the \
                acceleration, without distortion",
    typical: "32 ms in total on a KUKA robot with RSI, 16 to 26 ms on a UR5; a few ms beyond what a data \
              sheet says",
    parameters: &[Parameter::new("extra_delay_s", "s", 0.0, 10.0)
        .delay_or_lag()
        .hidden(0.012, 0.02)
        .pictured(0.032)],
    confused_with: &[
        "actuation_lag",
        "second_order_servo",
        "ft_latency",
        "clock_offset",
    ],
    tell_apart: "a train of velocity steps that stand out of the noise: a delay keeps the edges sharp, a lag rounds them; \
                 with small steps or slow motion the two cannot be told apart",
    law: Law::Actuator(Actuator {
        axis: None,
        late: Some(|p| DelayAndLag {
            delay_s: p[0],
            lag_s: 0.0,
        }),
    }),
    kind: Some(Kind::LateCommand),
    ..Effect::PLAIN
};

/// Delay line for `AXES` commands that are each held for one cycle.
///
/// The delay is any real number of cycles. The line remembers `N` commands; the longest delay is
/// `N − 1` cycles.
///
/// ```
/// use softdock_physics::effects::actuator::actuation_delay::TransportDelay;
/// let mut line = TransportDelay::<1, 4>::new(0.006, 0.004).unwrap();
/// line.push([1.0]); // held from now on
/// line.push([3.0]); // 4 ms later
/// assert_eq!(line.mean_over(0.0, 0.004), [0.5]); // 2 ms of rest, then 2 ms of the first command
/// ```
#[derive(Clone, Copy, Debug)]
pub struct TransportDelay<const AXES: usize, const N: usize> {
    commands: [[f64; AXES]; N],
    newest: usize,
    delay_s: f64,
    hold_s: f64,
}

impl<const AXES: usize, const N: usize> TransportDelay<AXES, N> {
    /// A line at rest: `delay_s` in 0..=(N−1)·`hold_s`, where `hold_s` is the time (s) for which a
    /// command is held.
    pub fn new(delay_s: f64, hold_s: f64) -> Result<Self, SettingsError> {
        check_step(hold_s)?;
        let longest_s = hold_s * N.saturating_sub(1) as f64;
        in_range("delay_s", delay_s, 0.0, longest_s)?;
        Ok(Self {
            commands: [[0.0; AXES]; N],
            newest: 0,
            delay_s,
            hold_s,
        })
    }

    /// Begins the next hold period with this command.
    pub fn push(&mut self, command: [f64; AXES]) {
        self.newest = (self.newest + 1) % N.max(1);
        self.replace_newest(command);
    }

    /// Corrects the command of the running hold period.
    pub fn replace_newest(&mut self, command: [f64; AXES]) {
        if let Some(slot) = self.commands.get_mut(self.newest) {
            *slot = command;
        }
    }

    /// Mean of the delayed command between two instants, in seconds since the last [`Self::push`].
    ///
    /// Instants before the oldest remembered command read that command; instants after the running
    /// hold period read its command. A negative `from_s` looks back, which is also how a varying
    /// delay is expressed: subtract the additional delay from both instants.
    pub fn mean_over(&self, from_s: f64, to_s: f64) -> [f64; AXES] {
        let from = (from_s - self.delay_s) / self.hold_s;
        let to = (to_s - self.delay_s) / self.hold_s;
        let width = to - from;
        let mut cell = from.floor();
        if to <= cell + 1.0 || width <= 0.0 {
            return self.command_of(cell); // the usual case: one command spans the interval
        }
        let (mut sum, mut begin) = ([0.0; AXES], from);
        for _ in 0..=N {
            let end = (cell + 1.0).min(to);
            for (total, command) in sum.iter_mut().zip(self.command_of(cell)) {
                *total += command * (end - begin);
            }
            (begin, cell) = (end, cell + 1.0);
            if begin >= to {
                break;
            }
        }
        sum.map(|total| total / width)
    }

    /// The command of hold period `cell`: 0 is the running one, −1 the one before.
    fn command_of(&self, cell: f64) -> [f64; AXES] {
        let periods_back = ((-cell).max(0.0) as usize).min(N.saturating_sub(1));
        let slot = (self.newest + N - periods_back) % N.max(1);
        self.commands.get(slot).copied().unwrap_or([0.0; AXES])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// u(t) = n + 1 in cycle n: the delayed mean against the written integral, at odd delays.
    #[test]
    fn mean_equals_the_integral_of_the_held_command() {
        let (hold, step) = (0.004, 0.0005);
        for delay in [0.0, 0.0003, 0.004, 0.0111, 0.032, 0.0605] {
            let mut line = TransportDelay::<1, 17>::new(delay, hold).unwrap();
            for cycle in 0..40 {
                line.push([cycle as f64 + 1.0]);
                for k in 0..8 {
                    let from = k as f64 * step;
                    let start = cycle as f64 * hold + from - delay;
                    // fine sampling of the definition
                    let samples = 2000;
                    let mean: f64 = (0..samples)
                        .map(|i| start + step * (i as f64 + 0.5) / samples as f64)
                        .map(|t| {
                            if t < 0.0 {
                                0.0
                            } else {
                                (t / hold).floor() + 1.0
                            }
                        })
                        .sum::<f64>()
                        / samples as f64;
                    let [got] = line.mean_over(from, from + step);
                    assert!(
                        (got - mean).abs() < 1e-3,
                        "{delay} {cycle} {k}: {got} {mean}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_delay_longer_than_the_line_is_refused() {
        let error = TransportDelay::<6, 8>::new(0.0281, 0.004).unwrap_err();
        assert_eq!(
            (error.field, error.received, error.high),
            ("delay_s", 0.0281, 0.028)
        );
        assert!(TransportDelay::<6, 8>::new(0.028, 0.004).is_ok());
    }

    #[test]
    fn the_running_command_can_be_corrected() {
        let mut line = TransportDelay::<1, 3>::new(0.004, 0.004).unwrap();
        line.push([1.0]);
        line.replace_newest([2.0]);
        line.push([9.0]);
        let [got] = line.mean_over(0.001, 0.002);
        assert_eq!(got, 2.0);
    }
}
