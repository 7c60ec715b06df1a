//! The reference: the motion that the two spacecraft would have. Straight, through a spring and a damper,
//! straight.
//!
//! Along the direction of contact, from the onset on (Kelvin-Voigt model that never pulls):
//!
//! ```text
//! s(t) = V/ω_d e^(−ζωt) sin ω_d t   until k s + c s' = 0 at T = (π − 2 asin ζ)/ω_d, then −e V
//! e    = exp(−ζ/√(1−ζ²) (π − 2 asin ζ))
//! ```
//!
//! and across it straight on: Q(t) = Q₀ + V₀ t − d (V t − s(t)), where d is the direction into which
//! a force along the contact pushes, d · a = 1.

use super::V6;
use super::contact_estimator::Estimate;
use super::tuning::*;
use nalgebra::ComplexField;

/// A spring and a damper against the effective mass.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct KelvinVoigt {
    /// ω, ζ, ω_d; rad/s.
    omega: f64,
    pub(super) zeta: f64,
    damped: f64,
    /// T: duration of the contact, s.
    contact_s: f64,
    /// e.
    pub(super) restitution: f64,
    /// s at the end of the contact, in units of V, s.
    end: f64,
}

impl KelvinVoigt {
    /// From stiffness (N/m), damping (N·s/m) and effective mass (kg).
    pub(super) fn new(stiffness: f64, damping: f64, mass: f64) -> Self {
        let omega = ComplexField::sqrt((stiffness / mass).max(1e-6));
        let zeta = (damping / (2.0 * mass * omega)).clamp(0.0, DAMPING_RATIO_LIMIT);
        let root = ComplexField::sqrt(1.0 - zeta * zeta);
        let angle = core::f64::consts::PI - 2.0 * ComplexField::asin(zeta);
        let damped = omega * root;
        let contact_s = angle / damped;
        let restitution = ComplexField::exp(-zeta / root * angle);
        let decay = ComplexField::exp(-zeta * omega * contact_s);
        let end = decay * ComplexField::sin(angle) / damped;
        Self {
            omega,
            zeta,
            damped,
            contact_s,
            restitution,
            end,
        }
    }

    /// s and s' at `N` times from `t_s` on, `step_s` apart, for V = 1.
    fn sample<const N: usize>(&self, t_s: f64, step_s: f64) -> [(f64, f64); N] {
        let mut values = [(0.0, 0.0); N];
        // e^(−ζωt) (cos, sin)(ω_d t) of the next time within the contact.
        let mut wave: Option<(f64, f64)> = None;
        let turn = |t: f64| {
            let decay = ComplexField::exp(-self.zeta * self.omega * t);
            let angle = self.damped * t;
            (
                decay * ComplexField::cos(angle),
                decay * ComplexField::sin(angle),
            )
        };
        let (step_cos, step_sin) = turn(step_s);
        for (i, value) in values.iter_mut().enumerate() {
            let t = t_s + step_s * i as f64;
            *value = if t <= 0.0 {
                (t, 1.0)
            } else if t >= self.contact_s {
                let e = self.restitution;
                (self.end - e * (t - self.contact_s), -e)
            } else {
                let (cos, sin) = match wave {
                    Some((c, s)) => (c * step_cos - s * step_sin, s * step_cos + c * step_sin),
                    None => turn(t),
                };
                wave = Some((cos, sin));
                let s = sin / self.damped;
                (s, cos - self.zeta * self.omega * s)
            };
        }
        values
    }
}

/// The motion of the axes that is wanted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reference {
    /// Time of the onset, cycles; without a contact any time.
    pub(super) onset: f64,
    /// Position at that time and velocity before it.
    pub(super) position: V6,
    pub(super) velocity: V6,
    /// d: into which a force along the contact pushes; d · a = 1.
    pub(super) push: V6,
    /// V: closing velocity, m/s.
    pub(super) closing: f64,
    /// The contact; none: straight on.
    pub(super) contact: Option<KelvinVoigt>,
    /// What is pressed deeper than that.
    pub(super) preload: Preload,
}

/// A displacement into the contact beside the ideal motion. It is as it was commanded up to the time at which a
/// command of this cycle is executed; from then on it stays, or is taken back until the contact ends.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Preload {
    /// At that time, and a cycle before, two cycles ..., m.
    displacement: [f64; PRELOAD_HISTORY],
    /// That time, cycles.
    until: f64,
    /// When none of it is left, cycles; none: it stays.
    end: Option<f64>,
}

impl Preload {
    /// A cycle later, with a new move (m).
    pub(super) fn advance(&mut self, by: f64) {
        let next = self.at(self.until + 1.0) + by;
        self.displacement.rotate_right(1);
        self.displacement[0] = next;
    }

