//! A robot's conversation with a board, for every law: the bytes determine telegrams, samples and commands.

use super::Script;
use core::net::SocketAddr;
use softdock_app::robot_link::{Incoming, Prepared, RobotLink};
use softdock_app::settings::BoardSettings;
use softdock_control::delay::LawName;
use softdock_control::io::SensorSample;
use softdock_control::modes::{Command, Mode};
use softdock_link::rsi::{RobTelegram, Tags, parse_sen, write_rob};

/// Most events of a conversation.
const EVENTS: usize = 300;
/// Counts of the largest step of 2 mm, with the rounding of two cycles.
const LARGEST_STEP: i64 = 20_002;

pub(super) fn robot_session(input: &[u8]) {
    let mut script = Script(input);
    let mut settings = BoardSettings::default();
    settings.rsi.robot_ip = "192.168.1.10".try_into().unwrap();
    settings.control.body_k.velocity_m_s = [0.01, 0.0, 0.0];
    settings.control.delay.law = script.choose(&LawName::ALL);
    let tags = settings.rsi.tags().unwrap();
    let mut link = RobotLink::<f64>::new(Prepared::new(&settings).unwrap());
    let mut sample = SensorSample::default();
    let mut telegram = RobTelegram {
        ipoc: 1_000,
        actual_pose: Some([0.0; 6]),
        ..RobTelegram::default()
    };
    let robot = SocketAddr::from(([192, 168, 1, 10], 50_000));
    for n in 0..EVENTS {
        let Some(event) = script.byte() else {
            return;
        };
        let mut command = None;
        match event % 8 {
            0 => command = Some(script.choose(&Command::WORDS).1),
            1 => sample.wrench = core::array::from_fn(|_| script.number(1.0)),
            2 => telegram.actual_pose = Some(core::array::from_fn(|_| script.number(0.1))),
            3 => {
                telegram.ipoc = telegram
                    .ipoc
                    .wrapping_add(script.byte().unwrap_or_default().into())
            }
            4 => {
                let datagram = script.piece().unwrap_or_default();
                answer(&mut link, datagram, robot, sample, None, &tags);
                continue;
            }
            5 => sample.status = u32::from_le_bytes(script.bytes()),
            _ => {}
        }
        if event % 8 != 7 {
            sample.counter += 1;
            sample.counts[0] = n as i32;
        }
        telegram.ipoc = telegram.ipoc.wrapping_add(4);
        let mut bytes = [0; 1024];
        if let Ok(length) = write_rob(&telegram, 6, &tags, &mut bytes) {
            answer(&mut link, &bytes[..length], robot, sample, command, &tags);
        }
    }
}

/// A readable telegram is answered with its counter; in a fault the robot does not move, and no step exceeds its limit.
fn answer(
    link: &mut RobotLink<f64>,
    datagram: &[u8],
    from: SocketAddr,
    sample: SensorSample,
    command: Option<Command>,
    tags: &Tags,
) {
    let (counter, bytes) = match link.receive(datagram, from, 0) {
        Incoming::Telegram(report) => {
            if let Some(sequence) = link.follow(&report) {
                let record = link.run_cycle(&report, sequence, sample, command);
                let correction = record.output.correction;
                assert!(record.trace.mode != Mode::Fault || correction == [0; 6]);
                assert!(
                    correction[..3]
                        .iter()
                        .all(|counts| counts.abs() <= LARGEST_STEP),
                    "{correction:?}"
                );
            }
            (report.counter, link.last_answer().to_vec())
        }
        Incoming::Unreadable { counter } => (counter, link.resting_answer(counter).to_vec()),
        Incoming::Ignored => return,
    };
    let answer = parse_sen(&bytes, tags).expect("an answer");
    assert_eq!(answer.ipoc, counter);
}
