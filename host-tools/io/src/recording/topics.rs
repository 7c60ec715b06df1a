//! The format: each topic with all of its fields, in their order in the message.
//!
//! This is the one place where a recorded number gets its name, its unit and its meaning. All
//! topics together hold a complete cycle.

use super::TruthRecord;
use super::field::{Field, Number, Parts, Unit, Visitor};
use super::single::Single;
use super::words::Word;
use softdock_app::record::{CycleRecord, Inputs, Output, RobotReport};
use softdock_control::delay::PARTS;
use softdock_control::delay::status::{LawFlags, LawStatus};
use softdock_control::io::{BodyTrace, SensorSample, Sequence, Trace};
use softdock_control::limits::LimitFlags;
use softdock_control::modes::Fault;

/// Everything that is recorded of a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Row {
    pub(super) cycle: CycleRecord,
    pub(super) truth: TruthRecord,
    /// Checksum of the computed numbers, where these are in single precision.
    pub(super) checksum: u32,
}

/// A topic: one message per cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Topic {
    Robot,
    Sensor,
    Operator,
    Output,
    Wrench,
    Motion,
    BodyK,
    BodyQ,
    ModelVelocity,
    /// Relative motion of the docking surfaces, as an observer sees it.
    Docking,
    Law,
    /// State and actions of the delay law.
    LawStatus,
    Command,
    Status,
    /// Only in recordings of a simulated rig.
    Truth,
    /// Checksum of the computed numbers; only where these are in single precision.
    Checksum,
    /// [`Self::Sensor`] as earlier versions wrote it: status and counts have 16 bits.
    SensorOf16Bits,
}

impl Topic {
    /// All topics in the order in which they are written.
    const ALL: [Self; 15] = [
        Self::Robot,
        Self::Sensor,
        Self::Operator,
        Self::Output,
        Self::Wrench,
        Self::Motion,
        Self::BodyK,
        Self::BodyQ,
        Self::ModelVelocity,
        Self::Docking,
        Self::Law,
        Self::LawStatus,
        Self::Command,
        Self::Status,
        Self::Truth,
    ];

    /// Topics that a cycle computes from its inputs; see `recomputation`.
    pub(super) const COMPUTED: [Self; 8] = [
        Self::Wrench,
        Self::BodyK,
        Self::BodyQ,
        Self::ModelVelocity,
        Self::Docking,
        Self::Law,
        Self::LawStatus,
        Self::Command,
    ];

