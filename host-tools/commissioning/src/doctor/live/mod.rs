//! A board that answers on its serial line. It is asked first ([`ask`]) and judged afterwards
//! ([`checks`]):
//!
//! - `board`: firmware, origin of its settings, mode, fault, flash and log,
//! - `machine`: its stack, its Ethernet, its answers, the noise of its sensor,
//! - `robot` and `sensor`: what came from them, in all and while it was watched,
//! - `recorder`: whether somebody takes its cycles.

mod board;
mod machine;
mod recorder;
mod robot;
mod sensor;
#[cfg(test)]
mod tests;

use super::{Check, settings};
use crate::parameters::{Client, Identity, LinkError};
use softdock_app::image::{Image, schema};
use softdock_app::settings::BoardSettings;
use softdock_io::identity;
use softdock_io::port::Port;
use softdock_link::service::{Counters, FlashSlot, Health, LogLine, Machine, Refusal, Status};
use std::time::{Duration, Instant};

/// Time for which a board is watched: 250 cycles, and 1 ms of its clock is 0.1 %.
const WATCHED: Duration = Duration::from_secs(1);
/// How often the progress is told.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Answers of a board to all questions.
#[derive(Clone, Debug)]
pub(super) struct Answers {
    pub(super) identity: Identity,
    pub(super) status: Status,
    /// At both ends of the time for which it was watched.
    pub(super) counters: [Counters; 2],
    /// Likewise; none from a firmware that is older than the question.
    pub(super) health: Option<[Health; 2]>,
    /// None from a firmware that is older than the question.
    pub(super) slots: Option<[FlashSlot; 2]>,
    /// Likewise.
    pub(super) machine: Option<Machine>,
    pub(super) log: Vec<LogLine>,
    /// None if they have another form than this program knows.
    pub(super) settings: Option<Result<BoardSettings, String>>,
}

/// Checks the board on a port, and the settings that it runs with, as far as this program knows
/// them. A board that does not answer is a bad check. `progress` is told the share that is done.
pub(super) fn of_port(
    name: &str,
    baud_rate: u32,
    progress: impl FnMut(f64),
) -> (Vec<Check>, Option<BoardSettings>) {
    let port = match Port::open(name, baud_rate) {
        Ok(port) => port,
        Err(error) => {
            let text = format!("no board answers on {name}: {error:#}");
            return (vec![Check::bad("board", text)], None);
        }
    };
    let answers = Client::connect(port).and_then(|mut client| ask(&mut client, progress));
    match answers {
        Ok(answers) => {
            let checks = checks(name, &answers);
            (checks, answers.settings.and_then(Result::ok))
        }
        Err(error) => (vec![silent(name, &error)], None),
    }
}

fn silent(name: &str, error: &LinkError) -> Check {
    let text = match error {
        LinkError::Silent => format!(
            "no board answers on {name}: is it powered, is the baud rate right (--baud; a NUCLEO \
             has 115200), does another program hold the port?"
        ),
        other => format!("on {name}: {other}"),
    };
    Check::bad("board", text)
}

fn ask(client: &mut Client, mut progress: impl FnMut(f64)) -> Result<Answers, LinkError> {
    let first = (client.counters()?, known(client.health())?);
    let settings = (client.identity().schema == schema()).then(|| client.image());
    let settings = settings.transpose()?.map(|image| {
        let image = Image::decode(&image).map_err(|error| error.to_string())?;
        Ok(image.settings)
    });
    let slots = known(client.slots())?;
    let log = client.log(0)?;
    let began = Instant::now();
    while began.elapsed() < WATCHED {
        progress(began.elapsed().as_secs_f64() / WATCHED.as_secs_f64());
        std::thread::sleep(POLL_INTERVAL);
    }
    let last = (client.counters()?, known(client.health())?);
    Ok(Answers {
        identity: client.identity().clone(),
        status: client.status()?,
        counters: [first.0, last.0],
        machine: known(client.machine())?,
        health: first.1.zip(last.1).map(|(first, last)| [first, last]),
        slots,
        log,
        settings,
    })
}

/// None if the firmware does not know the question.
fn known<T>(answer: Result<T, LinkError>) -> Result<Option<T>, LinkError> {
    match answer {
        Ok(answer) => Ok(Some(answer)),
        Err(LinkError::Refused(Refusal::Unreadable)) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Judges the answers of a board.
fn checks(port: &str, answers: &Answers) -> Vec<Check> {
    let defaults = BoardSettings::default();
    let known = answers.settings.as_ref().and_then(|s| s.as_ref().ok());
    let mut checks = board::checks(port, answers);
    match &answers.settings {
        Some(Ok(settings)) => checks.extend(settings::checks(settings)),
        Some(Err(error)) => checks.push(Check::bad(
            "settings",
            format!("the board's cannot be used: {error}; `softdock params upload`"),
        )),
        None => {}
    }
    let control = &known.unwrap_or(&defaults).control;
    checks.extend(machine::checks(answers, control));
    checks.extend(robot::checks(answers, control));
    checks.extend(sensor::checks(answers, control));
    checks.push(board::flash(answers));
    checks.extend(known.map(|settings| {
        let told = identity::telemetry(&answers.identity.text).map(|to| to.to_string());
        recorder::check(told.as_deref().unwrap_or(&settings.network.recorder))
    }));
    checks.push(board::log(answers));
    checks
}
