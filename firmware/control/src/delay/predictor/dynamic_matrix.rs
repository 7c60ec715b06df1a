//! Dynamic matrix control of an axis: the moves that bring the robot from its free response to the reference.
//!
//! Over the prediction horizon the positions of an axis are x = x₀ + G U, with x₀ the free response (commands
//! that are sent, then those of the reference one mean delay ahead; pauses included) and G the dynamic matrix
//! from the robot model's response to one command. The moves that track the reference r with the least
//!
//! ```text
//! ‖r − x‖² + ρ ‖U‖²        are        U = H⁻¹ Gᵀ (r − x₀),        H = Gᵀ G + ρ I
//! ```
//!
//! (Cutler and Ramaker, "Dynamic matrix control: a computer control algorithm", Joint Automatic Control
//! Conference, 1980), and the first of them is sent.

use super::least_squares::Ldlt;
use super::preload::Preload;
use super::robot_model::RobotModel;
use super::tuning::*;
use nalgebra::{SMatrix, SVector};

type Moves = SVector<f64, CONTROL_HORIZON>;
/// A quantity along the horizon: now, and after 1, 2 ... cycles.
pub(super) type Trajectory = [f64; PREDICTION_HORIZON + 1];

/// The part of the control that depends on the robot model alone.
#[derive(Clone, Debug)]
pub(super) struct DynamicMatrix {
    /// Displacement after j cycles of a command that lasts for the first one, cycles.
    response: Trajectory,
    /// Cycles at the beginning of the response in which nothing moves.
    dead: usize,
    /// Gᵀ G, lower triangle.
    gram: SMatrix<f64, CONTROL_HORIZON, CONTROL_HORIZON>,
    /// [`Self::undamped_row`], once it has been computed.
    undamped_row: Option<Trajectory>,
}

/// The tracking law with the move suppression of this cycle.
pub(super) struct Tracking<'a> {
    matrix: &'a DynamicMatrix,
    factor: Ldlt<CONTROL_HORIZON>,
    /// Weight with which the first move corrects an error at each time of the horizon, per cycle.
    pub(super) first_row: Trajectory,
}

impl DynamicMatrix {
    /// For a robot whose pose has a latency (cycles).
    pub(super) fn new(model: &RobotModel, latency: usize) -> Self {
        let response: Trajectory = model.linear.pulse_response(latency);
        let dead = response.iter().take_while(|x| **x == 0.0).count();
        let mut gram = SMatrix::zeros();
        for lag in 0..CONTROL_HORIZON {
            let products = response.iter().zip(&response[lag..]);
            gram[(lag, 0)] = products.map(|(a, b)| a * b).sum();
        }
        // For a move one cycle later the sum ends one cycle earlier.
        for j in 1..CONTROL_HORIZON {
            for i in j..CONTROL_HORIZON {
                let last =
                    response[PREDICTION_HORIZON + 1 - i] * response[PREDICTION_HORIZON + 1 - j];
                gram[(i, j)] = gram[(i - 1, j - 1)] - last;
            }
        }
        Self {
            response,
            dead,
            gram,
            undamped_row: None,
        }
    }

    /// Computes the undamped row, which each cycle in free flight needs, once. Not done in [`Self::new`], which may be called
    /// deep in the stack.
    pub(super) fn prepare(&mut self) {
        if self.undamped_row.is_none() {
            self.undamped_row = Some(self.tracking(0.0).first_row);
        }
    }

    /// [`Tracking::first_row`] without a damping.
    pub(super) fn undamped_row(&self) -> Trajectory {
        self.undamped_row
            .unwrap_or_else(|| self.tracking(0.0).first_row)
    }

    /// The tracking law for a contact; `damping_cycles` is its damping over its stiffness, in cycles.
    #[inline(never)]
    pub(super) fn tracking(&self, damping_cycles: f64) -> Tracking<'_> {
        let rho = MOVE_SUPPRESSION + DAMPED_MOVE_SUPPRESSION * damping_cycles * damping_cycles;
        let mut h = self.gram;
        for i in 0..CONTROL_HORIZON {
            h[(i, i)] += rho;
        }
        let factor = Ldlt::new(h);
        let mut unit = Moves::zeros();
        unit[0] = 1.0;
        let first_row = self.positions(&factor.solve(&unit));
        Tracking {
            matrix: self,
            factor,
            first_row,
        }
    }

    /// G U.
    fn positions(&self, moves: &Moves) -> Trajectory {
        let mut positions = [0.0; PREDICTION_HORIZON + 1];
        for (i, by) in moves.iter().enumerate() {
            let moved = positions.get_mut(i + self.dead..).unwrap_or_default();
            for (position, displacement) in moved.iter_mut().zip(self.alive()) {
                *position += displacement * by;
            }
        }
        positions
    }

    /// Gᵀ e.
    fn gathered(&self, error: &Trajectory) -> Moves {
        Moves::from_fn(|i, _| {
            let errors = error.get(i + self.dead..).unwrap_or_default();
            let products = errors.iter().zip(self.alive());
            products.map(|(e, displacement)| e * displacement).sum()
        })
    }

    /// The response from the first cycle that moves on.
    fn alive(&self) -> &[f64] {
        self.response.get(self.dead..).unwrap_or_default()
    }

    /// Displacement along the horizon by a preload whose first move is 1 and which is taken back as planned, cycles.
    pub(super) fn preload(&self, cycle: usize, plan: &Preload) -> Trajectory {
        let mut displacement = 0.0;
        core::array::from_fn(|t| {
            displacement = PRELOAD_DECAY * displacement + self.response[t];
            displacement * plan.remaining_fraction((cycle + t) as f64)
        })
    }

    /// Displacement by a command of one cycle, summed over the times for which `during` is 1.
    pub(super) fn authority(&self, during: &Trajectory) -> f64 {
        (0..=PREDICTION_HORIZON)
            .map(|t| self.response[t] * during[t])
            .sum()
    }
}

impl Tracking<'_> {
    /// The displacement by all tracking moves for this error.
    #[inline(never)]
    pub(super) fn tracked(&self, error: &Trajectory) -> Trajectory {
        self.matrix
            .positions(&self.factor.solve(&self.matrix.gathered(error)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::predictor::scene::{CYCLE, Scene, robots};

    /// Moves of 1, ½, ¼ ..., each of which the plan takes back from cycle 70 to 80.
    #[test]
    fn a_planned_preload_goes_back_as_planned() {
        let [.., actuator] = robots();
        let scene = Scene::new(&actuator, 1, 0.0, 0.0);
        let matrix = DynamicMatrix::new(&scene.model, 1);
        let found = matrix.preload(CYCLE, &Preload::default().planned(70.0, Some(80.0)));
        let response: Trajectory = scene.model.linear.pulse_response(1);
        for (t, found) in found.iter().enumerate() {
            let way: f64 = (0..=t)
                .map(|i| response[t - i] * 0.5_f64.powi(i as i32))
                .sum();
            let left = (80.0 - (CYCLE + t) as f64).clamp(0.0, 10.0) / 10.0;
            assert!((found - way * left).abs() < 1e-12, "{t}");
        }
    }
}
