//! The rig against a board that takes three cycles for each answer.

use super::*;
use crate::rig::RigSettings;
use softdock_link::rsi::{SenTelegram, parse_rob, write_sen};

/// Telegrams that the slow board answers.
const ANSWERS: usize = 20;
const ANY: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 0);

struct Silent;

impl Watcher for Silent {
    fn captured(&self) {}

    fn say(&self, _: &str) {}
    fn show(&self, _: &Tally) {}
}

/// Late answers that the robot reported in each answered telegram, and what the rig counted.
fn beside_a_slow_board(patience: Duration) -> (Vec<u32>, Summary) {
    let board = UdpSocket::bind(ANY).unwrap();
    let settings = BoardSettings::default();
    let tags = settings.rsi.tags().unwrap();
    let mut rig = RigSettings::default();
    rig.robot.timeout_cycles = 1_000_000;
    let three_cycles = Duration::from_micros(3 * u64::from(rig.cycle_us));
    let peer = Peer {
        rig,
        start_pose: [1.0, 0.0, 1.0, 0.0, 0.0, 0.0],
        seed: 1,
        board: settings,
        robot: board.local_addr().unwrap(),
        // Nothing listens there.
        sensor: SensorLink::Can(SocketAddr::from((Ipv4Addr::LOCALHOST, 1))),
        patience,
    };
    let stop = AtomicBool::new(false);
    thread::scope(|scope| {
        let answers = scope.spawn(|| {
            let mut late = Vec::new();
            let mut bytes = [0; 2048];
            while late.len() < ANSWERS {
                let (length, robot) = board.recv_from(&mut bytes).unwrap();
                let telegram = parse_rob(&bytes[..length], &tags).unwrap();
                thread::sleep(three_cycles);
                late.push(telegram.late_answers.unwrap());
                let answer = SenTelegram {
                    ipoc: telegram.ipoc,
                    ..SenTelegram::default()
                };
                let length = write_sen(&answer, &tags, &mut bytes).unwrap();
                board.send_to(&bytes[..length], robot).unwrap();
            }
            stop.store(true, Ordering::Relaxed);
            late
        });
        let (_, poses) = std::sync::mpsc::channel();
        let tally = peer.run(&stop, None, poses, &Silent).unwrap();
        (answers.join().unwrap(), tally.summary())
    })
}

#[test]
fn a_robot_counts_late_answers_and_goes_on() {
    let (late, counted) = beside_a_slow_board(Duration::ZERO);
    assert!(late.last() > Some(&0), "{late:?}");
    assert_eq!(counted.waited, 0);
    assert!(counted.late + counted.missed > 0, "{counted}");
}

#[test]
fn the_clock_of_a_patient_rig_waits_and_the_robot_knows_nothing_of_it() {
    let (late, counted) = beside_a_slow_board(Duration::from_secs(60));
    assert_eq!(late, [0; ANSWERS]);
    // The first telegram of a run is repeated until it is answered; the end cuts off at most two.
    assert!(counted.waited >= ANSWERS as u64 - 4, "{counted}");
    assert_eq!(counted.late, counted.waited);
    assert!(
        counted.to_string().contains("the rig's clock waited for"),
        "{counted}"
    );
}
