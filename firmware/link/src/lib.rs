//! Wire formats of a docking rig: KUKA RSI telegrams, CAN force/torque sensors and the SLCAN adapter protocol.
//!
//! Everything here is sans-IO: functions from bytes to values and state machines that are told the time. Nothing
//! reads a socket, a clock or a bus, nothing allocates, and no input of any kind makes anything panic.
//!
//! | module | what it speaks | where the facts come from |
//! |---|---|---|
//! | [`decimal`] | finite decimal numbers as integers | the correction text of an RSI answer |
//! | [`rsi`] | KUKA Robot Sensor Interface, XML over UDP | KUKA RSI 3.x, public drivers named in `rsi` |
//! | [`sensor`] | what every force/torque sensor looks like | |
//! | [`can`] | CAN frames, ATI NETCANOEM and SRI M8123B2 sensors | ATI 9610-05-1030, public SRI drivers |
//! | [`ethercat`] | ATI's EtherCAT sensors: identity, process data, status | ATI 9610-05-EtherCAT Axia-09, nasa-jpl/jsd |
//! | [`slcan`] | Lawicel serial-line CAN, adapter and client side | Lawicel CAN232/CANUSB manual |
//! | [`service`] | the parameter service on a serial line | here |
#![cfg_attr(not(test), no_std)]
#![cfg_attr(not(test), warn(clippy::indexing_slicing))]

pub mod can;
pub mod decimal;
pub mod ethercat;
pub mod rsi;
pub mod sensor;
pub mod service;
pub mod slcan;