    /// At a time (cycles), m.
    fn at(&self, cycle: f64) -> f64 {
        let before = self.until - cycle;
        if before <= 0.0 {
            return self.displacement[0] * self.left(cycle);
        }
        let whole = ComplexField::floor(before);
        let of = |index: usize| self.displacement.get(index).copied().unwrap_or(0.0);
        let (later, earlier) = (of(whole as usize), of(whole as usize + 1));
        later + (earlier - later) * (before - whole)
    }

    /// Part of it that is left at a time, cycles.
    pub(super) fn left(&self, cycle: f64) -> f64 {
        let Some(end) = self.end.filter(|_| cycle > self.until) else {
            return 1.0;
        };
        if cycle < end {
            (end - cycle) / (end - self.until)
        } else {
            0.0
        }
    }
}

/// What the contact takes away of straight flight.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Deviation {
    /// V t − s(t), m.
    pub(super) displacement: f64,
    /// V − s'(t), m/s.
    pub(super) velocity: f64,
}

impl Reference {
    /// Straight on, from a position at a cycle.
    pub(super) fn straight(cycle: usize, position: V6, velocity: V6) -> Self {
        Self {
            onset: cycle as f64,
            position,
            velocity,
            push: V6::zeros(),
            closing: 0.0,
            contact: None,
            preload: Preload::default(),
        }
    }

    /// Into a contact that begins at a time (cycles) and position, with a velocity and closing velocity.
    pub(super) fn into_contact(
        estimate: &Estimate,
        (onset, position): (f64, V6),
        (velocity, closing): (V6, f64),
    ) -> Self {
        let (k, c, mass) = (estimate.stiffness, estimate.damping, estimate.mass);
        Self {
            onset,
            position,
            velocity,
            push: estimate.push,
            closing,
            contact: Some(KelvinVoigt::new(k, c, mass)),
            preload: Preload::default(),
        }
    }

    /// The same along the contact, but across its gradient a with the position and velocity of the model at a cycle.
    pub(super) fn across(
        mut self,
        gradient: &V6,
        cycle: f64,
        (position, velocity): (&V6, &V6),
        cycle_s: f64,
    ) -> Self {
        let t = (cycle - self.onset) * cycle_s;
        let across = |off: V6| off - self.push * gradient.dot(&off);
        let faster = across(velocity - self.velocity);
        let apart = across(position - (self.position + self.velocity * t));
        // Much more than the motion itself is an error of the gradient.
        if faster.norm() > SPEED_LIMIT * self.velocity.norm() {
            return self;
        }
        self.velocity += faster;
        self.position += apart - faster * t;
        self
    }

    /// The same with a preload that is executed up to a time, and taken back from then to another if there is one;
    /// cycles.
    pub(super) fn pressed(mut self, preload: &Preload, until: f64, end: Option<f64>) -> Self {
        self.preload = Preload {
            displacement: preload.displacement,
            until,
            end,
        };
        self
    }

    /// ζ of the contact.
    pub(super) fn damping_ratio(&self) -> f64 {
        self.contact.map_or(0.0, |contact| contact.zeta)
    }

    /// What the contact takes away at times from `cycle` on, one cycle apart.
    pub(super) fn deviations<const N: usize>(&self, cycle: f64, cycle_s: f64) -> [Deviation; N] {
        let Some(contact) = &self.contact else {
            return [Deviation::default(); N];
        };
        let begin = (cycle - self.onset) * cycle_s;
        let samples = contact.sample::<N>(begin, cycle_s);
        core::array::from_fn(|i| {
            let t = begin + cycle_s * i as f64;
            let (s, rate) = samples[i];
            Deviation {
                displacement: self.closing * (t - s) - self.preload.at(cycle + i as f64),
                velocity: self.closing * (1.0 - rate),
            }
        })
    }

    /// Position at a cycle.
    pub(super) fn position_at(&self, cycle: f64, cycle_s: f64) -> V6 {
        let [taken] = self.deviations::<1>(cycle, cycle_s);
        let straight = self.position + self.velocity * ((cycle - self.onset) * cycle_s);
        straight - self.push * taken.displacement
    }

    /// Restitution of the contact.
    pub(super) fn restitution(&self) -> f64 {
        self.contact.map_or(1.0, |contact| contact.restitution)
    }

