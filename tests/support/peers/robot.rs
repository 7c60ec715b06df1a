//! A KUKA controller that sends its next telegram as soon as the answer has come, so its rate depends on the board or on the
//! test. It parses answers independently, with a few lines of its own.

use crate::process::PATIENCE;
use std::io::ErrorKind;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

/// Interpolation cycle, ms.
const CYCLE_MS: u64 = 4;
/// A time stamp that does not fit into 32 bits, as on real controllers.
const FIRST_IPOC: u64 = 123_645_634_560;

/// An answer of the board.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Time stamp of the telegram that it answers.
    pub ipoc: u64,
    /// Correction X Y Z (10⁻⁴ mm) A B C (10⁻⁴ degrees).
    pub correction: [i64; 6],
    /// The datagram.
    pub bytes: Vec<u8>,
}

/// A simulated robot.
#[derive(Debug)]
pub struct Robot {
    socket: UdpSocket,
    board: SocketAddr,
    /// Time stamp of the next telegram.
    pub ipoc: u64,
    /// Pose in units of 10⁻⁴ mm and degrees: the sum of all corrections.
    pub pose: [i64; 6],
}

impl Robot {
    /// A robot on its own port.
    ///
    /// # Panics
    /// If there is no free port.
    pub fn new(board: SocketAddr) -> Self {
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a free UDP port");
        let robot = Self {
            socket,
            board,
            ipoc: FIRST_IPOC,
            pose: [0; 6],
        };
        robot.patience(PATIENCE);
        robot
    }

    /// The telegram with time stamp `ipoc`.
    pub fn telegram(&self, ipoc: u64) -> String {
        let [x, y, z, a, b, c] = self.pose.map(|counts| counts as f64 * 1e-4);
        format!(
            "<Rob Type=\"KUKA\"><RIst X=\"{x:.4}\" Y=\"{y:.4}\" Z=\"{z:.4}\" A=\"{a:.4}\" B=\"{b:.4}\" C=\"{c:.4}\"/>\
             <Delay D=\"0\"/><IPOC>{ipoc}</IPOC></Rob>"
        )
    }

    /// Sends any datagram.
    ///
    /// # Panics
    /// If it cannot be sent.
    pub fn send(&self, datagram: &[u8]) {
        let sent = self
            .socket
            .send_to(datagram, self.board)
            .expect("a datagram can be sent");
        assert_eq!(sent, datagram.len());
    }

    /// The next answer.
    ///
    /// # Panics
    /// If none comes within [`PATIENCE`], or it is malformed.
    pub fn receive(&self) -> Answer {
        let mut buffer = [0; 2048];
        let (length, _) = loop {
            match self.socket.recv_from(&mut buffer) {
                // The machine was paused.
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                // A board of a test that has ended, whose robot had the same port.
                Ok((_, from)) if from != self.board => {}
                other => break other.expect("the board answers"),
            }
        };
        Answer::parse(&buffer[..length])
    }

    /// Runs one cycle on a flooded network that may lose datagrams: the telegram is sent again, unchanged, until its answer
    /// comes.
    ///
    /// # Panics
    /// If the answer never comes.
    pub fn cycle_through_flood(&mut self) -> Answer {
        let give_up = Instant::now() + PATIENCE;
        self.patience(Duration::from_millis(100));
        let answer = loop {
            self.send(self.telegram(self.ipoc).as_bytes());
            let mut buffer = [0; 2048];
            if let Ok((length, _)) = self.socket.recv_from(&mut buffer) {
                let answer = Answer::parse(&buffer[..length]);
                // A telegram that was sent twice is answered twice.
                if answer.ipoc == self.ipoc {
                    break answer;
                }
                assert!(answer.ipoc < self.ipoc, "{answer:?}");
            }
            assert!(Instant::now() < give_up, "{} was never answered", self.ipoc);
        };
        self.patience(PATIENCE);
        self.apply(&answer);
        answer
    }

