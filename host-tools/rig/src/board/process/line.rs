//! The line of the service: a TCP port or a pseudo-terminal. Like a serial line it has one host at a
//! time and outlives a restart of the board.

use super::mailbox::Mailbox;
use anyhow::{Context, Result, bail};
use embedded_io_async::{ErrorKind, ErrorType, Read, Write};
use std::io::{self, Write as _};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Pieces that may wait for the service.
const QUEUE: usize = 256;
/// Bytes that are read at once.
const PIECE: usize = 512;
/// How often the thread looks whether the board stops.
const STOP_PERIOD: Duration = Duration::from_millis(20);
/// Longest time for a host to take an answer.
const WRITE_PATIENCE: Duration = Duration::from_secs(2);

/// Longest silence of a host. Our own hosts answer or repeat every request within seconds.
#[derive(Clone, Copy)]
struct Silence {
    /// Time after which another host may take the line over.
    takeover: Duration,
    /// Time after which it is disconnected in any case.
    idle: Duration,
}

const SILENCE: Silence = Silence {
    takeover: Duration::from_secs(10),
    idle: Duration::from_secs(300),
};

/// Where the service is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ServiceAddress {
    /// A TCP port.
    Tcp(SocketAddr),
    /// A pseudo-terminal, which the system names.
    Pty,
}

impl FromStr for ServiceAddress {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        match text {
            "pty" => Ok(Self::Pty),
            _ => text.parse().map(Self::Tcp).with_context(|| {
                format!("`{text}` is neither `pty` nor an address like 127.0.0.1:29537")
            }),
        }
    }
}

type Host = Arc<Mutex<Option<Box<dyn io::Write + Send>>>>;

fn lock(host: &Host) -> MutexGuard<'_, Option<Box<dyn io::Write + Send>>> {
    host.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The line.
#[derive(Clone)]
pub(super) struct Line {
    place: String,
    received: Mailbox<Vec<u8>>,
    host: Host,
}

impl Line {
    /// Opens it. Its thread ends when `stop` is raised.
    pub(super) fn open(address: ServiceAddress, stop: &Arc<AtomicBool>) -> Result<Self> {
        let received = Mailbox::new(QUEUE);
        let host = Host::default();
        let (queue, writer, stop) = (received.clone(), host.clone(), stop.clone());
        let place = match address {
            ServiceAddress::Tcp(address) => {
                let listener = TcpListener::bind(address).with_context(|| {
                    format!("cannot listen for the service (TCP) on {address}; is another board running, or is this not an address of this computer?")
                })?;
                listener
                    .set_nonblocking(true)
                    .context("the service's port")?;
                let place = format!("TCP {}", listener.local_addr()?);
                thread::spawn(move || {
                    serve_tcp(&listener, &queue, &writer, &stop, SILENCE);
                    queue.close();
                });
                place
            }
            ServiceAddress::Pty => open_pty(queue, writer, stop)?,
        };
        Ok(Self {
            place,
            received,
            host,
        })
    }

    /// For a person: "TCP 127.0.0.1:29537".
    pub(super) fn place(&self) -> &str {
        &self.place
    }

    /// The two directions.
    pub(super) fn halves(self) -> (LineReader, LineWriter) {
        let reader = LineReader {
            received: self.received,
            rest: Vec::new(),
        };
        (reader, LineWriter(self.host))
    }
}

/// Accepts one host at a time; another one is turned away while the first one talks.
fn serve_tcp(
    listener: &TcpListener,
    queue: &Mailbox<Vec<u8>>,
    host: &Host,
    stop: &AtomicBool,
    silence: Silence,
) {
    let mut present: Option<(TcpStream, Instant)> = None;
    while !stop.load(Ordering::Relaxed) {
        let silent = |(_, heard): &(TcpStream, Instant)| heard.elapsed() > silence.takeover;
        if let Ok((stream, _)) = listener.accept()
            && present.as_ref().is_none_or(silent)
            && let Ok((read, write)) = connect(stream)
        {
            present = Some((read, Instant::now()));
            *lock(host) = Some(Box::new(write));
        }
        let Some((stream, heard)) = &mut present else {
            thread::sleep(STOP_PERIOD);
            continue;
        };
        let stays = match pass_on(stream, queue) {
            Passed::Bytes => {
                *heard = Instant::now();
                true
            }
            Passed::Nothing => heard.elapsed() <= silence.idle,
            Passed::Gone => false,
        };
        if !stays {
            present = None;
            *lock(host) = None;
        }
    }
}

/// The two directions of a connection.
fn connect(stream: TcpStream) -> io::Result<(TcpStream, TcpStream)> {
    stream.set_nonblocking(false)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(STOP_PERIOD))?;
    stream.set_write_timeout(Some(WRITE_PATIENCE))?;
    Ok((stream.try_clone()?, stream))
}

/// Outcome of an attempt to read.
enum Passed {
    Bytes,
    Nothing,
    /// The host has gone.
    Gone,
}

