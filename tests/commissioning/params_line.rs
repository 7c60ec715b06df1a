//! `softdock params` on lines that are taken, noisy, cut off, or not there.

use softdock_tests::peers::{Board, Fault, Proxy, Served, params, serve};
use softdock_tests::process::{json, scratch};

const MASS: &str = "control.sensor.tool_mass_kg";

fn mass(served: &Served) -> f64 {
    served.json(&["get", MASS])["value"].as_f64().unwrap()
}

#[test]
fn a_pseudo_terminal_is_a_port_for_one_program() {
    let board = Board::start("params_pty", "", &["--service", "pty"]);
    let port = board.service.clone().unwrap();
    assert!(port.starts_with("/dev/"), "{port}");
    let set = params(&board.folder, &port, &["set", MASS, "0.25"]);
    assert_eq!(set.code, Some(0), "{}", set.stderr);
    let got = params(&board.folder, &port, &["get", MASS]);
    assert_eq!(got.stdout, "0.25 kg\n");
    // Another program has it.
    let held = std::fs::File::options()
        .read(true)
        .write(true)
        .open(&port)
        .unwrap();
    held.lock().unwrap();
    let second = params(&board.folder, &port, &["get", MASS]);
    assert_eq!(second.code, Some(1));
    assert!(
        second.stderr.contains("another program has it open"),
        "{}",
        second.stderr
    );
    drop(held);
    assert_eq!(params(&board.folder, &port, &["get", MASS]).code, Some(0));
    board.stop();
}

#[test]
fn a_port_that_is_none_is_named() {
    let folder = scratch("params_ports");
    for (port, says) in [
        ("/dev/no-such-port", "no such port"),
        ("tcp:nowhere", "write it like tcp:127.0.0.1:29537"),
        ("tcp:127.0.0.1:1", "does the board run with --service"),
    ] {
        let run = params(&folder, port, &["status"]);
        assert_eq!(run.code, Some(1));
        assert!(run.stderr.contains(says), "{port}: {}", run.stderr);
    }
    let ports = json(&folder, &["params", "ports"]);
    assert!(ports["ports"].is_array());
}

#[test]
fn a_second_program_is_told_that_there_is_a_first() {
    let served = serve("params_two", "", &[]);
    let mut first = std::process::Command::new(softdock_tests::process::softdock_binary())
        .args(["params", "watch", "--port", &served.port])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    // It has the port when it says something.
    let mut byte = [0];
    std::io::Read::read_exact(first.stdout.as_mut().unwrap(), &mut byte).unwrap();
    let said = served.refused(&["status"]);
    first.kill().unwrap();
    first.wait().unwrap();
    assert!(
        said.contains("another softdock is talking to this board"),
        "{said}"
    );
    served.done(&["status"]);
    // A program that is not softdock.
    let held = std::net::TcpStream::connect(served.address()).unwrap();
    std::thread::sleep(std::time::Duration::from_millis(200));
    let said = served.refused(&["status"]);
    assert!(said.contains("another program"), "{said}");
    drop(held);
    served.board.stop();
}

#[test]
fn noise_on_the_line_is_survived_and_another_speed_is_guessed() {
    let served = serve("params_noise", "", &[]);
    let proxy = Proxy::start(served.address(), Fault::Noise(700));
    let port = format!("tcp:{}", proxy.address);
    let folder = &served.board.folder;
    let set = params(folder, &port, &["set", MASS, "0.125"]);
    assert_eq!(set.code, Some(0), "{}", set.stderr);
    assert_eq!(mass(&served), 0.125);
    let damaged = served.json(&["status"])["counters"]["damaged_frames"].as_u64();
    assert!(damaged.is_some());
    proxy.set(Fault::Garbled);
    let run = params(folder, &port, &["status"]);
    assert_eq!(run.code, Some(1));
    assert!(run.stderr.contains("baud rate"), "{}", run.stderr);
    served.board.stop();
}

