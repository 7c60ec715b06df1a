//! The fallback law: a second-order lead without a contact model, for contacts that the identification does not describe.
//!
//! ```text
//! v_cmd = v + τ v' + ½ τ² v''
//! ```
//!
//! as in the law [`lead`](crate::delay::lead), with the model's velocity during the contact. The predictor is blended into the
//! lead, and back, over [`BLEND_CYCLES`], and only between contacts, where both command the model's velocity.

use super::V6;
use super::command::{Command, limited};
use super::control_problem::ControlProblem;
use super::tuning::*;

/// State of the lead, and the share of the predictor in the command.
#[derive(Clone, Debug)]
pub(super) struct Fallback {
    /// 1: the predictor; 0: the lead.
    pub(super) trust: f64,
    last: V6,
    slope: V6,
}

impl Fallback {
    pub(super) fn new() -> Self {
        Self {
            trust: 1.0,
            last: V6::zeros(),
            slope: V6::zeros(),
        }
    }

    /// The command, with the identification of contacts `trusted` or not.
    #[inline(never)]
    pub(super) fn command(
        &mut self,
        problem: &ControlProblem<'_>,
        in_contact: bool,
        trusted: bool,
    ) -> Command {
        let velocity = &problem.velocity;
        let lead = self.lead(velocity, in_contact, problem.delay());
        if !in_contact {
            self.blend(trusted);
        }
        let trust = self.trust;
        if trust >= 1.0 {
            return problem.solve();
        }
        let (simple, at_speed_limit) = limited(velocity + lead, &problem.reference.velocity);
        let mut command = Command {
            velocity: simple,
            tracking: simple - velocity,
            preload: V6::zeros(),
            preload_rate: 0.0,
            reversals: problem.reversals,
            at_speed_limit,
        };
        if trust > 0.0 {
            let full = problem.solve();
            command.velocity += (full.velocity - command.velocity) * trust;
            command.tracking += (full.tracking - command.tracking) * trust;
            command.preload = full.preload * trust;
            command.preload_rate = full.preload_rate * trust;
            command.reversals = full.reversals;
            command.at_speed_limit |= full.at_speed_limit;
        }
        command
    }

    /// Moves the share of the predictor by one cycle, between contacts. It is clamped, so that it can return at once.
    fn blend(&mut self, trusted: bool) {
        let step = if trusted { 1.0 } else { -1.0 } / BLEND_CYCLES;
        self.trust = (self.trust + step).clamp(0.0, 1.0);
    }

