//! The firmware's tasks on the host.

use embassy_sync::blocking_mutex::raw::RawMutex;
use softdock_app::auto_start::AutoStart;
use softdock_app::board::{Clock, DatagramSocket, EthernetPort, Recorder, SensorBus};
use softdock_app::ethercat::{self, Frames};
use softdock_app::meter::Meter;
use softdock_app::robot::RobotTask;
use softdock_app::robot_link::RobotLink;
use softdock_app::sensor;
use softdock_app::settings::BoardSettings;
use softdock_app::shared::Shared;
use softdock_link::can::Frame;

/// Runs the sensor task on the link of the settings, if the board has it: a CAN bus, or the port to an EtherCAT segment.
pub(super) async fn sensor<M: RawMutex>(
    shared: &Shared<M>,
    settings: BoardSettings,
    bus: Option<impl SensorBus<Frame = Frame>>,
    port: Option<impl EthernetPort>,
    clock: impl Clock,
) {
    match (settings.ethercat.enabled, bus, port) {
        (false, Some(mut bus), _) => {
            sensor::run(shared, &mut bus, &clock, settings.can.driver()).await;
        }
        (true, _, Some(port)) => {
            let frames = Box::new(Frames::new());
            ethercat::run(shared, &settings.ethercat, &frames, port, &clock).await;
        }
        _ => sensor::refuse(shared),
    }
}

/// Runs the robot task on a socket of the host.
pub(super) async fn robot<M: RawMutex>(
    shared: &Shared<M>,
    link: RobotLink<f64>,
    start: bool,
    sample_wait_us: u64,
    mut io: (impl DatagramSocket, impl Clock),
    recorder: &mut impl Recorder,
) {
    let auto_start = AutoStart::new(start);
    let mut task = RobotTask {
        shared,
        link,
        auto_start,
        sample_wait_us,
        meter: Meter::default(),
    };
    task.run(&mut io.0, &io.1, recorder).await;
}
