//! Which program made a recording: name, version, git hash, with changes or not.

use std::net::SocketAddr;
use std::sync::OnceLock;

/// Git state of the program's build. The program sets it at its start: if this crate contained it, the crate and all that
/// depend on it would be compiled anew at each commit.
static GIT: OnceLock<&'static str> = OnceLock::new();

/// Sets the git state from which the program was built. Only the first call has an effect.
pub fn built_from(git: &'static str) {
    GIT.get_or_init(|| git);
}

/// Name, version and git state of the program.
pub fn text() -> String {
    let git = GIT.get().copied().unwrap_or("as a library");
    format!("softdock {} ({git})", env!("CARGO_PKG_VERSION"))
}

/// Part of the identity of a board that forgets its settings when it ends.
const NO_FLASH: &str = ", no flash";
/// Part of the identity of a board whose telemetry goes to another address than its settings name; the address follows.
const TELEMETRY: &str = ", telemetry to ";

/// Identity of a board on this computer. It contains what the settings do not: whether the board keeps them (`flash`), and
/// the address of its telemetry if that is not the one of the settings.
pub fn of_board_process(flash: bool, telemetry: Option<SocketAddr>) -> String {
    let mut identity = format!("{}, board of this computer, f64", text());
    if !flash {
        identity += NO_FLASH;
    }
    if let Some(recorder) = telemetry {
        identity += &format!("{TELEMETRY}{recorder}");
    }
    identity
}

/// Whether the identity is that of a board that forgets its settings when it ends.
pub fn is_without_flash(identity: &str) -> bool {
    identity.contains(NO_FLASH)
}

/// The address of the board's telemetry in place of that of its settings; None if the identity names none.
pub fn telemetry(identity: &str) -> Option<SocketAddr> {
    identity.split_once(TELEMETRY)?.1.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_identity_of_a_board_process_fits() {
        let address = "[ffff:ffff:ffff:ffff:ffff:ffff:ffff:ffff%4294967295]:65535";
        let longest = of_board_process(false, address.parse().ok());
        assert!(longest.ends_with(address));
        // With the hash of a changed clone in place of "as a library".
        let length = longest.len() + "123456789012 with changes".len() - "as a library".len();
        assert!(length <= softdock_app::service::IDENTITY_BYTES, "{length}");
    }

    #[test]
    fn a_board_process_says_what_its_settings_do_not() {
        let recorder = Some(SocketAddr::from(([127, 0, 0, 1], 49_200)));
        let told = of_board_process(false, recorder);
        assert!(
            is_without_flash(&told) && telemetry(&told) == recorder,
            "{told}"
        );
        let silent = of_board_process(true, None);
        assert!(
            !is_without_flash(&silent) && telemetry(&silent).is_none(),
            "{silent}"
        );
        assert!(told.starts_with(&silent));
    }
}
