//! Walls that were touched before: the robot turns where one is expected, not when it is felt.

use super::V6;
use super::identify::{Estimate, Evidence};
use super::reference::{Reference, Spring};

/// Walls that are kept.
const WALLS: usize = 2;
/// Cosine between loads above which they are of the same wall.
const SAME: f64 = 0.95;
/// Cycles beyond its place after which a wall that is not felt is forgotten.
const MISSED: f64 = 6.0;

/// A wall.
#[derive(Clone, Debug)]
struct Wall {
    direction: V6,
    latency: usize,
    evidence: Evidence,
    estimate: Estimate,
}

/// The walls of a run.
#[derive(Clone, Debug, Default)]
pub(super) struct Walls {
    kept: [Option<Wall>; WALLS],
    /// The place that is given away next.
    next: usize,
}

impl Walls {
    /// What is known of the wall that a load of this direction comes from.
    pub(super) fn of(&self, direction: &V6) -> Option<(usize, &Evidence)> {
        let same = |wall: &&Wall| cosine(&wall.direction, direction) > SAME;
        let wall = self.kept.iter().flatten().find(same)?;
        Some((wall.latency, &wall.evidence))
    }

    /// Keeps a wall in place of what was known of it.
    pub(super) fn keep(
        &mut self,
        direction: &V6,
        latency: usize,
        evidence: Evidence,
        estimate: &Estimate,
    ) {
        let same = |wall: &Option<Wall>| {
            wall.as_ref()
                .is_none_or(|wall| cosine(&wall.direction, direction) > SAME)
        };
        let place = self.kept.iter().position(same).unwrap_or(self.next);
        self.next = (place + 1) % WALLS;
        if let Some(slot) = self.kept.get_mut(place) {
            *slot = Some(Wall {
                direction: *direction,
                latency,
                evidence,
                estimate: *estimate,
            });
        }
    }

    /// The contact that is coming, for a straight flight from a position at a cycle; the nearest of
    /// those within a horizon. A wall that should have been felt is forgotten.
    pub(super) fn ahead(
        &mut self,
        position: &V6,
        velocity: &V6,
        cycle: usize,
        horizon: f64,
        cycle_s: f64,
    ) -> Option<(Reference, Estimate)> {
        let mut nearest: Option<(f64, Estimate)> = None;
        for slot in &mut self.kept {
            let Some(wall) = slot else { continue };
            let estimate = wall.estimate;
            let closing = estimate.gradient.dot(velocity);
            if closing <= 1e-3 * velocity.norm() {
                continue;
            }
            let distance = estimate.wall - estimate.gradient.dot(position);
            let cycles = distance / (closing * cycle_s);
            if cycles < -MISSED {
                *slot = None;
            } else if cycles < horizon && nearest.is_none_or(|(best, _)| cycles < best) {
                nearest = Some((cycles, estimate));
            }
        }
        let (cycles, estimate) = nearest?;
        let reference = Reference {
            touch: cycle as f64 + cycles,
            position: position + velocity * (cycles * cycle_s),
            velocity: *velocity,
            push: estimate.push,
            closing: estimate.gradient.dot(velocity),
            spring: Some(Spring::new(
                estimate.stiffness,
                estimate.damping,
                estimate.mass,
            )),
        };
        Some((reference, estimate))
    }
}

fn cosine(a: &V6, b: &V6) -> f64 {
    a.dot(b) / (a.norm() * b.norm()).max(f64::MIN_POSITIVE)
}
