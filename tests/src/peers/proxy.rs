//! A line between a host and a board that is not what it should be: noisy, cut off in the middle, or
//! run at another speed.

use std::io::{Read, Write};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

/// What the line does to bytes, in both directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Nothing.
    None,
    /// Flips a bit of every so many bytes, and drops another one.
    Noise(usize),
    /// Ends after so many bytes to the board.
    CutAfter(usize),
    /// Makes other bytes of all that the board says, as another baud rate does.
    Garbled,
}

/// A TCP port in front of that of a board. It ends with the test.
#[derive(Debug)]
pub struct Proxy {
    /// Where a host connects.
    pub address: SocketAddr,
    fault: Arc<Mutex<Fault>>,
    to_board: Arc<AtomicUsize>,
}

impl Proxy {
    /// A line to a board.
    ///
    /// # Panics
    /// If no port is free.
    pub fn start(board: SocketAddr, fault: Fault) -> Self {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a free TCP port");
        let address = listener.local_addr().expect("its address");
        let fault = Arc::new(Mutex::new(fault));
        let to_board = Arc::new(AtomicUsize::new(0));
        let (shared, count) = (fault.clone(), to_board.clone());
        thread::spawn(move || {
            for host in listener.incoming().flatten() {
                let Ok(board) = TcpStream::connect(board) else {
                    continue;
                };
                let fault = *shared.lock().unwrap_or_else(PoisonError::into_inner);
                connect(&host, &board, fault, &count);
            }
        });
        Self {
            address,
            fault,
            to_board,
        }
    }

    /// What connections from now on do.
    pub fn set(&self, fault: Fault) {
        *self.fault.lock().unwrap_or_else(PoisonError::into_inner) = fault;
        self.to_board.store(0, Ordering::Relaxed);
    }

    /// Bytes that went to the board since the last [`Self::set`].
    pub fn to_board(&self) -> usize {
        self.to_board.load(Ordering::Relaxed)
    }
}

fn connect(host: &TcpStream, board: &TcpStream, fault: Fault, to_board: &Arc<AtomicUsize>) {
    let clone = |stream: &TcpStream| stream.try_clone().expect("a stream can be cloned");
    let (from, to, count) = (clone(host), clone(board), to_board.clone());
    thread::spawn(move || pass(from, to, fault, &count));
    let (from, to) = (clone(board), clone(host));
    let fault = match fault {
        Fault::CutAfter(_) => Fault::None,
        other => other,
    };
    thread::spawn(move || pass(from, to, fault, &AtomicUsize::new(1)));
}

/// Passes bytes on until one end or the fault ends it.
fn pass(mut from: TcpStream, mut to: TcpStream, fault: Fault, count: &AtomicUsize) {
    let mut bytes = [0; 256];
    while let Ok(length @ 1..) = from.read(&mut bytes) {
        let mut out = Vec::new();
        let mut over = false;
        for byte in &bytes[..length] {
            let number = count.fetch_add(1, Ordering::Relaxed);
            match fault {
                Fault::Noise(every) if number % every == every / 2 => out.push(byte ^ 0x10),
                Fault::Noise(every) if number % (7 * every) == 3 * every => {}
                Fault::CutAfter(last) if number >= last => over = true,
                Fault::Garbled => out.push(byte.rotate_left(3) ^ 0x5a),
                _ => out.push(*byte),
            }
        }
        if to.write_all(&out).is_err() || over {
            break;
        }
    }
    let _ = from.shutdown(Shutdown::Both);
    let _ = to.shutdown(Shutdown::Both);
}
