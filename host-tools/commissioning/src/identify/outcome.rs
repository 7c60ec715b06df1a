//! The answer of an identification.

use super::track::{Track, centred};
use serde::Serialize;
use softdock_actuator::Chain;
use softdock_physics::model::{Axis, Channel};
use softdock_report::number;
use softdock_statistics::rms;

/// Ratio of rms residual to noise from which on the structure is incomplete.
const MISFIT: f64 = 1.5;

/// A number with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Best value.
    pub value: f64,
    /// Low end.
    pub low: f64,
    /// High end; None if the recording does not bound it.
    pub high: Option<f64>,
}

impl Estimate {
    pub(super) fn around(value: f64, reach: f64) -> Self {
        Self {
            value,
            low: value - reach,
            high: reach.is_finite().then_some(value + reach),
        }
    }

    pub(super) fn exactly(value: f64) -> Self {
        Self::around(value, 0.0)
    }

    pub(super) fn at_least(self, least: f64) -> Self {
        Self {
            value: self.value.max(least),
            low: self.low.max(least),
            high: self.high.map(|h| h.max(least)),
        }
    }

    /// The same value with an interval extended to that of another estimate.
    pub(super) fn reaching(self, other: &Self) -> Self {
        Self {
            value: self.value,
            low: self.low.min(other.low),
            high: match (self.high, other.high) {
                (Some(a), Some(b)) => Some(a.max(b)),
                _ => None,
            },
        }
    }

    /// Width of the interval.
    fn width(&self) -> f64 {
        self.high.map_or(f64::INFINITY, |high| high - self.low)
    }

    /// Whether the interval contains one value only.
    pub(super) fn is_exact(&self) -> bool {
        self.high == Some(self.low)
    }

    /// A number of cycles and those that are possible, as text.
    pub(super) fn in_cycles(&self) -> String {
        let Self { value, low, high } = self;
        match high {
            Some(high) if high == low => format!("{value} cycle(s)"),
            Some(high) => format!("{value} cycle(s), {low} to {high} are possible"),
            None => format!("{value} cycle(s), {low} and more are possible"),
        }
    }

    /// In ms, as text.
    pub fn in_ms(&self) -> String {
        let ms = |v: f64| number::fixed(v * 1e3, 2);
        let high = self.high.map_or_else(|| "?".to_owned(), ms);
        format!("{} ms [{}, {high}]", ms(self.value), ms(self.low))
    }
}

/// Actuator of one axis.
#[derive(Clone, Debug, Serialize)]
pub struct AxisActuator {
    /// Which.
    pub axis: Axis,
    /// Its structure: `delay + lag`.
    pub structure: String,
    /// Transport delay up to the reported pose, s.
    pub delay_s: Estimate,
    /// Time constant of the lag, s.
    pub lag_s: Estimate,
    /// Delay, lag and 2ζ/ω of the servo together, s: known best.
    pub mean_delay_s: Estimate,
    /// Natural frequency of a second-order servo, Hz, if there is one.
    pub servo_hz: Option<Estimate>,
    /// Its damping ratio.
    pub servo_damping: Option<Estimate>,
    /// Standstill when the axis reverses, s; None if it never does in the recording.
    pub pause_s: Option<Estimate>,
    /// What begins and ends the pause.
    pub pause_form: Option<String>,
    /// Limit of the acceleration, m/s² or rad/s²; None if none was reached.
    pub max_acceleration: Option<Estimate>,
    /// Limit of the velocity, m/s or rad/s; None if none was reached.
    pub max_velocity: Option<Estimate>,
    /// Largest acceleration that was asked for, m/s² or rad/s².
    pub tried_acceleration: f64,
    /// Fastest velocity that was asked for, m/s or rad/s.
    pub tried_velocity: f64,
    /// Root mean square of the residual positions, m or rad.
    pub residual_rms: f64,
    /// Noise of the positions combined with the least error of a simulation, m or rad.
    pub noise_rms: f64,
    /// Other structures that explain the recording as well.
    pub rivals: Vec<String>,
    /// Age of the reported pose, cycles, if a force shows it.
    pub feedback_latency: Option<Estimate>,
    /// What the report draws.
    #[serde(skip)]
    pub evidence: Evidence,
}

/// What the report draws of an axis.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// Time of the judged positions, s.
    pub time_s: Vec<f64>,
    /// The positions as they were measured, m or rad.
    pub measured: Vec<f64>,
    /// Their residuals, m or rad.
    pub residual: Vec<f64>,
    /// The actuator.
    pub chain: Chain,
}

