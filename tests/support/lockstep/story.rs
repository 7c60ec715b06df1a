//! Steps with all events in the life of a rig: flight, contacts, commands in every mode, faults of the sensor and of the
//! line, datagrams of other computers, garbage.

use crate::walls::Case;
use softdock_app::record::CycleRecord;
use softdock_app::settings::BoardSettings;
use softdock_control::delay::ModelVelocity;
use softdock_control::modes::Command;
use softdock_link::rsi::{RobTelegram, write_rob};
use softdock_lockstep::Step;

/// Time stamp of the first telegram, ms.
const FIRST_IPOC: u64 = 4_000_000;
/// Cycles from one start to the next.
const CHAPTER: usize = 2500;
/// Decimals that the robot sends.
const DECIMALS: u8 = 6;

/// Steps of `cycles` cycles for a board with `settings`. The inputs are those of a spacecraft that bounces between two turned
/// walls and also turns slowly; they do not depend on the answers.
///
/// # Panics
/// If the telegrams cannot be written.
pub fn story(settings: &BoardSettings, cycles: usize) -> Vec<Step> {
    let mut case = Case::new(15.0, 0.01).turned(0.4);
    case.left_m = 0.002;
    case.right_m = 0.002;
    // All bounces are equally fast.
    case.settings.delay.model_velocity = ModelVelocity::End;
    let mut rig = case.start::<f64>();
    let mut steps = Vec::with_capacity(cycles);
    let mut kept = Step::default();
    for n in 0..cycles {
        let record = rig.step();
        let mut step = step(settings, n, &record);
        spoil(n, &mut step, &kept);
        kept = step.clone();
        // Telegrams are lost, once for a short and once for too long a time.
        if !matches!(n % CHAPTER, 1600..1602 | 2300..2315) {
            steps.push(step);
        }
    }
    steps
}

fn step(settings: &BoardSettings, n: usize, record: &CycleRecord) -> Step {
    let cycle_s = settings.control.robot.cycle_s;
    let cycle_ms = (cycle_s * 1e3).round() as u64;
    let seconds = n as f64 * cycle_s;
    let [x, y, z, ..] = record.inputs.robot.pose.expect("the rig has a pose");
    let turn = [0.3, 0.7, 1.1].map(|rate: f64| (rate * seconds).sin());
    let mm = [x, y, z].map(|metres| 1000.0 * metres);
    let pose = [mm[0], mm[1], mm[2], turn[0], turn[1], turn[2]];
    let telegram = RobTelegram {
        ipoc: FIRST_IPOC + cycle_ms * n as u64,
        actual_pose: Some(pose),
        setpoint_pose: Some(pose),
        late_answers: Some(0),
        poscorr_stat: Some(1),
    };
    let tags = settings.rsi.tags().expect("usable settings");
    let mut bytes = [0; 1024];
    let length = write_rob(&telegram, DECIMALS, &tags, &mut bytes).expect("a telegram");
    let mut sample = record.inputs.sensor;
    sample.counter = n as u32 + 1;
    sample.counts = [i32::from(n as i16), 1, 2, 3, 4, 5];
    for (torque, turn) in sample.wrench[3..].iter_mut().zip(turn) {
        *torque = 0.2 * turn;
    }
    Step {
        datagram: heapless::Vec::from_slice(&bytes[..length]).expect("it fits"),
        sender: 0,
        now_us: 1000 * cycle_ms * n as u64,
        sample,
        command: command(n % CHAPTER),
    }
}

/// Each chapter is started and stopped. In between, reset, arm and start are tried repeatedly; they are refused while the
/// loop is closed and while the load is too large.
fn command(cycle: usize) -> Option<Command> {
    match (cycle, cycle % 100) {
        (5, _) => Some(Command::Hold),
        (7 | 1550, _) => Some(Command::Zero),
        (2000, _) => Some(Command::Stop),
        (_, 10) => Some(Command::Reset),
        (_, 20) => Some(Command::Arm),
        (_, 30) => Some(Command::Start),
        _ => None,
    }
}

/// Faults, each at a different place; the longer ones in separate chapters.
fn spoil(n: usize, step: &mut Step, last: &Step) {
    let (chapter, cycle) = (n / CHAPTER, n % CHAPTER);
    match (chapter % 8, cycle) {
        (_, 300) => step.sender = 1,
        (_, 310) => *step = last.clone(),
        (_, 320) => step.datagram.truncate(step.datagram.len() / 2),
        (_, 330) => step.datagram.fill(b'<'),
        (_, 340..343) => step.sample.counter = 0,
        (1, 1200..1240) => step.sample.counter = last.sample.counter,
        (2, 1200) => step.sample.saturated = true,
        (3, 1200) => step.sample.wrench[2] = 1e9,
        (4, 1200) => step.sample.wrench[1] = f64::NAN,
        (5, 1200) => step.sample.status = 0x8000,
        (6, 1200..1210) => step.sample.wrench[4] = 80.0,
        _ => {}
    }
}
