//! The robot between velocity command and executed velocity, and the effects hidden in it.
//!
//! Per axis: held command -> transport delay -> lag `T y' = u - y`. The command is piecewise
//! constant, so the lag is stepped exactly, `y += (1 - exp(-h/T)) (u - y)`, between the instants
//! at which delayed commands arrive.

use nalgebra::Vector6;

use crate::meta::ActuatorModel;

/// Longest step of the linear chain, s: only the position integral depends on it.
const LINEAR_STEP_S: f64 = 5e-4;
/// Longest step with a hidden effect, s, as its switching instants are rounded to steps.
const EFFECT_STEP_S: f64 = 1e-4;

/// Place of a limit or a trigger in the chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Location {
    /// On the delayed command, before the lag.
    Input,
    /// On the executed velocity, after the lag.
    Output,
}

/// A hidden effect of the robot, beyond delay and lag. Units: s, m/s, rad/s, m/s², rad/s².
#[derive(Clone, Debug)]
pub(crate) enum ActuatorEffect {
    /// `actuation_delay`.
    Delay { extra_s: f64 },
    /// `actuation_lag`: a second lag in series.
    Lag { extra_s: f64 },
    /// `zero_cross_pause`: the output is zero for a time after a change of sign of the output, or of the command. `reset`
    /// also empties the lag; otherwise the lag goes on behind the closed gate.
    Pause {
        pause_s: f64,
        trigger: Location,
        reset: bool,
    },
    /// `rate_limit`: per cycle of the command before the lag, or continuously after it.
    RateLimit {
        linear: f64,
        angular: f64,
        place: Location,
    },
    /// `velocity_saturation`.
    Saturation {
        linear: f64,
        angular: f64,
        place: Location,
    },
    /// `structural_resonance`: `x'' = W² (u - x) - 2 z W x'` in series.
    Resonance { frequency_hz: f64, damping: f64 },
}

/// Parameters of the chain, collected from the effects; neutral values disable a part.
#[derive(Clone, Debug)]
struct Chain {
    delay_s: f64,
    lag_s: f64,
    extra_lag_s: f64,
    pause: Option<(f64, Location, bool)>,
    slew: Option<([f64; 2], Location)>,
    limit: Option<([f64; 2], Location)>,
    resonance: Option<(f64, f64)>,
    cycle_s: f64,
}

impl Chain {
    fn new(model: &ActuatorModel, cycle_s: f64, effects: &[&ActuatorEffect]) -> Self {
        let mut chain = Self {
            delay_s: model.transport_delay_s,
            lag_s: model.lag_time_constant_s,
            extra_lag_s: 0.0,
            pause: None,
            slew: None,
            limit: None,
            resonance: None,
            cycle_s,
        };
        for effect in effects {
            match **effect {
                ActuatorEffect::Delay { extra_s } => chain.delay_s += extra_s,
                ActuatorEffect::Lag { extra_s } => chain.extra_lag_s += extra_s,
                ActuatorEffect::Pause {
                    pause_s,
                    trigger,
                    reset,
                } => chain.pause = Some((pause_s, trigger, reset)),
                ActuatorEffect::RateLimit {
                    linear,
                    angular,
                    place,
                } => chain.slew = Some(([linear, angular], place)),
                ActuatorEffect::Saturation {
                    linear,
                    angular,
                    place,
                } => chain.limit = Some(([linear, angular], place)),
                ActuatorEffect::Resonance {
                    frequency_hz,
                    damping,
                } => chain.resonance = Some((core::f64::consts::TAU * frequency_hz, damping)),
            }
        }
        chain
    }
}

/// State of one axis.
#[derive(Clone, Copy, Debug, Default)]
struct Axis {
    input: f64,
    lag: f64,
    extra_lag: f64,
    mode: f64,
    mode_rate: f64,
    slewed: f64,
    output: f64,
    pause_left_s: f64,
    sign: f64,
}

impl Axis {
    /// A delayed command arrives. `kind` is 0 for a linear, 1 for an angular axis.
    fn arrive(&mut self, command: f64, chain: &Chain, kind: usize) {
        let mut value = command;
        if let Some((limit, Location::Input)) = chain.limit {
            value = value.clamp(-limit[kind], limit[kind]);
        }
        if let Some((slew, Location::Input)) = chain.slew {
            let step = slew[kind] * chain.cycle_s;
            value = self.input + (value - self.input).clamp(-step, step);
        }
        self.input = value;
    }