/// Passes received bytes on.
fn pass_on(stream: &mut impl io::Read, queue: &Mailbox<Vec<u8>>) -> Passed {
    let mut piece = [0; PIECE];
    match stream.read(&mut piece) {
        Ok(0) => Passed::Gone,
        Ok(length) => {
            queue.push(piece[..length].to_vec());
            Passed::Bytes
        }
        Err(error) => match error.kind() {
            io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut | io::ErrorKind::Interrupted => {
                Passed::Nothing
            }
            _ => Passed::Gone,
        },
    }
}

/// Opens a pseudo-terminal. Returns its name.
#[cfg(unix)]
fn open_pty(queue: Mailbox<Vec<u8>>, host: Host, stop: Arc<AtomicBool>) -> Result<String> {
    use serialport::{SerialPort, TTYPort};
    let (mut board, far_end) = TTYPort::pair().context("the system gives no pseudo-terminal")?;
    let Some(name) = far_end.name() else {
        bail!("the pseudo-terminal has no name");
    };
    board.set_timeout(STOP_PERIOD)?;
    *lock(&host) = Some(Box::new(board.try_clone_native()?));
    thread::spawn(move || {
        // While it is open here as well, hosts may come and go.
        let _far_end = far_end;
        while !stop.load(Ordering::Relaxed) {
            if matches!(pass_on(&mut board, &queue), Passed::Gone) {
                thread::sleep(STOP_PERIOD);
            }
        }
        queue.close();
    });
    Ok(format!("pty {name}"))
}

/// There are none on this system.
#[cfg(not(unix))]
fn open_pty(_: Mailbox<Vec<u8>>, _: Host, _: Arc<AtomicBool>) -> Result<String> {
    bail!("this system has no pseudo-terminals; give a TCP address")
}

/// Bytes from the host.
pub(super) struct LineReader {
    received: Mailbox<Vec<u8>>,
    rest: Vec<u8>,
}

impl ErrorType for LineReader {
    type Error = ErrorKind;
}

impl Read for LineReader {
    /// 0: the board stops.
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, ErrorKind> {
        if self.rest.is_empty() {
            match self.received.take().await {
                Ok(piece) => self.rest = piece,
                Err(_) => return Ok(0),
            }
        }
        let length = self.rest.len().min(buffer.len());
        let rest = self.rest.split_off(length);
        buffer[..length].copy_from_slice(&self.rest);
        self.rest = rest;
        Ok(length)
    }
}

/// Bytes to the host.
pub(super) struct LineWriter(Host);

impl ErrorType for LineWriter {
    type Error = ErrorKind;
}

impl Write for LineWriter {
    /// An answer is lost if there is no host, or it does not read.
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
        if let Some(host) = lock(&self.0).as_mut() {
            let _ = host.write_all(bytes);
        }
        Ok(bytes.len())
    }

    async fn flush(&mut self) -> Result<(), ErrorKind> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read as _;

    /// A line, and a test of it: `then` is given the address, a connected host, and a function that waits for bytes on the line.
    fn with_host(
        silence: Silence,
        then: impl FnOnce(SocketAddr, TcpStream, &dyn Fn(&[u8]) -> bool),
    ) {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        listener.set_nonblocking(true).unwrap();
        let address = listener.local_addr().unwrap();
        let (queue, host, stop) = (Mailbox::new(QUEUE), Host::default(), AtomicBool::new(false));
        thread::scope(|scope| {
            scope.spawn(|| serve_tcp(&listener, &queue, &host, &stop, silence));
            let first = TcpStream::connect(address).unwrap();
            first.set_read_timeout(Some(WRITE_PATIENCE)).unwrap();
            let heard = |bytes: &[u8]| {
                let waits = Instant::now();
                while waits.elapsed() < WRITE_PATIENCE {
                    if queue.try_take().is_some_and(|piece| piece == bytes) {
                        return true;
                    }
                    thread::sleep(Duration::from_millis(1));
                }
                false
            };
            then(address, first, &heard);
            stop.store(true, Ordering::Relaxed);
        });
    }

    const LONG: Duration = Duration::from_secs(3600);

    #[test]
    fn a_silent_host_is_disconnected() {
        let silence = Silence {
            takeover: LONG,
            idle: Duration::ZERO,
        };
        with_host(silence, |_, mut first, _| {
            assert_eq!(first.read(&mut [0; 8]).unwrap(), 0);
        });
    }

    #[test]
    fn another_host_takes_a_silent_line_over() {
        let silence = Silence {
            takeover: Duration::ZERO,
            idle: LONG,
        };
        with_host(silence, |address, mut first, heard| {
            let mut second = TcpStream::connect(address).unwrap();
            assert_eq!(first.read(&mut [0; 8]).unwrap(), 0, "the first one is gone");
            second.write_all(b"second").unwrap();
            assert!(heard(b"second"));
        });
    }

    #[test]
    fn another_host_is_turned_away_while_the_first_one_talks() {
        let silence = Silence {
            takeover: LONG,
            idle: LONG,
        };
        with_host(silence, |address, mut first, heard| {
            let mut second = TcpStream::connect(address).unwrap();
            second.set_read_timeout(Some(WRITE_PATIENCE)).unwrap();
            assert_eq!(second.read(&mut [0; 8]).unwrap_or(0), 0);
            first.write_all(b"still here").unwrap();
            assert!(heard(b"still here"));
        });
    }
}
