//! How effects act: what each kind of law is given, and what it returns.
//!
//! A law is a pure function of its parameters, in the order of the catalogue entry, and of the state on which it acts.
//! Simulation, prediction, fit and picture all evaluate this function; how it enters a log follows from its kind.

use super::actuator::AxisStage;
use super::formula::Formula;
use super::sensor::tool::ToolState;
use nalgebra::Vector3;
use softdock_control::frames::Wrench;
use softdock_control::range::SettingsError;
use softdock_control::settings::BodySettings;
use softdock_mechanism::Kind;
use std::collections::VecDeque;

/// Parameters of a law, in the order of the catalogue entry.
pub type Values<'a> = &'a [f64];

/// How an effect acts.
#[derive(Clone, Copy, Debug)]
pub enum Law {
    /// A force on the moving side along the guide; of a bearing a torque about it.
    Guide(Guide),
    /// The same, for effects that only a bearing has.
    Bearing(Guide),
    /// A force (N) on the moving side in all directions, from its displacement (m) from the position of rest.
    Spring(fn(Values<'_>, &Vector3<f64>) -> Vector3<f64>),
    /// Push (N) of a wall in addition to the nominal one, where the tip is in the wall. A wall cannot pull: the sum of all pushes
    /// is clipped at zero.
    Push(fn(Values<'_>, &Penetration) -> f64),
    /// Penetration (m) of the wall's spring, from the nominal one.
    Depth(fn(Values<'_>, f64, &Facing) -> f64),
    /// Force (N) across the normal, from the wall's push (N) and the sliding velocity (m/s).
    Friction(fn(Values<'_>, f64, &Vector3<f64>) -> Vector3<f64>),
    /// Changes the nominal docking mechanism in place.
    Docking(fn(Values<'_>, &mut Kind)),
    /// Wrench at S of the tool, in addition to the nominal one.
    Tool(fn(Values<'_>, &ToolState) -> Wrench<f64>),
    /// The wrench that the sensor measures of its load.
    SensorGain(fn(Values<'_>, &Wrench<f64>) -> Wrench<f64>),
    /// The command for a force that has to act, where the scale of the commands is a guess.
    CommandGain(fn(Values<'_>, &Wrench<f64>) -> Wrench<f64>),
    /// Zero of the sensor at a time (s) after the log began.
    SensorZero(fn(Values<'_>, f64) -> Wrench<f64>),
    /// Delay and lag of the reading.
    ReadingDelay(fn(Values<'_>) -> DelayAndLag),
    /// Time by which the log reads the motion late, s, or early if negative; on a rig, which sends velocities as well, only its
    /// poses.
    ClockOffset(fn(Values<'_>) -> f64),
    /// A wrench clipped to the sensor's range.
    Saturation(fn(Values<'_>, &Wrench<f64>) -> Wrench<f64>),
    /// The samples that the sensor sends.
    Sample(Sampling),
    /// From the commanded velocity to the executed one.
    Actuator(Actuator),
    /// A formula of the user.
    Formula(&'static Formula),
    /// Changes the spacecraft that the rig integrates as the one that its robot moves.
    Spacecraft(fn(Values<'_>, &mut BodySettings)),
    /// The clock of the control cycle.
    Clock(Clock),
}

/// Makes a stage of one axis from the values and the duration of a step, s.
pub type MakeAxisStage = fn(Values<'_>, f64) -> Result<AxisStage, SettingsError>;

/// A stage of the actuator.
#[derive(Clone, Copy, Debug)]
pub struct Actuator {
    /// Makes the stage that acts on the velocity of one axis; `None` if the effect acts on the commands of all axes at once.
    pub axis: Option<MakeAxisStage>,
    /// Delay and lag of a force that is commanded through the same actuator; `None` if the effect does more than that.
    pub late: Option<fn(Values<'_>) -> DelayAndLag>,
}

/// An error of the clock.
#[derive(Clone, Copy, Debug)]
pub enum Clock {
    /// Deviation of an instant, s, from the values and a standard normal number.
    Scatter(fn(Values<'_>, f64) -> f64),
    /// Error of the rate: a nominal second is longer by this, s.
    Rate(fn(Values<'_>) -> f64),
}

/// Six numbers, x y z rx ry rz.
pub type Six = [f64; 6];

/// How the sensor samples and sends.
#[derive(Clone, Copy, Debug)]
pub struct Sampling {
    /// The sample that is sent, from the wrench, the sample before and a random number in (0, 1].
    pub sent: fn(Values<'_>, &Wrench<f64>, &Wrench<f64>, f64) -> Wrench<f64>,
    /// The reading that corresponds to a predicted wrench, given the measured sample and the one before it, such that their
    /// difference is the distance from the predicted wrench to the nearest one that would have been sent as measured. `None` if
    /// the sample carries no information.
    pub read: fn(Values<'_>, Six, &Six, Option<&Six>) -> Option<Six>,
}

/// A force along the guide.
#[derive(Clone, Copy, Debug)]
pub struct Guide {
    /// Force on the moving side, N, positive along the guide.
    pub force: fn(Values<'_>, &Slide) -> f64,
    /// How the direction changes at a reversal; `None` for parameters that exclude each other.
    pub reversal: fn(Values<'_>) -> Option<Reversal>,
}

/// Motion of the guided point along the guide.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slide {
    /// Position, m.
    pub position: f64,
    /// Velocity, m/s.
    pub velocity: f64,
    /// Acceleration, m/s².
    pub acceleration: f64,
    /// Direction of the motion, −1 to 1: the sign of the velocity, with the transition that the [`Reversal`] describes.
    pub direction: f64,
}

impl Slide {
    /// A motion with this velocity and a sharp direction.
    pub fn at_velocity(velocity: f64) -> Self {
        Self {
            velocity,
            direction: sign(velocity),
            ..Self::default()
        }
    }
}

/// How the direction of a motion changes at a reversal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reversal {
    /// At once; 0 at standstill.
    Sharp,
    /// Over this speed, m/s: tanh(v/speed).
    OverSpeed(f64),
    /// Over this distance, m (Dahl 1968): dz/dx = (1 − sgn(dx) z)/distance.
    OverDistance(f64),
    /// Over this distance, m, with linear unloading: dz/dx = 1 − |z| while z and dx have the same sign, else 1, divided by the
    /// distance (Bouc-Wen with A = 1, β = γ = 1/2, n = 1).
    BoucWen(f64),
}

impl Reversal {
    /// For a law without dry friction.
    pub fn sharp(_: Values<'_>) -> Option<Self> {
        Some(Self::Sharp)
    }

    /// Over a speed or over a distance; sharp if both are 0, `None` if neither is.
    pub fn of(speed_m_s: f64, distance_m: f64) -> Option<Self> {
        match (speed_m_s > 0.0, distance_m > 0.0) {
            (false, false) => Some(Self::Sharp),
            (true, false) => Some(Self::OverSpeed(speed_m_s)),
            (false, true) => Some(Self::OverDistance(distance_m)),
            (true, true) => None,
        }
    }
}

/// The direction of a motion from instant to instant.
#[derive(Clone, Copy, Debug)]
pub struct Direction {
    reversal: Reversal,
    /// State z of the transition, −1 to 1.
    share: f64,
    velocity: f64,
}

impl Direction {
    /// Relaxed and at rest.
    pub fn new(reversal: Reversal) -> Self {
        Self {
            reversal,
            share: 0.0,
            velocity: 0.0,
        }
    }

    /// The direction at the next instant, `step_s` later; the velocity (m/s) is linear between the two.
    pub fn advance(&mut self, velocity: f64, step_s: f64) -> f64 {
        let before = std::mem::replace(&mut self.velocity, velocity);
        if matches!(self.reversal, Reversal::Sharp | Reversal::OverSpeed(_)) {
            return self.at(velocity);
        }
        let path = |v: f64, share: f64| 0.5 * v * share * step_s;
        if before * velocity < 0.0 {
            // Split the step where the motion reverses.
            let cut = before / (before - velocity);
            self.advance_by(path(before, cut));
            self.advance_by(path(velocity, 1.0 - cut));
        } else {
            self.advance_by(path(before + velocity, 1.0));
        }
        self.at(velocity)
    }

    /// The direction at a velocity (m/s), without advancing the state.
    pub fn at(&self, velocity: f64) -> f64 {
        match self.reversal {
            Reversal::Sharp => sign(velocity),
            Reversal::OverSpeed(speed) => (velocity / speed).tanh(),
            Reversal::OverDistance(_) | Reversal::BoucWen(_) => self.share,
        }
    }

    /// Advances the state by a path (m) in one direction; exact.
    pub fn advance_by(&mut self, path: f64) {
        let towards = sign(path);
        if towards == 0.0 {
            return;
        }
        match self.reversal {
            Reversal::OverDistance(distance) => {
                let left = decay(path.abs() / distance);
                self.share = towards + (self.share - towards) * left;
            }
            Reversal::BoucWen(distance) => {
                let mut along = self.share * towards;
                let mut travel = path.abs() / distance.max(1e-9);
                let relaxed = travel.min((-along).max(0.0));
                along += relaxed;
                travel -= relaxed;
                if travel > 0.0 {
                    along = 1.0 + (along - 1.0) * decay(travel);
                }
                self.share = along * towards;
            }
            Reversal::Sharp | Reversal::OverSpeed(_) => {}
        }
    }
}

/// The tip in a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penetration {
    /// How deep, m; positive.
    pub depth: f64,
    /// How fast it grows, m/s.
    pub rate: f64,
    /// Share of the wall's damping that acts at this depth, 0 to 1.
    pub onset: f64,
}

/// Which wall it is, and how it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facing {
    /// Component of its outward normal along the guide, or for a bearing along the path of its tip, −1 to 1.
    pub along_axis: f64,
    /// Its number in the model, from 1.
    pub number: usize,
}

/// A delay followed by a first-order lag, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DelayAndLag {
    /// Delay.
    pub delay_s: f64,
    /// Time constant.
    pub lag_s: f64,
}

impl DelayAndLag {
    /// The input of which `series` is the delayed output: the series one delay later, plus the time constant of the lag times its
    /// slope.
    ///
    /// Between samples Thiran's first-order all-pass interpolates (Laakso and others, Splitting the unit delay, IEEE Signal
    /// Processing Magazine 13(1), 1996), as it keeps the amplitude of all frequencies. Linear interpolation would halve the
    /// variance of noise at half a step, and where acceleration is differentiated from positions, a search for a delay would find
    /// that half step.
    pub fn anticipated(&self, series: &[f64], step_s: f64) -> Vec<f64> {
        let steps = self.delay_s.max(0.0) / step_s;
        // Advance by whole steps, then delay by half a step to one and a half.
        let later = steps.round() as usize + 1;
        let delay = later as f64 - steps;
        let pole = (1.0 - delay) / (1.0 + delay);
        let last = series.len().saturating_sub(1);
        let at = |n: usize| series.get(n.min(last)).copied().unwrap_or(0.0);
        let mut before = at(later - 1);
        let mut value = before;
        let anticipated = (0..series.len()).map(|n| {
            let now = at(n + later);
            let first = std::mem::replace(&mut before, now);
            value = pole * (now - value) + first;
            let (from, to) = (n.saturating_sub(1), (n + 1).min(last));
            let span_s = (to - from).max(1) as f64 * step_s;
            value + self.lag_s * (at(to) - at(from)) / span_s
        });
        anticipated.collect()
    }

    /// The delayed output of a series, as if its first value had been there for a long time.
    pub fn delayed(&self, series: &[f64], step_s: f64) -> Vec<f64> {
        let mut late = DelayLine::new(*self, step_s, [series.first().copied().unwrap_or(0.0)]);
        series
            .iter()
            .map(|value| late.advance([*value])[0])
            .collect()
    }
}

/// Signals that are delayed together, sampled at equal steps and linear between two samples.
#[derive(Clone, Debug)]
pub struct DelayLine<const N: usize = 6> {
    lateness: DelayAndLag,
    step_s: f64,
    /// Factor of the lag's state after a step: exp(−step/lag).
    decay: f64,
    line: VecDeque<[f64; N]>,
    delayed: [f64; N],
    value: [f64; N],
}

impl<const N: usize> DelayLine<N> {
    /// As if `first` had been there for a long time.
    pub fn new(lateness: DelayAndLag, step_s: f64, first: [f64; N]) -> Self {
        let held = (lateness.delay_s.max(0.0) / step_s).ceil() as usize + 2;
        Self {
            lateness,
            step_s,
            decay: (-step_s / lateness.lag_s).exp(),
            line: VecDeque::from(vec![first; held]),
            delayed: first,
            value: first,
        }
    }

    /// The output for this sample.
    pub fn advance(&mut self, sample: [f64; N]) -> [f64; N] {
        self.line.pop_back();
        self.line.push_front(sample);
        let steps = self.lateness.delay_s.max(0.0) / self.step_s;
        let (whole, rest) = (steps.floor() as usize, steps.fract());
        let (near, far) = (
            self.line[whole],
            self.line[(whole + 1).min(self.line.len() - 1)],
        );
        let now: [f64; N] = std::array::from_fn(|i| near[i] + rest * (far[i] - near[i]));
        let before = std::mem::replace(&mut self.delayed, now);
        if self.lateness.lag_s <= 0.0 {
            self.value = now;
            return now;
        }
        // Exact for an input that is linear between two samples.
        let h = self.step_s / self.lateness.lag_s;
        for (i, value) in self.value.iter_mut().enumerate() {
            let slope = (now[i] - before[i]) / h;
            *value = now[i] - slope + (*value - before[i] + slope) * self.decay;
        }
        self.value
    }

    /// The present output.
    pub fn value(&self) -> [f64; N] {
        self.value
    }
}

/// exp(−x) for x ≥ 0. Where it underflows to zero, it is returned at once, as the library function takes ten times as long there.
pub fn decay(x: f64) -> f64 {
    /// The smallest number that is not zero is exp(−744.4).
    const GONE: f64 = 746.0;
    if x > GONE { 0.0 } else { (-x).exp() }
}

/// +1, −1, or 0 for zero, which `signum` does not give.
pub fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// From rest: z = 1 − exp(−x/x0); back: linear to zero, then exponential again.
    #[test]
    fn bouc_wen_forth_and_back() {
        let (length, speed, step_s) = (0.002, 0.02, 0.001);
        let mut direction = Direction::new(Reversal::BoucWen(length));
        direction.velocity = speed;
        for k in 1..=300 {
            let expected = 1.0 - (-speed * step_s * f64::from(k) / length).exp();
            assert!((direction.advance(speed, step_s) - expected).abs() < 1e-12);
        }
        direction.velocity = -speed;
        for k in 1..=300 {
            let back = speed * step_s * f64::from(k) / length;
            let top = 1.0 - (-3.0_f64).exp();
            let z = if back < top {
                top - back
            } else {
                (top - back).exp() - 1.0
            };
            assert!((direction.advance(-speed, step_s) - z).abs() < 1e-9, "{k}");
        }
    }

    /// A motion that reverses within a step: out for half a step, back for half a step.
    #[test]
    fn dahl_is_cut_where_the_motion_turns() {
        let mut direction = Direction::new(Reversal::OverDistance(1e-3));
        direction.velocity = 1.0;
        let out = 1.0 - (-0.25_f64).exp();
        let back = -1.0 + (out + 1.0) * (-0.25_f64).exp();
        assert!((direction.advance(-1.0, 1e-3) - back).abs() < 1e-12);
        assert_eq!(Reversal::of(1e-3, 1e-3), None);
    }

    /// A slow sine comes out early by delay and lag, and noise keeps its power at any fraction of a step.
    #[test]
    fn anticipation_moves_a_series_and_keeps_its_noise() {
        let step_s = 0.002;
        let sine = |t: f64| (TAU * 3.0 * t).sin();
        let series: Vec<f64> = (0..2000).map(|n| sine(f64::from(n) * step_s)).collect();
        for delay_s in [0.0, 0.0007, 0.001, 0.0013, 0.007, 0.0116] {
            let late = DelayAndLag {
                delay_s,
                lag_s: 0.0,
            };
            let early = late.anticipated(&series, step_s);
            for (n, early) in early.iter().enumerate().take(1900).skip(5) {
                let expected = sine(n as f64 * step_s + delay_s);
                assert!((early - expected).abs() < 1e-4, "{delay_s} {n}");
            }
            let noise: Vec<f64> = (0..2000_u32)
                .map(|n| f64::from(n.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24) - 0.5)
                .collect();
            let power = |series: &[f64]| series[10..1900].iter().map(|v| v * v).sum::<f64>();
            let share = power(&late.anticipated(&noise, step_s)) / power(&noise);
            assert!((share - 1.0).abs() < 0.02, "{delay_s}: {share}");
        }
        let slow = DelayAndLag {
            delay_s: 0.0,
            lag_s: 0.005,
        };
        let early = slow.anticipated(&series, step_s);
        let expected = sine(0.5) + 0.005 * TAU * 3.0 * (TAU * 3.0 * 0.5).cos();
        assert!((early[250] - expected).abs() < 1e-4);
    }

    #[test]
    fn a_ramp_is_late_by_delay_and_lag() {
        let late = DelayAndLag {
            delay_s: 0.010,
            lag_s: 0.003,
        };
        let mut line = DelayLine::new(late, 0.004, [0.0; 6]);
        let mut value = 0.0;
        for k in 1..=40 {
            value = line.advance([f64::from(k); 6])[5];
        }
        assert!((value - (40.0 - 0.013 / 0.004)).abs() < 1e-6, "{value}");
    }
}