/// How the robot follows.
#[derive(Clone, Debug, Serialize)]
pub struct Identification {
    /// Transport delay from command to motion, s; without the age of the reported pose if that is
    /// known.
    pub delay_s: Estimate,
    /// Time constant of the lag, s.
    pub lag_s: Estimate,
    /// Standstill when an axis reverses, s; None if none does.
    pub pause_s: Option<Estimate>,
    /// Mean delay: delay, lag and servo together, s.
    pub mean_delay_s: Estimate,
    /// Natural frequency of a second-order servo, Hz.
    pub servo_hz: Option<Estimate>,
    /// Its damping ratio.
    pub servo_damping: Option<Estimate>,
    /// Age of the reported pose, cycles.
    pub feedback_latency_cycles: Option<Estimate>,
    /// The axis to which these values belong: the one whose mean delay is known best.
    pub axis: Axis,
    /// Its structure.
    pub structure: String,
    /// Root mean square of its residual positions, m or rad.
    pub residual_rms: f64,
    /// Every axis that moved.
    pub axes: Vec<AxisActuator>,
    /// What the user should know.
    pub notes: Vec<String>,
    /// Cycle, s.
    pub cycle_s: f64,
}

impl Identification {
    /// `axes` is not empty.
    pub(super) fn new(axes: Vec<AxisActuator>, refused: Vec<String>, cycle_s: f64) -> Self {
        let order = |a: &&AxisActuator, b: &&AxisActuator| {
            a.mean_delay_s.width().total_cmp(&b.mean_delay_s.width())
        };
        let best = axes.iter().min_by(order).unwrap_or(&axes[0]).clone();
        let latency = axes
            .iter()
            .filter_map(|a| a.feedback_latency)
            .min_by(|a, b| a.width().total_cmp(&b.width()));
        let age = latency.map(|l| {
            (
                l.value * cycle_s,
                l.low * cycle_s,
                l.high.map(|h| h * cycle_s),
            )
        });
        let without_age = |e: Estimate| match age {
            Some((value, low, high)) => Estimate {
                value: e.value - value,
                low: e.low - high.unwrap_or(value),
                high: e.high.map(|h| h - low),
            }
            .at_least(0.0),
            None => e,
        };
        let pause = axes
            .iter()
            .filter_map(|a| a.pause_s)
            .min_by(|a, b| a.width().total_cmp(&b.width()));
        let mut found = Self {
            delay_s: without_age(best.delay_s),
            lag_s: best.lag_s,
            pause_s: pause,
            mean_delay_s: without_age(best.mean_delay_s),
            servo_hz: best.servo_hz,
            servo_damping: best.servo_damping,
            feedback_latency_cycles: latency,
            axis: best.axis,
            structure: best.structure.clone(),
            residual_rms: best.residual_rms,
            notes: Vec::new(),
            axes,
            cycle_s,
        };
        found.notes = found.remarks(&best, &refused);
        found
    }

    /// What was found, in a sentence.
    pub fn sentence(&self) -> String {
        let pause = self.pause_s.map_or_else(
            || "a pause was not tried, because nothing reversed".to_owned(),
            |pause| format!("it stands still for {} when it reverses", pause.in_ms()),
        );
        format!(
            "The robot follows {} late on average ({} along {}: delay {}, lag {}); {pause}.",
            self.mean_delay_s.in_ms(),
            self.structure,
            self.axis,
            self.delay_s.in_ms(),
            self.lag_s.in_ms()
        )
    }

    fn remarks(&self, best: &AxisActuator, refused: &[String]) -> Vec<String> {
        let no_reversal = "No axis reverses in this recording, so nothing is known of a pause at a zero crossing: jog to and fro, too.";
        let reverses = self.pause_s.is_some();
        let one = [
            best.remark_on_rivals(),
            best.remark_on_misfit(),
            Some(self.remark_on_age()),
            (!reverses).then(|| no_reversal.to_owned()),
        ];
        let all = one.into_iter().flatten().chain(best.remarks_on_limits());
        let mut notes: Vec<String> = all.chain(self.disagreement(best)).collect();
        if self.axes.len() > 1 || refused.len() < 5 {
            let moving = refused.iter().filter(|r| !r.contains("no velocity"));
            notes.extend(moving.cloned());
        }
        notes
    }

