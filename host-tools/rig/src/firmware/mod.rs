//! Images for controller boards: built by cargo, measured, checked before they are flashed.

mod build;
mod image;
mod memory;
mod usage;

pub use build::{BoardImage, RELEASED, build, emulated_profile, repository};
pub use image::Elf;
pub use memory::{Region, regions};
pub use usage::{Usage, usage};

use clap::ValueEnum;

/// What the sensor of a board is on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum SensorLink {
    /// CAN; the robot is on the on-board Ethernet
    #[default]
    Can,
    /// EtherCAT on the on-board Ethernet; the robot is on a W5500
    Ethercat,
}

/// The image of the board that the project is made for.
pub fn nucleo_h743zi(sensor: SensorLink) -> BoardImage {
    BoardImage {
        package: "softdock-nucleo-h743zi",
        target: "thumbv7em-none-eabihf",
        features: match sensor {
            SensorLink::Can => &[],
            SensorLink::Ethercat => &["ethercat"],
        },
    }
}
