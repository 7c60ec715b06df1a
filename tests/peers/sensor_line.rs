//! What can happen on the sensor's line: noise, silence, another client.

use softdock_control::modes::{FaultCode, Mode};
use softdock_io::recording::Recording;
use softdock_tests::peers::{BUSY_COMPUTER, Board, Robot, Sensor, counted};

/// Answers are lost after 20 ms here, so that the line resynchronises within the test.
fn settings(velocity: &str) -> String {
    let patient = BUSY_COMPUTER.replace("answer_timeout_s = 1.0", "answer_timeout_s = 0.02");
    format!("{patient}\n[control.body_k]\nvelocity_m_s = {velocity}\n")
}

#[test]
fn noise_on_the_line_is_survived() {
    let mut board = Board::start("noise", &settings("[0.0, 0.0, 0.0]"), &["--start"]);
    let sensor = Sensor::connect(board.can);
    board.process.wait_for("sensor Running");
    let mut robot = Robot::new(board.robot);
    board.cycles_until(&mut robot, "mode Running");
    sensor.be_noisy(true);
    let before = sensor.readings();
    let mut cycles = 0;
    while sensor.readings() < before + 400 {
        robot.cycle();
        cycles += 1;
        assert!(cycles < 100_000, "the sensor is not asked any more");
    }
    sensor.be_noisy(false);
    for _ in 0..20 {
        robot.cycle();
    }
    let (path, _) = board.stop();
    let recording = Recording::open(&path).unwrap();
    let last = recording.cycles[recording.cycles.len() - 1];
    assert_eq!((last.trace.mode, last.trace.fault), (Mode::Running, None));
    // Some answers were spoiled, and most came through.
    let read = u64::from(last.inputs.sensor.counter);
    assert!(
        read > before + 200 && read < sensor.readings(),
        "{read} of {} readings",
        sensor.readings()
    );
}

#[test]
fn without_its_sensor_the_board_faults_and_still_answers() {
    let patient = settings("[0.005, 0.0, 0.0]");
    let strict = patient.replace("fault_after_cycles = 1000", "fault_after_cycles = 200");
    let mut board = Board::start("silence", &strict, &["--start"]);
    let sensor = Sensor::connect(board.can);
    board.process.wait_for("sensor Running");
    let mut robot = Robot::new(board.robot);
    board.cycles_until(&mut robot, "mode Running");
    sensor.be_silent(true);
    board.cycles_until(
        &mut robot,
        "fault: cycles without a new sensor sample: expected 200, received 201",
    );
    for _ in 0..200 {
        // The robot checks that each answer has its time stamp.
        let answer = robot.cycle();
        assert!(answer.is_zero(), "{answer:?}");
    }
    // The operator may not go on before the sensor does.
    board.process.say("reset");
    board.cycles_until(&mut robot, "reset refused: there is no fresh sensor sample");
    let (path, log) = board.stop();
    assert_eq!(counted(&log, "lost"), 0, "{log}");
    let recording = Recording::open(&path).unwrap();
    let last = recording.cycles[recording.cycles.len() - 1].trace;
    assert_eq!(
        (last.mode, last.fault.map(|f| f.code)),
        (Mode::Fault, Some(FaultCode::SensorStale))
    );
}

#[test]
fn a_new_client_takes_the_place_of_the_old() {
    let mut board = Board::start("clients", &settings("[0.0, 0.0, 0.0]"), &["--start"]);
    let first = Sensor::connect(board.can);
    board.process.wait_for("sensor Running");
    let mut robot = Robot::new(board.robot);
    board.cycles_until(&mut robot, "mode Running");
    let second = Sensor::connect(board.can);
    let mut cycles = 0;
    while second.readings() < 100 {
        robot.cycle();
        cycles += 1;
        assert!(cycles < 100_000, "the second client is not asked");
    }
    let left = first.readings();
    for _ in 0..100 {
        robot.cycle();
    }
    assert_eq!(
        first.readings(),
        left,
        "the first client is not asked any more"
    );
    let (path, _) = board.stop();
    let recording = Recording::open(&path).unwrap();
    assert_eq!(
        recording.cycles[recording.cycles.len() - 1].trace.fault,
        None
    );
}
