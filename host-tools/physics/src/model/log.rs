//! A recording as plain series, one per axis: the data for the search for effects.

use crate::model::load::{Followed, turn_between, turned_since_first};
use crate::model::prediction::robot_axes::AngleRateMap;
use crate::model::prediction::signals::{Signals, Step, VelocityMeaning};
use crate::model::{FilterModel, Model, NoiseModel};
use anyhow::ensure;
use nalgebra::{UnitQuaternion, Vector3, Vector6};
use softdock_actuator::Reading;
use softdock_control::frames::{Pose, Twist};
use softdock_io::recording::{Beginning, Recording};
use std::ops::Range;

/// Six series, one per axis.
pub type Series = [Vec<f64>; 6];

/// The longest stretch of a recording without a gap.
#[derive(Clone, Debug)]
pub struct Log {
    /// Cycle time, s.
    pub cycle_s: f64,
    /// Time of each cycle, s.
    pub time_s: Vec<f64>,
    /// Meaning of the executed velocity.
    pub reading: Reading,
    /// Rates of the robot's axes sent in each cycle; m/s, rad/s.
    pub sent: Series,
    /// Executed rates of the robot's axes; m/s, rad/s.
    pub executed: Series,
    /// Map from these rates to a velocity in each cycle; `None` where they are the velocity.
    pub turned: Vec<Option<AngleRateMap>>,
    /// Measured pose of M in C.
    pub pose: Vec<Pose<f64>>,
    /// Raw wrench in S; N, N·m.
    pub wrench: Series,
    /// The wrench of this cycle is new.
    pub fresh: Vec<bool>,
    /// The filter of the import of the executed rates.
    pub filter: Option<FilterModel>,
    /// Noise of the executed velocity by data sheet, one standard deviation.
    pub velocity_sigma: [f64; 6],
    /// First cycle of the stretch in the recording.
    pub first: usize,
    /// The log is of a rig with a controller: see [`Signals::is_of_a_rig`].
    pub of_a_rig: bool,
    /// The recorded wrench is not constant.
    pub wrench_changes: bool,
    /// Axes of a free swing: their wrench is known although it is zero.
    free: [bool; 6],
    /// A model of spacecraft ran: see [`Signals::has_spacecraft`].
    pub has_spacecraft: bool,
    /// Whole turns of the first pose about the axis of a machine that turns.
    pub whole_turns: i32,
    /// Beginning of the log of which this is a stretch.
    pub began: Beginning,
}

/// Whether values are readings: no sensor reads exactly 0 throughout, and values that are not finite come from none.
pub(super) fn is_measured(mut values: impl Iterator<Item = f64>) -> bool {
    values.any(|value| value != 0.0 && value.is_finite())
}

/// Whether two forces are equal within the rounding of an import's filter on a constant.
pub fn is_same_force(one: f64, other: f64) -> bool {
    const ROUNDING: f64 = 1e-6;
    (one - other).abs() <= ROUNDING * one.abs()
}

/// The same of a whole wrench.
pub fn is_same_wrench(one: [f64; 6], other: [f64; 6]) -> bool {
    let mut both = one.into_iter().zip(other);
    both.all(|(one, other)| is_same_force(one, other))
}

impl Log {
    /// From a recording.
    ///
    /// # Errors
    ///
    /// Those of [`Signals::new`], and a recording without a whole stretch.
    pub fn new(model: &Model, recording: &Recording) -> anyhow::Result<Self> {
        Self::of(&Signals::new(recording)?, model)
    }

