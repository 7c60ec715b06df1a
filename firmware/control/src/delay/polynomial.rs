//! Polynomial extrapolation: a polynomial through the present and n earlier positions, spaced by the delay, is extrapolated by
//! one delay.
//!
//! ```text
//! x_cmd = Σ_{i=0..n} a_i x(t − i τ)      n = 3: 4, −6, 4, −1      n = 2: 3, −3, 1
//! ```
//!
//! Horiuchi, Inoue, Konno and Namita, "Real-time hybrid experimental system with actuator delay
//! compensation", Earthquake Engng Struct. Dyn. 28 (1999) 1121. It needs neither acceleration nor measured motion. The law is
//! linear and its weights add up to 1, so that the same weighted sum of velocities commands the same motion without a reference
//! position. Before the start the spacecraft is taken to have flown with its first velocity. τ is any real number of cycles:
//! between two cycles the velocity is interpolated, which is exact for the position if a velocity is held over a cycle.

use super::axes::{components, saturated, twist};
use super::{DelaySettings, LawOutput};
use crate::frames::Twist;
use crate::scalar::Scalar;

/// Cycles that are remembered: enough for a delay of 42 cycles or 0.17 s with n = 3, beyond what the law could make stable. A
/// longer delay is compensated as if it were the longest one.
const MEMORY: usize = 128;

crate::described! {
/// Settings of the polynomial extrapolation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct PolynomialSettings: "delay.polynomial" {
    /// Degree of the polynomial, 2 or 3.
    pub order: u8 = 3 => 2.0..=3.0,
    /// Added to the believed delay, s: negative leads less.
    pub extra_s: f64 = 0.0 => -0.05..=0.05,
}
}

/// The law on six components.
#[derive(Clone, Debug)]
pub struct Polynomial<S: Scalar> {
    weights: &'static [f64],
    /// How long ago each point is: whole cycles, and the fraction of a cycle.
    points: [(usize, S); 3],
    /// Velocities of the last cycles, a ring.
    past: [[S; 6]; MEMORY],
    newest: usize,
    started: bool,
}

impl<S: Scalar> Polynomial<S> {
    /// The initial state; `cycle_s` in s.
    pub fn new(settings: &DelaySettings, cycle_s: f64) -> Self {
        let own = &settings.polynomial;
        let longest = (MEMORY - 2) as f64 / f64::from(own.order.max(1));
        let wanted = (settings.horizon_s(cycle_s) + own.extra_s) / cycle_s;
        let cycles = wanted.clamp(0.0, longest);
        let point = |i: f64| {
            let back = (i * cycles).min((MEMORY - 2) as f64);
            let whole = back as usize;
            (whole, S::of(back - whole as f64))
        };
        Self {
            weights: match own.order {
                2 => &[-3.0, 1.0],
                _ => &[-6.0, 4.0, -1.0],
            },
            points: [1.0, 2.0, 3.0].map(point),
            past: [[S::zero(); 6]; MEMORY],
            newest: 0,
            started: false,
        }
    }

    /// One cycle: m/s and rad/s in and out. Part i is a_i (v(t − i τ) − v(t)).
    pub fn step(&mut self, model: &Twist<S>) -> LawOutput<S> {
        let now = components(model);
        self.remember(now);
        let mut output = LawOutput::of(*model);
        let mut command = now;
        let terms = self.weights.iter().zip(&self.points);
        for ((weight, point), part) in terms.zip(&mut output.parts) {
            let past = self.at(point);
            let added = core::array::from_fn(|i| saturated(S::of(*weight) * (past[i] - now[i])));
            command = core::array::from_fn(|i| command[i] + added[i]);
            *part = twist(added);
        }
        output.command = twist(command.map(saturated));
        output
    }

    fn remember(&mut self, now: [S; 6]) {
        if !self.started {
            self.started = true;
            self.past = [now; MEMORY];
        }
        self.newest = (self.newest + 1) % MEMORY;
        self.past[self.newest] = now;
    }

