//! A board with one thing wrong.

use super::super::State;
use super::*;
use softdock_link::service::{EthernetHealth, Origin, RobotHealth, SensorHealth, StackUse};

fn word<const N: usize>(text: &str) -> heapless::String<N> {
    heapless::String::try_from(text).unwrap()
}

/// A second of a board in order: 250 cycles, each with a sample.
fn answers() -> Answers {
    let counters = |cycles| Counters {
        cycles,
        runs: 1,
        ..Counters::default()
    };
    let health = |uptime_ms, cycles, counter| Health {
        uptime_ms,
        cycles,
        robot: Some(RobotHealth {
            late_answers: 0,
            poscorr_stat: 0,
            pose: true,
        }),
        sensor: Some(SensorHealth {
            counter,
            age_ms: 1,
            status: 0,
            saturated: false,
        }),
    };
    Answers {
        identity: Identity {
            schema: schema(),
            boot: 1,
            text: format!("{} on a bench", softdock_io::identity::text()),
        },
        status: Status {
            uptime_ms: 6_000,
            origin: Origin::Flash { sequence: 4 },
            draft: false,
            mode: word("Hold"),
            moves: false,
            robot: true,
            sensor: word("Running"),
            fault: None,
            refusal: None,
            commands: 1,
        },
        counters: [counters(5_000), counters(5_250)],
        health: Some([health(5_000, 5_000, u32::MAX), health(6_000, 5_250, 249)]),
        slots: Some([FlashSlot::Kept { sequence: 4 }, FlashSlot::Empty]),
        machine: Some(machine()),
        log: vec![line("mode Hold")],
        settings: Some(Ok(BoardSettings::default())),
    }
}

/// A NUCLEO with room on its stack and quick answers.
fn machine() -> Machine {
    let mut machine = Machine {
        reset: word("power-up"),
        stack: Some(StackUse {
            deepest: 80_000,
            available: 131_072,
        }),
        ethernet: Some(EthernetHealth {
            link: true,
            losses: 0,
            overruns: 0,
        }),
        ..Machine::default()
    };
    machine.answers.take(600, 4000);
    machine.inputs.force_noise_n = 0.1;
    machine
}

const FULL: StackUse = StackUse {
    deepest: 120_000,
    available: 131_072,
};

const UNPLUGGED: EthernetHealth = EthernetHealth {
    link: false,
    losses: 0,
    overruns: 0,
};

fn machine_of(answers: &mut Answers) -> &mut Machine {
    answers.machine.as_mut().unwrap()
}

fn line(text: &str) -> LogLine {
    LogLine {
        number: 0,
        at_ms: 1_500,
        text: word(text),
    }
}

fn state(checks: &[Check], name: &str) -> State {
    let check = checks.iter().find(|check| check.name == name);
    check
        .unwrap_or_else(|| panic!("no {name}: {checks:#?}"))
        .state
}

#[test]
fn a_board_in_order_has_nothing_bad() {
    let checks = checks("a port", &answers());
    for name in [
        "board",
        "protocol",
        "serial line",
        "stack",
        "Ethernet",
        "answer time",
        "noise",
        "origin of settings",
        "settings",
        "mode",
        "faults",
        "robot link",
        "lost telegrams",
        "robot cycle",
        "late answers",
        "robot pose",
        "POSCORR",
        "sensor",
        "sensor rate",
        "sensor status",
        "CAN bus",
        "flash",
        "log",
    ] {
        assert_eq!(state(&checks, name), State::Good, "{name}: {checks:#?}");
    }
    assert_eq!(state(&checks, "recorder"), State::Warning, "nobody is set");
}

