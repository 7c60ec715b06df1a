//! A late robot against elastic walls: the plant of the known answers about the delay.
//!
//! Each axis of C: a transport delay, then a zero-crossing pause. When the delayed velocity
//! changes its sign, the output is held at 0 for the pause and then resumes at the command that
//! is due at that time: the position is lost, not caught up. Two parallel walls push back
//! elastically, `F = −k × depth`. The sub-step is 0.5 ms.

use nalgebra::Vector3;
use softdock_app::record::Correction;
use std::collections::VecDeque;

/// Interpolation cycle of the robot, s.
pub const CYCLE_S: f64 = 0.004;

/// Sub-steps of the plant per cycle: 0.5 ms each.
const SUB_STEPS: usize = 8;
const SUB_STEP_S: f64 = CYCLE_S / SUB_STEPS as f64;

/// Actuator and walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlantSettings {
    /// Transport delay, s.
    pub delay_s: f64,
    /// Pause at each change of sign, s.
    pub pause_s: f64,
    /// Stiffness of the walls, N/m.
    pub stiffness_n_per_m: f64,
    /// Unit normal: from the left wall to the right one, axes of C.
    pub normal: Vector3<f64>,
    /// Distance of the right wall from the start along the normal, m.
    pub right_m: f64,
    /// Distance of the left wall against the normal, m; infinite for none.
    pub left_m: f64,
    /// Metres per count of the correction.
    pub metres_per_count: f64,
}

/// One axis of the robot.
#[derive(Clone, Debug)]
struct Axis {
    pipeline: VecDeque<f64>,
    pause_steps: usize,
    /// Sign of the last motion; 0 before the first.
    direction: f64,
    paused_steps_left: usize,
}

impl Axis {
    fn new(settings: &PlantSettings) -> Self {
        let steps = |time_s: f64| (time_s / SUB_STEP_S).round() as usize;
        Self {
            pipeline: VecDeque::from(vec![0.0; steps(settings.delay_s)]),
            pause_steps: steps(settings.pause_s),
            direction: 0.0,
            paused_steps_left: 0,
        }
    }

    /// Executed velocity of the next sub-step, m/s.
    fn execute(&mut self, command: f64) -> f64 {
        self.pipeline.push_back(command);
        let due = self.pipeline.pop_front().unwrap_or(command);
        if due * self.direction < 0.0 {
            self.paused_steps_left = self.pause_steps;
        }
        if due != 0.0 {
            self.direction = due.signum();
        }
        if self.paused_steps_left > 0 {
            self.paused_steps_left -= 1;
            return 0.0;
        }
        due
    }
}

/// The robot between the walls.
#[derive(Clone, Debug)]
pub struct Plant {
    settings: PlantSettings,
    axes: [Axis; 3],
    position: Vector3<f64>,
}

impl Plant {
    /// At rest at the origin.
    pub fn new(settings: PlantSettings) -> Self {
        Self {
            settings,
            axes: [(); 3].map(|()| Axis::new(&settings)),
            position: Vector3::zeros(),
        }
    }

    /// Executes one relative correction during one cycle.
    pub fn advance(&mut self, correction: &Correction) {
        for _ in 0..SUB_STEPS {
            for (i, axis) in self.axes.iter_mut().enumerate() {
                let step_m = correction[i] as f64 * self.settings.metres_per_count;
                self.position[i] += axis.execute(step_m / CYCLE_S) * SUB_STEP_S;
            }
        }
    }

    /// Position of the flange, m.
    pub fn position(&self) -> Vector3<f64> {
        self.position
    }

    /// Force of the walls on the flange, N, axes of C.
    pub fn force(&self) -> Vector3<f64> {
        let s = &self.settings;
        let x = self.position.dot(&s.normal);
        let depth = (x - s.right_m).max(0.0) - (-x - s.left_m).max(0.0);
        s.normal * (-s.stiffness_n_per_m * depth)
    }
}
