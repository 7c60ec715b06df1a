//! Times at which datagrams left the Ethernet controller. A socket's queue keeps no times, and the time of an answer counts from
//! the arrival of the telegram, not from when the board reads it.

use core::cell::RefCell;
use core::net::{Ipv4Addr, SocketAddr, SocketAddrV4};
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::RawMutex;
use heapless::HistoryBuf;

/// Datagrams that are remembered: as many as may wait in the robot's socket.
const REMEMBERED: usize = 16;

/// Senders and times of the last datagrams, µs since boot.
pub struct Arrivals<M: RawMutex>(Mutex<M, RefCell<HistoryBuf<(SocketAddr, u64), REMEMBERED>>>);

impl<M: RawMutex> Arrivals<M> {
    /// None yet.
    #[allow(clippy::new_without_default, reason = "for statics")]
    pub const fn new() -> Self {
        Self(Mutex::new(RefCell::new(HistoryBuf::new())))
    }

    /// Remembers a datagram.
    pub fn note(&self, sender: SocketAddr, at_us: u64) {
        self.0.lock(|last| last.borrow_mut().write((sender, at_us)));
    }

    /// When the newest datagram of `sender` came, µs since boot; `None` if too many others have come since.
    pub fn newest_us(&self, sender: SocketAddr) -> Option<u64> {
        self.0.lock(|last| {
            let last = last.borrow();
            let mut newest_first = last.oldest_ordered().rev();
            let newest = newest_first.find(|(from, _)| *from == sender);
            newest.map(|(_, at_us)| *at_us)
        })
    }
}

/// Sender of a datagram to UDP port `port`, from its Ethernet frame; `None` for other frames (RFC 894, 791 and 768).
pub fn udp_sender(frame: &[u8], port: u16) -> Option<SocketAddr> {
    const IPV4: [u8; 2] = [0x08, 0x00];
    const UDP: u8 = 17;
    let (ethernet, packet) = frame.split_at_checked(14)?;
    let header = 4 * usize::from(packet.first()? & 0xF);
    // Flags may be set, but no offset: a later fragment has no ports.
    let [flags, offset] = *packet.get(6..)?.first_chunk()?;
    if ethernet[12..] != IPV4 || *packet.get(9)? != UDP || (flags & 0x1F, offset) != (0, 0) {
        return None;
    }
    let address: [u8; 4] = *packet.get(12..)?.first_chunk()?;
    let [from_high, from_low, to_high, to_low] = *packet.get(header..)?.first_chunk()?;
    let from = u16::from_be_bytes([from_high, from_low]);
    let sender = SocketAddrV4::new(Ipv4Addr::from(address), from);
    (u16::from_be_bytes([to_high, to_low]) == port).then_some(sender.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use embassy_sync::blocking_mutex::raw::NoopRawMutex;

    const PORT: u16 = 49152;

    /// A datagram of 192.168.1.10:1234, with `words` of options behind the IP header.
    fn frame(words: u8) -> Vec<u8> {
        let mut frame = vec![2; 12];
        frame.extend([0x08, 0x00, 0x45 + words, 0, 0, 32, 0, 1, 0x40, 0, 64, 17]);
        frame.extend([0, 0, 192, 168, 1, 10, 192, 168, 1, 20]);
        frame.extend(vec![1; 4 * usize::from(words)]);
        frame.extend(1234_u16.to_be_bytes());
        frame.extend(PORT.to_be_bytes());
        frame.extend([0, 12, 0, 0, b'<', b'R', b'o', b'b']);
        frame
    }

    fn robot() -> SocketAddr {
        "192.168.1.10:1234".parse().unwrap()
    }

    #[test]
    fn the_sender_of_a_datagram_to_the_port_is_found() {
        for words in [0, 1, 10] {
            assert_eq!(udp_sender(&frame(words), PORT), Some(robot()), "{words}");
        }
    }

    #[test]
    fn other_frames_have_none() {
        let changed = |at: usize, to: u8| {
            let mut frame = frame(0);
            frame[at] = to;
            udp_sender(&frame, PORT)
        };
        assert_eq!(changed(12, 0x88), None, "EtherCAT");
        assert_eq!(changed(23, 6), None, "TCP");
        assert_eq!(changed(37, 1), None, "another port");
        assert_eq!(changed(21, 1), None, "a later fragment");
        assert_eq!(changed(20, 0x1F), None, "a later fragment");
        assert_eq!(changed(20, 0x20), Some(robot()), "the first of several");
        let whole = frame(0);
        for length in 0..38 {
            assert_eq!(udp_sender(&whole[..length], PORT), None, "{length}");
        }
        assert_eq!(udp_sender(&whole[..38], PORT), Some(robot()));
    }

    #[test]
    fn the_newest_of_a_sender_counts_while_it_is_remembered() {
        let arrivals = Arrivals::<NoopRawMutex>::new();
        let stranger = "192.168.1.66:1234".parse().unwrap();
        assert_eq!(arrivals.newest_us(robot()), None);
        for at_us in [100, 200] {
            arrivals.note(robot(), at_us);
        }
        for at_us in 0..REMEMBERED as u64 {
            assert_eq!(arrivals.newest_us(robot()), Some(200));
            arrivals.note(stranger, 300 + at_us);
        }
        assert_eq!(arrivals.newest_us(robot()), None, "pushed out");
    }
}
