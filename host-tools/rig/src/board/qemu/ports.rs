//! Addresses of a board in QEMU. They are tried before QEMU starts, because its own message about one in use gives no reason and
//! comes late.

use anyhow::{Context, Result, bail};
use std::fmt;
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io;
use std::net::{SocketAddr, SocketAddrV4, TcpListener, UdpSocket};
use std::ops::Range;

/// Range in which a free port is looked for. Ports from 32,768 on are given to clients by the system: such a one may be taken
/// between this check and the start of QEMU, as the build of the firmware lies in between.
const NOT_GIVEN_TO_CLIENTS: Range<u16> = 20_000..32_768;
/// How many ports are tried before the system is asked for one.
const TRIES: usize = 32;

/// Addresses that were free when they were tried; a port 0 was replaced by a free one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Ports {
    /// UDP.
    pub(super) robot: SocketAddrV4,
    /// TCP.
    pub(super) can: Option<SocketAddr>,
    /// TCP.
    pub(super) service: Option<SocketAddr>,
}

impl Ports {
    /// Tries all addresses.
    ///
    /// # Errors
    /// One is taken, or not an address of this computer.
    pub(super) fn check(
        robot: SocketAddr,
        can: Option<SocketAddr>,
        service: Option<SocketAddr>,
    ) -> Result<Self> {
        let SocketAddr::V4(_) = robot else {
            bail!(
                "QEMU takes the robot on an IPv4 address only, like 127.0.0.1:49152; found {robot}"
            );
        };
        // All are bound at the same time, so that no two are the same. They are released when the sockets are dropped, and QEMU
        // binds them.
        let udp = bound(UdpSocket::bind, robot).with_context(|| taken("robot (UDP)", robot))?;
        let listen = |what: &str, address: SocketAddr| {
            bound(TcpListener::bind, address).with_context(|| taken(what, address))
        };
        let tcp = can.map(|can| listen("sensor (TCP)", can)).transpose()?;
        let line = service.map(|service| listen("service (TCP)", service));
        let line = line.transpose()?;
        let SocketAddr::V4(robot) = udp.local_addr()? else {
            bail!("{robot} became another kind of address");
        };
        Ok(Self {
            robot,
            can: tcp.map(|tcp| tcp.local_addr()).transpose()?,
            service: line.map(|line| line.local_addr()).transpose()?,
        })
    }
}

/// The socket for an EtherCAT segment.
///
/// # Errors
/// The address is taken, or not one of this computer.
pub(super) fn segment(address: SocketAddr) -> Result<UdpSocket> {
    bound(UdpSocket::bind, address).with_context(|| taken("EtherCAT sensor (UDP)", address))
}

/// Socket made by `bind` at `address`; for port 0 at a free port that no client is given when the socket is dropped.
pub(super) fn bound<S>(
    bind: impl Fn(SocketAddr) -> io::Result<S>,
    address: SocketAddr,
) -> io::Result<S> {
    if address.port() != 0 {
        return bind(address);
    }
    let ports = NOT_GIVEN_TO_CLIENTS.len() as u64;
    (0..TRIES)
        .find_map(|_| {
            let drawn = RandomState::new().build_hasher().finish() % ports;
            let port = NOT_GIVEN_TO_CLIENTS.start + u16::try_from(drawn).ok()?;
            bind(SocketAddr::new(address.ip(), port)).ok()
        })
        .map_or_else(|| bind(address), Ok)
}

fn taken(what: &str, address: SocketAddr) -> String {
    format!(
        "cannot listen for the {what} on {address}; is another board running, or is this not an address of this computer?"
    )
}

impl fmt::Display for Ports {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "robot on UDP {}", self.robot)?;
        if let Some(can) = self.can {
            write!(f, ", SLCAN on TCP {can}")?;
        }
        match self.service {
            Some(service) => write!(f, ", service on TCP {service}"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::Ipv4Addr;

    const ANY: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 0);

    #[test]
    fn free_ports_are_found() {
        let ports = Ports::check(ANY, Some(ANY), Some(ANY)).unwrap();
        assert!(ports.robot.port() > 0 && ports.can.is_some_and(|can| can.port() > 0));
        assert!(ports.service.is_some_and(|service| service.port() > 0));
        assert_ne!(ports.service, ports.can);
    }

    #[test]
    fn a_taken_port_is_named() {
        let udp = UdpSocket::bind(ANY).unwrap();
        let tcp = TcpListener::bind(ANY).unwrap();
        let (udp, tcp) = (udp.local_addr().unwrap(), tcp.local_addr().unwrap());
        let error = |robot, can, service| {
            let error = Ports::check(robot, Some(can), service).unwrap_err();
            error.to_string()
        };
        assert!(error(udp, ANY, None).contains(&format!("robot (UDP) on {udp}")));
        assert!(error(ANY, tcp, None).contains(&format!("sensor (TCP) on {tcp}")));
        assert!(error(ANY, ANY, Some(tcp)).contains(&format!("service (TCP) on {tcp}")));
    }

    #[test]
    fn sensor_and_service_cannot_share_a_port() {
        let free = Ports::check(ANY, Some(ANY), None).unwrap().can;
        assert!(Ports::check(ANY, free, free).is_err());
    }
}