    /// One step with the held input; `decay` = `exp(-h/T)` of the nominal and the extra lag.
    fn step(&mut self, h: f64, decay: [f64; 2], chain: &Chain, kind: usize) {
        let before = self.lag;
        self.lag = self.input + (self.lag - self.input) * decay[0];
        let (mut last, mut value) = (before, self.lag);
        if chain.extra_lag_s > 0.0 {
            let drive = 0.5 * (before + self.lag);
            last = self.extra_lag;
            self.extra_lag = drive + (self.extra_lag - drive) * decay[1];
            value = self.extra_lag;
        }
        if let Some((omega, damping)) = chain.resonance {
            self.swing(h, 0.5 * (last + value), omega, damping);
            value = self.mode;
        }
        if let Some((slew, Location::Output)) = chain.slew {
            let step = slew[kind] * h;
            self.slewed += (value - self.slewed).clamp(-step, step);
            value = self.slewed;
        }
        if let Some((limit, Location::Output)) = chain.limit {
            value = value.clamp(-limit[kind], limit[kind]);
        }
        self.output = self.gate(value, h, chain);
    }

    /// One step of the structural mode, accurate to second order in `h`: half a drift, a kick with the mean drive and rate,
    /// half a drift. A first-order step would be early by `h`, which looks like damping.
    fn swing(&mut self, h: f64, drive: f64, omega: f64, damping: f64) {
        self.mode += 0.5 * h * self.mode_rate;
        let braked = damping * omega * h;
        let pull = h * omega * omega * (drive - self.mode);
        self.mode_rate = (self.mode_rate * (1.0 - braked) + pull) / (1.0 + braked);
        self.mode += 0.5 * h * self.mode_rate;
    }

    /// Output after the pause.
    fn gate(&mut self, value: f64, h: f64, chain: &Chain) -> f64 {
        let Some((pause_s, trigger, reset)) = chain.pause else {
            return value;
        };
        if self.pause_left_s > 0.0 {
            self.pause_left_s -= h;
            if reset {
                self.lag = 0.0;
                self.extra_lag = 0.0;
                self.mode = 0.0;
                self.mode_rate = 0.0;
                self.slewed = 0.0;
            }
            return 0.0;
        }
        let watched = match trigger {
            Location::Input => self.input,
            Location::Output => value,
        };
        let sign = if watched == 0.0 {
            0.0
        } else {
            watched.signum()
        };
        let crossed = sign * self.sign < 0.0;
        if sign != 0.0 {
            self.sign = sign;
        }
        if crossed {
            self.pause_left_s = pause_s - h;
            return 0.0;
        }
        value
    }
}

/// Six axes and the commands in the delay.
#[derive(Clone, Debug)]
pub(crate) struct Actuator {
    chain: Chain,
    moves: [bool; 6],
    longest_step_s: f64,
    axes: [Axis; 6],
    sent: Vec<(f64, Vector6<f64>)>,
    arrived: usize,
    now_s: f64,
}

impl Actuator {
    /// The robot at rest at time 0.
    pub(crate) fn new(
        model: &ActuatorModel,
        cycle_s: f64,
        moves: [bool; 6],
        effects: &[&ActuatorEffect],
    ) -> Self {
        Self {
            chain: Chain::new(model, cycle_s, effects),
            moves,
            longest_step_s: if effects.is_empty() {
                LINEAR_STEP_S
            } else {
                EFFECT_STEP_S
            },
            axes: [Axis::default(); 6],
            sent: Vec::new(),
            arrived: 0,
            now_s: 0.0,
        }
    }

    /// Present executed velocity, m/s and rad/s.
    pub(crate) fn velocity(&self) -> Vector6<f64> {
        Vector6::from_fn(|i, _| self.axes[i].output)
    }

    /// Takes a command, which is held until the next.
    pub(crate) fn send(&mut self, at_s: f64, command: Vector6<f64>) {
        self.sent.push((at_s, command));
    }

