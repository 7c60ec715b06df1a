//! The cable of the robot's network: out and in while the loop is closed, and out when the board starts.
//! The PHY is QEMU's, what looks at it is what ships; the robot is answered again within ten of its cycles.

use super::faults::{assert_left_behind, moving};
use softdock_tests::peers::{Cable, QemuBoard, Robot, params};
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::thread;
use std::time::Duration;

fn free() -> SocketAddr {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    listener.local_addr().unwrap()
}

/// What the board says of its link, when it says so.
fn link_is(board: &QemuBoard, link: bool) -> serde_json::Value {
    let port = format!("tcp:{}", board.service);
    for _ in 0..100 {
        let status = params(&board.folder, &port, &["status", "--json"]).json();
        let ethernet = &status["machine"]["ethernet"];
        if ethernet["link"] == link {
            return ethernet.clone();
        }
        thread::sleep(Duration::from_millis(20));
    }
    panic!("never a link that is {link}");
}

#[test]
fn a_cable_that_was_out_is_left_behind_within_ten_cycles() {
    let monitor = free();
    let (board, mut robot, _sensor) = moving("qemu_cable", &["--monitor", &monitor.to_string()]);
    let mut cable = Cable::of(monitor);
    assert_eq!(link_is(&board, true)["losses"], 0);
    let mut losses = 0;
    assert_left_behind(|| {
        losses += 1;
        cable.plug(false);
        for _ in 0..20 {
            robot.send(robot.telegram(robot.ipoc).as_bytes());
        }
        assert_eq!(link_is(&board, false)["losses"], losses);
        assert_eq!(robot.unread(), 0, "answers through no cable");
        cable.plug(true);
        let cycles = robot.cycles_until_answered();
        link_is(&board, true);
        cycles
    });
    board.stop();
}

#[test]
fn a_board_that_starts_without_a_cable_answers_when_it_comes() {
    let monitor = free();
    let mut board = QemuBoard::start("qemu_no_cable", "", &["--monitor", &monitor.to_string()]);
    let mut cable = Cable::of(monitor);
    let mut mass_kg = 0.0;
    assert_left_behind(|| {
        cable.plug(false);
        // New settings, and with them another start.
        let port = format!("tcp:{}", board.service);
        mass_kg += 0.25;
        let change = ["set", "control.sensor.tool_mass_kg", &format!("{mass_kg}")];
        let run = params(&board.folder, &port, &change);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        board.process().wait_for("on trial for 60 s");
        assert_eq!(link_is(&board, false)["losses"], 0);
        cable.plug(true);
        let cycles = Robot::new(board.robot).cycles_until_answered();
        link_is(&board, true);
        cycles
    });
    board.end();
}
