//! One axis in small fixed steps: the second formulation, which shares no code with the first except for the list of
//! commands.

use super::pipeline::Pipeline;
use super::{Actuator, Dynamics};
use std::f64::consts::TAU;

/// Number of steps in a cycle: 0.02 ms each in a cycle of 4 ms.
pub(super) const STEPS_PER_CYCLE: u32 = 200;

/// State of an axis.
#[derive(Clone, Debug)]
pub(super) struct SteppedAxis {
    /// Coefficients of y'' = a (u − y) − b y'; with a = 0, y' = b (u − y).
    a: f64,
    b: f64,
    instant: bool,
    step_s: f64,
    steps: u64,
    pause_s: f64,
    pause_left_s: f64,
    position: f64,
    y: f64,
    dy: f64,
    last_executed: f64,
    /// Sign of the last velocity that was not zero.
    sign: i8,
}

impl SteppedAxis {
    pub(super) fn new(settings: &Actuator, cycle_s: f64, position: f64) -> Self {
        let (a, b) = match settings.dynamics {
            Dynamics::None => (0.0, 0.0),
            Dynamics::Lag { time_constant_s } => (0.0, 1.0 / time_constant_s),
            Dynamics::Servo { hz, damping } => {
                let omega = TAU * hz;
                (omega * omega, 2.0 * damping * omega)
            }
        };
        Self {
            a,
            b,
            instant: settings.dynamics == Dynamics::None,
            step_s: cycle_s / f64::from(STEPS_PER_CYCLE),
            steps: 0,
            pause_s: settings.pause_s,
            pause_left_s: 0.0,
            position,
            y: 0.0,
            dy: 0.0,
            last_executed: 0.0,
            sign: 0,
        }
    }

    /// One step. Returns position and velocity at its end.
    pub(super) fn advance(&mut self, commands: &Pipeline) -> (f64, f64) {
        let middle_s = (self.steps as f64 + 0.5) * self.step_s;
        let input = input_at(commands, middle_s);
        self.steps += 1;
        if self.instant {
            (self.y, self.last_executed) = (input, input);
        } else {
            self.runge_kutta(input);
        }
        let executed = self.held();
        self.position += 0.5 * self.step_s * (self.last_executed + executed);
        self.last_executed = executed;
        (self.position, executed)
    }

    /// The output, or zero while the pause lasts.
    fn held(&mut self) -> f64 {
        if self.pause_left_s > 0.5 * self.step_s {
            self.pause_left_s -= self.step_s;
            if self.instant {
                self.last_executed = 0.0;
            }
            if self.pause_left_s <= 0.5 * self.step_s {
                self.sign = sign(self.y);
            }
            return 0.0;
        }
        let now = sign(self.y);
        if now != 0 {
            let reversed = now == -self.sign;
            self.sign = now;
            if reversed && self.pause_s > 0.0 {
                self.pause_left_s = self.pause_s;
                return self.held();
            }
        }
        self.y
    }

    fn slope(&self, y: f64, dy: f64, u: f64) -> (f64, f64) {
        if self.a == 0.0 {
            (self.b * (u - y), 0.0)
        } else {
            (dy, self.a * (u - y) - self.b * dy)
        }
    }

    fn runge_kutta(&mut self, u: f64) {
        let (h, y, dy) = (self.step_s, self.y, self.dy);
        let k1 = self.slope(y, dy, u);
        let k2 = self.slope(y + 0.5 * h * k1.0, dy + 0.5 * h * k1.1, u);
        let k3 = self.slope(y + 0.5 * h * k2.0, dy + 0.5 * h * k2.1, u);
        let k4 = self.slope(y + h * k3.0, dy + h * k3.1, u);
        self.y += h / 6.0 * (k1.0 + 2.0 * k2.0 + 2.0 * k3.0 + k4.0);
        self.dy += h / 6.0 * (k1.1 + 2.0 * k2.1 + 2.0 * k3.1 + k4.1);
    }
}

/// The delayed command that acts at a time.
fn input_at(commands: &Pipeline, time_s: f64) -> f64 {
    let period_s = commands.edge_s(1) - commands.edge_s(0);
    let cycle = ((time_s - commands.edge_s(0)) / period_s).floor();
    if cycle < 0.0 {
        0.0
    } else {
        commands.after_edge(cycle as usize)
    }
}

fn sign(v: f64) -> i8 {
    if v > 0.0 {
        1
    } else if v < 0.0 {
        -1
    } else {
        0
    }
}
