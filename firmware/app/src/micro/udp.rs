//! The robot's UDP socket over `embassy-net`.

use super::stamped::ARRIVALS;
use crate::board::{DatagramSocket, IoError};
use crate::robot::TELEGRAM_BYTES;
use crate::settings::Network;
use core::net::SocketAddr;
use core::task::Poll;
use embassy_futures::poll_once;
use embassy_net::udp::{PacketMetadata, UdpMetadata, UdpSocket};
use embassy_net::{Config, IpAddress, IpEndpoint, Ipv4Cidr, Stack, StaticConfigV4};
use softdock_link::rsi::SEN_MAX_BYTES;
use static_cell::{ConstStaticCell, StaticCell};

/// Datagrams that may wait; the robot task answers the newest and counts the others. Half a cycle
/// of a flood of 8,000 datagrams per second.
const RECEIVE_QUEUE: usize = 16;
/// Answers that may wait for the network, for example until the robot's address is resolved.
const SEND_QUEUE: usize = 4;

/// A static address, from settings.
pub(super) fn static_address(network: &Network) -> Config {
    Config::ipv4_static(StaticConfigV4 {
        address: Ipv4Cidr::new(network.address, network.prefix_bits),
        gateway: network.gateway,
        dns_servers: heapless::Vec::new(),
    })
}

/// A socket on a port of the board.
pub struct UdpPort(UdpSocket<'static>);

impl UdpPort {
    /// Takes port `port`, once; for 0 any that is free. The queues take about 27 kB.
    pub(super) fn bind(stack: Stack<'static>, port: u16) -> Option<Self> {
        type Received = [u8; RECEIVE_QUEUE * TELEGRAM_BYTES];
        type Sent = [u8; SEND_QUEUE * SEN_MAX_BYTES];
        static FROM: StaticCell<[PacketMetadata; RECEIVE_QUEUE]> = StaticCell::new();
        static RECEIVED: ConstStaticCell<Received> =
            ConstStaticCell::new([0; RECEIVE_QUEUE * TELEGRAM_BYTES]);
        static TO: StaticCell<[PacketMetadata; SEND_QUEUE]> = StaticCell::new();
        static SENT: ConstStaticCell<Sent> = ConstStaticCell::new([0; SEND_QUEUE * SEN_MAX_BYTES]);
        let mut socket = UdpSocket::new(
            stack,
            FROM.try_init_with(|| [PacketMetadata::EMPTY; RECEIVE_QUEUE])?,
            RECEIVED.try_take()?,
            TO.try_init_with(|| [PacketMetadata::EMPTY; SEND_QUEUE])?,
            SENT.try_take()?,
        );
        socket.bind(port).ok()?;
        Some(Self(socket))
    }
}

/// Hands a datagram to the network's stack; waits for room in the socket's queue.
pub(super) async fn send(
    socket: &UdpSocket<'_>,
    datagram: &[u8],
    to: SocketAddr,
) -> Result<(), IoError> {
    let SocketAddr::V4(to) = to else {
        return Err(IoError::Lost);
    };
    let to = IpEndpoint::new(IpAddress::Ipv4(*to.ip()), to.port());
    let sent = socket.send_to(datagram, to).await;
    sent.map_err(|_| IoError::Lost)
}

fn sender(metadata: UdpMetadata) -> SocketAddr {
    let IpAddress::Ipv4(address) = metadata.endpoint.addr;
    SocketAddr::new(address.into(), metadata.endpoint.port)
}

impl DatagramSocket for UdpPort {
    async fn receive(&mut self, buffer: &mut [u8]) -> Result<(usize, SocketAddr), IoError> {
        match self.0.recv_from(buffer).await {
            Ok((length, metadata)) => Ok((length, sender(metadata))),
            // `TELEGRAM_BYTES` holds every datagram of an Ethernet frame; fragments are not reassembled.
            Err(_) => Err(IoError::Lost),
        }
    }

    fn try_receive(&mut self, buffer: &mut [u8]) -> Option<(usize, SocketAddr)> {
        match poll_once(self.receive(buffer)) {
            Poll::Ready(Ok(received)) => Some(received),
            Poll::Ready(Err(_)) | Poll::Pending => None,
        }
    }

    fn came_us(&self, sender: SocketAddr) -> Option<u64> {
        ARRIVALS.newest_us(sender)
    }

    /// Never waits: an answer that has to wait for room would come too late, and the robot's task must not wait for an address
    /// that cannot be resolved.
    async fn send(&mut self, datagram: &[u8], to: SocketAddr) -> Result<(), IoError> {
        match poll_once(send(&self.0, datagram, to)) {
            Poll::Ready(sent) => sent,
            Poll::Pending => Err(IoError::Lost),
        }
    }
}
