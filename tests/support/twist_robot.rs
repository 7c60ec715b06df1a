//! A second robot, for tests only: a fixed binary protocol with a cycle of 1 ms whose robot reports a quaternion and executes
//! twists. It has neither KUKA's angles nor its millimetres, decimals or IPOC.
//!
//! All numbers are little-endian.
//!
//! | telegram, 76 bytes | answer, 37 bytes |
//! |---|---|
//! | `TWST` | `TWSA` |
//! | u64 time stamp, µs | u64 time stamp, µs |
//! | 7 × f64 pose: x y z (m), quaternion w x y z | 6 × f32 twist: linear in C (m/s), angular in M (rad/s) |
//! | u32 late answers | u8 stop |
//! | u32 status: bit 0 clamped | |

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use softdock_app::record::{Correction, Output, RobotReport};
use softdock_app::robot_protocol::{Received, RobotProtocol};
use softdock_control::io::{self, Motion, RobotSample, Sequence};
use softdock_control::robot::RobotInterface;

/// Cycle of the robot, µs.
pub const CYCLE_US: u64 = 1000;
/// Cycle of the robot, s.
pub const CYCLE_S: f64 = 1e-3;
/// Number of cycles without a telegram after which the next one begins a new run.
const NEW_RUN_AFTER: u64 = 1000;

const TELEGRAM: [u8; 4] = *b"TWST";
const ANSWER: [u8; 4] = *b"TWSA";

/// Position (m) and orientation.
pub type Place = (Vector3<f64>, UnitQuaternion<f64>);

/// The board's side.
#[derive(Clone, Debug)]
pub struct Twists {
    last: Option<u64>,
    /// Sum of the sent twists since the start.
    sent: Place,
}

impl Default for Twists {
    fn default() -> Self {
        Self {
            last: None,
            sent: (Vector3::zeros(), UnitQuaternion::identity()),
        }
    }
}

impl RobotProtocol for Twists {
    fn interface(&self) -> RobotInterface {
        RobotInterface {
            cycle_s: CYCLE_S,
            gimbal_lock: None,
        }
    }

    fn read(&self, datagram: &[u8]) -> Received {
        let Some((TELEGRAM, rest)) = take::<4>(datagram) else {
            return Received::Unreadable;
        };
        let Some((counter, rest)) = take::<8>(rest) else {
            return Received::Unreadable;
        };
        let counter = u64::from_le_bytes(counter);
        match body(rest) {
            Some((pose, late_answers, status)) => Received::Telegram(RobotReport {
                counter,
                sequence: Sequence::default(),
                pose: Some(pose),
                late_answers,
                status,
            }),
            None => Received::Counter(counter),
        }
    }

    fn forget(&mut self) {
        self.last = None;
    }

    fn follow(&mut self, counter: u64) -> Option<Sequence> {
        let Some(last) = self.last.replace(counter) else {
            return Some(Sequence::NewRun);
        };
        match counter.checked_sub(last).map(|step| step / CYCLE_US) {
            Some(0) => None,
            Some(1) => Some(Sequence::Next),
            Some(cycles @ ..=NEW_RUN_AFTER) => Some(Sequence::Gap(cycles as u32 - 1)),
            _ => Some(Sequence::NewRun),
        }
    }

    fn is_late(&self, counter: u64, other: u64) -> bool {
        counter < other
    }

    fn sample(&self, report: &RobotReport) -> RobotSample {
        RobotSample {
            sequence: report.sequence,
            pose: report.pose.map(|pose| {
                let (p, q) = place(pose);
                [p.x, p.y, p.z, q.w, q.i, q.j, q.k]
            }),
            gimbal_locked: false,
            late_answers: report.late_answers,
            clamped: report.status & 1 != 0,
        }
    }

    fn correct(&mut self, report: &RobotReport, wanted: &io::Output) -> Correction {
        if wanted.start {
            let (_, orientation) = place(report.pose.unwrap_or_default());
            self.sent = (Vector3::zeros(), orientation);
        }
        let Motion::Move {
            displacement_m,
            orientation_wxyz: [w, x, y, z],
            ..
        } = wanted.motion
        else {
            return self.rest();
        };
        let orientation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let step = Vector3::from(displacement_m) - self.sent.0;
        let turn = (self.sent.1.inverse() * orientation).scaled_axis();
        let twist = [step.x, step.y, step.z, turn.x, turn.y, turn.z];
        let twist = twist.map(|step| (step / CYCLE_S) as f32);
        // The remainder of the rounding is sent with the next twist.
        advance(&mut self.sent, twist);
        twist.map(|rate| rate.to_bits().into())
    }

