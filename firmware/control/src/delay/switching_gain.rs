//! Force lead with a gain that an energy observer switches.
//!
//! ```text
//! F = F_meas + K τ Ḟ         Ḟ from a tracking differentiator
//! E = Σ F (v_model − v_exec) Ts
//! K = K₀ + γ max(E, 0)/E₀ unless the loop has lost energy (E < −E₀/100), then 0
//! ```
//!
//! "Stability Analysis and Delay Compensation for Space Instable Target Simulator", Actuators 13 (2024) 123: a switching
//! compensator with variable gain, made of an energy observer and a tracking differentiator, against a fixed and a
//! linear gain. Only the abstract was at hand. It leaves open:
//! - what the gain multiplies: here the rate of the force times the delay, as in the force leads that it is compared with;
//! - the energy that is observed: here the energy that the model takes from the contact beyond the work on the robot, over E₀,
//!   the energy of the approach; and the law from energy to gain: here linear, with the gain zero where more than a hundredth of
//!   E₀ was lost, as the sign of E at the beginning of a contact is one of rounding;
//! - the differentiator: here Han's, with the time-optimal feedback of a double integrator,
//!   Han, "From PID to active disturbance rejection control", IEEE Trans. Ind. Electron. 56 (2009) 900;
//! - the numbers K₀, γ, and those of the differentiator.

use super::contact::{ContactLine, LATENCIES};
use super::status::LawStatus;
use super::{DelaySettings, LawInput};
use crate::frames::Wrench;
use crate::scalar::Scalar;
use nalgebra::ComplexField;

/// −E/E₀ that counts as energy lost.
const LEAST_SHARE: f64 = 0.01;
/// Largest gain, and largest force that the lead adds, N.
const LARGEST_GAIN: f64 = 5.0;
const LARGEST_N: f64 = 1e5;

crate::described! {
/// Settings of the switched force lead.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct SwitchingGainSettings: "delay.switching_gain" {
    /// K₀: gain where no energy was lost; 1 leads by the delay.
    pub gain: f64 = 1.0 => 0.0..=LARGEST_GAIN,
    /// γ: gain more for energy as large as that of the approach.
    pub gain_by_energy: f64 = 0.5 => 0.0..=100.0,
    /// Largest second derivative of the force that the differentiator follows, N/s².
    pub acceleration_n_per_s2: f64 = 1e6 => 1.0..=1e10,
    /// Filter of the differentiator, cycles.
    pub filter_cycles: f64 = 1.0 => 1.0..=50.0,
    /// Force from which a contact counts, N: beyond the sensor's noise.
    pub threshold_n: f64 = 1.0 => 0.01..=1e3,
}
}

/// The law and its contact. It computes in f64 whatever the scalar type of the cycle is.
#[derive(Clone, Debug)]
pub struct SwitchingGain<S: Scalar> {
    settings: SwitchingGainSettings,
    line: ContactLine<S>,
    cycle_s: f64,
    delay_s: f64,
    /// Force as tracked, N, and its rate, N/s.
    tracked: f64,
    rate: f64,
    /// E and E₀, J.
    made: f64,
    brought: f64,
    /// Latency of the pose, cycles, and the energy that the model took in each of the last cycles, J, newest first.
    latency: usize,
    taken: [f64; LATENCIES],
}

impl<S: Scalar> SwitchingGain<S> {
    /// No contact yet; `cycle_s` in s.
    pub fn new(settings: &DelaySettings, cycle_s: f64) -> Self {
        let own = settings.switching_gain;
        Self {
            settings: own,
            line: ContactLine::new(own.threshold_n, &settings.actuator),
            cycle_s,
            delay_s: settings.horizon_s(cycle_s),
            tracked: 0.0,
            rate: 0.0,
            made: 0.0,
            brought: 0.0,
            latency: settings.actuator.feedback_latency_cycles.into(),
            taken: [0.0; LATENCIES],
        }
    }

    /// The measured wrench, led along the contact.
    pub fn condition(&mut self, input: &LawInput<'_, S>) -> Wrench<S> {
        let measured = *input.wrench;
        let Some(along) = self.line.update(input) else {
            return measured;
        };
        self.line.close_when_quiet();
        let (load, velocity) = (along.load.get(), along.velocity.get());
        if along.opened {
            (self.tracked, self.rate, self.made) = (0.0, 0.0, 0.0);
            self.taken = [0.0; LATENCIES];
            self.brought = 0.5 * velocity * velocity / along.mobility.get().max(1e-8);
        }
        self.track(load);
        // The work on the robot is that at the time of its reported pose, so the model's part is delayed alike.
        self.taken.rotate_right(1);
        self.taken[0] = load * velocity * self.cycle_s;
        let taken = self.taken[self.latency.min(LATENCIES - 1)];
        self.made += taken - along.load_then.get() * along.moved.get();
        let lead = self.gain() * self.delay_s * self.rate;
        // The contact never pulls.
        let lead = lead.clamp(-load.max(0.0), LARGEST_N);
        measured + self.line.wrench(S::of(lead))
    }

