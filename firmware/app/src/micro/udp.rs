//! The robot's UDP socket over `embassy-net`.

use crate::board::{DatagramSocket, IoError};
use crate::robot::TELEGRAM_BYTES;
use crate::settings::Network;
use core::net::SocketAddr;
use core::task::Poll;
use embassy_futures::poll_once;
use embassy_net::udp::{BindError, PacketMetadata, UdpMetadata, UdpSocket};
use embassy_net::{Config, IpAddress, IpEndpoint, Ipv4Cidr, Stack, StaticConfigV4};
use softdock_link::rsi::SEN_MAX_BYTES;

/// Datagrams that may wait; the robot task answers the newest and counts the others. Half a cycle
/// of a flood of 8,000 datagrams per second.
const RECEIVE_QUEUE: usize = 16;
/// Answers that may wait for the network, for example until the robot's address is resolved.
const SEND_QUEUE: usize = 4;

/// A static address, from settings.
pub fn static_address(network: &Network) -> Config {
    Config::ipv4_static(StaticConfigV4 {
        address: Ipv4Cidr::new(network.address, network.prefix_bits),
        gateway: network.gateway,
        dns_servers: heapless::Vec::new(),
    })
}

const RECEIVED_BYTES: usize = RECEIVE_QUEUE * TELEGRAM_BYTES;
/// Bytes of the datagrams in both queues of a [`UdpPort`], about 27 kB.
pub const UDP_BYTES: usize = RECEIVED_BYTES + SEND_QUEUE * SEN_MAX_BYTES;

/// Lengths and senders of the datagrams.
#[derive(Debug)]
pub struct UdpMetadataQueues {
    received_from: [PacketMetadata; RECEIVE_QUEUE],
    sent_to: [PacketMetadata; SEND_QUEUE],
}

impl UdpMetadataQueues {
    /// Empty queues.
    pub const fn new() -> Self {
        Self {
            received_from: [PacketMetadata::EMPTY; RECEIVE_QUEUE],
            sent_to: [PacketMetadata::EMPTY; SEND_QUEUE],
        }
    }
}

impl Default for UdpMetadataQueues {
    fn default() -> Self {
        Self::new()
    }
}

/// Memory of a [`UdpPort`].
#[derive(Debug)]
pub struct UdpQueues {
    /// Lengths and senders.
    pub metadata: &'static mut UdpMetadataQueues,
    /// The datagrams.
    pub bytes: &'static mut [u8; UDP_BYTES],
}

/// A socket on a port of the board.
pub struct UdpPort<'a> {
    socket: UdpSocket<'a>,
}

impl<'a> UdpPort<'a> {
    /// Takes port `port`.
    ///
    /// # Errors
    /// The port is 0.
    pub fn bind(stack: Stack<'a>, port: u16, queues: UdpQueues) -> Result<Self, BindError> {
        let (received, sent) = queues.bytes.split_at_mut(RECEIVED_BYTES);
        let mut socket = UdpSocket::new(
            stack,
            &mut queues.metadata.received_from,
            received,
            &mut queues.metadata.sent_to,
            sent,
        );
        socket.bind(port)?;
        Ok(Self { socket })
    }
}

fn sender(metadata: UdpMetadata) -> SocketAddr {
    let IpAddress::Ipv4(address) = metadata.endpoint.addr;
    SocketAddr::new(address.into(), metadata.endpoint.port)
}

impl DatagramSocket for UdpPort<'_> {
    async fn receive(&mut self, buffer: &mut [u8]) -> Result<(usize, SocketAddr), IoError> {
        match self.socket.recv_from(buffer).await {
            Ok((length, metadata)) => Ok((length, sender(metadata))),
            // `TELEGRAM_BYTES` hold every datagram of an Ethernet frame; fragments are not put
            // together.
            Err(_) => Err(IoError::Lost),
        }
    }

    fn try_receive(&mut self, buffer: &mut [u8]) -> Option<(usize, SocketAddr)> {
        match poll_once(self.receive(buffer)) {
            Poll::Ready(Ok(received)) => Some(received),
            Poll::Ready(Err(_)) | Poll::Pending => None,
        }
    }

    async fn send(&mut self, datagram: &[u8], to: SocketAddr) -> Result<(), IoError> {
        let SocketAddr::V4(to) = to else {
            return Err(IoError::Lost);
        };
        let to = IpEndpoint::new(IpAddress::Ipv4(*to.ip()), to.port());
        let sent = self.socket.send_to(datagram, to).await;
        sent.map_err(|_| IoError::Lost)
    }
}
