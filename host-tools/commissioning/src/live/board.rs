//! The board's service, as far as a measurement needs it.

use crate::fragment::Fragment;
use crate::parameters::{Client, Difference, OwnedValue, Setting, differences, parse};
use anyhow::{Context, Result, bail, ensure};
use softdock_io::identity;
use softdock_io::port::{Port, only_board};
use softdock_link::service::{Origin, Status};
use std::net::SocketAddr;

/// Where the board sends its cycles to.
const RECORDER: &str = "network.recorder";

/// A board on a port.
pub struct LiveBoard {
    /// The conversation with it.
    pub client: Client,
    /// Its port, for messages.
    pub port: String,
}

impl LiveBoard {
    /// Connects to the board on `port`; without one, to the only board on USB.
    ///
    /// # Errors
    /// There is no board.
    pub fn connect(port: Option<&str>, baud: u32) -> Result<Self> {
        let port = match port {
            Some(port) => port.to_owned(),
            None => only_board()?,
        };
        let client = Client::connect(Port::open(&port, baud)?).with_context(|| port.clone())?;
        Ok(Self { client, port })
    }

    /// A setting that is a number.
    ///
    /// # Errors
    /// The board is silent, or its firmware does not know it.
    pub fn number(&mut self, name: &str) -> Result<f64> {
        match self.client.value(name) {
            Ok(OwnedValue::Real(number)) => Ok(number),
            Ok(OwnedValue::Whole(number)) => Ok(number as f64),
            Ok(other) => bail!("{}: `{name}` is {other}, expected a number", self.port),
            Err(error) => {
                let context = format!(
                    "{}: `{name}` cannot be read; if the firmware is older than this softdock, flash it anew",
                    self.port
                );
                Err(error).context(context)
            }
        }
    }

    /// A setting that is a list of numbers.
    ///
    /// # Errors
    /// The board is silent, or does not know it.
    pub fn numbers<const N: usize>(&mut self, name: &str) -> Result<[f64; N]> {
        let value = self.client.value(name);
        let value = value.with_context(|| format!("{}: `{name}`", self.port))?;
        let numbers = match &value {
            OwnedValue::Array(rows) => rows.concat().try_into().ok(),
            _ => None,
        };
        numbers.with_context(|| format!("{}: `{name}` is {value}, expected {N} numbers", self.port))
    }

    /// The address on which the board's cycles can be heard: `listen`, or where its command line or its settings send
    /// them.
    ///
    /// # Errors
    /// There is none.
    pub fn recorder(&mut self, listen: Option<SocketAddr>) -> Result<SocketAddr> {
        if let Some(told) = listen.or(identity::telemetry(&self.client.identity().text)) {
            return Ok(told);
        }
        let set = self.client.value(RECORDER);
        let set = set.with_context(|| self.port.clone())?;
        let address = match &set {
            OwnedValue::Text(text) => text.parse().ok(),
            _ => None,
        };
        address.with_context(|| {
            format!(
                "{}: the board's settings do not say where it sends its cycles: `softdock params set \
                 {RECORDER} ADDRESS:49200` with this computer's address, or `softdock board --telemetry`",
                self.port
            )
        })
    }

    /// Brings the board into hold, if it is idle and nothing is wrong.
    ///
    /// # Errors
    /// Something must be done first: it says what.
    pub fn hold(&mut self) -> Result<Status> {
        let status = self.client.status().with_context(|| self.port.clone())?;
        let port = &self.port;
        if let Origin::Defaults { reason } = &status.origin {
            bail!(
                "{port}: the board runs on defaults ({reason}): `softdock params upload BOARD.toml` first"
            );
        }
        if let Some((name, expected, received)) = &status.fault {
            bail!(
                "{port}: {name} is latched (expected {expected}, received {received}): mend its cause, \
                 then `softdock params mode reset`"
            );
        }
        ensure!(
            status.robot,
            "{port}: the robot sends no telegrams: start RSI first"
        );
        match status.mode.as_str() {
            "Hold" => Ok(status),
            "Idle" => self.client.operate("hold").with_context(|| port.clone()),
            mode => bail!(
                "{port}: the board is in mode {mode}: `softdock params mode hold`, and see that nobody \
                 else works with it"
            ),
        }
    }

    /// All settings; `progress` is told how many of how many there are.
    ///
    /// # Errors
    /// The board is silent.
    pub fn settings(&mut self, progress: impl FnMut(u16, u16)) -> Result<Vec<Setting>> {
        let settings = self.client.list(progress);
        settings.with_context(|| self.port.clone())
    }

    /// Writes what was found into the board's settings, for good, and answers what changed. `tell` is
    /// told each step.
    ///
    /// # Errors
    /// The board refuses it; its settings are as they were then.
    pub fn write(
        &mut self,
        fragment: &Fragment,
        progress: impl FnMut(u16, u16),
        tell: &mut impl FnMut(&str),
    ) -> Result<Vec<Difference>> {
        /// Time after which the board goes back if this program does not come back, s.
        const CONFIRM_WITHIN_S: u16 = 60;
        let settings = self.settings(progress)?;
        let wanted = parse(&fragment.text(), "what was found", &settings)?;
        let changes = differences(&settings, &wanted)?;
        if !changes.is_empty() {
            let changed = self.client.change(&changes, CONFIRM_WITHIN_S, tell);
            changed.with_context(|| self.port.clone())?;
        }
        Ok(changes)
    }
}