/// Whichever answer behind the list of the settings is lost, a change is made and confirmed, and
/// rolled back again.
#[test]
fn any_answer_may_be_lost() {
    let served = serve("params_lost_answer", "", &[]);
    let proxy = Proxy::start(served.address(), Fault::None);
    let port = format!("tcp:{}", proxy.address);
    let folder = &served.board.folder;
    // Before them come the greeting, each setting, and the end of their list. The number of
    // questions whether the board is back varies; there are fewer than twelve answers in all.
    let first = 2 + served.json(&["list"])["settings"].as_array().unwrap().len();
    served.done(&["set", MASS, "0.25"]);
    for lost in first..first + 12 {
        proxy.set(Fault::LosesAnswer(lost));
        let value = lost as f64 / 1024.0;
        let run = params(folder, &port, &["set", MASS, &value.to_string()]);
        assert_eq!(run.code, Some(0), "answer {lost}: {}", run.stderr);
        assert_eq!(mass(&served), value, "answer {lost}");
        proxy.set(Fault::LosesAnswer(lost));
        let run = params(folder, &port, &["rollback"]);
        assert_eq!(run.code, Some(0), "rollback, answer {lost}: {}", run.stderr);
        assert_ne!(mass(&served), value, "rollback, answer {lost}");
    }
    assert!(proxy.answers() > first, "no answer was lost");
    served.board.stop();
}

/// The cable is pulled after any number of bytes of a change: the board has the old settings or the
/// new ones, whole, after the time for the confirmation.
#[test]
fn an_unplugged_cable_leaves_all_or_nothing() {
    let served = serve("params_cut", "", &[]);
    let proxy = Proxy::start(served.address(), Fault::None);
    let port = format!("tcp:{}", proxy.address);
    let folder = &served.board.folder;
    std::fs::write(
        folder.join("new.toml"),
        "[can]\nbase_id = 7\nsensor = \"sri\"\n",
    )
    .unwrap();
    std::fs::write(folder.join("old.toml"), "[can]\nbase_id = 32\n").unwrap();
    let upload = |file: &str, port: &str| {
        let change = ["upload", file, "--yes", "--confirm-within", "2"];
        params(folder, port, &change)
    };
    assert_eq!(upload("new.toml", &port).code, Some(0));
    let whole = proxy.to_board();
    assert_eq!(upload("old.toml", &port).code, Some(0));
    let (mut old, mut new) = (0, 0);
    // The last bytes are the change itself; all before only lists the settings.
    for left in [300, 200, 150, 120, 90, 60, 45, 30, 20, 10] {
        proxy.set(Fault::CutAfter(whole - left));
        let run = upload("new.toml", &port);
        let state = settled(&served);
        match (state["base_id"].as_i64(), state["sensor"].as_str()) {
            (Some(32), Some("ati")) => old += 1,
            (Some(7), Some("sri")) => new += 1,
            other => panic!("{left} bytes before the end: {other:?}"),
        }
        if run.code != Some(0) {
            assert!(
                run.stderr.contains("connection has ended"),
                "{}",
                run.stderr
            );
        }
        assert_eq!(upload("old.toml", &served.port).code, Some(0));
    }
    assert!(old > 0, "the cable was never pulled in time");
    println!("{old} times the old settings, {new} times the new ones");
    served.board.stop();
}

/// The two settings when nothing is on trial any more. A board that has not noticed yet that the
/// cable is out has no ear for another one, so this asks again.
fn settled(served: &Served) -> serde_json::Value {
    let is_settled = || {
        let status = served.params(&["status", "--json"]);
        let text = status.stdout.as_str();
        status.code == Some(0) && {
            let told: serde_json::Value = serde_json::from_str(text).unwrap();
            told["status"]["origin"].get("Trial").is_none()
        }
    };
    let mut asked = 0;
    while !is_settled() {
        asked += 1;
        assert!(asked < 150, "the board does not settle");
        std::thread::sleep(std::time::Duration::from_millis(200));
    }
    let list = served.json(&["list"]);
    let value = |name: &str| {
        let list = list["settings"].as_array().unwrap();
        let setting = list.iter().find(|setting| setting["name"] == name);
        setting.unwrap()["value"].clone()
    };
    serde_json::json!({ "base_id": value("can.base_id"), "sensor": value("can.sensor") })
}
