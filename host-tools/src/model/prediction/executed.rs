//! Executed velocity from the velocities that were sent (README A of docking-rig-log/1).
//!
//! A velocity u(n), sent in cycle n, is held for a cycle. With the transport delay
//! `(d + f) Ts`, 0 ≤ f < 1, the robot's drive sees u(n−2−d) during the first share f of the cycle
//! that ends with cycle n, then u(n−1−d); so without any delay cycle n moves the robot until
//! cycle n + 1. Behind it stands the lag `T dy/dt = u − y`, solved exactly. A sampled velocity is
//! compared with y at the end of that cycle, the difference of two poses with its mean.
//!
//! Without f and seen at the end this is `y(n) = e y(n−1) + (1−e) u(n−1−d)`, `e = exp(−Ts/T)`.

use super::signals::{Signals, Step, VelocityMeaning};
use super::{ChannelPrediction, Six};
use crate::model::{ActuatorModel, Channel, Model};
use std::collections::VecDeque;

/// Predicts the channel.
pub fn predict(model: &Model, signals: &Signals<'_>) -> ChannelPrediction {
    let mut actuator = Actuator::new(&model.actuator, signals.cycle_s);
    let mut unknown = 0;
    let predicted = (0..signals.len())
        .map(|n| {
            let motion = match signals.steps[n] {
                Step::Next => actuator.step(),
                Step::Lost(cycles) => {
                    // More than the memory of the delay has no further effect.
                    for _ in 0..cycles.min(actuator.memory_cycles()) {
                        actuator.send([0.0; 6]);
                        actuator.step();
                    }
                    actuator.step()
                }
                Step::NewRun => actuator.rest(),
                Step::Hole => {
                    unknown = actuator.memory_cycles();
                    actuator.rest()
                }
            };
            actuator.send(signals.cycles[n].trace.sent_velocity);
            if unknown > 0 {
                unknown -= 1;
                return None;
            }
            signals.executed(n)?;
            Some(match signals.velocity {
                VelocityMeaning::CycleMean => motion.mean,
                VelocityMeaning::Sampled => motion.end,
            })
        })
        .collect();
    ChannelPrediction {
        channel: Channel::ExecutedVelocity,
        measured: signals
            .cycles
            .iter()
            .map(|c| c.trace.executed_velocity)
            .collect(),
        predicted,
        sigma: signals.velocity_sigma(&model.noise),
        expected_sigma: Vec::new(),
    }
}

/// Velocity over the cycle that has just ended.
#[derive(Clone, Copy, Debug)]
struct Motion {
    mean: Six,
    end: Six,
}

/// The nominal actuator: hold, delay, lag.
#[derive(Debug)]
struct Actuator {
    /// Duration of the two parts of a cycle, in cycles: first the older command, then the newer.
    parts: [f64; 2],
    /// Lag in cycles.
    lag: f64,
    /// Commands that are still on their way and the one before, oldest first.
    pipeline: VecDeque<Six>,
    velocity: Six,
}

impl Actuator {
    fn new(model: &ActuatorModel, cycle_s: f64) -> Self {
        let delay = model.transport_delay_s / cycle_s;
        let fraction = delay.fract();
        Self {
            parts: [fraction, 1.0 - fraction],
            lag: model.lag_s / cycle_s,
            pipeline: vec![[0.0; 6]; delay as usize + 2].into(),
            velocity: [0.0; 6],
        }
    }

    /// Cycles after which an unknown past is forgotten to 1 %.
    fn memory_cycles(&self) -> u32 {
        self.pipeline.len() as u32 + (5.0 * self.lag).ceil() as u32
    }

    /// Takes the command of the cycle that begins.
    fn send(&mut self, command: Six) {
        self.pipeline.pop_front();
        self.pipeline
            .push_back(command.map(|v| if v.is_finite() { v } else { 0.0 }));
    }

    /// The robot stands still and has nothing to do.
    fn rest(&mut self) -> Motion {
        self.pipeline.iter_mut().for_each(|u| *u = [0.0; 6]);
        self.velocity = [0.0; 6];
        Motion {
            mean: [0.0; 6],
            end: [0.0; 6],
        }
    }

    /// Moves through the cycle after the last [`Self::send`].
    fn step(&mut self) -> Motion {
        let mut mean = [0.0; 6];
        let commands = [self.pipeline[0], self.pipeline[1]];
        for (duration, command) in self.parts.into_iter().zip(commands) {
            let (decay, area) = self.response(duration);
            for (i, u) in command.into_iter().enumerate() {
                let offset = self.velocity[i] - u;
                mean[i] += u * duration + offset * area;
                self.velocity[i] = u + offset * decay;
            }
        }
        Motion {
            mean,
            end: self.velocity,
        }
    }

    /// What is left of an initial offset after a duration, and its integral, in cycles.
    fn response(&self, duration: f64) -> (f64, f64) {
        if duration <= 0.0 {
            (1.0, 0.0)
        } else if self.lag <= 0.0 {
            (0.0, 0.0)
        } else {
            let decay = (-duration / self.lag).exp();
            (decay, self.lag * (1.0 - decay))
        }
    }
}