    /// Takes in a cycle. Returns the addition to the model's velocity for a robot that is `delay` cycles late; zero without a
    /// contact.
    fn lead(&mut self, velocity: &V6, in_contact: bool, delay: f64) -> V6 {
        if !in_contact {
            (self.last, self.slope) = (*velocity, V6::zeros());
            return V6::zeros();
        }
        let before = core::mem::replace(&mut self.slope, velocity - self.last);
        self.last = *velocity;
        // The difference is that of the middle of the cycle: half a cycle more.
        self.slope * delay + (self.slope - before) * (0.5 * delay * (delay + 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::predictor::scene::{Scene, robots};

    /// However long the identification was trusted or not, each way takes [`BLEND_CYCLES`], no cycle more.
    #[test]
    fn the_blend_takes_as_long_after_a_year_as_after_a_second() {
        let mut fallback = Fallback::new();
        let mut blended = |trusted, cycles| {
            (0..cycles).for_each(|_| fallback.blend(trusted));
            fallback.trust
        };
        let passage = BLEND_CYCLES as usize + 1;
        for (trusted, end) in [(true, 1.0), (false, 0.0), (true, 1.0)] {
            assert_eq!(blended(trusted, passage), end);
            assert_eq!(blended(trusted, 1000), end);
        }
    }

    #[test]
    fn the_blend_is_straight() {
        let mut fallback = Fallback::new();
        for trusted in [false, true] {
            for n in 1..=10 {
                fallback.blend(trusted);
                let passed = f64::from(n) / BLEND_CYCLES;
                let expected = if trusted { passed } else { 1.0 - passed };
                assert!((fallback.trust - expected).abs() < 1e-12);
            }
        }
    }

    /// For a velocity that is a parabola in time the lead gives the velocity a delay later.
    #[test]
    fn the_lead_of_a_parabola_is_exact() {
        let of = |coefficient: f64, t: f64| {
            V6::new(1.0, -2.0, 0.5, 0.0, 3.0, 0.1) * (coefficient * t * t - t)
        };
        for (coefficient, delay) in [(0.0, 8.0), (0.3, 8.0), (0.3, 2.5), (-0.2, 0.0)] {
            let mut fallback = Fallback::new();
            let at = |n: i32| of(coefficient, f64::from(n));
            assert_eq!(fallback.lead(&at(0), false, delay), V6::zeros());
            for n in 1..20 {
                let lead = fallback.lead(&at(n), true, delay);
                let later = of(coefficient, f64::from(n) + delay) - at(n);
                // The first difference of a contact has no predecessor.
                assert!(n < 2 || (lead - later).amax() < 1e-9, "{n}: {lead} {later}");
            }
            // In free flight it is reset, also after a contact.
            assert_eq!(fallback.lead(&at(0), false, delay), V6::zeros());
            let first = fallback.lead(&at(1), true, delay);
            let slope = at(1) - at(0);
            let expected = slope * (delay + 0.5 * delay * (delay + 1.0));
            assert!((first - expected).amax() < 1e-9);
        }
    }

    /// In a contact in which the model is braked, with a trust of 1, of a fraction and of 0.
    #[test]
    fn a_command_is_the_predictors_by_its_trust_and_the_lead_by_the_rest() {
        let [robot, ..] = robots();
        let scene = Scene::new(&robot, 1, 0.1, 4.0);
        let before = scene.velocity + scene.contact.push * 1e-4;
        scene.ask(|problem| {
            let full = problem.solve();
            let lead = Fallback {
                trust: 0.0,
                last: before,
                slope: V6::zeros(),
            };
            let lead = lead.clone().lead(&problem.velocity, true, problem.delay());
            let (simple, _) = limited(problem.velocity + lead, &problem.reference.velocity);
            for trust in [1.0, 0.7, 0.3, 0.0] {
                let mut fallback = Fallback {
                    trust,
                    last: before,
                    slope: V6::zeros(),
                };
                let found = fallback.command(problem, true, trust < 0.5);
                assert_eq!(fallback.trust, trust);
                let mixed = |full: V6, simple: V6| full * trust + simple * (1.0 - trust);
                for (found, expected) in [
                    (found.velocity, mixed(full.velocity, simple)),
                    (
                        found.tracking,
                        mixed(full.tracking, simple - problem.velocity),
                    ),
                    (found.preload, full.preload * trust),
                    (
                        V6::repeat(found.preload_rate),
                        V6::repeat(full.preload_rate * trust),
                    ),
                ] {
                    assert!(
                        (found - expected).amax() < 1e-12,
                        "{trust}: {found} {expected}"
                    );
                }
            }
        });
    }

    /// The lead is at the limit, the predictor is not; the flag is set if the lead has a share in the command.
    #[test]
    fn the_speed_limit_is_told_of_either_part() {
        let [robot, ..] = robots();
        let scene = Scene::new(&robot, 1, 0.0, -12.0);
        // Both are at the limit.
        let [.., servo] = robots();
        Scene::new(&servo, 1, 0.0, 30.0).ask(|problem| {
            assert!(problem.solve().at_speed_limit);
            let mut fallback = Fallback {
                trust: 0.5,
                last: V6::repeat(1.0),
                slope: V6::zeros(),
            };
            assert!(fallback.command(problem, true, true).at_speed_limit);
        });
        scene.ask(|problem| {
            let quiet = problem.solve();
            assert!(!quiet.at_speed_limit);
            for (trust, jump, expected) in [
                (0.5, 0.0, false),
                (0.5, 1.0, true),
                (0.0, 1.0, true),
                (1.0, 1.0, false),
            ] {
                let last = problem.velocity + V6::repeat(jump);
                let mut fallback = Fallback {
                    trust,
                    last,
                    slope: V6::zeros(),
                };
                assert_eq!(
                    fallback.command(problem, true, true).at_speed_limit,
                    expected
                );
            }
        });
    }
}
