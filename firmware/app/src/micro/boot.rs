//! The log's first lines: who this is, and with which settings.

use crate::processor::Processor;
use crate::settings::BoardSettings;
use crate::store::{Boot, Origin};
use defmt::{Display2Format, error, info, warn};

/// Who the firmware is.
#[derive(Clone, Copy, Debug)]
pub struct Identity {
    /// Version of the firmware.
    pub version: &'static str,
    /// Git hash, and whether there were changes.
    pub git: &'static str,
    /// Board and chip.
    pub board: &'static str,
    /// What it can compute.
    pub processor: Processor,
}

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

/// Logs which settings are used, and whether the processor keeps up with them.
pub fn report_settings(boot: &Boot, processor: Processor) {
    match boot.origin {
        Origin::Flash { sequence, .. } => info!("settings {=u32} from flash", sequence),
        Origin::Trial(trial) => warn!(
            "settings {=u32} from flash, on trial for {=u16} s",
            trial.sequence, trial.confirm_within_s
        ),
        Origin::Defaults(error) => error!(
            "DEFAULT SETTINGS, not to be armed: {}",
            Display2Format(&error)
        ),
    }
    let settings: &BoardSettings = &boot.settings;
    if let Err(slow) = processor.accepts(settings) {
        error!("NOT TO BE ARMED: {}", Display2Format(&slow));
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