    /// From signals that have been read already.
    ///
    /// # Errors
    ///
    /// A recording without a whole stretch.
    pub fn of(signals: &Signals<'_>, model: &Model) -> anyhow::Result<Self> {
        let stretches = stretches(signals).into_iter();
        let longest = stretches.rev().max_by_key(Range::len);
        let range = longest.unwrap_or_default();
        ensure!(
            range.len() >= 2,
            "no two cycles of the recording follow each other; record again, with the loop closed"
        );
        let trace = |n: usize| &signals.cycles[n].trace;
        let series = |of: &dyn Fn(usize) -> [f64; 6]| -> Series {
            let rows: Vec<[f64; 6]> = range.clone().map(of).collect();
            std::array::from_fn(|axis| rows.iter().map(|row| row[axis]).collect())
        };
        let executed = |n: usize| {
            let velocity = signals.executed(n).map_or([0.0; 6], |v| v.get());
            let turned = signals.turned(n);
            turned.map_or(velocity, |turned| turned.rates(&velocity))
        };
        let identity = Pose::identity();
        Ok(Self {
            cycle_s: signals.cycle_s,
            time_s: range.clone().map(|n| trace(n).time_s).collect(),
            reading: match signals.velocity {
                VelocityMeaning::CycleMean => Reading::Mean,
                VelocityMeaning::Sampled => Reading::AtEnd,
            },
            sent: series(&|n| signals.sent_rates(n)),
            executed: series(&executed),
            turned: range.clone().map(|n| signals.turned(n)).collect(),
            pose: range
                .clone()
                .map(|n| signals.pose(n).unwrap_or(identity))
                .collect(),
            wrench: series(&|n| finite(signals.cycles[n].inputs.sensor.wrench)),
            fresh: range
                .clone()
                .map(|n| signals.sampled_in(n) == Some(n))
                .collect(),
            filter: model.sensor.filter,
            velocity_sigma: signals.velocity_sigma(model),
            first: range.start,
            of_a_rig: signals.is_of_a_rig(),
            wrench_changes: signals.wrench_changes(),
            free: model.free_axes(),
            has_spacecraft: signals.has_spacecraft(),
            whole_turns: signals.whole_turns_at(range.start),
            began: signals.began,
        })
    }

    /// Applies the filter of the import to velocities that are computed from commands.
    pub fn as_imported(&self, velocity: Vec<f64>) -> Vec<f64> {
        match self.filter {
            Some(filter) => filter.zero_phase(self.cycle_s, &velocity),
            None => velocity,
        }
    }

    /// Linear and angular velocity for rates in cycle n.
    pub fn velocity(&self, n: usize, rates: [f64; 6]) -> [f64; 6] {
        self.turned[n].map_or(rates, |turned| turned.velocity(&rates))
    }

    /// Axes on which the wrench was measured.
    pub fn measured(&self) -> [bool; 6] {
        std::array::from_fn(|axis| {
            self.free[axis] || is_measured(self.wrench[axis].iter().copied())
        })
    }

    /// The wrench, if a motion was logged under a constant one, as under a constant command; else `None`. Rows at rest without any
    /// load before the first one, as before a step of the command, do not count.
    pub fn constant_wrench(&self) -> Option<[f64; 6]> {
        let row = |series: &[Vec<f64>; 6], n: usize| series.each_ref().map(|series| series[n]);
        let stands = |n: &usize| row(&self.executed, *n) == [0.0; 6];
        let rests = |n: &usize| stands(n) && row(&self.wrench, *n) == [0.0; 6];
        let mut loads = (0..self.cycle_count())
            .skip_while(rests)
            .map(|n| row(&self.wrench, n));
        let first = loads.next()?;
        let moves = is_measured(self.executed.iter().flatten().copied());
        let is_constant = !self.wrench_changes || loads.all(|load| is_same_wrench(first, load));
        (moves && is_measured(first.into_iter()) && is_constant).then_some(first)
    }

    /// Number of cycles.
    pub fn cycle_count(&self) -> usize {
        self.time_s.len()
    }

    /// Whether any velocity was sent.
    pub fn is_commanded(&self) -> bool {
        self.sent.iter().flatten().any(|v| *v != 0.0)
    }

    /// Whether its origin was not measured: its poses are the integral of its velocity from the identity.
    pub fn has_own_origin(&self) -> bool {
        self.pose.first() == Some(&Pose::identity()) && self.is_integrated()
    }