    /// The velocity at a point of the past, interpolated between two cycles.
    fn at(&self, (whole, rest): &(usize, S)) -> [S; 6] {
        let back = |cycles: usize| &self.past[(self.newest + MEMORY - cycles) % MEMORY];
        let (later, earlier) = (back(*whole), back(whole + 1));
        core::array::from_fn(|i| later[i] + (earlier[i] - later[i]) * *rest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::ModelVelocity;
    use crate::scalar::Fixed;

    /// A velocity that is a polynomial of the law's own degree is continued exactly.
    fn continues<S: Scalar>(order: u8, delay_s: f64, tolerance: f64) {
        let ts = 0.004;
        let mut settings = DelaySettings {
            model_velocity: ModelVelocity::End,
            ..DelaySettings::default()
        };
        settings.polynomial.order = order;
        // A part of the delay is given as `extra_s`.
        (settings.actuator.delay_s, settings.polynomial.extra_s) = (delay_s - 0.008, 0.008);
        let mut law = Polynomial::<S>::new(&settings, ts);
        let cubic = f64::from(order) - 2.0;
        let v = |t: f64| 0.003 - 0.02 * t + 0.05 * t * t + cubic * 0.1 * t * t * t;
        for n in 0..150 {
            let t = f64::from(n) * ts;
            let got = law.step(&Twist::of(&[v(t), 0.0, 0.0, 0.0, 0.0, -v(t)]));
            if f64::from(n) * ts > 3.0 * delay_s + ts {
                let (x, c) = (got.command.linear.x.get(), got.command.angular.z.get());
                let wanted = v(t + delay_s);
                assert!((x - wanted).abs() < tolerance, "{order} {n}: {x} {wanted}");
                assert!((c + wanted).abs() < tolerance);
            }
        }
    }

    #[test]
    fn a_polynomial_is_continued() {
        for order in [2, 3] {
            continues::<f64>(order, 0.032, 1e-12);
            continues::<f32>(order, 0.032, 1e-6);
            continues::<Fixed>(order, 0.032, 1e-8);
            // Between two cycles: the error of the interpolation, a Ts² v''/8 for each point.
            continues::<f64>(order, 0.0333, 1e-4);
        }
    }

    #[test]
    fn a_start_with_full_speed_is_no_jump() {
        let mut law = Polynomial::<f64>::new(&DelaySettings::default(), 0.004);
        let model = Twist::of(&[0.005, 0.0, 0.0, 0.01, 0.0, 0.0]);
        for _ in 0..200 {
            assert_eq!(law.step(&model).command, model);
        }
    }

    /// A delay beyond the memory is compensated as if it were the longest one that is remembered.
    #[test]
    fn a_delay_beyond_the_memory_is_led_by_what_is_remembered() {
        let command = |delay_s: f64| {
            let mut settings = DelaySettings::default();
            settings.actuator.delay_s = delay_s;
            let mut law = Polynomial::<f64>::new(&settings, 0.004);
            let mut last = 0.0;
            for n in 0..200 {
                let model = Twist::of(&[1e-5 * f64::from(n), 0.0, 0.0, 0.0, 0.0, 0.0]);
                last = law.step(&model).command.linear.x;
            }
            last
        };
        let (longest, longer) = (command(0.166), command(0.2));
        assert!((longest - 1e-5 * 241.0).abs() < 1e-9, "{longest}");
        assert_eq!(longest, longer);
    }

    /// v(t + τ) = 3 v(t) − 3 v(t − τ) + v(t − 2 τ); for a cubic c t³ that is 6 c τ³ too little.
    #[test]
    fn a_parabola_is_laid_through_three_points() {
        let mut settings = DelaySettings {
            model_velocity: ModelVelocity::End,
            ..DelaySettings::default()
        };
        settings.polynomial.order = 2;
        let mut law = Polynomial::<f64>::new(&settings, 0.004);
        let v = |t: f64| 0.5 * t * t * t;
        for n in 0..60 {
            let t = f64::from(n) * 0.004;
            let found = law.step(&Twist::of(&[v(t); 6])).command.linear.x;
            let expected = v(t + 0.032) - 6.0 * 0.5 * 0.032_f64.powi(3);
            assert!(
                n < 20 || (found - expected).abs() < 1e-12,
                "{n}: {found} {expected}"
            );
        }
    }
}
