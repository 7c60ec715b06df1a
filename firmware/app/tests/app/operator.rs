//! The operator's commands and the start without an operator.

use crate::bench::{Bench, START_CYCLES, counts, flying};
use crate::sensor::{Behaviour, opcode};
use softdock_app::auto_start::AutoStart;
use softdock_control::modes::{Command, FaultCode, Mode, Refusal};
use softdock_link::sensor::SensorState;

const RESET: u16 = 0xC;

fn sensor_resets(bench: &Bench) -> usize {
    let world = bench.world();
    world
        .requests
        .iter()
        .filter(|(_, f)| opcode(f) == RESET)
        .count()
}

#[test]
fn without_a_wish_nothing_starts() {
    let mut bench = Bench::new(&flying(), false);
    for _ in 0..100 {
        assert_eq!(counts(&bench.cycle()), [0; 6]);
    }
    assert_eq!(bench.status().mode, Mode::Idle);
}

#[test]
fn an_automatic_start_waits_for_the_sensor() {
    let mut bench = Bench::switched_on(&flying(), true);
    bench.world().sensor.behaviour = Behaviour::Silent;
    bench.cycles(100);
    assert_eq!(bench.status().mode, Mode::Hold);
    // The automatic start gives no command that would be refused.
    assert_eq!(bench.status().refusal, None);
    bench.world().sensor.behaviour = Behaviour::Healthy;
    bench.cycles(100);
    assert_eq!(bench.status().mode, Mode::Running);
    assert_eq!(bench.status().refusal, None);
}

#[test]
fn an_automatic_start_is_not_repeated_after_a_stop() {
    let mut bench = Bench::cruising(&flying());
    bench.command(Command::Stop);
    bench.cycles(200);
    assert_eq!(bench.status().mode, Mode::Hold);
    assert_eq!(counts(&bench.cycle()), [0; 6]);
    // The operator may start again.
    assert_eq!(bench.command(Command::Arm).trace.mode, Mode::Armed);
    assert_eq!(bench.command(Command::Start).trace.mode, Mode::Running);
}

/// The state that a restart of the board would interrupt.
#[test]
fn the_board_says_that_it_moves_until_a_stop_has_faded_out() {
    let mut bench = Bench::new(&flying(), false);
    bench.cycle();
    for (command, moves) in [
        (Command::Hold, false),
        (Command::Arm, true),
        (Command::Start, true),
    ] {
        bench.command(command);
        assert_eq!(bench.status().moves, moves, "{command:?}");
    }
    bench.cycles(START_CYCLES);
    bench.command(Command::Stop);
    assert_eq!(bench.status().mode, Mode::Hold);
    while counts(&bench.cycle()) != [0; 6] {
        assert!(bench.status().moves);
    }
    bench.cycle();
    assert!(!bench.status().moves);
}

#[test]
fn a_robot_near_the_gimbal_lock_of_its_angles_is_not_armed() {
    let mut bench = Bench::new(&flying(), false);
    bench.cycle();
    for (b_deg, refusal) in [
        (89.9, Some(Refusal::OrientationSingular)),
        (-89.9, Some(Refusal::OrientationSingular)),
        (45.0, None),
    ] {
        bench.says.actual_pose = Some([1000.0, 0.0, 1000.0, 0.0, b_deg, 0.0]);
        bench.command(Command::Hold);
        let record = bench.command(Command::Arm);
        assert_eq!(record.trace.refusal, refusal, "B = {b_deg}");
    }
}

#[test]
fn an_automatic_start_is_not_repeated_after_a_fault() {
    let mut bench = Bench::cruising(&flying());
    bench.lose(20);
    bench.cycle();
    assert_eq!(bench.fault(), Some(FaultCode::TelegramsLost));
    bench.cycles(100);
    assert_eq!(bench.fault(), Some(FaultCode::TelegramsLost));
    assert_eq!(bench.command(Command::Reset).trace.mode, Mode::Hold);
    bench.cycles(200);
    assert_eq!(bench.status().mode, Mode::Hold);
}

