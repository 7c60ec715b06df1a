//! A recording as signals: cycle time, continuity, and the meaning of its velocities.

use super::differences::{
    acceleration_of_means, acceleration_of_samples, noise_of, taps_of_first, taps_of_second,
    velocity_of_means,
};
use super::robot_axes::{AngleRateMap, RobotAxes};
use crate::model::Model;
use crate::model::load::{
    Followed, angle_about, angles, pose_of, turn_between, turned_since_first,
};
use crate::model::log::is_same_wrench;
use crate::model::prediction::{Six, six};
use anyhow::{bail, ensure};
use nalgebra::{Complex, Vector3, Vector6};
use softdock_app::record::CycleRecord;
use softdock_control::frames::{Pose, Twist};
use softdock_control::io::Sequence;
use softdock_control::settings::Settings;
use softdock_control::wrench::Motion;
use softdock_io::recording::{Beginning, Recording};
use softdock_statistics::{LowPassed, sample_time};
use std::f64::consts::TAU;
use std::sync::OnceLock;

/// Meaning of the recorded velocity of cycle n.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VelocityMeaning {
    /// Mean over the cycle that ended with cycle n: the difference of two poses, as the board
    /// records it.
    CycleMean,
    /// Measured at the instant of cycle n.
    Sampled,
}

/// How a cycle follows the one before it in the recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// One cycle later.
    Next,
    /// After this number of telegrams without an answer, in which the robot got no command.
    Lost(u32),
    /// A new run of the robot, which stands still and has forgotten all commands.
    NewRun,
    /// Something is missing in the recording before this cycle.
    Hole,
}

/// Signals of a recording.
#[derive(Clone, Debug)]
pub struct Signals<'a> {
    /// The cycles.
    pub cycles: &'a [CycleRecord],
    /// Cycle time, s.
    pub cycle_s: f64,
    /// Meaning of the recorded velocity.
    pub velocity: VelocityMeaning,
    /// How each cycle follows its predecessor.
    pub steps: Vec<Step>,
    /// The board's settings; `None` if the recording holds none.
    pub settings: Option<Settings>,
    /// See [`Header::whole_turns`](softdock_io::recording::Header::whole_turns).
    pub whole_turns: i32,
    /// Beginning of the log of which these are all cycles, or a later part.
    pub began: Beginning,
    /// The robot's own axes; `None` if the recording does not hold the answers.
    axes: Option<RobotAxes>,
    /// Robot telegrams are recorded. An imported log has none.
    telegrams: bool,
    /// Sensor samples are counted.
    samples_counted: bool,
    /// A velocity was sent in steps from cycle to cycle.
    commanded: bool,
    /// See [`Self::motion`]; a fit asks for all of them in each of its steps.
    motions: OnceLock<Vec<Option<Motion<f64>>>>,
    /// See [`Self::pose`]; likewise.
    poses: OnceLock<Vec<Option<Pose<f64>>>>,
    /// See [`Self::has_own_acceleration`]; likewise.
    own_accelerations: OnceLock<Vec<bool>>,
}

impl<'a> Signals<'a> {
    /// Reads a recording.
    ///
    /// # Errors
    ///
    /// Fewer than two cycles, unreadable settings, or no cycle time.
    pub fn new(recording: &'a Recording) -> anyhow::Result<Self> {
        let cycles = recording.cycles.as_slice();
        let foreign = recording.header.settings_toml.trim().is_empty();
        if cycles.len() < 2 {
            let cut = recording.cut.as_deref().unwrap_or("the run was too short");
            let again = match foreign {
                true => "import its log again",
                false => "record again, with the loop closed",
            };
            bail!(
                "the recording holds {} cycle(s) and at least 2 are needed ({cut}); {again}",
                cycles.len()
            );
        }
        let settings = if foreign {
            None
        } else {
            Some(recording.header.control_settings()?)
        };
        let cycle_s = match &settings {
            Some(settings) => settings.robot.cycle_s,
            None => sample_time(cycles.iter().map(|c| c.trace.time_s)).unwrap_or(0.0),
        };
        ensure!(
            cycle_s > 0.0 && cycle_s.is_finite(),
            "the time in the recording does not rise from cycle to cycle (found {cycle_s} s); \
             expected a column with the time in seconds"
        );
        let telegrams = cycles.iter().any(|c| c.inputs.robot.counter != 0);
        let answered = telegrams && cycles.iter().any(|c| c.output.correction != [0; 6]);
        let mut signals = Self {
            axes: settings.as_ref().filter(|_| answered).map(RobotAxes::new),
            cycles,
            cycle_s,
            velocity: velocity_meaning(cycles, cycle_s),
            steps: steps(cycles, telegrams),
            settings,
            whole_turns: recording.header.whole_turns,
            began: Beginning {
                time_s: cycles[0].trace.time_s,
                pose: cycles[0].trace.pose,
                whole_turns: recording.header.whole_turns,
            },
            telegrams,
            commanded: cycles.iter().any(|c| c.trace.sent_velocity != [0.0; 6]),
            samples_counted: cycles.iter().any(|c| c.inputs.sensor.counter != 0),
            motions: OnceLock::new(),
            poses: OnceLock::new(),
            own_accelerations: OnceLock::new(),
        };
        let first_pose = (0..signals.len()).find_map(|n| signals.recorded_pose(n));
        signals.began.pose = first_pose.unwrap_or(signals.began.pose);
        signals.began = recording.header.began.unwrap_or(signals.began);
        Ok(signals)
    }

