//! The microcontroller's firmware in QEMU.

mod boot;
mod contact;
mod crash;
mod faults;
mod functions;
mod link;
mod lockstep;
mod params;
mod ping;
mod rig;
mod rsipi;
mod stack;
mod telemetry;
