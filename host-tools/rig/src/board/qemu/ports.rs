//! The addresses of a board in QEMU. QEMU's own message about a taken one names no reason and
//! comes late, so they are tried before.

use anyhow::{Context, Result, bail};
use std::fmt;
use std::net::{SocketAddr, SocketAddrV4, TcpListener, UdpSocket};

/// Addresses that were free a moment ago; a port 0 was replaced by a free one.
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
        // All at the same time, so that two of them cannot be the same; QEMU takes them when they
        // are dropped.
        let udp = UdpSocket::bind(robot).with_context(|| taken("robot (UDP)", robot))?;
        let listen = |what: &str, address: SocketAddr| {
            TcpListener::bind(address).with_context(|| taken(what, address))
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
    UdpSocket::bind(address).with_context(|| taken("EtherCAT sensor (UDP)", address))
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
