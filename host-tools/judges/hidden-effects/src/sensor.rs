//! From the wrench on the sensor to the recorded reading, and the effects hidden in between.

use core::f64::consts::TAU;

use nalgebra::{Matrix6, Vector6};

use crate::noise::Noise;

/// Time course of a drift of the zero.
#[derive(Clone, Copy, Debug)]
pub(crate) enum DriftShape {
    /// `1 - exp(-t/tau)`, s.
    Exponential(f64),
    /// `min(1, t/duration)`, s.
    Ramp(f64),
}

/// An effect of the sensor on the reading. N (3x), Nm (3x), s, Hz.
#[derive(Clone, Debug)]
pub(crate) enum SensorEffect {
    /// `ft_scale`: gain per component.
    Scale { gain: Vector6<f64>, with_bias: bool },
    /// `ft_crosstalk`: `w[row] += value w[column]`.
    CrossTalk {
        entries: Vec<(usize, usize, f64)>,
        with_bias: bool,
    },
    /// `ft_bias_drift`.
    Drift {
        last: Vector6<f64>,
        shape: DriftShape,
    },
    /// `ft_quantisation`: rounding to the nearest step, or down to the next.
    Quantisation { force: f64, torque: f64, down: bool },
    /// `ft_dropout`: with a probability per tick the last reading is repeated for `run` ticks.
    DropOut { probability: f64, run: usize },
    /// Outside the catalogue: a step of one component with the time constant `rise`.
    TemperatureStep {
        axis: usize,
        size: f64,
        at: f64,
        rise: f64,
    },
    /// Outside the catalogue: random walk of the zero, sigma per sqrt(s).
    RandomWalk { per_root_second: Vector6<f64> },
    /// Outside: one frequency on every component.
    Hum {
        frequency: f64,
        amplitude: Vector6<f64>,
        phase: Vector6<f64>,
    },
}

/// The sensor with its state.
#[derive(Clone, Debug)]
pub(crate) struct Sensor<'a> {
    bias: Vector6<f64>,
    effects: Vec<&'a SensorEffect>,
    noise: Noise,
    walk: Vector6<f64>,
    held: Option<Vector6<f64>>,
    hold_left: usize,
    last_s: f64,
}

impl<'a> Sensor<'a> {
    /// `seed` is used for the random parts of the effects only.
    pub(crate) fn new(bias: Vector6<f64>, effects: Vec<&'a SensorEffect>, seed: u64) -> Self {
        Self {
            bias,
            effects,
            noise: Noise::new(seed, 2),
            walk: Vector6::zeros(),
            held: None,
            hold_left: 0,
            last_s: 0.0,
        }
    }

    /// Reading at the time `t_s` for the load `wrench` and the electronic `noise`.
    pub(crate) fn read(
        &mut self,
        t_s: f64,
        wrench: Vector6<f64>,
        noise: &Vector6<f64>,
    ) -> Vector6<f64> {
        let interval_s = t_s - self.last_s;
        self.last_s = t_s;
        let mut value = self.couple(wrench) + noise;
        let effects = self.effects.clone();
        for effect in &effects {
            value += self.additive(effect, t_s, interval_s);
        }
        for effect in &effects {
            if let SensorEffect::DropOut { probability, run } = **effect {
                value = self.drop_out(value, probability, run);
            }
        }
        for effect in &effects {
            if let SensorEffect::Quantisation {
                force,
                torque,
                down,
            } = **effect
            {
                value = Vector6::from_fn(|i, _| {
                    let step = if i < 3 { force } else { torque };
                    let count = value[i] / step;
                    step * if down { count.floor() } else { count.round() }
                });
            }
        }
        value
    }

    /// Applies gain and cross-talk, before or after the bias is added.
    fn couple(&self, wrench: Vector6<f64>) -> Vector6<f64> {
        let mut matrix = Matrix6::identity();
        let mut biased = false;
        for effect in &self.effects {
            match effect {
                SensorEffect::Scale { gain, with_bias } => {
                    matrix = Matrix6::from_diagonal(gain) * matrix;
                    biased |= with_bias;
                }
                SensorEffect::CrossTalk { entries, with_bias } => {
                    for (row, column, value) in entries {
                        matrix[(*row, *column)] += value;
                    }
                    biased |= with_bias;
                }
                _ => {}
            }
        }
        if biased {
            matrix * (wrench + self.bias)
        } else {
            matrix * wrench + self.bias
        }
    }

    fn additive(&mut self, effect: &SensorEffect, t_s: f64, interval_s: f64) -> Vector6<f64> {
        match effect {
            SensorEffect::Drift { last, shape } => {
                last * match shape {
                    DriftShape::Exponential(tau) => 1.0 - (-t_s / tau).exp(),
                    DriftShape::Ramp(duration) => (t_s / duration).min(1.0),
                }
            }
            SensorEffect::TemperatureStep {
                axis,
                size,
                at,
                rise,
            } => {
                let mut step = Vector6::zeros();
                if t_s > *at {
                    step[*axis] = size * (1.0 - (-(t_s - at) / rise).exp());
                }
                step
            }
            SensorEffect::RandomWalk { per_root_second } => {
                self.walk += self
                    .noise
                    .normal6()
                    .component_mul(per_root_second)
                    .scale(interval_s.max(0.0).sqrt());
                self.walk
            }
            SensorEffect::Hum {
                frequency,
                amplitude,
                phase,
            } => Vector6::from_fn(|i, _| amplitude[i] * (TAU * frequency * t_s + phase[i]).sin()),
            _ => Vector6::zeros(),
        }
    }

    fn drop_out(&mut self, value: Vector6<f64>, probability: f64, run: usize) -> Vector6<f64> {
        if self.hold_left == 0 && self.noise.chance(probability / run as f64) {
            self.hold_left = run;
        }
        if self.hold_left > 0
            && let Some(held) = self.held
        {
            self.hold_left -= 1;
            return held;
        }
        self.held = Some(value);
        value
    }
}
