//! The start of the firmware, and the first lines of the log: identity and settings.

use super::SHARED;
use super::identity::Identity;
use super::service::{self, Prepared};
use crate::processor::Processor;
use crate::settings::BoardSettings;
use crate::store::{Boot, Origin, Store, TRIAL_BYTES, Trial};
use defmt::{Display2Format, error, info, warn};
use embedded_storage_async::nor_flash::NorFlash;

/// Information of a start on the run before.
#[derive(Clone, Copy, Debug)]
pub struct Before<'a> {
    /// The message of a panic or of a fault; `None` if there was neither.
    pub crash: Option<&'a str>,
    /// Bytes that it handed over; arbitrary after power-up.
    pub retained: [u8; TRIAL_BYTES],
    /// What ended it, as the chip reports.
    pub reset: &'static str,
}

/// Reads the settings to start with, and logs identity, cause of the start, and settings. `None` if called more than once.
/// `number` differs from start to start. Reading flash must not wait for anything.
pub fn boot<F: NorFlash>(
    identity: &Identity,
    store: &'static mut Store<F>,
    before: Before<'_>,
    number: u32,
) -> Option<(Boot, Prepared<F>)> {
    info!(
        "softdock {=str} ({=str}) on {=str}",
        identity.version, identity.git, identity.board
    );
    info!("reset by: {=str}", before.reset);
    SHARED.update_machine(|machine| machine.reset = before.reset);
    if let Some(message) = before.crash {
        error!("started over after: {=str}", message);
    }
    let trial = Trial::decode(&before.retained);
    let prepared = service::prepare(store, trial, number, identity, before.crash)?;
    report_settings(&prepared.0, identity.processor);
    Some(prepared)
}

/// Logs which settings are used, and whether the processor keeps up with them.
fn report_settings(boot: &Boot, processor: Processor) {
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
            "" => "anyone, not to be armed",
            address => address,
        }
    );
}

/// Logs that settings which passed their checks cannot be used, so that nothing was started.
pub fn report_unusable() {
    error!("settings passed their checks, but cannot be used: nothing was started");
}

/// Logs that the board is ready for robot and sensor. A launcher waits for this line.
pub fn report_ready() {
    info!("ready");
}