    /// Whether its poses are the integral of its velocity.
    pub fn is_integrated(&self) -> bool {
        /// Smaller fractions of a step are round-off.
        const ROUND_OFF: f64 = 1e-6;
        let mut steps = (1..self.cycle_count()).map(|n| {
            let (from, to) = (&self.pose[n - 1], &self.pose[n]);
            let said = self.moved_by_velocity(n);
            let moved = Twist {
                linear: to.translation.vector - from.translation.vector,
                angular: turn_between(&from.rotation, &to.rotation, &said.angular),
            };
            let norm = |twist: Twist<f64>| Vector6::from_row_slice(&twist.get()).norm();
            // The resolution of a sum depends on its magnitude.
            let digits = 8.0 * f64::EPSILON * (1.0 + to.translation.vector.norm());
            norm(moved - said) <= ROUND_OFF * norm(said) + digits
        });
        self.reading == Reading::AtEnd && steps.all(|is_sum| is_sum)
    }

    /// Its poses, each with the rotation since the one before by the velocity.
    pub fn turned_poses(&self) -> impl Iterator<Item = Followed> {
        let poses = self.pose.iter().enumerate();
        poses.map(|(n, pose)| Followed {
            pose: *pose,
            by_velocity: self.turned_by_velocity(n),
        })
    }

    /// Rotation since the cycle before by the velocity, rad in M; zero in the first.
    pub fn turned_by_velocity(&self, n: usize) -> Vector3<f64> {
        match n {
            0 => Vector3::zeros(),
            n => self.moved_by_velocity(n).angular,
        }
    }

    /// Displacement since the cycle before by the velocity, m in C and rad in M.
    fn moved_by_velocity(&self, n: usize) -> Twist<f64> {
        let velocity = |n: usize| {
            let rates = std::array::from_fn(|axis| self.executed[axis][n]);
            Twist::of(&self.velocity(n, rates))
        };
        let mean = match self.reading {
            Reading::Mean => velocity(n),
            Reading::AtEnd => (velocity(n - 1) + velocity(n)) * 0.5,
        };
        mean * self.cycle_s
    }

    /// Whether the rig is at rest throughout: nothing is sent, and poses and velocities stay within their noise.
    pub fn rests(&self, noise: &NoiseModel) -> bool {
        /// Standard deviations of noise that even a log of hours does not exceed.
        const STILL: f64 = 7.0;
        let Some(first) = self.pose.first() else {
            return true;
        };
        let velocities = self.executed.iter().zip(self.velocity_sigma);
        let slow = |(rates, sigma): (&Vec<f64>, f64)| rates.iter().all(|v| v.abs() < STILL * sigma);
        // Two poses are compared.
        let reach = STILL * std::f64::consts::SQRT_2;
        let mut turned = turned_since_first(self.pose.iter().copied().map(Followed::from));
        let near = |pose: &Pose<f64>| {
            (pose.translation.vector - first.translation.vector).amax() < reach * noise.position_m
        };
        let stays = self.pose.iter().all(near)
            && turned.all(|turned| turned.norm() < reach * noise.angle_rad);
        !self.is_commanded() && velocities.into_iter().all(slow) && stays
    }

    /// Position of M in C.
    pub fn position(&self, n: usize) -> Vector3<f64> {
        self.pose[n].translation.vector
    }

    /// Orientation of M in C.
    pub fn rotation(&self, n: usize) -> UnitQuaternion<f64> {
        self.pose[n].rotation
    }
}

fn finite(six: [f64; 6]) -> [f64; 6] {
    six.map(|v| if v.is_finite() { v } else { 0.0 })
}

/// The stretches of consecutive cycles that all have a pose.
pub fn stretches(signals: &Signals<'_>) -> Vec<Range<usize>> {
    let mut all: Vec<Range<usize>> = Vec::new();
    for n in (0..signals.len()).filter(|n| signals.pose(*n).is_some()) {
        match all.last_mut() {
            Some(last) if last.end == n && signals.steps[n] == Step::Next => last.end = n + 1,
            _ => all.push(n..n + 1),
        }
    }
    all
}
