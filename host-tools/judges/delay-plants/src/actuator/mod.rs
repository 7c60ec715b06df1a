//! The robot's axes: from the commanded velocity of each cycle to the executed motion.
//!
//! An axis is a transport delay, then a first-order lag or a second-order servo, then a pause at each reversal. When the
//! executed velocity changes its sign, the axis stands still for a while and then goes on with what the dynamics give by
//! then. The distance of the pause is lost, not made up for.

mod exact;
mod fixed_steps;
mod pipeline;
mod response;

use crate::Axes;
use crate::noise::Noise;
use exact::ExactAxis;
use fixed_steps::SteppedAxis;
use pipeline::Pipeline;

/// Dynamics after the transport delay.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Dynamics {
    /// Nothing: the delayed velocity is executed at once.
    #[default]
    None,
    /// T y' + y = u.
    Lag {
        /// T, s.
        time_constant_s: f64,
    },
    /// y'' + 2 ζ ω y' + ω² y = ω² u.
    Servo {
        /// ω / 2π, Hz.
        hz: f64,
        /// ζ.
        damping: f64,
    },
}

/// How the motion is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Formulation {
    /// Closed forms between events that are located as roots.
    #[default]
    Exact,
    /// Fixed steps of a two-hundredth of a cycle with a Runge-Kutta method.
    FixedSteps,
}

/// A robot's axes, all alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Actuator {
    /// Transport delay from the beginning of a command's cycle, s.
    pub delay_s: f64,
    /// Dynamics after the delay.
    pub dynamics: Dynamics,
    /// Standstill at each reversal, s.
    pub pause_s: f64,
    /// Largest velocity of a command, m/s and rad/s.
    pub max_velocity: f64,
    /// Largest change of a command per second, m/s² and rad/s².
    pub max_acceleration: f64,
    /// Whether the delay of each cycle is random: one cycle shorter or longer with a probability of a quarter each.
    pub jitter: bool,
    /// A change of the transport delay during the run.
    pub delay_change: Option<DelayChange>,
}

/// A transport delay that changes at some time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DelayChange {
    /// Commands from this time on have the other delay, s.
    pub at_s: f64,
    /// Number of cycles by which it becomes longer; negative for shorter.
    pub cycles: i8,
}

impl Actuator {
    /// A robot that executes each command at once.
    pub const fn ideal() -> Self {
        Self {
            delay_s: 0.0,
            dynamics: Dynamics::None,
            pause_s: 0.0,
            max_velocity: f64::INFINITY,
            max_acceleration: f64::INFINITY,
            jitter: false,
            delay_change: None,
        }
    }
}

/// Position and velocity of the six axes at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Motion {
    pub(crate) time_s: f64,
    pub(crate) position: Axes,
    pub(crate) velocity: Axes,
}

/// One axis in either formulation.
#[derive(Clone, Debug)]
enum Axis {
    Exact(ExactAxis),
    Stepped(SteppedAxis),
}

/// Six axes and their commands.
#[derive(Clone, Debug)]
pub(crate) struct Robot {
    settings: Actuator,
    cycle_s: f64,
    cycles: u64,
    axes: [(Pipeline, Axis); 6],
    jitter: Noise,
    /// Number of times within a cycle at which the motion is evaluated.
    samples_per_cycle: u32,
}

impl Robot {
    /// The robot at rest at a position.
    pub(crate) fn new(
        settings: &Actuator,
        formulation: Formulation,
        cycle_s: f64,
        start: Axes,
        seed: u64,
    ) -> Self {
        let axis = |i: usize| {
            let axis = match formulation {
                Formulation::Exact => Axis::Exact(ExactAxis::new(settings, start[i])),
                Formulation::FixedSteps => {
                    Axis::Stepped(SteppedAxis::new(settings, cycle_s, start[i]))
                }
            };
            (Pipeline::new(settings.delay_s, cycle_s), axis)
        };
        Self {
            settings: *settings,
            cycle_s,
            cycles: 0,
            axes: std::array::from_fn(axis),
            jitter: Noise::new(seed, 7),
            samples_per_cycle: match formulation {
                Formulation::Exact => 40,
                Formulation::FixedSteps => fixed_steps::STEPS_PER_CYCLE,
            },
        }
    }

    /// Executes one cycle; `sample` is called with the motion at many times of it, the last at its end.
    pub(crate) fn cycle(&mut self, command: Axes, mut sample: impl FnMut(&Motion)) {
        let begin_s = self.cycles as f64 * self.cycle_s;
        let mut shift = if self.settings.jitter {
            [-1, 0, 0, 1][self.jitter.below(4)]
        } else {
            0
        };
        let change = self.settings.delay_change;
        if let Some(change) = change.filter(|change| begin_s >= change.at_s) {
            shift -= change.cycles;
        }
        for (i, (pipeline, _)) in self.axes.iter_mut().enumerate() {
            let limited = self
                .settings
                .limited(pipeline.newest(), command[i], self.cycle_s);
            pipeline.push(limited, shift);
        }
        for k in 1..=self.samples_per_cycle {
            let time_s = begin_s + self.cycle_s * f64::from(k) / f64::from(self.samples_per_cycle);
            let mut motion = Motion {
                time_s,
                position: [0.0; 6],
                velocity: [0.0; 6],
            };
            for (i, (pipeline, axis)) in self.axes.iter_mut().enumerate() {
                (motion.position[i], motion.velocity[i]) = match axis {
                    Axis::Exact(axis) => axis.advance(pipeline, time_s),
                    Axis::Stepped(axis) => axis.advance(pipeline),
                };
            }
            sample(&motion);
        }
        self.cycles += 1;
    }
}

impl Actuator {
    /// The command after `last`, limited in change and magnitude.
    fn limited(&self, last: f64, command: f64, cycle_s: f64) -> f64 {
        let change = self.max_acceleration * cycle_s;
        let near = command.clamp(last - change, last + change);
        near.clamp(-self.max_velocity, self.max_velocity)
    }
}