    /// Continues as a real robot does, with a new telegram each cycle even without an answer, until one is answered within
    /// its cycle; returns the number of cycles.
    ///
    /// # Panics
    /// If none ever is.
    pub fn cycles_until_answered(&mut self) -> usize {
        let give_up = Instant::now() + PATIENCE;
        for cycles in 1.. {
            if self.answered_in_time() {
                return cycles;
            }
            assert!(Instant::now() < give_up, "no answer in {cycles} cycles");
        }
        unreachable!("it is patient for less")
    }

    /// One cycle in real time. An answer to an older telegram is too late.
    fn answered_in_time(&mut self) -> bool {
        let end = Instant::now() + Duration::from_millis(CYCLE_MS);
        self.send(self.telegram(self.ipoc).as_bytes());
        let asked = self.ipoc;
        self.ipoc += CYCLE_MS;
        let mut buffer = [0; 2048];
        while let Some(left) = end.checked_duration_since(Instant::now()) {
            self.patience(left.max(Duration::from_micros(1)));
            let Ok((length, _)) = self.socket.recv_from(&mut buffer) else {
                continue;
            };
            let answer = Answer::parse(&buffer[..length]);
            if answer.ipoc == asked {
                self.patience(PATIENCE);
                self.apply(&answer);
                return true;
            }
        }
        self.patience(PATIENCE);
        false
    }

    fn patience(&self, patience: Duration) {
        self.socket
            .set_read_timeout(Some(patience))
            .expect("a timeout can be set");
    }

    /// Number of datagrams that were received but not read; there should be none without a telegram.
    ///
    /// # Panics
    /// If the socket cannot be read.
    pub fn unread(&self) -> usize {
        self.socket
            .set_nonblocking(true)
            .expect("a socket can be made non-blocking");
        let count = std::iter::from_fn(|| self.socket.recv_from(&mut [0; 2048]).ok()).count();
        self.socket
            .set_nonblocking(false)
            .expect("a socket can be made blocking");
        count
    }

    /// One cycle: telegram, answer, motion.
    ///
    /// # Panics
    /// If the answer has another time stamp.
    pub fn cycle(&mut self) -> Answer {
        self.send(self.telegram(self.ipoc).as_bytes());
        let answer = self.receive();
        assert_eq!(
            answer.ipoc, self.ipoc,
            "the time stamp must come back as it was"
        );
        self.apply(&answer);
        answer
    }

    /// Moves as an answer says and continues with the cycle after it.
    pub fn apply(&mut self, answer: &Answer) {
        for (pose, step) in self.pose.iter_mut().zip(answer.correction) {
            *pose += step;
        }
        self.ipoc = answer.ipoc + CYCLE_MS;
    }
}

impl Answer {
    fn parse(bytes: &[u8]) -> Self {
        let text = std::str::from_utf8(bytes).expect("an answer in UTF-8");
        assert!(
            text.starts_with("<Sen Type=\"ImFree\">") && text.ends_with("</Sen>"),
            "{text}"
        );
        let between = |before: &str, after: &str| {
            let rest = text.split_once(before).map(|(_, rest)| rest);
            let value = rest
                .and_then(|rest| rest.split_once(after))
                .map(|(value, _)| value);
            value.unwrap_or_else(|| panic!("expected {before}..{after} in {text}"))
        };
        let ipoc = between("<IPOC>", "</IPOC>").parse().expect("a time stamp");
        let axes = ["X", "Y", "Z", "A", "B", "C"];
        let correction = axes.map(|axis| counts(between(&format!(" {axis}=\""), "\"")));
        Self {
            ipoc,
            correction,
            bytes: bytes.to_vec(),
        }
    }

    /// Whether the correction is zero.
    pub fn is_zero(&self) -> bool {
        self.correction == [0; 6]
    }
}

/// Decimal text with four decimals in units of the last one.
///
/// # Panics
/// If it is anything else.
pub fn counts(text: &str) -> i64 {
    let (whole, decimals) = text.split_once('.').expect("a decimal point");
    assert_eq!(decimals.len(), 4, "{text}");
    format!("{whole}{decimals}").parse().expect("a number")
}
