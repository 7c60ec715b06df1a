//! What comes on the robot's port besides one good telegram per cycle: garbage, strangers,
//! repetitions, queues.

use softdock_tests::peers::{BUSY_COMPUTER, Board, Robot, Sensor, counted};

/// Cycles of the start ramp, with some to spare.
const RAMP: usize = 40;

/// Datagrams of the robot that were no telegrams. One that waits together with the next telegram
/// is passed over, like everything that is not the newest.
fn unread_by_board(log: &str) -> u64 {
    counted(log, "malformed") + counted(log, "overtaken")
}

/// A running board whose loop is closed and moves at 5 mm/s, with robot and sensor.
fn moving(test: &str) -> (Board, Robot, Sensor) {
    let settings = format!("{BUSY_COMPUTER}\n[control.body_k]\nvelocity_m_s = [0.005, 0.0, 0.0]\n");
    let mut board = Board::start(test, &settings, &["--start"]);
    let sensor = Sensor::connect(board.can);
    board.process.wait_for("sensor Running");
    let mut robot = Robot::new(board.robot);
    let mut cycles = 0;
    while robot.cycle().is_zero() {
        cycles += 1;
        assert!(
            cycles < 100_000,
            "the robot never moved\n{}",
            board.process.transcript()
        );
    }
    for _ in 0..RAMP {
        robot.cycle();
    }
    (board, robot, sensor)
}

#[test]
fn garbage_costs_a_counter() {
    let (board, mut robot, _sensor) = moving("garbage");
    let whole = robot.telegram(robot.ipoc);
    let garbage: [&[u8]; 6] = [
        b"",
        b"\x00\xff\xfe garbage \x80",
        b"<Rob Type=\"KUKA\"><IPOC>123</Rob>",
        b"<Rob Type=\"KUKA\"><RIst X=\"nan\"/></Rob>",
        &whole.as_bytes()[..whole.len() / 2],
        &[b'<'; 1500],
    ];
    for datagram in garbage {
        robot.send(datagram);
        // The cycle's own answer is the next thing that comes: garbage had none.
        assert!(!robot.cycle().is_zero(), "the loop goes on");
    }
    let (_, log) = board.stop();
    assert_eq!(robot.unread(), 0);
    assert_eq!(
        (unread_by_board(&log), counted(&log, "lost")),
        (6, 0),
        "{log}"
    );
}

#[test]
fn a_telegram_that_is_damaged_behind_its_time_stamp_is_answered_with_zero() {
    let (board, mut robot, _sensor) = moving("damaged");
    let whole = robot.telegram(robot.ipoc);
    let damaged = whole.replace("<Delay D=\"0\"/>", "<Delay D=\"0\">");
    robot.send(damaged.as_bytes());
    let answer = robot.receive();
    assert_eq!(answer.ipoc, robot.ipoc);
    assert!(answer.is_zero(), "{answer:?}");
    robot.apply(&answer);
    assert!(!robot.cycle().is_zero(), "the loop goes on");
    let (_, log) = board.stop();
    assert_eq!(
        (counted(&log, "malformed"), counted(&log, "lost")),
        (1, 1),
        "{log}"
    );
}

#[test]
fn a_datagram_that_is_too_long_is_cut_off_and_survived() {
    let (board, mut robot, _sensor) = moving("oversize");
    // Good XML, but longer than an Ethernet frame: its time stamp is not read any more.
    let padded = robot
        .telegram(robot.ipoc)
        .replace("<Delay", &format!("{}<Delay", " ".repeat(60_000)));
    robot.send(padded.as_bytes());
    assert!(!robot.cycle().is_zero(), "the loop goes on");
    let (_, log) = board.stop();
    assert_eq!(robot.unread(), 0);
    assert_eq!(
        (unread_by_board(&log), counted(&log, "lost")),
        (1, 0),
        "{log}"
    );
}

#[test]
fn a_stranger_gets_no_answer_and_changes_nothing() {
    let (board, mut robot, _sensor) = moving("stranger");
    let stranger = Robot::new(board.robot);
    let before = robot.cycle();
    for ipoc in [robot.ipoc, robot.ipoc + 4, 1, u64::MAX] {
        stranger.send(stranger.telegram(ipoc).as_bytes());
        let answer = robot.cycle();
        // Free flight: the same step, but for the rounding that is carried on.
        assert!(
            (answer.correction[0] - before.correction[0]).abs() <= 1,
            "{:?} after {:?}",
            answer.correction,
            before.correction
        );
    }
    assert_eq!(stranger.unread(), 0);
    let (_, log) = board.stop();
    assert_eq!(
        (counted(&log, "foreign"), counted(&log, "lost")),
        (4, 0),
        "{log}"
    );
}

#[test]
fn a_telegram_that_comes_twice_gets_the_same_answer_twice() {
    let (board, mut robot, _sensor) = moving("twice");
    for _ in 0..10 {
        let telegram = robot.telegram(robot.ipoc);
        robot.send(telegram.as_bytes());
        let first = robot.receive();
        robot.send(telegram.as_bytes());
        assert_eq!(robot.receive(), first);
        robot.apply(&first);
    }
    let (_, log) = board.stop();
    assert_eq!(
        (counted(&log, "twice"), counted(&log, "lost")),
        (10, 0),
        "{log}"
    );
}

#[test]
fn of_queued_telegrams_the_newest_is_answered() {
    const BURST: u64 = 10;
    let (board, mut robot, sensor) = moving("queued");
    // Without a reading each cycle waits 2 ms for one, so that a burst is sure to queue.
    sensor.be_silent(true);
    let mut answered = 0;
    for _ in 0..10 {
        let newest = robot.ipoc + 4 * (BURST - 1);
        for cycle in 0..BURST {
            robot.send(robot.telegram(robot.ipoc + 4 * cycle).as_bytes());
        }
        let mut last = 0;
        while last < newest {
            let answer = robot.receive();
            assert!(answer.ipoc > last, "{} after {last}", answer.ipoc);
            last = answer.ipoc;
            answered += 1;
        }
        assert_eq!(last, newest);
        robot.ipoc = newest + 4;
    }
    assert_eq!(robot.unread(), 0);
    let (_, log) = board.stop();
    let overtaken = counted(&log, "overtaken");
    assert!(overtaken > 0, "{log}");
    assert_eq!(overtaken + answered, 10 * BURST, "{log}");
    assert_eq!(
        counted(&log, "lost"),
        overtaken,
        "an overtaken cycle is a lost one\n{log}"
    );
}
