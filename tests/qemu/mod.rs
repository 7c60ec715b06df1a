//! The microcontroller's firmware in QEMU.

mod boot;
mod contact;
mod crash;
mod faults;
mod lockstep;
mod params;
mod rig;
mod rsipi;
mod stack;
mod telemetry;
