//! Whether somebody takes the board's cycles where its settings say. Nothing is sent for that: a
//! recorder would take it for a board.

use super::super::{Check, settings};
use std::io::ErrorKind;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};

pub(super) fn check(recorder: &str) -> Check {
    let name = "recorder";
    let Ok(address) = recorder.parse::<SocketAddr>() else {
        // Empty; anything else does not pass the checks of the settings.
        return settings::recorder(recorder);
    };
    let start = format!("softdock record --listen {address} -o RUN.mcap");
    let own = UdpSocket::bind((address.ip(), 0)).is_ok();
    if !own {
        return elsewhere(name, address, &start);
    }
    match UdpSocket::bind(address).map_err(|error| error.kind()) {
        Err(ErrorKind::AddrInUse) => Check::good(
            name,
            format!("a program of this computer listens on {address}"),
        ),
        Err(error) => Check::warning(name, format!("{address} cannot be looked at: {error}")),
        Ok(_) => Check::warning(
            name,
            format!("nobody listens on {address} of this computer; `{start}`"),
        ),
    }
}

fn elsewhere(name: &'static str, address: SocketAddr, start: &str) -> Check {
    // The system looks for a way there; no packet goes out.
    let route =
        UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).and_then(|socket| socket.connect(address));
    match route {
        Ok(()) => Check::warning(
            name,
            format!(
                "{address} is another computer's, so it cannot be seen from here whether a recorder listens: \
                 `{start}` there, or set `network.recorder`"
            ),
        ),
        Err(error) => Check::warning(
            name,
            format!(
                "{address} is no address of this computer, and there is no way to it ({error}): set \
                 `network.recorder`"
            ),
        ),
    }
}
