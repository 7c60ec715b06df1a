//! Shared helpers of the tests: the three scalar types, a driver of the cycle, a plant for the closed loop, and peers of a
//! board.
#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    reason = "a fixture that cannot be built is a failed test"
)]

pub mod bench;
pub mod browser;
pub mod closed_loop;
pub mod contact;
pub mod driver;
pub mod every_setting;
pub mod fuzz;
pub mod lockstep;
pub mod one_axis;
pub mod peers;
pub mod process;
pub mod scalars;
pub mod synthetic;
pub mod twist_robot;
pub mod walls;
