//! The free response: the motion of the robot over the horizon with the commands that were sent, then with those of the
//! reference.
//!
//! The reference is straight except along its push, so that only the robot's own motion has to be computed for all six axes.

use super::V6;
use super::control_problem::ControlProblem;
use super::dynamic_matrix::Trajectory;
use super::reference::Deviations;
use super::tuning::*;

/// The quantities from which the moves are computed.
pub(super) struct FreeResponse {
    /// The first tracking move of each axis, m.
    pub(super) first_move: V6,
    /// Error (reference minus free response) and position along the contact, m.
    pub(super) error: Trajectory,
    pub(super) position: Trajectory,
    /// Displacement along the contact in the cycle that ends then, as the trapezoidal sum of the sampled velocities gives it, m.
    pub(super) sampled: Trajectory,
}

impl FreeResponse {
    /// From the deviations of the reference from now on (`deviations_now`), and from a delay ahead on (`deviations_at_execution`).
    /// `first_row` holds the weights of the errors in the first move.
    #[inline(never)]
    pub(super) fn new(
        problem: &ControlProblem<'_>,
        deviations_now: &Deviations,
        deviations_at_execution: &Deviations,
        first_row: &Trajectory,
    ) -> Self {
        let reference = &problem.reference;
        let (per_cycle, push) = (reference.velocity * problem.model.cycle_s, &reference.push);
        let start = reference.position + per_cycle * (problem.cycle as f64 - reference.onset);
        let (mut sum, mut later, mut lost) = (0.0, 0.0, 0.0);
        for (t, (first, deviation)) in first_row.iter().zip(deviations_now).enumerate() {
            sum += first;
            later += first * t as f64;
            lost += first * deviation.displacement;
        }
        let gradient = problem.contact.map(|contact| contact.gradient);
        let mut position = [0.0; PREDICTION_HORIZON + 1];
        let mut sampled = [0.0; PREDICTION_HORIZON + 1];
        let mut before = 0.0;
        let (mut robot, mut moved) = (problem.robot, V6::zeros());
        let mut older = executed(problem, deviations_at_execution, 0);
        let along_contact = position.iter_mut().zip(&mut sampled);
        for (t, (first, (position, sampled))) in first_row.iter().zip(along_contact).enumerate() {
            if t > 0 {
                let newer = executed(problem, deviations_at_execution, t);
                robot.step(problem.model, &older, &newer);
                older = newer;
            }
            moved += robot.position * *first;
            if let Some(gradient) = &gradient {
                *position = gradient.dot(&robot.position);
                let rate = gradient.dot(&robot.velocity);
                if t > 0 {
                    *sampled = 0.5 * problem.model.cycle_s * (before + rate);
                }
                before = rate;
            }
        }
        let error = gradient.map_or([0.0; PREDICTION_HORIZON + 1], |gradient| {
            let along = |v: &V6| gradient.dot(v);
            let (start, rate, push) = (along(&start), along(&per_cycle), along(push));
            core::array::from_fn(|t| {
                start + rate * t as f64 - push * deviations_now[t].displacement - position[t]
            })
        });
        Self {
            first_move: start * sum + per_cycle * later - push * lost - moved,
            error,
            position,
            sampled,
        }
    }
}

/// The commands that are executed at the end of cycle `t` of the horizon and at the beginning of the next: first those that were
/// sent, then those of the reference.
fn executed(problem: &ControlProblem<'_>, deviations_at_execution: &Deviations, t: usize) -> V6 {
    let reference = &problem.reference;
    let sent = problem.model.linear.whole + 1;
    let Some(new) = (t + problem.latency).checked_sub(sent) else {
        let cycle = (problem.cycle + t + problem.latency).checked_sub(sent);
        return cycle.map_or(V6::zeros(), |cycle| problem.commands.of(cycle, 0));
    };
    reference.velocity - reference.push * change(problem, deviations_at_execution, new)
}

/// Change of the reference's velocity along the contact in a cycle `t` that begins a delay ahead, m/s.
fn change(problem: &ControlProblem<'_>, deviations_at_execution: &Deviations, t: usize) -> f64 {
    let per_displacement = 1.0 / problem.model.cycle_s;
    match (
        deviations_at_execution.get(t),
        deviations_at_execution.get(t + 1),
    ) {
        (Some(now), Some(next)) => (next.displacement - now.displacement) * per_displacement,
        _ => deviations_at_execution[PREDICTION_HORIZON].velocity,
    }
}
