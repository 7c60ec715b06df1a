//! The control cycle with healthy inputs, as a start for tests.

use softdock_control::delay::LawName;
use softdock_control::scalar::Scalar;
use softdock_control::settings::Settings;
pub use softdock_rig::board::cycle_driver::CycleDriver;

/// A cycle in Idle and a robot at rest at the origin.
///
/// # Panics
/// If the settings are not valid.
pub fn idle<S: Scalar>(settings: &Settings) -> CycleDriver<S> {
    CycleDriver::new(settings).expect("valid settings")
}

/// As [`idle`], after its first running cycle.
///
/// # Panics
/// If the settings are not valid, or the cycle refuses to start.
pub fn started<S: Scalar>(settings: &Settings) -> CycleDriver<S> {
    let mut driver = idle(settings);
    driver.start().expect("the cycle starts");
    driver
}

/// Settings of a spacecraft that moves at `speed_m_s` along x in front of a fixed one.
pub fn flying(speed_m_s: f64) -> Settings {
    let mut settings = Settings::default();
    settings.body_k.velocity_m_s = [speed_m_s, 0.0, 0.0];
    settings.body_q.fixed = true;
    // The simulated robot does not execute the commands.
    settings.delay.law = LawName::None;
    settings
}

/// A driver whose spacecraft moves at full velocity: the start ramp is over.
pub fn cruising<S: Scalar>(settings: &Settings) -> CycleDriver<S> {
    let mut driver = started(settings);
    for _ in 0..settings.start.zero_cycles + settings.start.ramp_cycles {
        driver.step();
    }
    driver
}
