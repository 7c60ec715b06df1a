//! The board's place on the network of the robot.

use super::{BoardSettingsError, Text, text};
use core::net::{Ipv4Addr, SocketAddrV4};

softdock_control::described! {
/// The board's place on the network. A board that is a process listens where it is told to instead.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NetworkSettings: "network" {
    /// Static IPv4 address of the board, in the robot's subnet.
    pub address: Text = text("192.168.1.20"),
    /// Length of the subnet's prefix, bits: 24 is the mask 255.255.255.0.
    pub prefix_bits: u8 = 24 => 1.0..=30.0,
    /// Gateway to other subnets; empty: none.
    pub gateway: Text = Text::new(),
    /// UDP port that takes the robot's telegrams.
    pub rsi_port: u16 = 49_152 => 1.0..=65_535.0,
    /// Address and port of the recorder that gets each cycle, as "192.168.1.5:49200"; empty: none.
    pub recorder: Text = Text::new(),
}
}

/// The settings, ready for a network stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Network {
    /// Address of the board.
    pub address: Ipv4Addr,
    /// Length of the subnet's prefix, bits.
    pub prefix_bits: u8,
    /// Gateway to other subnets.
    pub gateway: Option<Ipv4Addr>,
    /// UDP port that takes the robot's telegrams.
    pub rsi_port: u16,
    /// Recorder that gets each cycle.
    pub recorder: Option<SocketAddrV4>,
}

impl NetworkSettings {
    /// Checks the settings and makes them ready for a network stack.
    pub fn build(&self) -> Result<Network, BoardSettingsError> {
        self.check_ranges()?;
        Ok(Network {
            address: host("network.address", &self.address)?,
            prefix_bits: self.prefix_bits,
            gateway: match self.gateway.is_empty() {
                true => None,
                false => Some(host("network.gateway", &self.gateway)?),
            },
            rsi_port: self.rsi_port,
            recorder: self.recorder()?,
        })
    }

    /// The configured recorder, if any.
    pub fn recorder(&self) -> Result<Option<SocketAddrV4>, BoardSettingsError> {
        const FIELD: &str = "network.recorder";
        if self.recorder.is_empty() {
            return Ok(None);
        }
        let socket: SocketAddrV4 = self
            .recorder
            .parse()
            .map_err(|_| BoardSettingsError::Socket { field: FIELD })?;
        match one_host(*socket.ip()) && socket.port() > 0 {
            true => Ok(Some(socket)),
            false => Err(BoardSettingsError::Socket { field: FIELD }),
        }
    }
}

fn host(field: &'static str, text: &Text) -> Result<Ipv4Addr, BoardSettingsError> {
    text.parse()
        .ok()
        .filter(|address| one_host(*address))
        .ok_or(BoardSettingsError::Address { field })
}

/// An address that a single host can have.
fn one_host(address: Ipv4Addr) -> bool {
    !(address.is_unspecified() || address.is_multicast() || address.is_broadcast())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(change: impl FnOnce(&mut NetworkSettings)) -> Result<Network, BoardSettingsError> {
        let mut settings = NetworkSettings::default();
        change(&mut settings);
        settings.build()
    }

    #[test]
    fn defaults_are_a_private_subnet_without_recorder() {
        let network = NetworkSettings::default().build().unwrap();
        assert_eq!(network.address, Ipv4Addr::new(192, 168, 1, 20));
        assert_eq!((network.gateway, network.recorder), (None, None));
    }

    #[test]
    fn an_address_that_no_host_has_is_refused_by_name() {
        for address in ["", "192.168.1", "224.0.0.1", "255.255.255.255", "0.0.0.0"] {
            let error = with(|s| s.address = Text::try_from(address).unwrap());
            let field = "network.address";
            assert_eq!(error, Err(BoardSettingsError::Address { field }));
        }
        for recorder in ["192.168.1.5", "192.168.1.5:0", "0.0.0.0:49200"] {
            let error = with(|s| s.recorder = Text::try_from(recorder).unwrap());
            let field = "network.recorder";
            assert_eq!(error, Err(BoardSettingsError::Socket { field }));
        }
        let recorder = with(|s| s.recorder = Text::try_from("192.168.1.5:49200").unwrap());
        assert_eq!(recorder.unwrap().recorder.unwrap().port(), 49_200);
    }

    #[test]
    fn a_prefix_leaves_room_for_two_hosts() {
        assert!(with(|s| s.prefix_bits = 31).is_err());
        assert!(with(|s| s.prefix_bits = 30).is_ok());
    }
}
