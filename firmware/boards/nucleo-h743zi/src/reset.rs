//! Why the chip started.

use embassy_stm32::pac::RCC;

/// By the flags of the reset status register, which are cleared for the next time. A reset from inside
/// sets the flag of the pin as well, power-up that of the brown-out too: the special ones come first
/// (RM0433, 8.4.4).
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