    fn remark_on_age(&self) -> String {
        match self.feedback_latency_cycles {
            Some(age) => {
                let found = format!(
                    "The reported pose is older than the force by {}; delay and mean delay are without that age.",
                    age.in_cycles()
                );
                match age.is_exact() {
                    true => found,
                    false => {
                        found
                            + " The settings do not take it as known: a jog with a heavier tool tells more."
                    }
                }
            }
            None => "How old the reported pose is cannot be told from the robot's delay: no force follows the acceleration of this motion. \
                     Delay and mean delay hold that age. A jog with a heavier tool (kilograms) and the sensor recorded shows it."
                .to_owned(),
        }
    }

    /// A note on axes whose mean delay contradicts that of the best one; None if there are none.
    fn disagreement(&self, best: &AxisActuator) -> Option<String> {
        let [low, high] = [
            best.mean_delay_s.low,
            best.mean_delay_s.high.unwrap_or(f64::MAX),
        ];
        let others = self.axes.iter().filter(|a| {
            let own = a.mean_delay_s;
            own.low > high || own.high.is_some_and(|h| h < low)
        });
        let words: Vec<String> = others
            .map(|a| format!("{} {}", a.axis, a.mean_delay_s.in_ms()))
            .collect();
        (!words.is_empty()).then(|| {
            format!(
                "Other axes have another mean delay: {}; the settings hold one for all, that of {}.",
                words.join(", "),
                best.axis
            )
        })
    }
}

impl AxisActuator {
    /// Why this actuator says nothing about the robot, and what to check: it leaves most of the motion. None if it does not.
    pub(super) fn goes_elsewhere(&self, track: &Track) -> Option<String> {
        /// Largest share of a motion (rms) that an actuator may leave that follows at all. Set by hand.
        const MOST: f64 = 0.5;
        /// Correlation with the command from which on a motion follows it up to sign or scale. Set by hand.
        const ALIKE: f64 = 0.9;
        let moved = rms(&centred(&self.evidence.measured));
        if self.residual_rms <= MOST * moved {
            return None;
        }
        let axis = self.axis;
        if self.residual_rms <= MISFIT * self.noise_rms {
            return Some(format!(
                "{axis} moves by no more than its noise ({} m or rad rms): jog it further",
                number::significant(self.noise_rms, 2)
            ));
        }
        let (ratio, correlation) = track.followed();
        let times = number::significant(ratio, 2);
        let suspicion = match correlation {
            c if c.abs() < ALIKE => "is the command of another axis?".to_owned(),
            c if c < 0.0 => {
                format!("it moves by {times} times that: is the command of the other sign?")
            }
            _ => format!(
                "it moves by {times} times that: is the command in another unit, or the robot's override not 100 %?"
            ),
        };
        Some(format!(
            "{axis} does not follow what it was sent ({suspicion}): of {} m or rad rms of its motion {} are left",
            number::significant(moved, 2),
            number::significant(self.residual_rms, 2)
        ))
    }

    fn remark_on_rivals(&self) -> Option<String> {
        (!self.rivals.is_empty()).then(|| {
            format!(
                "{} explains the recording as well as {}: take the mean delay for certain and the split for likely; faster jumps of \
                 the velocity or less noise tell them apart.",
                self.rivals.join(" or "),
                self.structure
            )
        })
    }

    fn remark_on_misfit(&self) -> Option<String> {
        (self.residual_rms > MISFIT * self.noise_rms).then(|| {
            format!(
                "No structure explains {} to its noise: {} m or rad rms are left where {} would be noise. The mean delay holds for slow \
                 motions; delay, lag and servo are the nearest description, and their intervals do not know of what is missing.",
                self.axis,
                number::significant(self.residual_rms, 2),
                number::significant(self.noise_rms, 2)
            )
        })
    }

    /// Notes on limits that were not reached.
    fn remarks_on_limits(&self) -> impl Iterator<Item = String> {
        let acceleration = (self.max_acceleration, self.tried_acceleration);
        let velocity = (self.max_velocity, self.tried_velocity);
        let all = [
            ("acceleration", acceleration, "/s²"),
            ("velocity", velocity, "/s"),
        ];
        let unmet = all.into_iter().filter(|(_, (met, _), _)| met.is_none());
        unmet.map(|(of, (_, tried), per_s)| {
            let tried = number::significant(tried, 2);
            format!(
                "No limit of the {of} of {} was met up to {tried} {}{per_s}.",
                self.axis,
                Channel::Pose.unit(self.axis)
            )
        })
    }
}
