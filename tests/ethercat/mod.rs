//! The sensor on EtherCAT: ethercrab on the board against the simulated SubDevice.

mod closed_loop;
mod faults;
mod main_devices;
mod path;
mod process;
