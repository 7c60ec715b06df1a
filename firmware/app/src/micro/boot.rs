//! The log's first lines: who this is, and with which settings.

use crate::image::ImageError;
use crate::settings::BoardSettings;
use defmt::{Display2Format, info, warn};

/// Who the firmware is.
#[derive(Clone, Copy, Debug)]
pub struct Identity {
    /// Version of the firmware.
    pub version: &'static str,
    /// Git hash, and whether there were changes.
    pub git: &'static str,
    /// Board and chip.
    pub board: &'static str,
}

/// Where settings come from: the sequence of their block, or why there is none that can be used.
pub type Origin = Result<u32, ImageError>;

/// Logs who this is.
pub fn report_identity(identity: &Identity) {
    info!(
        "softdock {=str} ({=str}) on {=str}",
        identity.version, identity.git, identity.board
    );
}

/// Logs why the firmware started over, if it did not do so by itself: the message of a panic or of
/// a fault.
pub fn report_crash(message: Option<&str>) {
    if let Some(message) = message {
        defmt::error!("started over after: {=str}", message);
    }
}

/// Logs which settings are used.
pub fn report_settings(origin: &Origin, settings: &BoardSettings) {
    match origin {
        Ok(sequence) => info!("settings {=u32} from flash", sequence),
        Err(error) => warn!("default settings: {}", Display2Format(error)),
    }
    info!(
        "address {=str}/{=u8}, robot on UDP port {=u16}, from {=str}",
        settings.network.address,
        settings.network.prefix_bits,
        settings.network.rsi_port,
        match settings.rsi.robot_ip.as_str() {
            "" => "anyone",
            address => address,
        }
    );
}

/// Logs that settings which passed their checks cannot be used, so that nothing was started.
pub fn report_unusable() {
    defmt::error!("settings passed their checks, but cannot be used: nothing was started");
}

/// Logs that robot and sensor may come. A launcher waits for this line.
pub fn report_ready() {
    info!("ready");
}
