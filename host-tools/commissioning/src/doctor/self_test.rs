//! First power-on of a board: what can be tested without a robot or a sensor.
//!
//! The board writes its present settings once more, tries them after a reset and keeps them: this needs flash, the memory that
//! outlives a reset, and the start. Its CAN controller receives its own frames. A person confirms what the LEDs show. On request
//! it hangs, so that its watchdog has to reset it. docs/board.md lists what remains to be checked by hand.

use super::Check;
use crate::parameters::{Client, LinkError};
use softdock_io::port::Port;
use softdock_link::service::LoopBack;
use softdock_report::number::significant;
use std::net::Ipv4Addr;
use std::process::Command;
use std::time::{Duration, Instant};

/// Time for which the board's clock is watched: a serial line answers within 10 ms, 0.1 % of it.
const WATCHED: Duration = Duration::from_secs(10);
/// How far the board's clock may be from this computer's: the crystal of the ST-Link is good to 0.01 %,
/// the oscillator inside of the chip, which must not be in use, to 1 %.
const CLOCK: f64 = 0.003;
/// Time for the settings to be confirmed.
const CONFIRM_WITHIN_S: u16 = 60;

/// Message for a board that does not say why it started.
const NO_CHIP: &str =
    "this board is a program on a computer, and has no chip that tells why it started";

/// LEDs: what is printed beside them, their pin, and which is to be lit.
const LEDS: [(&str, &str, [bool; 3]); 3] = [
    ("LD1 (green)", "PB0", [true, false, false]),
    ("LD2 (yellow)", "PE1", [false, true, false]),
    ("LD3 (red)", "PB14", [false, false, true]),
];

/// A person who watches the board.
pub trait Onlooker {
    /// Is told each step.
    fn tell(&mut self, step: &str);
    /// Answers a question; None if nobody is there.
    fn sees(&mut self, question: &str) -> Option<bool>;
}

/// Runs all tests on the board on a port. `hang`: also the one of the watchdog.
pub fn self_test(
    name: &str,
    baud_rate: u32,
    hang: bool,
    onlooker: &mut impl Onlooker,
) -> Vec<Check> {
    let client = Port::open(name, baud_rate).map_err(|error| format!("{error:#}"));
    let client = client.and_then(|port| Client::connect(port).map_err(|error| error.to_string()));
    let mut client = match client {
        Ok(client) => client,
        Err(error) => {
            let text = format!("no board answers on {name}: {error}");
            return vec![Check::bad("board", text)];
        }
    };
    onlooker.tell("watching the clock");
    let clock = clock(&mut client);
    let flash = flash_and_reset(&mut client, &mut |step| onlooker.tell(step));
    let reset = reset(&mut client);
    onlooker.tell("sending CAN frames to itself");
    let can = can(&mut client);
    onlooker.tell("asking for its address");
    let ping = ping(&mut client, name);
    let leds = leds(&mut client, onlooker);
    let watchdog = watchdog(&mut client, hang, onlooker);
    vec![clock, flash, reset, can, ping, leds, watchdog]
}

fn clock(client: &mut Client) -> Check {
    let name = "clock";
    let watch = |client: &mut Client| -> Result<f64, LinkError> {
        let mut look = || Ok::<_, LinkError>((client.health()?.uptime_ms, Instant::now()));
        let first = look()?;
        std::thread::sleep(WATCHED);
        let last = look()?;
        let board_s = last.0.saturating_sub(first.0) as f64 * 1e-3;
        Ok(board_s / (last.1 - first.1).as_secs_f64() - 1.0)
    };
    match watch(client) {
        Ok(error) if error.abs() <= CLOCK => Check::good(
            name,
            format!(
                "within {} % of this computer's",
                significant(error * 100.0, 1)
            ),
        ),
        Ok(error) => Check::bad(
            name,
            format!(
                "{} % off this computer's: is the 8 MHz of the ST-Link at OSC_IN (PH0)? Measure it; the solder bridges of UM2407, clock sources",
                significant(error * 100.0, 2)
            ),
        ),
        Err(error) => Check::bad(name, error.to_string()),
    }
}

fn flash_and_reset(client: &mut Client, tell: &mut impl FnMut(&str)) -> Check {
    let name = "flash and reset";
    match client.change(&[], CONFIRM_WITHIN_S, tell) {
        Ok(()) => Check::good(
            name,
            "its settings were written, handed over a reset, tried and kept",
        ),
        Err(error) => Check::bad(
            name,
            format!(
                "{error:#}. If it started over without the new settings, the memory that outlives a reset was lost: send us the log"
            ),
        ),
    }
}