    /// Whole turns of the pose of a cycle about the axis of M about which the poses up to it turn most.
    pub fn whole_turns_at(&self, cycle: usize) -> i32 {
        let turned = |n: usize| {
            Some(Followed {
                pose: self.pose(n)?,
                by_velocity: self.turned_by_velocity(n),
            })
        };
        let poses = || (0..=cycle).filter_map(turned);
        let farthest = turned_since_first(poses())
            .fold(Vector3::zeros(), |most: Vector3<f64>, turned| {
                most.sup(&turned.abs())
            });
        let axis = Vector3::ith(farthest.imax(), 1.0);
        let turned = angles(poses(), &axis, self.whole_turns);
        let (Some(turned), Some(last)) = (turned.last(), poses().last()) else {
            return self.whole_turns;
        };
        ((turned - angle_about(&last.pose, &axis)) / TAU).round() as i32
    }

    /// The same signals with other values in their cycles.
    pub fn with_cycles<'b>(&self, cycles: &'b [CycleRecord]) -> Signals<'b> {
        Signals {
            cycles,
            steps: self.steps.clone(),
            settings: self.settings.clone(),
            axes: self.axes.clone(),
            motions: OnceLock::new(),
            poses: OnceLock::new(),
            own_accelerations: OnceLock::new(),
            ..*self
        }
    }

    /// Number of cycles.
    pub fn len(&self) -> usize {
        self.cycles.len()
    }

    /// Whether a velocity was sent in steps from cycle to cycle.
    pub fn is_commanded(&self) -> bool {
        self.commanded
    }

    /// Whether the log is of a rig, whose controller sends velocities and has a model of its own, and not of any other machine.
    pub fn is_of_a_rig(&self) -> bool {
        self.commanded || self.has_spacecraft()
    }

    /// Whether a model of the spacecraft ran, or its settings are known.
    pub fn has_spacecraft(&self) -> bool {
        let models = |c: &CycleRecord| {
            c.trace
                .model_velocity
                .iter()
                .any(|v| *v != 0.0 && v.is_finite())
        };
        self.settings.is_some() || self.cycles.iter().any(models)
    }

    /// Never: a recording without cycles is refused.
    pub fn is_empty(&self) -> bool {
        self.cycles.is_empty()
    }

    /// Measured pose of M in C, if this cycle has one.
    pub fn pose(&self, n: usize) -> Option<Pose<f64>> {
        let of = |n: usize| Some(pose_of(&self.recorded_pose(n)?));
        let all = || (0..self.len()).map(of).collect();
        *self.poses.get_or_init(all).get(n)?
    }

    /// Whether the wrench differs between rows that have one.
    pub fn wrench_changes(&self) -> bool {
        let rows = self.cycles.iter().map(|c| c.inputs.sensor.wrench);
        let mut known = rows.filter(|row| row.iter().all(|v| v.is_finite()));
        let first = known.next();
        first.is_some_and(|first| known.any(|row| !is_same_wrench(first, row)))
    }

    /// Rotation in cycle n by the recorded velocity, rad in M; zero if unknown.
    pub fn turned_by_velocity(&self, n: usize) -> Vector3<f64> {
        self.moved_by_velocity(n)
            .map_or_else(Vector3::zeros, |moved| moved.angular)
    }

    /// Displacement in cycle n by the recorded velocity, m in C and rad in M; `None` if the cycle does not follow the one before.
    pub fn moved_by_velocity(&self, n: usize) -> Option<Twist<f64>> {
        let last = n.checked_sub(1).filter(|_| self.steps[n] == Step::Next)?;
        let mean = match self.velocity {
            VelocityMeaning::CycleMean => self.executed(n)?,
            VelocityMeaning::Sampled => (self.executed(n)? + self.executed(last)?) * 0.5,
        };
        Some(mean * self.cycle_s)
    }

    /// The recorded numbers of the pose; its quaternion is not normalised.
    fn recorded_pose(&self, n: usize) -> Option<[f64; 7]> {
        let cycle = self.cycles.get(n)?;
        let told = !self.telegrams || cycle.inputs.robot.pose.is_some();
        let pose = cycle.trace.pose;
        (told && pose.iter().all(|v| v.is_finite())).then_some(pose)
    }

    /// Recorded velocity; `None` where it is none, such as a difference of poses in the first cycle of a run or across a gap.
    pub fn executed(&self, n: usize) -> Option<Twist<f64>> {
        let v = self.cycles.get(n)?.trace.executed_velocity;
        let whole = match self.velocity {
            VelocityMeaning::Sampled => true,
            VelocityMeaning::CycleMean => {
                let next = n > 0 && self.steps[n] == Step::Next;
                next && self.recorded_pose(n).is_some() && self.recorded_pose(n - 1).is_some()
            }
        };
        (whole && v.iter().all(|v| v.is_finite())).then(|| Twist::of(&v))
    }

    /// Rates of the robot's axes that were commanded in cycle n, see [`RobotAxes`]; in a log without telegrams the velocity that
    /// was sent.
    pub fn sent_rates(&self, n: usize) -> Six {
        let cycle = &self.cycles[n];
        let last = n.checked_sub(1).and_then(|last| self.cycles.get(last));
        let wire = self
            .axes
            .as_ref()
            .and_then(|axes| axes.sent_rates(last, cycle));
        let sent = wire.unwrap_or_else(|| {
            let meant = cycle.trace.sent_velocity;
            self.turned(n).map_or(meant, |turned| turned.rates(&meant))
        });
        sent.map(|v| if v.is_finite() { v } else { 0.0 })
    }

    /// Map from the rates of the robot's axes to a velocity in the cycle that ended with cycle n; `None` where the rates are the
    /// velocity.
    pub fn turned(&self, n: usize) -> Option<AngleRateMap> {
        self.axes.as_ref()?;
        AngleRateMap::between(self.cycles.get(n.checked_sub(1)?)?, self.cycles.get(n)?)
    }

    /// Whether cycle n has an acceleration of its own. At either end of a stretch of poses without commands it is that of the
    /// neighbouring pose, which is 23 % off for an oscillation of 35 rad/s at 10 ms.
    pub fn has_own_acceleration(&self, n: usize) -> bool {
        let derived = self.velocity == VelocityMeaning::CycleMean && !self.commanded;
        let of = |n: usize| [0, 1].iter().all(|j| self.within_stretch(n, *j).is_some());
        let all = || (0..self.len()).map(of).collect();
        !derived || self.own_accelerations.get_or_init(all)[n]
    }

    /// Velocity and acceleration at the instant of the pose of cycle n, as they were measured.
    pub fn motion(&self, n: usize) -> Option<Motion<f64>> {
        let at = |n| {
            Some(Motion {
                velocity: self.velocity_at_pose(n)?,
                acceleration: self.acceleration_at_pose(n),
            })
        };
        let all = self
            .motions
            .get_or_init(|| (0..self.len()).map(at).collect());
        *all.get(n)?
    }

    /// Velocity at the instant of the pose of cycle n.
    pub fn velocity_at_pose(&self, n: usize) -> Option<Twist<f64>> {
        match self.velocity {
            VelocityMeaning::Sampled => self.executed(n),
            VelocityMeaning::CycleMean if !self.commanded => {
                velocity_of_means(|j| self.within_stretch(n, j))
            }
            VelocityMeaning::CycleMean => match (self.executed(n), self.executed(n + 1)) {
                (Some(before), Some(after)) => Some((before + after) * 0.5),
                (before, after) => before.or(after),
            },
        }
    }

    /// Acceleration at the instant of the pose; zero where only one velocity is known.
    ///
    /// Where velocities are sent it is the mean over the cycle: a held command is a staircase, and docking-rig-log/1 defines the
    /// inertial load by it. In any other log it is a central difference, as the one over the last cycle is half a cycle late: a
    /// mass m that oscillates with ω would show the damping −m ω² Ts/2.
    pub fn acceleration_at_pose(&self, n: usize) -> Twist<f64> {
        let executed = |j| self.within_stretch(n, j);
        let change = match (self.velocity, self.commanded) {
            (VelocityMeaning::CycleMean, false) => acceleration_of_means(executed),
            (VelocityMeaning::Sampled, false) => acceleration_of_samples(executed),
            (VelocityMeaning::CycleMean, true) => change(executed(0), executed(1)),
            (VelocityMeaning::Sampled, true) => change(executed(-1), executed(0)),
        };
        change.unwrap_or(Twist::zero()) * (1.0 / self.cycle_s)
    }

    /// Recorded velocity `offset` cycles later; `None` beyond a gap. A difference of two poses does not count if the earlier pose
    /// is beyond the gap.
    fn within_stretch(&self, n: usize, offset: isize) -> Option<Twist<f64>> {
        let at = n.checked_add_signed(offset)?;
        let next = |k: usize| self.steps.get(k) == Some(&Step::Next);
        let derived = self.velocity == VelocityMeaning::CycleMean && !self.commanded;
        let whole = (n.min(at) + 1..=n.max(at)).all(next) && (!derived || next(at));
        whole.then(|| self.executed(at)).flatten()
    }

    /// The cycle in which the wrench of cycle n was new; `None` if there was no sample yet.
    pub fn sampled_in(&self, n: usize) -> Option<usize> {
        let cycle = self.cycles.get(n)?;
        let finite = cycle.inputs.sensor.wrench.iter().all(|v| v.is_finite());
        if !finite || (self.samples_counted && cycle.inputs.sensor.counter == 0) {
            return None;
        }
        n.checked_sub(cycle.trace.sensor_age as usize)
    }

    /// Noise of the recorded velocity, one standard deviation.
    ///
    /// A difference of two poses has √2 times the pose's noise per cycle if that is white, and less if a filter has correlated
    /// neighbouring samples.
    pub fn velocity_sigma(&self, model: &Model) -> Six {
        let noise = &model.noise;
        match self.velocity {
            VelocityMeaning::Sampled => six(noise.velocity_m_s, noise.rate_rad_s),
            VelocityMeaning::CycleMean => {
                let per_cycle = self.noise_of_steps(model) / self.cycle_s;
                six(noise.position_m * per_cycle, noise.angle_rad * per_cycle)
            }
        }
    }

    /// Noise of the difference of successive samples, in units of that of a sample.
    pub(super) fn noise_of_steps(&self, model: &Model) -> f64 {
        noise_of(&[-1.0, 1.0], self.filter(model))
    }

    fn filter(&self, model: &Model) -> Option<LowPassed> {
        model
            .sensor
            .filter
            .map(|filter| filter.on_samples(self.cycle_s))
    }

    /// Noise of [`Self::velocity_at_pose`] and [`Self::acceleration_at_pose`], far from gaps, one standard deviation: from white
    /// noise, or noise that the filter of the log has passed.
    ///
    /// Where velocities are sent: σ and √2 σ / Ts for sampled velocities; for poses those of (p(n+1) − p(n−1)) / 2 Ts and of
    /// their second difference, √6 σ / Ts².
    pub fn motion_sigma(&self, model: &Model) -> (Six, Six) {
        let filter = self.filter(model);
        let of = |taps: &[f64]| noise_of(taps, filter);
        // Noise of a mean velocity times Ts, in units of the pose's.
        let of_pose = self.noise_of_steps(model);
        let acceleration = of(&self.acceleration_taps());
        let (velocity, acceleration) = match (self.velocity, self.commanded) {
            (VelocityMeaning::Sampled, _) => (1.0, acceleration),
            (VelocityMeaning::CycleMean, false) => {
                (of(&taps_of_first()) / of_pose, acceleration / of_pose)
            }
            (VelocityMeaning::CycleMean, true) => {
                (of(&[-0.5, 0.0, 0.5]) / of_pose, acceleration / of_pose)
            }
        };
        let recorded = self.velocity_sigma(model);
        (
            recorded.map(|s| s * velocity),
            recorded.map(|s| s * acceleration / self.cycle_s),
        )
    }

    /// Weights of the samples in [`Self::acceleration_at_pose`], far from gaps: of velocities, times Ts, or of the poses that they
    /// were computed from, times Ts².
    fn acceleration_taps(&self) -> Vec<f64> {
        match (self.velocity, self.commanded) {
            (VelocityMeaning::Sampled, false) => taps_of_first().to_vec(),
            (VelocityMeaning::Sampled, true) => vec![-1.0, 1.0],
            (VelocityMeaning::CycleMean, false) => taps_of_second().to_vec(),
            (VelocityMeaning::CycleMean, true) => vec![1.0, -2.0, 1.0],
        }
    }

    /// Power density that white noise of the recorded motion has in [`Self::acceleration_at_pose`], up to a factor: a function of
    /// the frequency relative to the sampling rate.
    pub fn noise_of_acceleration(&self) -> impl Fn(f64) -> f64 {
        let taps = self.acceleration_taps();
        move |frequency| {
            let waves = taps.iter().enumerate();
            let wave = |(n, weight): (usize, &f64)| {
                Complex::from_polar(*weight, TAU * frequency * n as f64)
            };
            waves.map(wave).sum::<Complex<f64>>().norm_sqr()
        }
    }
}

