//! The host's end of the service line to a board.

mod lock;

use anyhow::{Context, Result, bail};
use lock::Lock;
use serde::Serialize;
use serialport::{SerialPort, SerialPortInfo, SerialPortType};
use std::io::{self, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::Arc;
use std::time::Duration;

/// Speed of the NUCLEO's serial line, bit/s.
pub const BAUD_RATE: u32 = 115_200;
/// Longest wait of a single read.
const POLL_INTERVAL: Duration = Duration::from_millis(20);
/// Timeout of a TCP connection, and of writes to a slow host.
const TIMEOUT: Duration = Duration::from_secs(3);
/// USB vendor of debug probes with a serial line: STMicroelectronics.
const ST: u16 = 0x0483;

/// A byte stream in both directions.
pub trait Line: Read + Write + Send {
    /// A second handle of the same line, for another thread.
    ///
    /// # Errors
    /// The system gives no more handles.
    fn try_clone(&self) -> io::Result<Box<dyn Line>>;
}

impl Line for TcpStream {
    fn try_clone(&self) -> io::Result<Box<dyn Line>> {
        Ok(Box::new(Self::try_clone(self)?))
    }
}

impl Line for Box<dyn SerialPort> {
    fn try_clone(&self) -> io::Result<Box<dyn Line>> {
        Ok(Box::new(SerialPort::try_clone(&**self)?))
    }
}

/// An open line, which no other softdock can open.
pub struct Port {
    line: Box<dyn Line>,
    /// Lock of a TCP port; None for other lines.
    lock: Option<Arc<Lock>>,
}

impl Port {
    /// Opens `tcp:HOST:PORT` (or `HOST:PORT`), or the serial device or pseudo-terminal of that path.
    ///
    /// # Errors
    /// It is not there, or another program has it.
    pub fn open(name: &str, baud_rate: u32) -> Result<Self> {
        match tcp_address(name) {
            Some(address) => Self::open_tcp(address),
            None => Self::open_serial(name, baud_rate),
        }
    }

    /// A port over a line that is open already.
    pub fn over_line(line: impl Line + 'static) -> Self {
        Self {
            line: Box::new(line),
            lock: None,
        }
    }

    /// A second handle of the same port, for another thread.
    ///
    /// # Errors
    /// The system gives no more handles.
    pub fn try_clone(&self) -> io::Result<Self> {
        Ok(Self {
            line: self.line.try_clone()?,
            lock: self.lock.clone(),
        })
    }

    fn open_tcp(text: &str) -> Result<Self> {
        let address = text
            .to_socket_addrs()
            .ok()
            .and_then(|mut addresses| addresses.next());
        let Some(address) = address else {
            bail!("`tcp:{text}` is no address; write it like tcp:127.0.0.1:29537");
        };
        let lock = Lock::take(&format!("tcp-{address}"))?;
        let stream = TcpStream::connect_timeout(&address, TIMEOUT).with_context(|| {
            format!("cannot connect to {address}; does the board run with --service {address}?")
        })?;
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(POLL_INTERVAL))?;
        stream.set_write_timeout(Some(TIMEOUT))?;
        Ok(Self {
            line: Box::new(stream),
            lock: Some(Arc::new(lock)),
        })
    }

    fn open_serial(path: &str, baud_rate: u32) -> Result<Self> {
        // `serialport` locks the device, also against programs other than softdock.
        let port = serialport::new(path, baud_rate)
            .timeout(POLL_INTERVAL)
            .open();
        let stream = port.map_err(|error| serial_error(path, &error))?;
        Ok(Self::over_line(stream))
    }
}

/// The address in `tcp:HOST:PORT` or `HOST:PORT`, which no device name looks like; None for a device.
fn tcp_address(name: &str) -> Option<&str> {
    let is_port = |(host, port): (&str, &str)| {
        !host.is_empty() && !host.contains(['/', '\\']) && port.parse::<u16>().is_ok()
    };
    let bare = || name.rsplit_once(':').is_some_and(is_port);
    name.strip_prefix("tcp:").or_else(|| bare().then_some(name))
}