    /// Runs to `to_s` and calls `moved(h, before, after)` for every step.
    pub(crate) fn advance(
        &mut self,
        to_s: f64,
        mut moved: impl FnMut(f64, &Vector6<f64>, &Vector6<f64>),
    ) {
        while self.now_s < to_s - 1e-12 {
            self.take_arrived();
            let next = self
                .sent
                .get(self.arrived)
                .map_or(f64::INFINITY, |(sent, _)| sent + self.chain.delay_s);
            let stop = next.min(to_s);
            let pieces = ((stop - self.now_s) / self.longest_step_s).ceil().max(1.0);
            let h = (stop - self.now_s) / pieces;
            let decay = [
                (-h / self.chain.lag_s).exp(),
                (-h / self.chain.extra_lag_s.max(1e-9)).exp(),
            ];
            for _ in 0..pieces as usize {
                let before = self.velocity();
                for axis in 0..6 {
                    if self.moves[axis] {
                        self.axes[axis].step(h, decay, &self.chain, axis / 3);
                    }
                }
                moved(h, &before, &self.velocity());
            }
            self.now_s = stop;
        }
    }

    fn take_arrived(&mut self) {
        while let Some((sent, command)) = self.sent.get(self.arrived) {
            if sent + self.chain.delay_s > self.now_s + 1e-12 {
                break;
            }
            for axis in 0..6 {
                self.axes[axis].arrive(command[axis], &self.chain, axis / 3);
            }
            self.arrived += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(effects: &[ActuatorEffect], command: impl Fn(f64) -> f64) -> Vec<f64> {
        let model = ActuatorModel {
            transport_delay_s: 0.008,
            lag_time_constant_s: 0.004,
        };
        let effects: Vec<&ActuatorEffect> = effects.iter().collect();
        let mut actuator = Actuator::new(&model, 0.004, [true; 6], &effects);
        (0..250)
            .map(|n| {
                let t = f64::from(n) * 0.004;
                actuator.advance(t, |_, _, _| ());
                actuator.send(t, Vector6::from_element(command(t)));
                actuator.velocity()[0]
            })
            .collect()
    }

    #[test]
    fn nominal_chain_is_the_sampled_lag_of_the_delayed_command() {
        let command = |t: f64| (9.0 * t).sin();
        let y = run(&[], command);
        let e = (-1.0_f64).exp();
        for n in 4..250 {
            let delayed = command((n - 3) as f64 * 0.004);
            assert!((y[n] - (e * y[n - 1] + (1.0 - e) * delayed)).abs() < 1e-12);
        }
    }

    #[test]
    fn pause_stands_still_for_its_time() {
        for (trigger, reset) in [(Location::Input, true), (Location::Output, false)] {
            let pause = ActuatorEffect::Pause {
                pause_s: 0.04,
                trigger,
                reset,
            };
            let y = run(&[pause], |t| (9.0 * (t + 0.02)).cos());
            let still = y[20..].iter().filter(|v| **v == 0.0).count();
            // Three crossings of ten ticks each; each may gain or lose one tick.
            assert!((27..=33).contains(&still), "{still}");
        }
    }

    #[test]
    fn a_step_swings_as_the_differential_equation_says() {
        let (frequency_hz, damping) = (12.0, 0.05);
        let mode = ActuatorEffect::Resonance {
            frequency_hz,
            damping,
        };
        let y = run(&[mode], |_| 1.0);
        let (omega, pole) = (core::f64::consts::TAU * frequency_hz, 1.0 / 0.004);
        let (decay, swing) = (damping * omega, omega * (1.0 - damping * damping).sqrt());
        // Partial fractions of the step response of lag and mode.
        let lag = omega * omega / (pole * pole - 2.0 * decay * pole + omega * omega);
        let cosine = 1.0 - lag;
        let sine = (pole * lag + decay * cosine) / swing;
        for (n, value) in y.iter().enumerate().skip(2) {
            let t = n as f64 * 0.004 - 0.008;
            let (s, c) = (swing * t).sin_cos();
            let exact =
                1.0 - lag * (-pole * t).exp() - (-decay * t).exp() * (cosine * c + sine * s);
            assert!((value - exact).abs() < 5e-4, "{t}: {value} {exact}");
        }
    }

    #[test]
    fn limits_hold() {
        for place in [Location::Input, Location::Output] {
            let slew = ActuatorEffect::RateLimit {
                linear: 3.0,
                angular: 3.0,
                place,
            };
            let limit = ActuatorEffect::Saturation {
                linear: 0.5,
                angular: 0.5,
                place,
            };
            let y = run(&[slew], |t| (9.0 * t).sin());
            assert!(y.windows(2).all(|w| (w[1] - w[0]).abs() < 0.0121));
            let y = run(&[limit], |t| (9.0 * t).sin());
            assert!(y.iter().all(|v| v.abs() < 0.5 + 1e-12));
        }
    }
}