    /// End of the contact, cycles.
    pub(super) fn end(&self, cycle_s: f64) -> f64 {
        self.onset + self.contact.map_or(0.0, |contact| contact.contact_s) / cycle_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::spacecraft::CYCLE_S;
    use softdock_delay_plants::truth::Bounce;

    #[test]
    fn restitution_and_duration_are_those_of_the_damped_contact() {
        let (mass, omega) = (500.0, 21.0);
        for zeta in [0.0, 0.1, 0.3, 0.5, 0.8] {
            let spring = KelvinVoigt::new(mass * omega * omega, 2.0 * zeta * mass * omega, mass);
            let bounce = Bounce::new(mass, mass * omega * omega, zeta, 0.005);
            assert!(
                (spring.restitution - bounce.restitution).abs() < 1e-12,
                "{zeta}"
            );
            assert!(
                (spring.contact_s - bounce.contact_s).abs() < 1e-12,
                "{zeta}"
            );
        }
    }

    /// The recursion gives the motion: its end is the rebound, and s' is the derivative of s.
    #[test]
    fn the_motion_is_consistent() {
        let spring = KelvinVoigt::new(220_500.0, 6300.0, 500.0);
        let step = 1e-4;
        let samples = spring.sample::<2000>(-0.003, step);
        for pair in samples.windows(2) {
            let [(s0, v0), (s1, v1)] = [pair[0], pair[1]];
            let slope = (s1 - s0) / step;
            assert!((slope - 0.5 * (v0 + v1)).abs() < 0.3 * step / 1e-4 * 0.02);
        }
        assert!((samples[1999].1 + spring.restitution).abs() < 1e-12);
    }

    /// A contact along an oblique direction, from cycle 100.5 on: a · d is 1.
    fn oblique(zeta: f64) -> (Reference, V6) {
        let (mass, omega) = (500.0, 21.0);
        let mut estimate = Estimate::exact(mass * omega * omega, 2.0 * zeta * mass * omega, mass);
        estimate.gradient = V6::new(0.8, -0.6, 0.1, 0.0, 0.2, -0.1);
        let push = V6::new(0.7, -0.6, 0.3, 0.2, 0.1, -0.3);
        estimate.push = push / push.dot(&estimate.gradient);
        let velocity = V6::new(0.006, -0.002, 0.001, 0.003, -0.001, 0.002);
        let closing = estimate.gradient.dot(&velocity);
        let position = V6::new(0.1, 0.2, -0.3, 0.4, 0.5, -0.6);
        let reference = Reference::into_contact(&estimate, (100.5, position), (velocity, closing));
        (reference, estimate.gradient)
    }

    /// Before the contact, in it and after it: along its gradient that of the bounce, across straight on.
    #[test]
    fn the_motion_is_that_of_a_mass_at_a_spring() {
        let (reference, gradient) = oblique(0.0);
        let (closing, omega) = (reference.closing, 21.0);
        let contact = core::f64::consts::PI / omega;
        assert!((reference.end(CYCLE_S) - 100.5 - contact / CYCLE_S).abs() < 1e-9);
        assert_eq!(
            (reference.damping_ratio(), reference.restitution()),
            (0.0, 1.0)
        );
        let taken: [Deviation; 80] = reference.deviations(80.25, CYCLE_S);
        for (n, taken) in taken.iter().enumerate() {
            let cycle = 80.25 + n as f64;
            let t = (cycle - 100.5) * CYCLE_S;
            let (way, rate) = match t {
                _ if t < 0.0 => (t, 1.0),
                _ if t > contact => (contact - t, -1.0),
                _ => ((omega * t).sin() / omega, (omega * t).cos()),
            };
            assert!(
                (taken.displacement - closing * (t - way)).abs() < 1e-12,
                "{cycle}"
            );
            assert!(
                (taken.velocity - closing * (1.0 - rate)).abs() < 1e-12,
                "{cycle}"
            );
            let found = reference.position_at(cycle, CYCLE_S) - reference.position;
            assert!(
                (gradient.dot(&found) - closing * way).abs() < 1e-12,
                "{cycle}"
            );
            let across = found - reference.velocity * t;
            let along = reference.push * gradient.dot(&across);
            assert!((across - along).amax() < 1e-12, "{cycle}");
        }
    }

    #[test]
    fn straight_flight_has_neither_end_nor_damping() {
        let straight = Reference::straight(7, V6::repeat(0.2), V6::repeat(0.01));
        assert_eq!(straight.end(CYCLE_S), 7.0);
        assert_eq!(
            (straight.damping_ratio(), straight.restitution()),
            (0.0, 1.0)
        );
        let later = straight.position_at(12.0, CYCLE_S);
        assert!((later - V6::repeat(0.2 + 0.01 * 5.0 * CYCLE_S)).amax() < 1e-15);
        assert!((oblique(0.3).0.damping_ratio() - 0.3).abs() < 1e-12);
    }

    /// Moves of 1, 2 ... 40 mm, each executed a cycle after the one before: in between it goes straight.
    #[test]
    fn a_preload_is_the_sum_of_its_moves() {
        let mut preload = Preload::default();
        for n in 0..40 {
            let (reference, _) = oblique(0.0);
            preload = reference.pressed(&preload, f64::from(n), None).preload;
            preload.advance(1e-3 * f64::from(n + 1));
        }
        let (reference, _) = oblique(0.0);
        let pressed = reference.pressed(&preload, 40.0, None);
        let sum = |n: i32| 0.5e-3 * f64::from(n * (n + 1));
        for n in 18..40 {
            for part in [0.0, 0.25, 0.5] {
                let cycle = f64::from(n) + part;
                let expected = sum(n) + (sum(n + 1) - sum(n)) * part;
                assert!(
                    (pressed.preload.at(cycle) - expected).abs() < 1e-12,
                    "{cycle}"
                );
                // Deeper than the bounce by it.
                let with: [Deviation; 4] = pressed.deviations(cycle - 3.0, CYCLE_S);
                let without: [Deviation; 4] = reference.deviations(cycle - 3.0, CYCLE_S);
                let deeper = without[3].displacement - with[3].displacement;
                assert!((deeper - expected).abs() < 1e-12, "{cycle}");
            }
        }
        // From then on it stays, and what is long past counts no more.
        for (cycle, expected) in [
            (40.0, sum(40)),
            (41.3, sum(40)),
            (90.0, sum(40)),
            (10.0, 0.0),
        ] {
            assert!(
                (pressed.preload.at(cycle) - expected).abs() < 1e-12,
                "{cycle}"
            );
        }
    }

    /// Executed up to cycle 20, and none of it is left at 30.
    #[test]
    fn a_preload_is_taken_back_straight_until_its_end() {
        let mut preload = Preload::default();
        for _ in 0..2 {
            preload.advance(1e-3);
        }
        let (reference, _) = oblique(0.0);
        preload = reference.pressed(&preload, 20.0, Some(30.0)).preload;
        for (cycle, expected) in [
            (19.0, 1.0),
            (19.5, 1.5),
            (20.0, 2.0),
            (20.5, 1.9),
            (25.0, 1.0),
            (29.0, 0.2),
            (30.0, 0.0),
            (99.0, 0.0),
        ] {
            let found = preload.at(cycle) * 1e3;
            assert!((found - expected).abs() < 1e-12, "{cycle}: {found}");
        }
        // A new move is added to what is left by then.
        preload.advance(1e-3);
        assert!((preload.displacement[0] - 2.8e-3).abs() < 1e-15);
    }

    #[test]
    fn across_the_contact_it_goes_as_the_model_and_along_it_as_before() {
        let (reference, gradient) = oblique(0.1);
        let position = reference.position + V6::new(1.0, 2.0, -1.0, 0.5, -2.0, 1.5) * 1e-4;
        let velocity = reference.velocity * 0.7 + V6::new(0.0, 1.0, 0.5, 0.0, -1.0, 0.3) * 1e-3;
        let cycle = 110.0;
        let turned = reference.across(&gradient, cycle, (&position, &velocity), CYCLE_S);
        for n in [100.0, 110.0, 125.0] {
            let apart = turned.position_at(n, CYCLE_S) - reference.position_at(n, CYCLE_S);
            assert!(gradient.dot(&apart).abs() < 1e-12, "{n}");
        }
        // Straight flight of both meets in that cycle, but for the push.
        let straight =
            |of: &Reference, n: f64| of.position + of.velocity * ((n - of.onset) * CYCLE_S);
        for n in [110.0, 118.0] {
            let off = straight(&turned, n) - (position + velocity * ((n - cycle) * CYCLE_S));
            let along = reference.push * gradient.dot(&off);
            assert!((off - along).amax() < 1e-12, "{n}: {off}");
        }
    }

    /// Four times the velocity before the contact.
    #[test]
    fn what_moves_much_faster_across_than_it_came_is_not_followed() {
        let (reference, gradient) = oblique(0.0);
        let off = V6::new(0.0, 0.0, 1.0, 0.0, 0.0, 0.0);
        let across = off - reference.push * gradient.dot(&off);
        let most = SPEED_LIMIT * reference.velocity.norm() / across.norm();
        for (size, followed) in [(0.99 * most, true), (1.01 * most, false)] {
            let velocity = reference.velocity + across * size;
            let motion = (&reference.position, &velocity);
            let turned = reference.across(&gradient, 100.5, motion, CYCLE_S);
            assert_eq!(turned.velocity != reference.velocity, followed, "{size}");
        }
    }
}
