//! The sensor on CAN; the robot's network on the on-board Ethernet.

use crate::can::Bus;
pub(crate) use crate::can::Pins;
use crate::ethernet;
use embassy_executor::Spawner;
use softdock_app::micro::SHARED;
use softdock_app::micro::clock::UptimeClock;
use softdock_app::micro::start::spawn;
use softdock_app::sensor;
use softdock_app::settings::BoardSettings;
use softdock_link::sensor::SensorFault;

/// What the sensor uses besides the Ethernet.
pub(crate) type Hardware = Result<Bus, SensorFault>;
/// The driver of the robot's network.
pub(crate) type Network = ethernet::Driver;

/// Starts the sensor's bus.
pub(crate) fn prepare(pins: Pins) -> Hardware {
    Bus::start(pins)
}

/// Starts the sensor's task; returns the driver of the robot's network.
pub(crate) async fn start(
    spawner: &Spawner,
    settings: &BoardSettings,
    ethernet: ethernet::Driver,
    bus: Hardware,
) -> Option<Network> {
    match bus {
        _ if settings.ethercat.enabled => sensor::refuse(&SHARED),
        Ok(bus) => spawn(spawner, sensor_task(settings.clone(), bus)),
        Err(fault) => sensor::fail(&SHARED, fault),
    }
    Some(ethernet)
}

#[embassy_executor::task]
async fn sensor_task(settings: BoardSettings, mut bus: Bus) {
    sensor::run(&SHARED, &mut bus, &UptimeClock, settings.can.driver()).await;
}