    /// The topics of a recording, with or without the rig's truth.
    pub(super) fn all(truth: bool) -> &'static [Self] {
        let [without @ .., _] = &Self::ALL;
        if truth { &Self::ALL } else { without }
    }

    /// Name of the topic, and of its type in the schema.
    fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Robot => ("/inputs/robot", "softdock/msg/Robot"),
            Self::Sensor | Self::SensorOf16Bits => ("/inputs/sensor", "softdock/msg/Sensor"),
            Self::Operator => ("/inputs/command", "softdock/msg/Operator"),
            Self::Output => ("/output", "softdock/msg/Output"),
            Self::Wrench => ("/wrench", "softdock/msg/Wrench"),
            Self::Motion => ("/motion", "softdock/msg/Motion"),
            Self::BodyK => ("/model/k", "softdock/msg/Body"),
            Self::BodyQ => ("/model/q", "softdock/msg/Body"),
            Self::ModelVelocity => ("/model/velocity", "softdock/msg/ModelVelocity"),
            Self::Docking => ("/model/docking", "softdock/msg/Docking"),
            Self::Law => ("/law", "softdock/msg/Law"),
            Self::LawStatus => ("/law/status", "softdock/msg/LawStatus"),
            Self::Command => ("/command", "softdock/msg/Command"),
            Self::Status => ("/status", "softdock/msg/Status"),
            Self::Truth => ("/truth", "softdock/msg/Truth"),
            Self::Checksum => ("/checksum", "softdock/msg/Checksum"),
        }
    }

    /// Name of the topic.
    pub(super) fn name(self) -> &'static str {
        self.names().0
    }

    /// Prefix of its column names: `model_k`.
    pub(super) fn prefix(self) -> String {
        self.name().trim_start_matches('/').replace('/', "_")
    }

    /// The topic with this name, if there is one.
    pub(super) fn from_name(name: &str) -> Option<Self> {
        let mut all = Self::ALL.into_iter().chain([Self::Checksum]);
        all.find(|topic| topic.name() == name)
    }

    /// One bit for each topic; both forms of a topic have the same bit.
    pub(super) fn bit(self) -> u16 {
        match self {
            Self::SensorOf16Bits => Self::Sensor.bit(),
            _ => 1 << self as u16,
        }
    }

    /// The forms that its messages may have in a file.
    pub(super) fn forms(self) -> [Form; 2] {
        match self {
            Self::Sensor => [Self::Sensor, Self::SensorOf16Bits].map(Form::Full),
            any => [Form::Full(any), any.in_single()],
        }
    }

    /// The form that a simulated run's recording has: computed topics are in single precision.
    pub(super) fn in_single(self) -> Form {
        if Self::COMPUTED.contains(&self) {
            Form::Single(self)
        } else {
            Form::Full(self)
        }
    }

    /// Goes through all fields of the topic's message.
    pub(super) fn visit<V: Visitor>(self, v: &mut V, row: &mut Row) -> Result<(), V::Error> {
        let Row {
            cycle,
            truth,
            checksum,
        } = row;
        let CycleRecord {
            inputs,
            output,
            trace,
        } = cycle;
        match self {
            Self::Robot => robot(v, &mut inputs.robot),
            Self::Sensor => sensor::<V, u32, i32>(v, &mut inputs.sensor),
            Self::SensorOf16Bits => sensor::<V, u16, i16>(v, &mut inputs.sensor),
            Self::Operator => operator(v, inputs),
            Self::Output => answer(v, output),
            Self::Wrench => wrench(v, trace),
            Self::Motion => motion(v, trace),
            Self::BodyK => body(v, &mut trace.body_k),
            Self::BodyQ => body(v, &mut trace.body_q),
            Self::ModelVelocity => model_velocity(v, trace),
            Self::Docking => docking(v, &mut trace.docking),
            Self::Law => law(v, trace),
            Self::LawStatus => law_status(v, trace),
            Self::Command => command(v, trace),
            Self::Status => status(v, trace),
            Self::Truth => rig_truth(v, truth),
            Self::Checksum => scalar(v, ("crc32", Unit::NONE, CHECKSUM), checksum),
        }
    }
}

/// A topic and the precision of its numbers in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    Full(Topic),
    Single(Topic),
}

impl From<Topic> for Form {
    fn from(topic: Topic) -> Self {
        Self::Full(topic)
    }
}

impl Form {
    pub(super) fn topic(self) -> Topic {
        let (Self::Full(topic) | Self::Single(topic)) = self;
        topic
    }

    /// Name of the message type in the schema; in single precision it ends in 32.
    pub(super) fn schema_name(self) -> String {
        let ending = if matches!(self, Self::Single(_)) {
            "32"
        } else {
            ""
        };
        self.topic().names().1.to_owned() + ending
    }

    /// Visits all fields of the message.
    pub(super) fn visit<V: Visitor>(self, v: &mut V, row: &mut Row) -> Result<(), V::Error> {
        match self {
            Self::Full(topic) => topic.visit(v, row),
            Self::Single(topic) => topic.visit(&mut Single(v), row),
        }
    }
}

const CHECKSUM: &str =
    "CRC-32 of all digits of the numbers in float32, which inputs and settings give back";

const XYZ: Parts =
    Parts::message("geometry_msgs/Vector3", &["x", "y", "z"]).or_single("geometry_msgs/Point32");
const ABC: Parts = Parts::message("softdock/Angles", &["a", "b", "c"]);
/// ROS 2's own quaternion has w last.
const WXYZ: Parts = Parts::message("softdock/QuaternionWxyz", &["w", "x", "y", "z"])
    .or_single("softdock/QuaternionWxyz32");
const XYZABC: Parts = Parts::message("softdock/Correction", &["x", "y", "z", "a", "b", "c"]);
const GAUGES: Parts = Parts::array(&["0", "1", "2", "3", "4", "5"]);

/// Parts of the paper's law in the order of its Fig. 9. Other laws put their own parts here.
const LAW_PARTS: [LawPart; PARTS] = [
    LawPart("c1_linear", "c1_angular", "c1 Σ s_v |dv|"),
    LawPart("c2_linear", "c2_angular", "c2 Σ s_v |dv|²"),
    LawPart("c3_linear", "c3_angular", "c3 Σ s_v |dv|³"),
    LawPart("c4_linear", "c4_angular", "c4 Σ s_v |dv|⁴"),
    LawPart("b0_linear", "b0_angular", "b0 s_dv"),
    LawPart("b1_linear", "b1_angular", "b1 s_v |dv|"),
    LawPart("back_linear", "back_angular", "v_back"),
];

