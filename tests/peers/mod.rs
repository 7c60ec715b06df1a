//! The board as a process, with peers that this project did not make.

mod datagrams;
mod live_rig;
mod mujoco;
mod operator;
mod pace;
mod python_can;
mod rsipi;
mod sensor_line;
