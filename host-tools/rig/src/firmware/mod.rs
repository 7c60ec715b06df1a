//! Images for controller boards: built by cargo, measured, checked before they are flashed.

mod build;
mod image;
mod memory;
mod usage;

pub use build::{BoardImage, RELEASED, build, emulated_profile, repository};
pub use image::Elf;
pub use memory::{Region, regions};
pub use usage::{Usage, usage};

/// The board that the project is made for.
pub const NUCLEO_H743ZI: BoardImage = BoardImage {
    package: "softdock-nucleo-h743zi",
    target: "thumbv7em-none-eabihf",
    features: &[],
};
