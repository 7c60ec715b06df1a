//! Images for controller boards: built by cargo, measured, checked before they are flashed.

mod build;
mod call_graph;
mod frame;
mod image;
mod memory;
mod stack;
mod usage;

pub use build::{BoardImage, RELEASED, build, emulated_profile, repository};
pub use image::Elf;
pub use memory::{Region, regions};
pub use stack::{Context, Executor, STACK_BUDGET, StackUsage, stack};
pub use usage::{Usage, usage};

/// The board that the project is made for.
pub const NUCLEO_H743ZI: BoardImage = BoardImage {
    package: "softdock-nucleo-h743zi",
    target: "thumbv7em-none-eabihf",
    features: &[],
};

/// Its executors, lowest priority first (`executors.rs` of the board), and the tasks that `main.rs` gives
/// to each.
pub const NUCLEO_EXECUTORS: [Executor; 3] = [
    Executor {
        name: "service",
        handler: "UART7",
        tasks: &["::serve"],
    },
    Executor {
        name: "background",
        handler: "UART5",
        tasks: &[
            "::monitor",
            "leds::show",
            "watchdog::feed",
            "::encoder_task",
        ],
    },
    Executor {
        name: "control",
        handler: "UART4",
        tasks: &[
            "::control",
            "watchdog::beat",
            "ethernet::watch",
            "::network_task",
            "::sensor_task",
            "::robot_task",
            "::transmitter_task",
        ],
    },
];
