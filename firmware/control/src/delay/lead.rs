//! Second-order lead: the model's motion is continued over the delay with its present acceleration.
//!
//! ```text
//! x_cmd = x + τ v + ½ τ² a          sent as a velocity:  v_cmd = v + τ v' + ½ τ² v''
//! ```
//!
//! Horiuchi and Konno, "A new method for compensating actuator delay in real-time hybrid
//! experiments", Phil. Trans. R. Soc. A 359 (2001) 1893. τ is the horizon: the robot's mean delay,
//! see [`super::DelaySettings::horizon_s`].
//!
//! How the derivatives are taken: v' is the change of the model's velocity in a cycle. With the model's own integration that is
//! its force over its mass, and needs no measured motion. The difference is the derivative at the middle of the cycle, half a
//! cycle ago; v'' extrapolates it over that half cycle, and over the delay of the low-pass. The velocity form drops only a
//! constant of integration, so that the law cannot jump at its start; a displacement that a limit clamps is not recovered.
//!
//! v'' multiplies noise of the force by ½ (τ/Ts)², which is 32 for eight cycles. The low-pass reduces the noise and costs
//! accuracy.

use super::axes::{components, saturated, twist};
use super::{DelaySettings, LawOutput};
use crate::frames::Twist;
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

crate::described! {
/// Settings of the second-order lead.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct LeadSettings {
    /// Low-pass of first order on the acceleration, Hz; 0 is none. From 10 Hz on.
    pub low_pass_hz: f64,
    /// Added to the believed delay, s: negative leads less.
    pub extra_s: f64,
}
}

impl LeadSettings {
    /// Checks every field.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let lowest = if self.low_pass_hz > 0.0 { 10.0 } else { 0.0 };
        in_range("delay.lead.low_pass_hz", self.low_pass_hz, lowest, 500.0)?;
        in_range("delay.lead.extra_s", self.extra_s, -0.05, 0.05)
    }
}

/// The law on six components.
#[derive(Clone, Debug)]
pub struct Lead<S: Scalar> {
    weights: Weights<S>,
    axes: [Axis<S>; 6],
}

/// Factors of the first and second difference, and gain of the low-pass.
#[derive(Clone, Copy, Debug)]
struct Weights<S> {
    slope: S,
    curvature: S,
    gain: S,
}

/// One component.
#[derive(Clone, Copy, Debug)]
struct Axis<S> {
    /// Velocity of the last cycle; none before the first.
    last: Option<S>,
    /// Filtered change of the velocity in a cycle.
    slope: S,
}

impl<S: Scalar> Lead<S> {
    /// The initial state; `cycle_s` in s.
    pub fn new(settings: &DelaySettings, cycle_s: f64) -> Self {
        let horizon_s = settings.horizon_s(cycle_s) + settings.lead.extra_s;
        let cycles = horizon_s.max(0.0) / cycle_s;
        let gain = match settings.lead.low_pass_hz {
            hz if hz > 0.0 => {
                1.0 - nalgebra::ComplexField::exp(-core::f64::consts::TAU * hz * cycle_s)
            }
            _ => 1.0,
        };
        // Delay of the first difference: half a cycle, and that of the low-pass for a ramp.
        let late = 0.5 + (1.0 - gain) / gain;
        Self {
            weights: Weights {
                slope: S::of(cycles),
                curvature: S::of(0.5 * cycles * cycles + cycles * late),
                gain: S::of(gain),
            },
            axes: [Axis {
                last: None,
                slope: S::zero(),
            }; 6],
        }
    }

    /// One cycle: m/s and rad/s in and out. Parts: τ v', then the term of v''.
    pub fn step(&mut self, model: &Twist<S>) -> LawOutput<S> {
        let mut parts = [[S::zero(); 6]; 2];
        let mut command = components(model);
        for (i, (axis, v)) in self.axes.iter_mut().zip(&mut command).enumerate() {
            let [first, second] = axis.step(*v, &self.weights);
            (parts[0][i], parts[1][i]) = (first, second);
            *v = saturated(*v + first + second);
        }
        let mut output = LawOutput::of(twist(command));
        (output.parts[0], output.parts[1]) = (twist(parts[0]), twist(parts[1]));
        output
    }
}