/// Change from one velocity to the next.
fn change(from: Option<Twist<f64>>, to: Option<Twist<f64>>) -> Option<Twist<f64>> {
    Some(to? - from?)
}

fn steps(cycles: &[CycleRecord], telegrams: bool) -> Vec<Step> {
    if !telegrams {
        let missing = |n: usize| n > 0 && cycles[n].trace.cycle > cycles[n - 1].trace.cycle + 1;
        let step = |n: usize| if missing(n) { Step::Hole } else { Step::Next };
        return (0..cycles.len()).map(step).collect();
    }
    let mut last: Option<u64> = None;
    cycles
        .iter()
        .map(|cycle| {
            let number = cycle.trace.cycle;
            let consecutive = last.map_or(number == 0, |last| number == last.wrapping_add(1));
            last = Some(number);
            match (cycle.inputs.robot.sequence, consecutive) {
                (Sequence::NewRun, _) => Step::NewRun,
                (_, false) => Step::Hole,
                (Sequence::Gap(lost), true) => Step::Lost(lost),
                (Sequence::Next, true) => Step::Next,
            }
        })
        .collect()
}

/// Whether the recorded velocity is the difference of two poses.
///
/// If it is, it contains their noise, and explains the steps of the position to the digits of the recording. If the velocity was
/// measured independently, either interpretation leaves the noise of the poses, and which leaves less is chance. Where the
/// velocity is constant, both are the same.
fn velocity_meaning(cycles: &[CycleRecord], cycle_s: f64) -> VelocityMeaning {
    /// Largest ratio of the squared errors under the two interpretations that speaks for a difference of poses.
    const OF_POSES: f64 = 0.25;
    /// Relative difference of velocities that is round-off.
    const ROUND_OFF: f64 = 1e-9;
    let pose = |c: &CycleRecord| pose_of(&c.trace.pose);
    let velocity = |c: &CycleRecord| Vector6::from_row_slice(&c.trace.executed_velocity);
    let (mut of_poses, mut steps) = (0, 0);
    for pair in cycles.windows(2) {
        let (from, to): (Pose<f64>, Pose<f64>) = (pose(&pair[0]), pose(&pair[1]));
        let displacement = to.translation.vector - from.translation.vector;
        let [before, after] = [0, 1].map(|n| velocity(&pair[n]));
        let mean = (before + after) * (0.5 * cycle_s);
        let by_velocity = mean.fixed_rows::<3>(3).into_owned();
        let turn = turn_between(&from.rotation, &to.rotation, &by_velocity);
        let moved = Vector6::new(
            displacement.x,
            displacement.y,
            displacement.z,
            turn.x,
            turn.y,
            turn.z,
        );
        if (after - before).norm() <= ROUND_OFF * after.norm() {
            continue;
        }
        let of_mean = (moved - after * cycle_s).norm_squared();
        let of_sampled = (moved - mean).norm_squared();
        if of_mean.is_finite() && of_sampled.is_finite() {
            of_poses += usize::from(of_mean <= OF_POSES * of_sampled);
            steps += 1;
        }
    }
    // The majority of steps decides: across gaps of the recording neither interpretation holds.
    if of_poses * 2 >= steps {
        VelocityMeaning::CycleMean
    } else {
        VelocityMeaning::Sampled
    }
}