fn reset(client: &mut Client) -> Check {
    let name = "reason of the reset";
    match client.machine() {
        Ok(machine) if machine.reset == "software" => Check::good(name, "software, as was asked"),
        Ok(machine) if machine.reset.is_empty() => Check::warning(name, NO_CHIP),
        Ok(machine) if machine.reset == "watchdog" => Check::bad(
            name,
            "the watchdog: the start takes longer than 0.35 s; the log says how far it came",
        ),
        Ok(machine) => Check::warning(name, format!("`{}`, expected was software", machine.reset)),
        Err(error) => Check::warning(name, error.to_string()),
    }
}

/// Pings the board once, with the program of the operating system.
fn ping(client: &mut Client, port: &str) -> Check {
    let name = "ping";
    if port.starts_with("tcp:") {
        return Check::warning(name, "a board behind TCP has no network of its own");
    }
    let address = client
        .value("network.address")
        .map(|value| value.to_string());
    let address = address
        .ok()
        .and_then(|text| text.trim_matches('"').parse().ok());
    let Some(address): Option<Ipv4Addr> = address else {
        return Check::warning(name, "the board does not tell its address");
    };
    let ping = Command::new("ping")
        .args(["-c", "3", "-W", "1", &address.to_string()])
        .output();
    match ping {
        Ok(output) if output.status.success() => Check::good(name, format!("{address} answers")),
        Ok(_) => Check::warning(
            name,
            format!(
                "{address} does not answer: is this computer in its network, and are the LEDs of CN14 lit? `ip addr`, then a cable from here to CN14"
            ),
        ),
        Err(error) => Check::warning(name, format!("there is no program `ping` here: {error}")),
    }
}

/// Loop-back within the CAN controller: pins, transceiver and bus are not tested.
fn can(client: &mut Client) -> Check {
    let name = "CAN controller";
    match client.loop_back() {
        Ok(Some(LoopBack { sent, back })) if sent == back => Check::good(
            name,
            format!(
                "{back} frames came back inside of it; next the bus: with the sensor on, `softdock params status` says Running, \
                 and a scope at PD1 shows bits of 1 µs"
            ),
        ),
        Ok(Some(LoopBack { sent, back })) => Check::bad(
            name,
            format!(
                "{back} of {sent} frames came back inside of it, where no cable can be at fault: does the log say anything of \
                 CAN? Send it to us"
            ),
        ),
        Ok(None) => Check::warning(
            name,
            "there is none that could be asked: not in QEMU, not in the image with EtherCAT, and not while the bus is off \
             (`softdock params status`)",
        ),
        Err(error) => Check::warning(name, error.to_string()),
    }
}

/// Lights the LEDs one after the other; a person has to look at them.
fn leds(client: &mut Client, onlooker: &mut impl Onlooker) -> Check {
    let name = "LEDs";
    let mut look = || -> Result<Check, LinkError> {
        for (led, pin, lit) in LEDS {
            client.lamps(Some(lit))?;
            match onlooker.sees(&format!("is {led} lit, and no other of LD1 to LD3?")) {
                Some(true) => {}
                Some(false) => {
                    let advice = format!(
                        "{led} is dark or not alone: measure {pin}, 3.3 V when it is to be lit"
                    );
                    return Ok(Check::bad(name, advice));
                }
                None => {
                    return Ok(Check::warning(
                        name,
                        "nobody was asked; look: all three are dark without a robot and without a fault",
                    ));
                }
            }
        }
        Ok(Check::good(name, "each was seen alone"))
    };
    let seen = look();
    // An older board has lit none.
    let _ = client.lamps(None);
    seen.unwrap_or_else(|error| Check::warning(name, error.to_string()))
}

fn watchdog(client: &mut Client, hang: bool, onlooker: &mut impl Onlooker) -> Check {
    let name = "watchdog";
    if !hang {
        return Check::warning(
            name,
            "not tried; with --hang the board hangs on purpose, and its watchdog has to reset it",
        );
    }
    onlooker.tell("hanging, until the watchdog resets the board");
    if let Err(error) = client.hang() {
        return Check::bad(
            name,
            format!(
                "{error:#}. If it hangs for ever, its watchdog does not run: push the black button (B2), and send us the log"
            ),
        );
    }
    match client.machine() {
        Ok(machine) if machine.reset == "watchdog" => {
            Check::good(name, "a board that hung was reset by it")
        }
        Ok(machine) if machine.reset.is_empty() => {
            Check::warning(name, format!("it came back; {NO_CHIP}"))
        }
        Ok(machine) => Check::warning(
            name,
            format!(
                "it came back, reset by `{}`, expected was watchdog",
                machine.reset
            ),
        ),
        Err(error) => Check::warning(name, error.to_string()),
    }
}
