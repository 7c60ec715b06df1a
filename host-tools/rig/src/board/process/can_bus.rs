//! The sensor's CAN bus: the board as an SLCAN adapter for a client, or as the client of an adapter.

use super::slcan_client::{AdapterBus, AdapterPort};
use super::slcan_server::SlcanBus;
use anyhow::{Context, Result};
use softdock_app::board::{IoError, SensorBus};
use softdock_io::address::address;
use softdock_io::port::BAUD_RATE;
use softdock_link::can::Frame;
use std::fmt;
use std::net::{SocketAddr, TcpListener};
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Where the sensor's side is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CanAddress {
    /// An SLCAN client comes to this TCP address.
    Listen(SocketAddr),
    /// An SLCAN adapter is opened.
    Adapter(AdapterPort),
}

impl FromStr for CanAddress {
    type Err = anyhow::Error;

    /// `127.0.0.1:29536` listens; `tcp:192.168.1.7:29536`, `/dev/ttyACM0`, `/dev/ttyUSB0@3000000` and `COM3` are adapters.
    fn from_str(text: &str) -> Result<Self> {
        if let Some(address) = address(text).ok().filter(|_| !text.starts_with("tcp:")) {
            return Ok(Self::Listen(address));
        }
        let is_device = text.contains('/') || text.starts_with("COM");
        let adapter = |name: &str, baud_rate| {
            let name = name.to_owned();
            Ok(Self::Adapter(AdapterPort { name, baud_rate }))
        };
        match text.rsplit_once('@') {
            Some((device, rate)) if is_device => {
                let rate = rate.parse().ok().filter(|rate| *rate > 0);
                adapter(device, rate.with_context(|| format!("`{text}`: expected a speed in bit/s behind the @, such as /dev/ttyUSB0@3000000"))?)
            }
            _ if is_device || text.starts_with("tcp:") => adapter(text, BAUD_RATE),
            _ => anyhow::bail!(
                "`{text}` is neither an address to listen on, like 127.0.0.1:29536, nor an SLCAN adapter, like /dev/ttyACM0 or tcp:192.168.1.7:29536"
            ),
        }
    }
}

/// A bus that is not in use yet.
#[derive(Debug)]
pub(super) enum CanPort {
    Listening(TcpListener),
    Adapter(AdapterPort),
}

impl CanPort {
    pub(super) fn prepare(address: CanAddress) -> Result<Self> {
        Ok(match address {
            CanAddress::Listen(address) => Self::Listening(
                TcpListener::bind(address)
                    .with_context(|| super::in_use("sensor (TCP)", address))?,
            ),
            CanAddress::Adapter(port) => {
                port.check()?;
                Self::Adapter(port)
            }
        })
    }

    pub(super) fn try_clone(&self) -> Result<Self> {
        Ok(match self {
            Self::Listening(listener) => Self::Listening(listener.try_clone()?),
            Self::Adapter(port) => Self::Adapter(port.clone()),
        })
    }

    /// The bus, until `stop` is raised.
    pub(super) fn start(self, stop: Arc<AtomicBool>) -> Result<CanBus> {
        Ok(match self {
            Self::Listening(listener) => CanBus::Client(SlcanBus::start(listener, stop)?),
            Self::Adapter(port) => CanBus::Adapter(AdapterBus::start(port, stop)),
        })
    }
}

impl fmt::Display for CanPort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Listening(listener) => match listener.local_addr() {
                Ok(address) => write!(f, "SLCAN on TCP {address}"),
                Err(error) => write!(f, "SLCAN on TCP ({error})"),
            },
            Self::Adapter(port) => write!(f, "SLCAN adapter {}", port.name),
        }
    }
}

/// The bus as the sensor task sees it.
pub(super) enum CanBus {
    /// The far end is a client.
    Client(SlcanBus),
    /// The far end is an adapter.
    Adapter(AdapterBus),
}

impl SensorBus for CanBus {
    type Frame = Frame;

    async fn send(&mut self, frame: &Frame) -> Result<(), IoError> {
        match self {
            Self::Client(bus) => bus.send(frame).await,
            Self::Adapter(bus) => bus.send(frame).await,
        }
    }

    async fn receive(&mut self) -> Result<Frame, IoError> {
        match self {
            Self::Client(bus) => bus.receive().await,
            Self::Adapter(bus) => bus.receive().await,
        }
    }

    async fn recover(&mut self) -> Result<(), IoError> {
        match self {
            Self::Client(bus) => bus.recover().await,
            Self::Adapter(bus) => bus.recover().await,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_an_address_means() {
        let adapter = |name: &str, baud_rate| {
            let name = name.to_owned();
            CanAddress::Adapter(AdapterPort { name, baud_rate })
        };
        for (text, address) in [
            (
                "127.0.0.1:29536",
                CanAddress::Listen(SocketAddr::from(([127, 0, 0, 1], 29536))),
            ),
            (
                "localhost:29536",
                CanAddress::Listen(SocketAddr::from(([127, 0, 0, 1], 29536))),
            ),
            ("/dev/ttyACM0", adapter("/dev/ttyACM0", 115_200)),
            ("/dev/ttyUSB0@3000000", adapter("/dev/ttyUSB0", 3_000_000)),
            ("COM3", adapter("COM3", 115_200)),
            ("tcp:can-box:29536", adapter("tcp:can-box:29536", 115_200)),
        ] {
            assert_eq!(text.parse::<CanAddress>().unwrap(), address, "{text}");
        }
        for (text, said) in [
            ("29536", "neither an address to listen on"),
            ("", "neither an address to listen on"),
            ("/dev/ttyUSB0@fast", "expected a speed in bit/s"),
            ("/dev/ttyUSB0@0", "expected a speed in bit/s"),
        ] {
            let error = text.parse::<CanAddress>().unwrap_err().to_string();
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