#[test]
fn what_is_wrong_with_a_board_is_named() {
    use State::{Bad, Warning};
    type Harm = fn(&mut Answers);
    let cases: [(&str, State, Harm); 28] = [
        ("firmware", Warning, |a| {
            a.identity.text = "softdock 0.0.0".into()
        }),
        ("protocol", Warning, |a| a.settings = None),
        ("protocol", Warning, |a| a.health = None),
        ("settings", Bad, |a| {
            a.settings = Some(Err("cut off".into()))
        }),
        ("machine", Warning, |a| a.machine = None),
        ("stack", Warning, |a| machine_of(a).stack = Some(FULL)),
        ("Ethernet", Warning, |a| {
            machine_of(a).ethernet = Some(UNPLUGGED)
        }),
        ("Ethernet", Warning, |a| {
            machine_of(a).ethernet = Some(EthernetHealth {
                link: true,
                overruns: 1,
                ..UNPLUGGED
            });
        }),
        ("answer time", Warning, |a| {
            machine_of(a).answers.take(2500, 4000)
        }),
        ("answer time", Warning, |a| {
            machine_of(a).answers.take(9000, 4000)
        }),
        ("serial line", Warning, |a| a.counters[1].damaged_frames = 1),
        ("origin of settings", Bad, |a| {
            a.status.origin = Origin::Defaults {
                reason: word("damaged"),
            };
        }),
        ("origin of settings", Warning, |a| {
            a.status.origin = Origin::Trial {
                sequence: 5,
                left_s: 9,
            };
        }),
        ("mode", Warning, |a| a.status.moves = true),
        ("faults", Bad, |a| {
            a.status.fault = Some((word("Overload"), 100.0, 120.0));
        }),
        ("robot link", Warning, |a| {
            a.status.robot = false;
            a.counters[0].cycles = a.counters[1].cycles;
        }),
        ("robot link", Warning, |a| a.counters[1].foreign = 3),
        ("lost telegrams", Warning, |a| a.counters[1].lost = 1),
        ("lost telegrams", Bad, |a| a.counters[1].overtaken = 900),
        ("robot cycle", Warning, |a| last(a).uptime_ms = 8_000),
        ("late answers", Warning, |a| robot_of(a).late_answers = 2),
        ("robot pose", Bad, |a| robot_of(a).pose = false),
        ("POSCORR", Bad, |a| robot_of(a).poscorr_stat = 4),
        ("sensor", Bad, |a| {
            a.status.sensor = word("Failed(NoAnswer)")
        }),
        ("sensor rate", Bad, |a| sensor_of(a).age_ms = 9),
        ("sensor rate", Warning, |a| sensor_of(a).counter = 200),
        ("sensor status", Bad, |a| sensor_of(a).status = 0x4000),
        ("CAN bus", Warning, |a| a.counters[1].sensor_timeouts = 1),
    ];
    for (name, expected, harm) in cases {
        let mut answers = answers();
        harm(&mut answers);
        let checks = checks("a port", &answers);
        assert_eq!(state(&checks, name), expected, "{name}: {checks:#?}");
    }
}

fn last(answers: &mut Answers) -> &mut Health {
    &mut answers.health.as_mut().unwrap()[1]
}

fn robot_of(answers: &mut Answers) -> &mut RobotHealth {
    last(answers).robot.as_mut().unwrap()
}

fn sensor_of(answers: &mut Answers) -> &mut SensorHealth {
    last(answers).sensor.as_mut().unwrap()
}

#[test]
fn flash_and_log_say_what_they_hold() {
    let mut answers = answers();
    let reason = word("settings are damaged");
    answers.slots = Some([
        FlashSlot::Unusable { reason },
        FlashSlot::Kept { sequence: 7 },
    ]);
    answers
        .log
        .push(line("fault Overload: expected 1, received 2"));
    let checks = checks("a port", &answers);
    let message = |name: &str| {
        let check = checks.iter().find(|check| check.name == name).unwrap();
        assert_eq!(check.state, State::Warning, "{check:?}");
        check.message.as_str()
    };
    assert!(message("flash").contains("settings are damaged, slot B holds set 7"));
    assert!(message("log").ends_with("1.500 s: fault Overload: expected 1, received 2"));
}