fn serial_error(path: &str, error: &serialport::Error) -> anyhow::Error {
    let text = error.to_string();
    let taken = ["lock", "busy", "temporarily unavailable"];
    let absent = matches!(
        error.kind(),
        serialport::ErrorKind::NoDevice | serialport::ErrorKind::Io(io::ErrorKind::NotFound)
    );
    let what = if taken.iter().any(|word| text.to_lowercase().contains(word)) {
        "another program has it open; close that first"
    } else if absent {
        "there is no such port; `softdock params ports` lists those that are there"
    } else if text.to_lowercase().contains("permission") {
        "you may not use it; on Debian and Ubuntu: sudo usermod -aG dialout $USER, then log in anew"
    } else {
        "it cannot be opened"
    };
    anyhow::anyhow!("{path}: {what} ({text})")
}

impl Read for Port {
    /// Returns 0 if no bytes came in time. The end of the line is an error.
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.line.read(buffer) {
            Ok(0) => Err(io::ErrorKind::UnexpectedEof.into()),
            Err(error)
                if matches!(
                    error.kind(),
                    io::ErrorKind::WouldBlock
                        | io::ErrorKind::TimedOut
                        | io::ErrorKind::Interrupted
                ) =>
            {
                Ok(0)
            }
            other => other,
        }
    }
}

impl Write for Port {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.line.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.line.flush()
    }
}

/// A serial port of this computer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct AvailablePort {
    /// Path or name of the port.
    pub port: String,
    /// Description of the device behind it.
    pub device: String,
    /// Whether it is a debug probe like that of a NUCLEO.
    pub probe: bool,
}

/// The serial ports of this computer.
///
/// # Errors
/// The system does not list its ports.
pub fn serial_ports() -> Result<Vec<AvailablePort>> {
    let ports = serialport::available_ports().context("the system does not tell its ports")?;
    let mut found: Vec<AvailablePort> = ports.into_iter().map(describe).collect();
    found.sort_by(|a, b| (!a.probe, &a.port).cmp(&(!b.probe, &b.port)));
    Ok(found)
}

fn describe(info: SerialPortInfo) -> AvailablePort {
    let (device, probe) = match info.port_type {
        SerialPortType::UsbPort(usb) => {
            let name = usb.product.unwrap_or_else(|| "USB device".into());
            let number = usb.serial_number.map(|number| format!(", {number}"));
            let text = format!("{name}{}", number.unwrap_or_default());
            (text, usb.vid == ST)
        }
        SerialPortType::PciPort => ("serial port".into(), false),
        SerialPortType::BluetoothPort => ("Bluetooth".into(), false),
        SerialPortType::Unknown => ("unknown".into(), false),
    };
    AvailablePort {
        port: info.port_name,
        device,
        probe,
    }
}

/// The port of the only board that is plugged in.
///
/// # Errors
/// There is none, or more than one.
pub fn only_board() -> Result<String> {
    let mut boards = serial_ports()?.into_iter().filter(|found| found.probe);
    match (boards.next(), boards.next()) {
        (Some(board), None) => Ok(board.port),
        (None, _) => bail!(
            "no board is plugged in by USB; say where it is: --port DEVICE or --port tcp:HOST:PORT (`softdock params ports` lists devices)"
        ),
        _ => bail!(
            "several boards are plugged in; choose one: --port (`softdock params ports` lists them)"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::tcp_address;

    #[test]
    fn what_is_an_address_and_what_a_device() {
        for (name, address) in [
            ("tcp:127.0.0.1:29537", Some("127.0.0.1:29537")),
            ("127.0.0.1:29537", Some("127.0.0.1:29537")),
            ("localhost:29537", Some("localhost:29537")),
            ("[::1]:29537", Some("[::1]:29537")),
            ("/dev/ttyACM0", None),
            ("/dev/serial/by-path/pci-0000:00:14.0", None),
            ("COM3", None),
        ] {
            assert_eq!(tcp_address(name), address, "{name}");
        }
    }
}