    /// K.
    fn gain(&self) -> f64 {
        let share = self.made / self.brought.max(f64::MIN_POSITIVE);
        if share < -LEAST_SHARE {
            return 0.0;
        }
        let gain = self.settings.gain + self.settings.gain_by_energy * share.max(0.0);
        gain.min(LARGEST_GAIN)
    }

    /// A step of the tracking differentiator.
    fn track(&mut self, load: f64) {
        let (r, h) = (
            self.settings.acceleration_n_per_s2,
            self.settings.filter_cycles * self.cycle_s,
        );
        let feedback = time_optimal(self.tracked - load, self.rate, r, h);
        self.tracked += self.rate * self.cycle_s;
        self.rate += feedback * self.cycle_s;
    }

    /// Status: the delay as set, and whether a contact is open.
    pub fn status(&self) -> LawStatus {
        LawStatus {
            delay_s: self.delay_s,
            ..self.line.status()
        }
    }
}

/// Han's fhan(x₁, x₂, r, h): the acceleration, at most r, that brings a double integrator to rest at zero in the least time
/// without overshoot.
fn time_optimal(x1: f64, x2: f64, r: f64, h: f64) -> f64 {
    let d = r * h * h;
    let a0 = h * x2;
    let y = x1 + a0;
    let sign = |v: f64| if v >= 0.0 { 1.0 } else { -1.0 };
    let a1 = ComplexField::sqrt(d * (d + 8.0 * y.abs()));
    let a = if y.abs() <= d {
        a0 + y
    } else {
        a0 + sign(y) * (a1 - d) * 0.5
    };
    if a.abs() <= d {
        -r * a / d
    } else {
        -r * sign(a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::spacecraft::{CYCLE_S, Spacecraft};
    use crate::delay::status::LawFlags;
    use crate::frames::Twist;

    /// The rate of a sine is found half a cycle late.
    #[test]
    fn the_differentiator_finds_a_rate() {
        let mut law = SwitchingGain::<f64>::new(&DelaySettings::default(), 0.004);
        let omega = 21.0;
        for n in 0..200 {
            law.track(50.0 * ComplexField::sin(omega * 0.004 * f64::from(n)));
            let late = 0.004 * (f64::from(n) - 0.5);
            let rate = 50.0 * omega * ComplexField::cos(omega * late);
            if n > 20 {
                assert!((law.rate - rate).abs() < 0.01 * 50.0 * omega, "{n}");
            }
        }
    }

    /// Steps until a double integrator rests at zero, and how far it goes beyond it.
    fn brought_to_rest(x1: f64, x2: f64, r: f64, h: f64) -> (usize, f64) {
        let (mut x, mut v, mut steps, mut beyond) = (x1, x2, 0, 0.0_f64);
        while (x.abs() > 1e-9 || v.abs() > 1e-9) && steps < 10_000 {
            let a = time_optimal(x, v, r, h);
            assert!(a.abs() <= r * (1.0 + 1e-12));
            (x, v) = (x + h * v, v + h * a);
            beyond = beyond.max(-x * x1.signum());
            steps += 1;
        }
        (steps, beyond)
    }

    /// From rest it takes 2 √(x/r): half of the way with each sign of the acceleration.
    #[test]
    fn a_double_integrator_comes_to_rest_in_the_shortest_time_without_overshoot() {
        let (r, h) = (100.0, 0.01);
        for x in [0.5, -0.5, 3.0, 20.0, -20.0] {
            let (steps, beyond) = brought_to_rest(x, 0.0, r, h);
            let shortest = 2.0 * f64::sqrt(f64::abs(x) / r) / h;
            let late = steps as f64 - shortest;
            assert!((0.0..=3.5).contains(&late), "{x}: {steps} {shortest}");
            // At most a fifth of what it moves in a step.
            assert!(beyond < 0.2 * r * h * h, "{x}: {beyond}");
        }
        // If it moves away it first stops, which takes v/r, and then goes back.
        let (steps, _) = brought_to_rest(1.0, 2.0, r, h);
        let shortest = (2.0 / r + 2.0 * f64::sqrt((1.0 + 0.5 * 4.0 / r) / r)) / h;
        assert!(
            (0.0..=3.5).contains(&(steps as f64 - shortest)),
            "{steps} {shortest}"
        );
    }

    /// So near that less than the largest acceleration is enough.
    #[test]
    fn near_its_goal_a_double_integrator_is_there_in_two_steps() {
        for (x, v) in [(1e-3, 0.0), (-2e-3, 0.1), (0.0, 0.2), (4e-3, -0.3)] {
            assert_eq!(brought_to_rest(x, v, 100.0, 0.01).0, 2, "{x} {v}");
        }
    }

    /// The gain depends on the energy relative to that of the approach: zero if a hundredth was lost, larger the more was
    /// generated, five at most.
    #[test]
    fn the_gain_is_switched_by_the_energy() {
        let mut law = SwitchingGain::<f64>::new(&DelaySettings::default(), CYCLE_S);
        law.brought = 2.0;
        for (made, gain) in [
            (-0.021, 0.0),
            (-0.019, 1.0),
            (0.0, 1.0),
            (1.0, 1.25),
            (4.0, 2.0),
            (100.0, 5.0),
        ] {
            law.made = made;
            assert!((law.gain() - gain).abs() < 1e-12, "{made}");
        }
        (law.made, law.brought) = (0.0, 0.0);
        assert_eq!(law.gain(), 1.0);
    }

    /// A cycle with K of 500 kg at this velocity away from a wall (m/s), at a position that has changed by this since the last
    /// cycle (m), with a load along x (N). Returns what is felt.
    fn cycle(
        law: &mut SwitchingGain<f64>,
        x: &mut f64,
        (load, velocity, moved): (f64, f64, f64),
    ) -> f64 {
        let mut spacecraft = Spacecraft::before_a_wall([0.0; 3]);
        *x += moved;
        spacecraft.measured.translation.x = *x;
        let wrench = Wrench::of(&[load, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let model = Twist::of(&[velocity, 0.0, 0.0, 0.0, 0.0, 0.0]);
        law.condition(&spacecraft.asked(&wrench, model)).force.x
    }

    /// F v Ts less F times what the robot has moved; E₀ is ½ m v².
    #[test]
    fn the_energy_is_what_the_model_takes_beyond_what_the_robot_was_paid() {
        let mut law = SwitchingGain::new(&DelaySettings::default(), CYCLE_S);
        let mut x = 0.0;
        assert_eq!(cycle(&mut law, &mut x, (0.5, -0.01, 0.0)), 0.5);
        assert!(!law.status().flags.has(LawFlags::CONTACT));
        let mut made = 0.0;
        for n in 0..5 {
            let (load, velocity, moved) =
                (10.0 + f64::from(n), -0.01 + 0.003 * f64::from(n), -3e-5);
            cycle(&mut law, &mut x, (load, velocity, moved));
            made += load * velocity * CYCLE_S - load * moved;
            assert!((law.made - made).abs() < 1e-12, "{n}: {} {made}", law.made);
            assert!((law.brought - 0.5 * 500.0 * 1e-4).abs() < 1e-9);
        }
        assert!(law.status().flags.has(LawFlags::CONTACT));
        assert!((law.status().delay_s - 0.034).abs() < 1e-12);
        // The next contact begins anew.
        for _ in 0..10 {
            cycle(&mut law, &mut x, (0.0, 0.01, 0.0));
        }
        cycle(&mut law, &mut x, (10.0, -0.02, 0.0));
        assert!((law.made + 10.0 * 0.02 * CYCLE_S).abs() < 1e-12);
        assert!((law.brought - 0.5 * 500.0 * 4e-4).abs() < 1e-9);
    }

    /// A robot that follows the model at once and reports its pose four cycles late generates no energy.
    #[test]
    fn a_late_pose_makes_no_energy() {
        let mut settings = DelaySettings::default();
        settings.actuator.feedback_latency_cycles = 4;
        let mut law = SwitchingGain::new(&settings, CYCLE_S);
        let (mut x, velocity) = (0.0, -0.01);
        for n in 0..20 {
            cycle(&mut law, &mut x, (10.0, velocity, velocity * CYCLE_S));
            assert!(law.made.abs() < 1e-12, "{n}: {}", law.made);
        }
    }

    /// A load that grows by 2 N per cycle is felt as it will be 34 ms later; it never pulls.
    #[test]
    fn the_load_is_led_by_the_delay() {
        let mut law = SwitchingGain::new(&DelaySettings::default(), CYCLE_S);
        let (mut x, mut felt) = (0.0, 0.0);
        for n in 0..60 {
            let load = 2.0 * f64::from(n + 1);
            // The energy that the model takes equals the work on the robot: none is generated.
            felt = cycle(&mut law, &mut x, (load, -0.01, -4e-5));
        }
        let later = 120.0 + 2.0 * 0.034 / CYCLE_S;
        assert!((felt / later - 1.0).abs() < 1e-3, "{felt} {later}");
        let mut least = f64::MAX;
        for n in 0..20 {
            let load = 120.0 - 40.0 * f64::from(n);
            least = least.min(cycle(&mut law, &mut x, (load.max(2.0), -0.01, -4e-5)));
        }
        assert_eq!(least, 0.0);
    }
}
