//! A line between a host and a board with a fault: noisy, cut off in the middle, or at another speed.

use std::io::{Read, Write};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

/// Effect of the line on bytes, in both directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Nothing.
    None,
    /// In every so many bytes, one bit is flipped, and less often a byte is dropped.
    Noise(usize),
    /// The line ends after so many bytes to the board.
    CutAfter(usize),
    /// One answer of the board is lost, by its number from 0.
    LosesAnswer(usize),
    /// All bytes of the board are changed, as with another baud rate.
    Garbled,
}

/// A TCP port in front of that of a board. It ends with the test.
#[derive(Debug)]
pub struct Proxy {
    /// Address for a host.
    pub address: SocketAddr,
    fault: Arc<Mutex<Fault>>,
    to_board: Arc<AtomicUsize>,
    /// Zero bytes from the board; there are two per answer.
    zeros: Arc<AtomicUsize>,
}

impl Proxy {
    /// Starts a line to a board.
    ///
    /// # Panics
    /// If no port is free.
    pub fn start(board: SocketAddr, fault: Fault) -> Self {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a free TCP port");
        let address = listener.local_addr().expect("its address");
        let fault = Arc::new(Mutex::new(fault));
        let to_board = Arc::new(AtomicUsize::new(0));
        let zeros = Arc::new(AtomicUsize::new(0));
        let (shared, counts) = (fault.clone(), (to_board.clone(), zeros.clone()));
        thread::spawn(move || {
            for host in listener.incoming().flatten() {
                let Ok(board) = TcpStream::connect(board) else {
                    continue;
                };
                let fault = *shared.lock().unwrap_or_else(PoisonError::into_inner);
                connect(&host, &board, fault, &counts);
            }
        });
        Self {
            address,
            fault,
            to_board,
            zeros,
        }
    }

    /// Sets the fault of connections from now on.
    pub fn set(&self, fault: Fault) {
        *self.fault.lock().unwrap_or_else(PoisonError::into_inner) = fault;
        self.to_board.store(0, Ordering::Relaxed);
        self.zeros.store(0, Ordering::Relaxed);
    }

    /// Bytes sent to the board since the last [`Self::set`].
    pub fn to_board(&self) -> usize {
        self.to_board.load(Ordering::Relaxed)
    }

    /// Answers of the board since the last [`Self::set`].
    pub fn answers(&self) -> usize {
        self.zeros.load(Ordering::Relaxed) / 2
    }
}

/// Bytes to the board and zeros from it.
type Counts = (Arc<AtomicUsize>, Arc<AtomicUsize>);

fn connect(host: &TcpStream, board: &TcpStream, fault: Fault, (to_board, zeros): &Counts) {
    let clone = |stream: &TcpStream| stream.try_clone().expect("a stream can be cloned");
    let (from, to, count) = (clone(host), clone(board), to_board.clone());
    thread::spawn(move || {
        pass(from, to, |byte| {
            damaged(byte, count.fetch_add(1, Ordering::Relaxed), fault)
        });
    });
    let (from, to, zeros) = (clone(board), clone(host), zeros.clone());
    let mut numbers = 1..;
    thread::spawn(move || {
        pass(from, to, |byte| match fault {
            Fault::CutAfter(_) => Some(Some(byte)),
            Fault::None | Fault::LosesAnswer(_) => {
                let before = zeros.fetch_add(usize::from(byte == 0), Ordering::Relaxed);
                let is_lost = fault == Fault::LosesAnswer(before / 2);
                Some((!is_lost).then_some(byte))
            }
            other => damaged(byte, numbers.next()?, other),
        });
    });
}

/// Effect on a byte by its number: unchanged, changed, or lost (`Some(None)`); None means that the line has ended.
fn damaged(byte: u8, number: usize, fault: Fault) -> Option<Option<u8>> {
    match fault {
        Fault::Noise(every) if number % every == every / 2 => Some(Some(byte ^ 0x10)),
        Fault::Noise(every) if number % (7 * every) == 3 * every => Some(None),
        Fault::CutAfter(last) if number >= last => None,
        Fault::Garbled => Some(Some(byte.rotate_left(3) ^ 0x5a)),
        _ => Some(Some(byte)),
    }
}

/// Passes bytes on until one end or the line itself ends.
fn pass(mut from: TcpStream, mut to: TcpStream, mut line: impl FnMut(u8) -> Option<Option<u8>>) {
    let mut bytes = [0; 256];
    while let Ok(length @ 1..) = from.read(&mut bytes) {
        let out: Vec<_> = bytes[..length]
            .iter()
            .map_while(|byte| line(*byte))
            .collect();
        let over = out.len() < length;
        let out: Vec<u8> = out.into_iter().flatten().collect();
        if to.write_all(&out).is_err() || over {
            break;
        }
    }
    let _ = from.shutdown(Shutdown::Both);
    let _ = to.shutdown(Shutdown::Both);
}
