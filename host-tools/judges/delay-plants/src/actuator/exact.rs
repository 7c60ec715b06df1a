//! One axis, propagated in closed form from event to event: the arrival of a command, a reversal, the end of a pause.

use super::pipeline::Pipeline;
use super::response::{Output, after};
use super::{Actuator, Dynamics};

/// Step of the search for a reversal, s. If a servo crosses zero twice within a step, the reversal is missed; at 10 Hz a step
/// is a hundredth of a period.
const SEARCH_STEP_S: f64 = 1e-3;
/// Bisections of such a step: to less than 1e-15 s.
const HALVINGS: u32 = 40;

/// Times closer than this count as equal, s.
const SAME_TIME_S: f64 = 1e-10;

/// State of an axis.
#[derive(Clone, Debug)]
pub(super) struct ExactAxis {
    dynamics: Dynamics,
    pause_s: f64,
    time_s: f64,
    position: f64,
    /// Output of the lag or the servo, which goes on during a pause.
    output: Output,
    input: f64,
    /// Cycle of the command that arrives next.
    next: usize,
    /// Direction of the last motion: -1, 0, 1.
    direction: f64,
    /// End of the running pause, s.
    paused_until_s: f64,
}

impl ExactAxis {
    pub(super) fn new(settings: &Actuator, position: f64) -> Self {
        Self {
            dynamics: settings.dynamics,
            pause_s: settings.pause_s,
            time_s: 0.0,
            position,
            output: Output::default(),
            input: 0.0,
            next: 0,
            direction: 0.0,
            paused_until_s: f64::NEG_INFINITY,
        }
    }

    /// Advances to a time and returns position and velocity there. A command that arrives exactly at that time acts after
    /// it.
    pub(super) fn advance(&mut self, commands: &Pipeline, to_s: f64) -> (f64, f64) {
        while self.time_s < to_s {
            while commands.edge_s(self.next) < self.time_s + SAME_TIME_S {
                self.input = commands.after_edge(self.next);
                self.next += 1;
            }
            self.turn();
            let mut stop_s = to_s;
            let edge_s = commands.edge_s(self.next);
            if edge_s < to_s - SAME_TIME_S {
                stop_s = edge_s;
            }
            if self.paused() {
                stop_s = stop_s.min(self.paused_until_s);
            }
            self.glide(stop_s);
        }
        let velocity = if self.paused() {
            0.0
        } else {
            self.output.velocity
        };
        (self.position, velocity)
    }

    fn paused(&self) -> bool {
        self.time_s < self.paused_until_s
    }

    /// Begins a pause if the axis reverses at the present time.
    fn turn(&mut self) {
        if self.dynamics == Dynamics::None {
            self.output.velocity = self.input;
        }
        if self.paused() || self.output.velocity == 0.0 {
            return;
        }
        let direction = self.output.velocity.signum();
        // A reversal during the pause does not cause another pause.
        let just_paused = self.time_s == self.paused_until_s;
        if self.direction * direction < 0.0 && !just_paused && self.pause_s > 0.0 {
            self.paused_until_s = self.time_s + self.pause_s;
        }
        self.direction = direction;
    }

    /// Advances to a time before which no command arrives, or to a reversal before it.
    fn glide(&mut self, stop_s: f64) {
        let mut dt_s = stop_s - self.time_s;
        let mut end_s = stop_s;
        if !self.paused()
            && let Some(reversal_s) = self.reversal(dt_s)
        {
            dt_s = reversal_s;
            end_s = (self.time_s + reversal_s).min(stop_s);
        }
        let (output, way) = after(self.dynamics, self.output, self.input, dt_s);
        if !self.paused() {
            self.position += way;
        }
        self.output = output;
        self.time_s = end_s;
    }

    /// Time from now to the first instant with the opposite direction, within `dt_s`; None if there is none.
    fn reversal(&self, dt_s: f64) -> Option<f64> {
        if self.dynamics == Dynamics::None || self.direction == 0.0 {
            return None;
        }
        let turned = |t: f64| {
            after(self.dynamics, self.output, self.input, t).0.velocity * self.direction < 0.0
        };
        let steps = (dt_s / SEARCH_STEP_S).ceil().max(1.0);
        let mut before = 0.0;
        for k in 1..=steps as u32 {
            let now = dt_s * f64::from(k) / steps;
            if turned(now) {
                let (mut low, mut high) = (before, now);
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (low + high);
                    if turned(middle) {
                        high = middle;
                    } else {
                        low = middle;
                    }
                }
                return Some(high);
            }
            before = now;
        }
        None
    }
}
