//! Addresses as people write them.

use std::net::{SocketAddr, ToSocketAddrs};

/// Parses `127.0.0.1:49152`, or a host name in place of the number: `localhost:49152`. Of the addresses of a name the first
/// IPv4 one is taken: boards and robots use IPv4.
///
/// # Errors
/// No address, with what was expected.
pub fn address(text: &str) -> Result<SocketAddr, String> {
    let bare = text
        .trim_start_matches("tcp:")
        .trim_start_matches("udp:")
        .trim_start_matches("//");
    let expected = || {
        format!(
            "`{text}` is no address; expected HOST:PORT, such as 127.0.0.1:49152 or localhost:49152"
        )
    };
    let found: Vec<SocketAddr> = bare.to_socket_addrs().map_err(|_| expected())?.collect();
    let v4 = found.iter().find(|address| address.is_ipv4());
    v4.or(found.first()).copied().ok_or_else(expected)
}

#[cfg(test)]
mod tests {
    use super::address;

    #[test]
    fn names_and_schemes_are_understood() {
        for text in [
            "127.0.0.1:49152",
            "localhost:49152",
            "tcp:127.0.0.1:49152",
            "tcp://localhost:49152",
        ] {
            let found = address(text).unwrap();
            assert!(found.ip().is_loopback() && found.port() == 49152, "{text}");
        }
        assert!(address("[::1]:7").unwrap().is_ipv6());
        for text in [
            "",
            "127.0.0.1",
            "127.0.0.1:",
            "127.0.0.1:99999",
            ":::",
            "a b:1",
        ] {
            let error = address(text).unwrap_err();
            assert!(error.contains("expected HOST:PORT"), "{error}");
        }
    }
}