/// Names of a part of the law, linear and angular, and its term in the paper.
struct LawPart(&'static str, &'static str, &'static str);

fn robot<V: Visitor>(v: &mut V, robot: &mut RobotReport) -> Result<(), V::Error> {
    let about = "time stamp of the telegram";
    scalar(v, ("ipoc", Unit::MILLISECOND, about), &mut robot.counter)?;

    let (mut code, mut lost) = match robot.sequence {
        Sequence::NewRun => (0, 0),
        Sequence::Next => (1, 0),
        Sequence::Gap(lost) => (2, lost),
    };
    let words = &["new_run", "next", "gap"];
    let about = "place of the telegram in the robot's sequence";
    v.choice(&single("sequence", Unit::NONE, about), words, &mut code)?;
    let about = "telegrams lost before this one";
    scalar(v, ("lost", Unit::NONE, about), &mut lost)?;
    robot.sequence = match code {
        0 => Sequence::NewRun,
        1 => Sequence::Next,
        _ => Sequence::Gap(lost),
    };

    let mut known = robot.pose.is_some();
    let mut pose = robot.pose.unwrap_or([f64::NAN; 6]);
    let about = "the telegram holds a pose; without one its numbers are NaN";
    scalar(v, ("pose_known", Unit::NONE, about), &mut known)?;
    let [x, y, z, a, b, c] = &mut pose;
    let (mut position, mut angles) = ([*x, *y, *z], [*a, *b, *c]);
    let about = "measured position of M in C";
    v.numbers(&array("position", Unit::METRE, XYZ, about), &mut position)?;
    let about = "measured angles A B C of M in C";
    v.numbers(&array("angle", Unit::RADIAN, ABC, about), &mut angles)?;
    [*x, *y, *z] = position;
    [*a, *b, *c] = angles;
    robot.pose = known.then_some(pose);

    let about = "the robot's counter of late or rejected answers";
    let late = &mut robot.late_answers;
    scalar(v, ("late_answers", Unit::NONE, about), late)?;
    let about = "POSCORR status bits: 1-3 lower, 4-6 upper X Y Z, 7 rotation clamped";
    let stat = &mut robot.status;
    scalar(v, ("poscorr_stat", Unit::NONE, about), stat)
}

fn sensor<V, Status, Count>(v: &mut V, sensor: &mut SensorSample) -> Result<(), V::Error>
where
    V: Visitor,
    Status: Number + Default + Into<u32> + TryFrom<u32>,
    Count: Number + Default + Into<i32> + TryFrom<i32>,
{
    let about = "number of the newest sample; 0 before the first";
    let counter = &mut sensor.counter;
    scalar(v, ("counter", Unit::NONE, about), counter)?;
    let about = "status word of the sensor";
    let mut status = Status::try_from(sensor.status).unwrap_or_default();
    scalar(v, ("status", Unit::NONE, about), &mut status)?;
    sensor.status = status.into();
    let about = "a gauge is at its range";
    let saturated = &mut sensor.saturated;
    scalar(v, ("saturated", Unit::NONE, about), saturated)?;
    let about = "raw words of the six gauges";
    let field = array("gauge", Unit::COUNTS, GAUGES, about);
    let mut counts = sensor
        .counts
        .map(|count| Count::try_from(count).unwrap_or_default());
    v.numbers(&field, &mut counts)?;
    sensor.counts = counts.map(Into::into);
    let names = ["force", "torque"];
    loads(v, names, "raw, in S", &mut sensor.wrench)
}

fn operator<V: Visitor>(v: &mut V, inputs: &mut Inputs) -> Result<(), V::Error> {
    let about = "command of the operator in this cycle";
    word(v, ("command", about), &mut inputs.command)
}

fn answer<V: Visitor>(v: &mut V, output: &mut Output) -> Result<(), V::Error> {
    let about = "correction as sent, in units of the last digit of mm and degrees";
    let field = array("correction", Unit::COUNTS, XYZABC, about);
    v.numbers(&field, &mut output.correction)?;
    let about = "the robot is asked to stop";
    scalar(v, ("stop", Unit::NONE, about), &mut output.stop)
}

fn wrench<V: Visitor>(v: &mut V, trace: &mut Trace) -> Result<(), V::Error> {
    let about = "compensated contact wrench at M, axes of M";
    loads(v, ["force", "torque"], about, &mut trace.wrench_at_m)?;
    let names = ["removed_force", "removed_torque"];
    let about = "weight and inertia of the tool that were removed, in S";
    loads(v, names, about, &mut trace.removed)
}

fn motion<V: Visitor>(v: &mut V, trace: &mut Trace) -> Result<(), V::Error> {
    pose(v, "measured, of M in C", &mut trace.pose)?;
    let about = "measured velocity of M: difference of two poses";
    twist(v, SPEED, about, &mut trace.executed_velocity)
}

fn body<V: Visitor>(v: &mut V, body: &mut BodyTrace) -> Result<(), V::Error> {
    pose(v, "of the spacecraft in C", &mut body.pose)?;
    twist(v, SPEED, "of the spacecraft", &mut body.velocity)
}

fn model_velocity<V: Visitor>(v: &mut V, trace: &mut Trace) -> Result<(), V::Error> {
    let about = "velocity of the model in the laboratory";
    twist(v, SPEED, about, &mut trace.model_velocity)
}

fn docking<V: Visitor>(v: &mut V, docking: &mut BodyTrace) -> Result<(), V::Error> {
    pose(
        v,
        "of the docking surface J of K, seen from P of Q",
        &mut docking.pose,
    )?;
    let about = "of J relative to P: linear in axes of P, angular in axes of J";
    twist(v, SPEED, about, &mut docking.velocity)
}

fn law<V: Visitor>(v: &mut V, trace: &mut Trace) -> Result<(), V::Error> {
    for (LawPart(linear, angular, term), part) in LAW_PARTS.iter().zip(&mut trace.law_parts) {
        twist(v, [linear, angular], term, part)?;
    }
    let names = ["sum_linear", "sum_angular"];
    let about = "velocity that the law asks for: the model's and all parts";
    twist(v, names, about, &mut trace.law_velocity)
}

fn law_status<V: Visitor>(v: &mut V, trace: &mut Trace) -> Result<(), V::Error> {
    let LawStatus {
        confidence,
        flags: LawFlags(flags),
        stiffness_n_per_m,
        damping_n_s_per_m,
        delay_s,
        latency_cycles,
        misfit,
    } = &mut trace.law_status;
    word(v, ("rung", "confidence level of the law"), confidence)?;
    scalar(v, ("flags", Unit::NONE, LawFlags::MEANING), flags)?;
    let about = "identified along the direction of contact";
    scalar(
        v,
        ("stiffness", Unit::NEWTON_PER_METRE, about),
        stiffness_n_per_m,
    )?;
    scalar(
        v,
        ("damping", Unit::NEWTON_SECOND_PER_METRE, about),
        damping_n_s_per_m,
    )?;
    let about = "mean delay of the robot, followed while running";
    scalar(v, ("delay", Unit::SECOND, about), delay_s)?;
    let about = "cycles by which the reported pose is older than the force";
    scalar(v, ("latency", Unit::CYCLES, about), latency_cycles)?;
    let about = "misfit of the robot before a contact, of the contact from then on";
    scalar(v, ("misfit", Unit::NONE, about), misfit)?;
    let names = ["unaccounted_impulse", "unaccounted_angular_impulse"];
    let about = "felt by the model beyond the measured wrench, at M, axes of M";
    let (linear, angular) = trace.unaccounted_impulse.split_at_mut(3);
    v.numbers(&array(names[0], Unit::NEWTON_SECOND, XYZ, about), linear)?;
    v.numbers(
        &array(names[1], Unit::NEWTON_METRE_SECOND, XYZ, about),
        angular,
    )
}

fn command<V: Visitor>(v: &mut V, trace: &mut Trace) -> Result<(), V::Error> {
    pose(v, "commanded, of M in C", &mut trace.command_pose)?;
    let about = "velocity after the limits: what is sent";
    twist(v, SPEED, about, &mut trace.sent_velocity)
}

fn status<V: Visitor>(v: &mut V, trace: &mut Trace) -> Result<(), V::Error> {
    let about = "number of the cycle since boot";
    scalar(v, ("cycle", Unit::NONE, about), &mut trace.cycle)?;
    let about = "number of the cycle times the nominal cycle time";
    scalar(v, ("time", Unit::SECOND, about), &mut trace.time_s)?;
    let about = "mode in which the cycle was answered";
    word(v, ("mode", about), &mut trace.mode)?;

    let mut code = trace.fault.map(|fault| fault.code);
    let [mut expected, mut received] = trace
        .fault
        .map_or([f64::NAN; 2], |fault| [fault.expected, fault.received]);
    word(v, ("fault", "the latched fault"), &mut code)?;
    let about = "limit that the fault's number is compared with; NaN without a fault";
    scalar(v, ("fault_expected", Unit::NONE, about), &mut expected)?;
    let about = "number that latched the fault; NaN without a fault";
    scalar(v, ("fault_received", Unit::NONE, about), &mut received)?;
    trace.fault = code.map(|code| Fault::new(code, expected, received));

    let about = "why a command was refused in this cycle";
    word(v, ("refusal", about), &mut trace.refusal)?;
    let LimitFlags(limits) = &mut trace.limits;
    scalar(v, ("limits", Unit::NONE, LimitFlags::MEANING), limits)?;
    let about = "cycles since the newest sensor sample";
    let age = &mut trace.sensor_age;
    scalar(v, ("sensor_age", Unit::CYCLES, about), age)
}

fn rig_truth<V: Visitor>(v: &mut V, truth: &mut TruthRecord) -> Result<(), V::Error> {
    scalar(v, ("time", Unit::SECOND, "of the rig"), &mut truth.time_s)?;
    pose(v, "true, of M in C", &mut truth.pose)?;
    twist(v, SPEED, "true, of M", &mut truth.velocity)?;
    let about = "true contact wrench at M, axes of M";
    loads(v, ["force", "torque"], about, &mut truth.contact_wrench)
}

/// Names of a velocity that needs no other.
const SPEED: [&str; 2] = ["linear", "angular"];

const fn single(name: &'static str, unit: Unit, about: &'static str) -> Field {
    array(name, unit, Parts::NONE, about)
}

const fn array(name: &'static str, unit: Unit, parts: Parts, about: &'static str) -> Field {
    Field {
        name,
        unit,
        parts,
        about,
    }
}

fn scalar<V: Visitor, T: Number>(
    v: &mut V,
    (name, unit, about): (&'static str, Unit, &'static str),
    value: &mut T,
) -> Result<(), V::Error> {
    v.numbers(&single(name, unit, about), core::slice::from_mut(value))
}

fn word<V: Visitor, T: Word + Copy>(
    v: &mut V,
    (name, about): (&'static str, &'static str),
    value: &mut T,
) -> Result<(), V::Error> {
    let mut code = value.code();
    v.choice(&single(name, Unit::NONE, about), T::WORDS, &mut code)?;
    // A visitor returns only codes that have a word.
    *value = T::from_code(code).unwrap_or(*value);
    Ok(())
}

/// Force (N) and torque (N·m).
fn loads<V: Visitor>(
    v: &mut V,
    [force, torque]: [&'static str; 2],
    about: &'static str,
    wrench: &mut [f64; 6],
) -> Result<(), V::Error> {
    let (forces, torques) = wrench.split_at_mut(3);
    v.numbers(&array(force, Unit::NEWTON, XYZ, about), forces)?;
    v.numbers(&array(torque, Unit::NEWTON_METRE, XYZ, about), torques)
}

/// Linear velocity in C (m/s) and angular velocity in body axes (rad/s).
fn twist<V: Visitor>(
    v: &mut V,
    [linear, angular]: [&'static str; 2],
    about: &'static str,
    velocity: &mut [f64; 6],
) -> Result<(), V::Error> {
    let (linear_part, angular_part) = velocity.split_at_mut(3);
    let field = array(linear, Unit::METRE_PER_SECOND, XYZ, about);
    v.numbers(&field, linear_part)?;
    let field = array(angular, Unit::RADIAN_PER_SECOND, XYZ, about);
    v.numbers(&field, angular_part)
}

/// Position (m) and quaternion (w x y z).
fn pose<V: Visitor>(v: &mut V, about: &'static str, pose: &mut [f64; 7]) -> Result<(), V::Error> {
    let (position, orientation) = pose.split_at_mut(3);
    v.numbers(&array("position", Unit::METRE, XYZ, about), position)?;
    let field = array("orientation", Unit::NONE, WXYZ, about);
    v.numbers(&field, orientation)
}