#[test]
fn an_automatic_start_gives_way_to_an_operator() {
    for (cycles, command) in [(1, Command::Stop), (2, Command::Hold), (2, Command::Stop)] {
        let mut bench = Bench::new(&flying(), true);
        bench.cycles(cycles);
        bench.command(command);
        bench.cycles(START_CYCLES);
        assert_eq!(
            bench.status().mode,
            Mode::Hold,
            "{command:?} after {cycles}"
        );
    }
}

/// It ends also at its own start or at a fault.
#[test]
fn an_automatic_start_is_for_once() {
    for mode in [Mode::Running, Mode::Fault] {
        let mut start = AutoStart::new(true);
        assert_eq!(start.command(Mode::Hold, false), None);
        assert_eq!(start.command(Mode::Hold, true), Some(Command::Arm));
        assert_eq!(start.command(mode, true), None);
        assert_eq!(start.command(Mode::Hold, true), None);
    }
}

/// A new run of the robot before the loop is closed does not end the automatic start.
#[test]
fn an_automatic_start_survives_a_new_run_before_it() {
    let mut bench = Bench::new(&flying(), true);
    bench.cycles(2);
    assert_eq!(bench.status().mode, Mode::Armed);
    bench.says.ipoc = 0;
    bench.cycle();
    assert_ne!(bench.status().mode, Mode::Running);
    bench.cycles(5);
    assert_eq!(bench.status().mode, Mode::Running);
}

#[test]
fn a_refused_command_shows_until_one_is_accepted() {
    let mut bench = Bench::new(&flying(), false);
    bench.cycle();
    bench.command(Command::Start);
    bench.cycles(3);
    let refused = Some((Command::Start, Refusal::WrongMode));
    assert_eq!(bench.status().refusal, refused);
    bench.command(Command::Hold);
    assert_eq!(bench.status().refusal, None);
    assert_eq!(sensor_resets(&bench), 0);
}

/// A reset that is refused because of the sensor's data restarts the sensor; after that it is accepted.
#[test]
fn a_reset_starts_a_faulty_sensor_over() {
    let mut bench = Bench::cruising(&flying());
    bench.world().sensor.status = 0x0001;
    bench.cycle();
    bench.assert_fault(FaultCode::SensorStatus, 0.0, 1.0);
    let refused = bench.command(Command::Reset);
    assert_eq!(refused.trace.refusal, Some(Refusal::SensorUnhealthy));
    assert_eq!(bench.status().sensor, Some(SensorState::Starting));
    bench.world().sensor.status = 0;
    // Repeated resets do not prevent the sensor from starting.
    for _ in 0..10 {
        assert!(bench.command(Command::Reset).trace.refusal.is_some());
    }
    bench.cycles(300);
    assert_eq!(sensor_resets(&bench), 1);
    assert_eq!(bench.status().sensor, Some(SensorState::Running));
    assert_eq!(bench.status().mode, Mode::Fault);
    let accepted = bench.command(Command::Reset);
    assert_eq!(
        (accepted.trace.mode, accepted.trace.fault),
        (Mode::Hold, None)
    );
    bench.cycles(10);
    assert_eq!(sensor_resets(&bench), 1);
}

#[test]
fn a_reset_leaves_a_healthy_sensor_alone() {
    let mut bench = Bench::cruising(&flying());
    bench.lose(20);
    bench.cycle();
    bench.command(Command::Reset);
    assert_eq!(bench.status().mode, Mode::Hold);
    bench.cycles(3);
    assert_eq!(sensor_resets(&bench), 0);

    // A reset does not restart the sensor while the loop is closed.
    let mut bench = Bench::cruising(&flying());
    bench.command(Command::Reset);
    bench.cycles(20);
    assert_eq!(bench.status().mode, Mode::Running);
    assert_eq!(sensor_resets(&bench), 0);
}

/// In Idle there is no fault to reset, so the reset concerns the sensor.
#[test]
fn a_reset_in_idle_starts_the_sensor_over() {
    let mut bench = Bench::new(&flying(), false);
    bench.cycle();
    bench.command(Command::Reset);
    assert_eq!(sensor_resets(&bench), 1);
    bench.cycles(300);
    assert_eq!(bench.status().sensor, Some(SensorState::Running));
}
