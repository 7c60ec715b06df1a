//! The sensor on CAN: SLCAN on UART 0.

use crate::lan9118::Lan9118;
use crate::uart::{self, UartReader, UartWriter};
use embassy_executor::Spawner;
use softdock_app::micro::SHARED;
use softdock_app::micro::clock::UptimeClock;
use softdock_app::micro::start::spawn;
use softdock_app::sensor;
use softdock_app::settings::BoardSettings;
use softdock_app::slcan_bus::SlcanBus;

/// The driver of the robot's network: the whole controller.
pub(crate) type Network = Lan9118;

/// Starts the sensor's task; returns the driver of the robot's network.
pub(crate) fn start(spawner: &Spawner, settings: &BoardSettings, ethernet: Lan9118) -> Network {
    if settings.ethercat.enabled {
        sensor::refuse(&SHARED);
        return ethernet;
    }
    let (reader, writer) = uart::CAN.open();
    let bus = SlcanBus::new(reader, writer);
    spawn(spawner, sensor_task(settings.clone(), bus));
    ethernet
}

#[embassy_executor::task]
async fn sensor_task(settings: BoardSettings, mut bus: SlcanBus<UartReader, UartWriter>) {
    sensor::run(&SHARED, &mut bus, &UptimeClock, settings.can.driver()).await;
}
