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

/// Executors of this board, lowest priority first (`executors.rs` of the board), and the tasks that `main.rs` and `sensor_can.rs`
/// or `sensor_ethercat.rs` spawn on each.
pub fn nucleo_executors(sensor: SensorLink) -> [Executor; 3] {
    [
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
            tasks: match sensor {
                SensorLink::Can => &CONTROL_TASKS,
                SensorLink::Ethercat => &CONTROL_TASKS_ETHERCAT,
            },
        },
    ]
}

const CONTROL_TASKS: [&str; 7] = [
    "::control",
    "watchdog::beat",
    "ethernet::watch",
    "::network_task",
    "::sensor_task",
    "::robot_task",
    "::transmitter_task",
];
const CONTROL_TASKS_ETHERCAT: [&str; 8] = [
    "::control",
    "watchdog::beat",
    "ethernet::watch",
    "::network_task",
    "::sensor_task",
    "::w5500_task",
    "::robot_task",
    "::transmitter_task",
];
