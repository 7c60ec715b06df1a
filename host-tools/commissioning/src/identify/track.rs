//! What one axis was commanded, and where it went.

use super::reversals::Steps;
use softdock_physics::model::Axis;
use softdock_physics::model::log::Log;
use softdock_report::number;

/// Longest memory of a robot, s: commands before the recording are not known.
const PAST_S: f64 = 0.3;
/// Least number of judged cycles.
const FEWEST_CYCLES: usize = 50;
/// Share of the fastest sent velocity that is a motion.
const MOVES: f64 = 0.02;
/// An axis rests if its fastest sent velocity is below this share of that of the fastest axis of its kind.
const RESTS: f64 = 1e-3;

/// One axis.
#[derive(Clone, Debug)]
pub(super) struct Track {
    /// Which.
    pub axis: Axis,
    /// Cycle, s.
    pub cycle_s: f64,
    /// Velocity sent in each cycle, m/s or rad/s.
    pub sent: Vec<f64>,
    /// Measured position at each cycle, m or rad.
    pub position: Vec<f64>,
    /// First cycle in which all commands that act are known.
    pub first: usize,
    /// Steps of the position that no actuator has to explain.
    pub steps: Steps,
}

impl Track {
    /// Fastest sent velocity.
    pub(super) fn fastest(&self) -> f64 {
        self.sent.iter().fold(0.0, |m, v| m.max(v.abs()))
    }

    /// Largest change of the sent velocity from one cycle to the next.
    pub(super) fn largest_step(&self) -> f64 {
        let steps = self.sent.windows(2).map(|w| (w[1] - w[0]).abs());
        steps.fold(0.0, f64::max)
    }

    /// Whether the sign of the sent velocity changes.
    pub(super) fn reverses(&self) -> bool {
        let moving = self
            .sent
            .iter()
            .filter(|v| v.abs() > MOVES * self.fastest());
        let signs: Vec<f64> = moving.map(|v| v.signum()).collect();
        signs.windows(2).any(|pair| pair[0] != pair[1])
    }

    /// Number of positions that are judged.
    pub(super) fn judged(&self) -> usize {
        self.position.len() - self.first
    }

    /// Share of the sent positions that the judged ones follow (a regression coefficient), and the correlation of both (-1 to 1),
    /// at the delay with the largest correlation.
    pub(super) fn followed(&self) -> (f64, f64) {
        let sent = self.sent.iter().scan(0.0, |place, velocity| {
            *place += velocity * self.cycle_s;
            Some(*place)
        });
        let sent: Vec<f64> = sent.collect();
        let measured = centred(&self.position[self.first..]);
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let late = |cycles: usize| {
            let at = |n: usize| sent[n.saturating_sub(cycles)];
            let told = centred(&(self.first..sent.len()).map(at).collect::<Vec<_>>());
            let [both, own] = [&measured, &told].map(|other| product(&told, other));
            (
                both / own,
                both / (own * product(&measured, &measured)).sqrt(),
            )
        };
        let delays = 0..=(PAST_S / self.cycle_s) as usize;
        let most = delays.map(late).filter(|(_, alike)| alike.is_finite());
        // For a periodic motion the smallest delay.
        most.fold((0.0, 0.0), |most, now| {
            if now.1.abs() > most.1.abs() {
                now
            } else {
                most
            }
        })
    }

    /// The same with an allowance for uncertain reversals: the axis is `late_s` late, and its positions have this `noise`, m or
    /// rad.
    pub(super) fn with_uncertain_reversals(&self, late_s: f64, noise: f64) -> Self {
        let late = (late_s / self.cycle_s).round() as usize;
        let sent = &self.sent[self.first..];
        Self {
            steps: Steps::at_reversals(sent, late, MOVES * self.fastest(), noise),
            ..self.clone()
        }
    }

    /// The unit of its velocity.
    pub(super) fn unit(&self) -> &'static str {
        if self.axis.index() < 3 {
            "m/s"
        } else {
            "rad/s"
        }
    }
}

/// Values without their mean.
pub(super) fn centred(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter().map(|value| value - mean).collect()
}

/// The axes that move and were commanded to, and why the others are refused.
pub(super) fn tracks(log: &Log) -> (Vec<Track>, Vec<String>) {
    let (mut tracks, mut refused) = (Vec::new(), Vec::new());
    let positions = positions(log);
    for axis in Axis::ALL {
        let track = Track {
            axis,
            cycle_s: log.cycle_s,
            sent: log.sent[axis.index()].clone(),
            position: positions[axis.index()].clone(),
            first: 0,
            steps: Steps::origin(log.time_s.len()),
        };
        match checked(track, log) {
            Ok(track) => tracks.push(track),
            Err(reason) => refused.push(reason),
        }
    }
    // Of a pure translation, the rounding of the angles is no motion.
    let fastest = |kind: bool| {
        let of_kind = tracks
            .iter()
            .filter(|t: &&Track| (t.axis.index() < 3) == kind);
        of_kind.map(Track::fastest).fold(0.0, f64::max)
    };
    let (linear, angular) = (fastest(true), fastest(false));
    tracks.retain(|t| {
        let of_kind = if t.axis.index() < 3 { linear } else { angular };
        t.fastest() > RESTS * of_kind
    });
    (tracks, refused)
}