impl<S: Scalar> Axis<S> {
    fn step(&mut self, v: S, weights: &Weights<S>) -> [S; 2] {
        let change = v - self.last.unwrap_or(v);
        self.last = Some(v);
        let before = self.slope;
        self.slope = before + (change - before) * weights.gain;
        let curvature = self.slope - before;
        [self.slope * weights.slope, curvature * weights.curvature].map(saturated)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Fixed;

    /// v = b t + c t² is extrapolated exactly by τ, whatever the low-pass, once that has settled.
    fn continues<S: Scalar>(low_pass_hz: f64, extra_s: f64, tolerance: f64) {
        let (ts, tau) = (0.004, 0.034 + extra_s);
        let mut settings = DelaySettings::default();
        (settings.lead.low_pass_hz, settings.lead.extra_s) = (low_pass_hz, extra_s);
        let mut law = Lead::<S>::new(&settings, ts);
        let v = |t: f64| 0.002 * t + if low_pass_hz > 0.0 { 0.0 } else { 0.03 * t * t };
        for n in 0..200 {
            let t = f64::from(n) * ts;
            let model = Twist::of(&[v(t), 0.0, -v(t), 0.0, 0.5 * v(t), 0.0]);
            let got = law.step(&model).command.get();
            // The first difference exists from the second cycle on, the second one a cycle later.
            if n > if low_pass_hz > 0.0 { 100 } else { 1 } {
                let wanted = v(t + tau);
                assert!((got[0] - wanted).abs() < tolerance, "{n}: {got:?} {wanted}");
                assert!((got[4] - 0.5 * wanted).abs() < tolerance);
                assert!((got[2] + wanted).abs() < tolerance);
            }
        }
    }

    #[test]
    fn a_parabola_of_velocity_is_continued() {
        // v'' from differences is that of one cycle ago, which is the same for a parabola.
        continues::<f64>(0.0, 0.0, 1e-12);
        continues::<f32>(0.0, 0.0, 2e-6);
        continues::<Fixed>(0.0, 0.0, 1e-7);
        continues::<f64>(20.0, 0.0, 1e-9);
        continues::<f64>(0.0, 0.01, 1e-12);
        continues::<f64>(0.0, -0.034, 1e-12);
    }

    #[test]
    fn a_start_with_full_speed_is_no_jump() {
        let mut law = Lead::<f64>::new(&DelaySettings::default(), 0.004);
        let model = Twist::of(&[0.005, 0.0, 0.0, 0.01, 0.0, 0.0]);
        assert_eq!(law.step(&model).command, model);
        assert_eq!(law.step(&model).command, model);
    }

    #[test]
    fn what_runs_away_saturates() {
        let mut law = Lead::<Fixed>::new(&DelaySettings::default(), 0.004);
        for n in 0..20 {
            let v = if n % 2 == 0 { 1e9 } else { -1e9 };
            let got = law.step(&Twist::of(&[v; 6])).command.get();
            assert!(got.iter().all(|v| v.abs() <= 100.0), "{got:?}");
        }
    }

    /// A low-pass of 20 Hz passes 1 − e^(−2π f Ts) of a change; the curvature term compensates its delay.
    #[test]
    fn the_low_pass_has_its_corner() {
        let mut settings = DelaySettings::default();
        settings.lead.low_pass_hz = 20.0;
        let mut law = Lead::<f64>::new(&settings, 0.004);
        let x = |v: f64| Twist::of(&[v, 0.0, 0.0, 0.0, 0.0, 0.0]);
        law.step(&Twist::zero());
        let gain = 1.0 - (-core::f64::consts::TAU * 20.0 * 0.004_f64).exp();
        let output = law.step(&x(0.001));
        let slope = output.parts[0].linear.x / 8.5;
        assert!((slope - 0.001 * gain).abs() < 1e-12, "{slope}");
        let late = 1.0 / gain - 0.5;
        let curvature = 0.001 * gain * (0.5 * 8.5 * 8.5 + 8.5 * late);
        assert!((output.parts[1].linear.x - curvature).abs() < 1e-12);
    }

    /// A negative delay counts as none.
    #[test]
    fn nothing_is_led_backwards() {
        let mut settings = DelaySettings::default();
        (settings.actuator.delay_s, settings.lead.extra_s) = (0.0, -0.05);
        let mut law = Lead::<f64>::new(&settings, 0.004);
        for n in 0..5 {
            let model = Twist::of(&[0.001 * f64::from(n * n); 6]);
            assert_eq!(law.step(&model).command, model);
        }
    }
}
