//! The next command: follow the reference, and leave the contact with the right momentum.
//!
//! Over the horizon the positions are x = x_nominal + G U, with G from the robot's response to one
//! command. U = H⁻¹ Gᵀ (reference − x_nominal), H = GᵀG + ρ I, tracks. On top, along the contact,
//! comes the multiple μ of the moves 1, ½, ¼ ... for which the impulse that is still to come turns the
//! model's momentum into that of the rebound. The earlier a lean, the less way it takes.

use super::linear::Factor;
use super::{HORIZON, MOVES};
use nalgebra::{SMatrix, SVector};

type Moves = SVector<f64, MOVES>;
/// A quantity along the horizon: now, and after 1, 2 ... cycles.
pub(super) type Line = [f64; HORIZON + 1];

/// ρ: what a change of the command costs against an error of position, cycles².
const EFFORT: f64 = 3.0;
/// The same for a damped contact, where commands are force: of (c / k Ts)².
const EFFORT_OF_DAMPING: f64 = 0.3;

/// Each move of a lean as a part of the one before.
const LEAN_FADES: f64 = 0.5;

/// What depends on the robot's response alone.
#[derive(Clone, Debug)]
pub(super) struct Solver {
    /// Way after j cycles of a command that lasts for the first one, cycles.
    response: Line,
    /// Cycles at its beginning in which nothing moves.
    dead: usize,
    gram: SMatrix<f64, MOVES, MOVES>,
}

/// The solver with the effort of this cycle.
pub(super) struct Step<'a> {
    solver: &'a Solver,
    factor: Factor<MOVES>,
    /// What the first move takes of an error at each time.
    first: Line,
}

impl Solver {
    pub(super) fn new(response: Line) -> Self {
        let dead = response.iter().take_while(|way| **way == 0.0).count();
        let mut gram = SMatrix::zeros();
        for lag in 0..MOVES {
            let products = response.iter().zip(&response[lag..]);
            gram[(lag, 0)] = products.map(|(a, b)| a * b).sum();
        }
        // One move later, the sum ends one cycle earlier.
        for j in 1..MOVES {
            for i in j..MOVES {
                let last = response[HORIZON + 1 - i] * response[HORIZON + 1 - j];
                gram[(i, j)] = gram[(i - 1, j - 1)] - last;
            }
        }
        Self {
            response,
            dead,
            gram,
        }
    }

    /// For a contact of this damping over stiffness, in cycles.
    #[inline(never)]
    pub(super) fn step(&self, damping_cycles: f64) -> Step<'_> {
        let effort = EFFORT + EFFORT_OF_DAMPING * damping_cycles * damping_cycles;
        let mut h = self.gram;
        for i in 0..MOVES {
            h[(i, i)] += effort;
        }
        let factor = Factor::new(&h);
        let mut unit = Moves::zeros();
        unit[0] = 1.0;
        let first = self.positions(&factor.solve(&unit));
        Step {
            solver: self,
            factor,
            first,
        }
    }

    /// G U.
    fn positions(&self, moves: &Moves) -> Line {
        let mut positions = [0.0; HORIZON + 1];
        for (i, by) in moves.iter().enumerate() {
            let moved = positions.get_mut(i + self.dead..).unwrap_or_default();
            for (position, way) in moved.iter_mut().zip(self.alive()) {
                *position += way * by;
            }
        }
        positions
    }

    /// Gᵀ e.
    fn gathered(&self, error: &Line) -> Moves {
        Moves::from_fn(|i, _| {
            let errors = error.get(i + self.dead..).unwrap_or_default();
            errors
                .iter()
                .zip(self.alive())
                .map(|(e, way)| e * way)
                .sum()
        })
    }

    /// The response from where something moves.
    fn alive(&self) -> &[f64] {
        self.response.get(self.dead..).unwrap_or_default()
    }

    /// Way of a lean whose first move is 1, cycles.
    pub(super) fn lean(&self) -> Line {
        let mut way = 0.0;
        self.response.map(|response| {
            way = LEAN_FADES * way + response;
            way
        })
    }

    /// Way that a command of one cycle makes within the times for which `during` is 1.
    pub(super) fn authority(&self, during: &Line) -> f64 {
        (0..=HORIZON).map(|t| self.response[t] * during[t]).sum()
    }
}

impl Step<'_> {
    /// What the first tracking move takes of an error at each time of the horizon, per cycle.
    pub(super) fn first(&self) -> &Line {
        &self.first
    }

    /// The positions that all tracking moves make.
    #[inline(never)]
    pub(super) fn tracked(&self, error: &Line) -> Line {
        self.solver
            .positions(&self.factor.solve(&self.solver.gathered(error)))
    }
}