/// The track with its first judged cycle; an error if it shows nothing.
fn checked(mut track: Track, log: &Log) -> Result<Track, String> {
    let axis = track.axis;
    if track.fastest() == 0.0 {
        return Err(format!("{axis} was sent no velocity"));
    }
    let at_rest = track.sent.first().is_some_and(|v| *v == 0.0);
    track.first = if at_rest {
        0
    } else {
        (PAST_S / log.cycle_s).ceil() as usize
    };
    if track.sent.len() < track.first + FEWEST_CYCLES {
        return Err(format!(
            "{axis} was recorded for {} cycles, at least {} are needed",
            track.sent.len(),
            track.first + FEWEST_CYCLES
        ));
    }
    track.steps = Steps::origin(track.judged());
    let judged = &track.sent[track.first.saturating_sub(1)..];
    let (low, high) = judged
        .iter()
        .fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
    if high - low < 1e-9 * track.fastest() {
        return Err(format!(
            "{axis} was sent one velocity all the time ({} {})",
            number::significant(low, 2),
            track.unit()
        ));
    }
    Ok(track)
}

/// Position of each axis: translation in C, and for rotations the sum of small rotations about the axes in which velocities were
/// sent: the robot's own angles where they are recorded, otherwise the axes of M.
fn positions(log: &Log) -> [Vec<f64>; 6] {
    let mut positions: [Vec<f64>; 6] =
        std::array::from_fn(|_| Vec::with_capacity(log.time_s.len()));
    let mut turned = [0.0; 3];
    for n in 0..log.time_s.len() {
        if n > 0 {
            let turn = (log.rotation(n - 1).inverse() * log.rotation(n)).scaled_axis();
            let about_m = [0.0, 0.0, 0.0, turn.x, turn.y, turn.z];
            let own = log.turned[n].map_or(about_m, |turned| turned.rates(&about_m));
            (0..3).for_each(|axis| turned[axis] += own[axis + 3]);
        }
        let position = log.position(n);
        for axis in 0..3 {
            positions[axis].push(position[axis]);
            positions[axis + 3].push(turned[axis]);
        }
    }
    positions
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_app::record::CycleRecord;
    use softdock_control::frames::{Pose, orientation_from_abc, pose_components};
    use softdock_control::io::Sequence;
    use softdock_control::settings::Settings;
    use softdock_io::recording::Recording;
    use softdock_physics::model::Model;
    use std::f64::consts::PI;

    /// Flange down, A turns against z of M: what was sent and what was measured are of the same angle.
    #[test]
    fn a_rotation_is_measured_in_the_angle_that_was_sent() {
        const COUNTS: i64 = 100;
        let decimals = Settings::default().robot.correction_decimals;
        let step_rad = (COUNTS as f64 * 0.1_f64.powi(decimals.into())).to_radians();
        let cycle = |n: u64| {
            let mut cycle = CycleRecord::default();
            cycle.trace.cycle = n;
            cycle.trace.time_s = n as f64 * 0.004;
            cycle.inputs.robot.counter = 4 * n + 4;
            let abc = [n as f64 * step_rad, 0.0, PI];
            cycle.inputs.robot.pose = Some([0.0, 0.0, 0.0, abc[0], abc[1], abc[2]]);
            let pose = Pose::from_parts(Default::default(), orientation_from_abc::<f64>(&abc));
            cycle.trace.pose = pose_components(&pose);
            cycle.inputs.robot.sequence = match n {
                0 => Sequence::NewRun,
                _ => Sequence::Next,
            };
            cycle.output.correction[3] = COUNTS as _;
            cycle
        };
        let mut recording = Recording {
            cycles: (0..20).map(cycle).collect(),
            ..Recording::default()
        };
        recording.header.settings_toml =
            "[control.robot]\ncorrection_mode = \"relative\"\n".to_owned();
        let log = Log::new(&Model::default(), &recording).unwrap();
        let angle = &positions(&log)[5];
        let moved = angle[10] - angle[9];
        let sent = log.sent[5][10] * log.cycle_s;
        assert!((sent - step_rad).abs() < 1e-12, "{sent} {step_rad}");
        assert!((moved - step_rad).abs() < 1e-9, "{moved} {step_rad}");
    }
}
