//! Cause of the last reset.

use embassy_stm32::pac::RCC;

/// Reads the flags of the reset status register and clears them for the next time. A reset from inside also sets the flag of
/// the pin, and power-up also sets that of the brown-out, so the more specific flags are checked first (RM0433, 8.4.4).
pub(crate) fn reason() -> &'static str {
    let flags = RCC.rsr().read();
    RCC.rsr().modify(|w| w.set_rmvf(true));
    let reasons = [
        (flags.iwdg1rstf(), "watchdog"),
        (flags.wwdg1rstf(), "window watchdog"),
        (flags.sftrstf(), "software"),
        (flags.lpwrrstf(), "low power"),
        (flags.porrstf(), "power-up"),
        (flags.borrstf(), "brown-out"),
        (flags.pinrstf(), "reset pin"),
    ];
    let found = reasons.iter().find(|(set, _)| *set);
    found.map_or("unknown", |(_, reason)| reason)
}