    fn rest(&self) -> Correction {
        [0; 6]
    }

    fn write(&self, counter: u64, answer: &Output, bytes: &mut [u8]) -> usize {
        let mut written = ANSWER.to_vec();
        written.extend(counter.to_le_bytes());
        written.extend(
            answer
                .correction
                .iter()
                .flat_map(|bits| rate(*bits).to_le_bytes()),
        );
        written.push(answer.stop.into());
        match bytes.get_mut(..written.len()) {
            Some(bytes) => {
                bytes.copy_from_slice(&written);
                written.len()
            }
            None => 0,
        }
    }
}

/// The robot: it executes each answer, and stands still in a cycle without an answer.
#[derive(Clone, Debug)]
pub struct TwistRobot {
    /// Time stamp of the next telegram, µs.
    pub counter: u64,
    /// Position and orientation.
    pub place: Place,
    /// Status bits.
    pub status: u32,
}

/// Content of an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// Time stamp of the telegram that it answers.
    pub counter: u64,
    /// Twist of the present cycle.
    pub twist: [f32; 6],
    /// Whether the robot is asked to stop.
    pub stop: bool,
}

impl TwistRobot {
    /// The next telegram.
    pub fn telegram(&self) -> Vec<u8> {
        let (p, q) = &self.place;
        let mut bytes = TELEGRAM.to_vec();
        bytes.extend(self.counter.to_le_bytes());
        let pose = [p.x, p.y, p.z, q.w, q.i, q.j, q.k];
        bytes.extend(pose.iter().flat_map(|v| v.to_le_bytes()));
        bytes.extend(0_u32.to_le_bytes());
        bytes.extend(self.status.to_le_bytes());
        bytes
    }

    /// Moves for a cycle.
    pub fn execute(&mut self, answer: &Answer) {
        advance(&mut self.place, answer.twist);
    }
}

impl Answer {
    /// Reads an answer; none if it is not complete.
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let (magic, rest) = take::<4>(bytes)?;
        let (counter, rest) = take::<8>(rest)?;
        let (twist, rest) = numbers::<6, 4>(rest)?;
        let &[stop] = rest else { return None };
        (magic == ANSWER).then_some(Self {
            counter: u64::from_le_bytes(counter),
            twist: twist.map(f32::from_le_bytes),
            stop: stop != 0,
        })
    }
}

/// Moves for one cycle at a twist.
fn advance((position, orientation): &mut Place, twist: [f32; 6]) {
    let [x, y, z, a, b, c] = twist.map(|rate| f64::from(rate) * CYCLE_S);
    *position += Vector3::new(x, y, z);
    *orientation *= UnitQuaternion::from_scaled_axis(Vector3::new(a, b, c));
}

/// The place in a report: x y z and a rotation vector.
fn place([x, y, z, a, b, c]: [f64; 6]) -> Place {
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(a, b, c));
    (Vector3::new(x, y, z), turn)
}

/// Pose in the form of a report, late answers and status.
fn body(bytes: &[u8]) -> Option<([f64; 6], u32, u32)> {
    let (pose, rest) = numbers::<7, 8>(bytes)?;
    let (late, rest) = take::<4>(rest)?;
    let (status, rest) = take::<4>(rest)?;
    let [x, y, z, w, i, j, k] = pose.map(f64::from_le_bytes);
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k)).scaled_axis();
    let pose = [x, y, z, turn.x, turn.y, turn.z];
    rest.is_empty()
        .then_some((pose, u32::from_le_bytes(late), u32::from_le_bytes(status)))
}

/// The number that an integer of a record encodes: the bits of an f32.
fn rate(bits: i64) -> f32 {
    f32::from_bits(bits as u32)
}

fn take<const N: usize>(bytes: &[u8]) -> Option<([u8; N], &[u8])> {
    bytes
        .split_first_chunk()
        .map(|(first, rest)| (*first, rest))
}

fn numbers<const COUNT: usize, const BYTES: usize>(
    bytes: &[u8],
) -> Option<([[u8; BYTES]; COUNT], &[u8])> {
    let (head, rest) = bytes.split_at_checked(COUNT * BYTES)?;
    let mut all = [[0; BYTES]; COUNT];
    for (number, chunk) in all.iter_mut().zip(head.chunks_exact(BYTES)) {
        number.copy_from_slice(chunk);
    }
    Some((all, rest))
}
