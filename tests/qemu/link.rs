//! The cable of the robot's network: out and in while the loop is closed, and out when the board starts.
//! The PHY is QEMU's, what looks at it is what ships; the robot is answered again within ten telegrams.

use super::faults::moving;
use softdock_tests::peers::{Cable, QemuBoard, Robot, params};
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::thread;
use std::time::Duration;

/// As the maker of the network's parts promises it: ten cycles.
const TELEGRAMS: usize = 10;

fn free() -> SocketAddr {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    listener.local_addr().unwrap()
}

/// What the board says of its link, when it says so.
fn link_is(board: &QemuBoard, link: bool) -> serde_json::Value {
    let port = format!("tcp:{}", board.service);
    for _ in 0..100 {
        let run = params(&board.folder, &port, &["status", "--json"]);
        let status: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
        let ethernet = &status["machine"]["ethernet"];
        if ethernet["link"] == link {
            return ethernet.clone();
        }
        thread::sleep(Duration::from_millis(20));
    }
    panic!("never a link that is {link}");
}

fn answered_again(robot: &mut Robot) {
    robot.cycle_through_flood();
    assert!(robot.attempts <= TELEGRAMS, "{} telegrams", robot.attempts);
}

#[test]
fn a_cable_that_was_out_is_left_behind_within_ten_telegrams() {
    let monitor = free();
    let (board, mut robot, _sensor) = moving("qemu_cable", &["--monitor", &monitor.to_string()]);
    let mut cable = Cable::of(monitor);
    assert_eq!(link_is(&board, true)["losses"], 0);
    for losses in 1..=3 {
        cable.plug(false);
        for _ in 0..20 {
            robot.send(robot.telegram(robot.ipoc).as_bytes());
        }
        assert_eq!(link_is(&board, false)["losses"], losses);
        assert_eq!(robot.unread(), 0, "answers through no cable");
        cable.plug(true);
        answered_again(&mut robot);
        link_is(&board, true);
    }
    board.stop();
}

#[test]
fn a_board_that_starts_without_a_cable_answers_when_it_comes() {
    let monitor = free();
    let mut board = QemuBoard::start("qemu_no_cable", "", &["--monitor", &monitor.to_string()]);
    let mut cable = Cable::of(monitor);
    cable.plug(false);
    // New settings, and with them another start.
    let port = format!("tcp:{}", board.service);
    let change = ["set", "control.sensor.tool_mass_kg", "0.25"];
    let run = params(&board.folder, &port, &change);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    board.process().wait_for("on trial for 60 s");
    assert_eq!(link_is(&board, false)["losses"], 0);
    cable.plug(true);
    answered_again(&mut Robot::new(board.robot));
    link_is(&board, true);
    board.end();
}
