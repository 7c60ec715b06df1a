//! State of the board on three LEDs, for a person at the rig.
//!
//! | LED | dark | blinks | lit |
//! |---|---|---|---|
//! | green | idle | hold: ready to be armed; fast: armed | the loop is closed or a jog runs, the robot moves |
//! | yellow | no telegrams of the robot | telegrams, but no sensor data | robot and sensor are there |
//! | red | no fault | a command was refused | a fault is latched: reset it |

use crate::board::Clock;
use crate::shared::{Leds, Shared, Status};
use embassy_sync::blocking_mutex::raw::RawMutex;
use softdock_control::modes::Mode;
use softdock_link::sensor::SensorState;

/// How often the LEDs are set, µs: half of the faster blinking.
const PERIOD_US: u64 = 125_000;

/// Ticks of a half period of slow blinking.
const SLOW_TICKS: u32 = 4;

/// Calls `set` with the LEDs of the board's state, forever.
pub async fn show<M: RawMutex>(
    shared: &Shared<M>,
    clock: &impl Clock,
    mut set: impl FnMut(Leds),
) -> ! {
    let mut next_us = clock.now_us();
    let mut tick = 0_u32;
    loop {
        let tested = shared.leds(clock.now_us());
        set(tested.unwrap_or_else(|| leds(&shared.status(), tick)));
        tick = tick.wrapping_add(1);
        next_us += PERIOD_US;
        clock.wait_until(next_us).await;
    }
}

/// The LEDs at a tick of [`PERIOD_US`].
fn leds(status: &Status, tick: u32) -> Leds {
    let fast = tick.is_multiple_of(2);
    let slow = (tick / SLOW_TICKS).is_multiple_of(2);
    let sensor = status.sensor == Some(SensorState::Running);
    Leds {
        green: match status.mode {
            Mode::Idle | Mode::Fault => false,
            Mode::Hold => slow,
            Mode::Armed => fast,
            Mode::Running | Mode::Jogging => true,
        },
        yellow: status.connected && (sensor || slow),
        red: status.fault.is_some() || (status.refusal.is_some() && slow),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::tests::Stopwatch;
    use embassy_futures::poll_once;
    use softdock_control::modes::{Fault, FaultCode};

    /// Number of ticks in two seconds, of 16, in which an LED is lit.
    fn lit(status: &Status, led: impl Fn(Leds) -> bool) -> usize {
        (0..16).filter(|tick| led(leds(status, *tick))).count()
    }

    #[test]
    fn each_mode_has_a_picture_of_its_own() {
        let mut status = Status::default();
        let mut changes = Vec::new();
        for mode in [
            Mode::Idle,
            Mode::Hold,
            Mode::Armed,
            Mode::Running,
            Mode::Jogging,
        ] {
            status.mode = mode;
            let green: Vec<bool> = (0..16).map(|tick| leds(&status, tick).green).collect();
            changes.push(green.windows(2).filter(|pair| pair[0] != pair[1]).count());
        }
        assert_eq!(changes, [0, 3, 15, 0, 0]);
        assert_eq!(lit(&status, |l| l.green), 16);
    }

    #[test]
    fn yellow_tells_a_missing_robot_from_a_missing_sensor() {
        let mut status = Status {
            sensor: Some(SensorState::Running),
            ..Status::default()
        };
        assert_eq!(lit(&status, |l| l.yellow), 0);
        status.connected = true;
        assert_eq!(lit(&status, |l| l.yellow), 16);
        status.sensor = Some(SensorState::Starting);
        assert_eq!(lit(&status, |l| l.yellow), 8);
    }

    #[test]
    fn a_test_lights_what_it_says_for_its_time() {
        let shared = Shared::<embassy_sync::blocking_mutex::raw::NoopRawMutex>::new();
        let red = Leds::from([false, false, true]);
        assert_eq!((red.green, red.yellow, red.red), (false, false, true));
        shared.light(Some((red, 1000)));
        assert_eq!([999, 1000].map(|us| shared.leds(us)), [Some(red), None]);
        shared.light(None);
        assert_eq!(shared.leds(0), None);
    }

    #[test]
    fn the_leds_are_set_in_each_half_of_the_faster_blinking() {
        let shared = Shared::<embassy_sync::blocking_mutex::raw::NoopRawMutex>::new();
        let clock = Stopwatch::until(500_000);
        let mut times_us = Vec::new();
        let show = show(&shared, &clock, |_| times_us.push(clock.now_us()));
        assert!(poll_once(show).is_pending());
        assert_eq!(times_us, [0, 125_000, 250_000, 375_000, 500_000]);
    }

    #[test]
    fn a_fault_is_red_until_it_is_reset() {
        let mut status = Status::default();
        assert_eq!(lit(&status, |l| l.red), 0);
        status.fault = Some(Fault::new(FaultCode::Overload, 1000.0, 1200.0));
        assert_eq!(lit(&status, |l| l.red), 16);
    }
}
