//! The free response: where the robot will be over the horizon with the commands that were sent, then with those of the
//! reference.
//!
//! The reference is straight but for what the contact takes away along its push, so that only the robot's own path needs all
//! six axes at each time.

use super::V6;
use super::control_problem::ControlProblem;
use super::dynamic_matrix::Trajectory;
use super::reference::Deviations;
use super::tuning::*;

/// What the moves are found from.
pub(super) struct FreeResponse {
    /// The first tracking moves for it, m.
    pub(super) first_move: V6,
    /// Along the contact its error and position, m.
    pub(super) error: Trajectory,
    pub(super) position: Trajectory,
}

impl FreeResponse {
    /// With what the contact takes away of the reference from now on, and from a delay ahead on, along a gradient; each error
    /// counts in the first moves as the row of the tracking law says.
    #[inline(never)]
    pub(super) fn new(
        problem: &ControlProblem<'_>,
        taken: &Deviations,
        ahead: &Deviations,
        gradient: &V6,
        first_row: &Trajectory,
    ) -> Self {
        let reference = &problem.reference;
        let (per_cycle, push) = (reference.velocity * problem.model.cycle_s, &reference.push);
        let start = reference.position + per_cycle * (problem.cycle as f64 - reference.onset);
        let (mut sum, mut later, mut lost) = (0.0, 0.0, 0.0);
        for (t, (first, taken)) in first_row.iter().zip(taken).enumerate() {
            sum += first;
            later += first * t as f64;
            lost += first * taken.displacement;
        }
        let mut free = Self {
            first_move: start * sum + per_cycle * later - push * lost,
            error: [0.0; PREDICTION_HORIZON + 1],
            position: [0.0; PREDICTION_HORIZON + 1],
        };
        let mut robot = problem.robot;
        let changes = changes(problem, ahead);
        let mut commands = [0.0; PREDICTION_HORIZON + 1];
        for (i, axis) in robot.0.iter_mut().enumerate() {
            executed(problem, i, &changes, &mut commands);
            let mut path = [axis.position; PREDICTION_HORIZON + 1];
            let [_, ahead @ ..] = &mut path;
            axis.follow(problem.model, &commands, ahead);
            let (mut moved, gradient) = (0.0, gradient[i]);
            for ((first, position), at) in first_row.iter().zip(&mut free.position).zip(path) {
                moved += first * at;
                *position += gradient * at;
            }
            free.first_move[i] -= moved;
        }
        let (start, rate, push) = (
            gradient.dot(&start),
            gradient.dot(&per_cycle),
            gradient.dot(push),
        );
        for (t, (error, position)) in free.error.iter_mut().zip(&free.position).enumerate() {
            *error = start + rate * t as f64 - push * taken[t].displacement - position;
        }
        free
    }
}

/// What the contact takes away of the velocity of the reference, a delay ahead of each cycle of the
/// horizon.
fn changes(problem: &ControlProblem<'_>, ahead: &Deviations) -> Trajectory {
    let per_displacement = 1.0 / problem.model.cycle_s;
    let mut changes = [ahead[PREDICTION_HORIZON].velocity; PREDICTION_HORIZON + 1];
    for (change, pair) in changes.iter_mut().zip(ahead.windows(2)) {
        if let [now, next] = pair {
            *change = (next.displacement - now.displacement) * per_displacement;
        }
    }
    changes
}

/// The commands that an axis executes: each cycle of the horizon begins with one of them and ends
/// with the next. First those that are sent, then the reference.
fn executed(
    problem: &ControlProblem<'_>,
    axis: usize,
    changes: &Trajectory,
    commands: &mut Trajectory,
) {
    let reference = &problem.reference;
    let (velocity, push) = (reference.velocity[axis], reference.push[axis]);
    let before = problem.model.linear.whole as isize + 1 - problem.latency as isize;
    let (sent, later) = (before.max(0) as usize, (-before).max(0) as usize);
    let sent = sent.min(commands.len());
    let (old, new) = commands.split_at_mut(sent);
    for (t, command) in old.iter_mut().enumerate() {
        let cycle = (problem.cycle + t).checked_add_signed(-before);
        *command = cycle.map_or(0.0, |cycle| problem.commands.of_axis(cycle, axis));
    }
    let [.., last] = changes;
    for (t, command) in new.iter_mut().enumerate() {
        *command = velocity - push * changes.get(later + t).unwrap_or(last);
    }
}
