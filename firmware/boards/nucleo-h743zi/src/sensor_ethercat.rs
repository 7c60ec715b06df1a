//! The sensor on EtherCAT, on the on-board Ethernet; the robot's network on a W5500.

pub(crate) use crate::w5500::Pins;
use crate::{ethernet, w5500};
use embassy_executor::Spawner;
use softdock_app::ethercat::port::DriverPort;
use softdock_app::ethercat::{self, Frames};
use softdock_app::micro::SHARED;
use softdock_app::micro::clock::UptimeClock;
use softdock_app::micro::start::spawn;
use softdock_app::sensor;
use softdock_app::settings::{BoardSettings, EtherCatSettings};

/// What the robot's network uses instead of the on-board Ethernet.
pub(crate) type Hardware = Pins;
/// The driver of the robot's network.
pub(crate) type Network = w5500::Driver;

/// Only passes the pins on; the chip is started by its task.
pub(crate) fn prepare(pins: Pins) -> Hardware {
    pins
}

/// Starts the sensor's task; returns the driver of the robot's network.
pub(crate) async fn start(
    spawner: &Spawner,
    settings: &BoardSettings,
    ethernet: ethernet::Driver,
    pins: Hardware,
) -> Option<Network> {
    match settings.ethercat.enabled {
        true => spawn(
            spawner,
            sensor_task(settings.ethercat.clone(), DriverPort(ethernet)),
        ),
        false => sensor::refuse(&SHARED),
    }
    let (network, runner) = w5500::start(pins).await?;
    spawn(spawner, w5500_task(runner));
    Some(network)
}

#[embassy_executor::task]
async fn sensor_task(settings: EtherCatSettings, port: DriverPort<ethernet::Driver>) {
    static FRAMES: Frames = Frames::new();
    ethercat::run(&SHARED, &settings, &FRAMES, port, &UptimeClock).await;
}

#[embassy_executor::task]
async fn w5500_task(runner: w5500::Runner) {
    runner.run().await;
}
