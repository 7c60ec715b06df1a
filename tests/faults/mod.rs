//! What goes wrong, in virtual time: robot, sensor, commands in the wrong mode, any input.

mod any_input;
mod contact;
mod jog;
mod modes;
mod robot;
mod sensor;
mod settings;
mod virtual_board;

use softdock_control::modes::{Fault, FaultCode, Mode};
use softdock_control::scalar::Scalar;
use softdock_tests::driver::CycleDriver;

const SPEED_M_S: f64 = 0.01;
/// Correction X of one cycle at that speed: 0.04 mm of 4 decimals.
const CRUISE_COUNTS: i64 = 400;

fn assert_fault(driver: &CycleDriver<impl Scalar>, code: FaultCode, expected: f64, received: f64) {
    assert_eq!(driver.cycle.mode(), Mode::Fault);
    let fault = Fault::new(code, expected, received);
    assert_eq!(driver.cycle.fault(), Some(fault));
}
