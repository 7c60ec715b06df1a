//! A force/torque sensor on any link.
//!
//! A [`SensorDriver`] is a state machine that owns no bus and no clock: the caller sends what
//! [`SensorDriver::poll_transmit`] hands out, gives every frame that comes to [`SensorDriver::receive`], and calls again
//! at [`SensorDriver::next_deadline_us`]. Times are microseconds of any monotonic clock.

use crate::can::SAMPLE_POINT_PER_MILLE;
use crate::ethercat::{
    ATI_VENDOR, INPUT_BYTES, MAX_COUNTS_PER_UNIT, OUTPUT_BYTES, Product, StartUp,
};

/// Converts the traffic on a sensor's link into readings.
///
/// Streaming and polled sensors have the same interface; so have a CAN bus and the process data of an EtherCAT SubDevice. A
/// driver guarantees for each reading that it is new, and that all its numbers belong together. A frame that repeats an old
/// reading completes none.
pub trait SensorDriver {
    /// The unit of traffic: a CAN frame, or the process data of one exchange with their working counter.
    type Frame;

    /// The next frame for the wire, if one is due. Call again after each frame: another one may be due then.
    fn poll_transmit(&mut self, now_us: u64) -> Option<Self::Frame>;

    /// When to call [`Self::poll_transmit`] again at the latest; `u64::MAX` for never.
    fn next_deadline_us(&self) -> u64;

    /// Takes in a frame from the link. Returns the reading that it completes, if any.
    fn receive(&mut self, frame: &Self::Frame, now_us: u64) -> Option<SensorReading>;

    /// Makes the next request due at once, if none is on its way; a streaming sensor cannot expedite.
    fn expedite(&mut self, now_us: u64);

    /// State of the driver.
    fn state(&self) -> SensorState;

    /// Counters of the driver.
    fn counters(&self) -> SensorCounters;

    /// Restarts: resets the sensor where that is possible, and reads its calibration anew. For the operator's reset of a latched
    /// sensor fault.
    fn restart(&mut self);
}

/// One raw reading of the sensor: bias, gravity and tool inertia are still in it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorReading {
    /// Force X, Y, Z (N) and torque X, Y, Z (N·m) in the sensor frame S.
    pub wrench: [f64; 6],
    /// Raw counts of six gauges or axes, as far as the sensor reports them; else zeros.
    pub counts: [i32; 6],
    /// Raw status word; zero for a sensor that has none. The control cycle judges it; a setting says which bits count.
    pub status: u32,
    /// Rises by one with every reading, wrapping.
    pub counter: u32,
    /// Earliest time at which the reading was taken, µs: when it was requested, or, from a streaming sensor, when its first frame
    /// arrived.
    pub at_us: u64,
    /// A gauge or an axis is at the end of its range. The calibration couples the gauges, so no axis is valid.
    pub saturated: bool,
}

/// State of a driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorState {
    /// Waking the sensor up or reading its calibration.
    Starting,
    /// Readings come in.
    Running,
    /// The sensor ran and then missed an answer; nothing is accepted until it answers in step again.
    Resynchronising,
    /// No readings, and why.
    Failed(SensorFault),
}

/// Why a driver gives no readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SensorFault {
    /// The sensor does not answer; the driver tries again by itself.
    #[error("the sensor does not answer")]
    NoAnswer,
    /// The identifier base of the configuration has more than seven bits.
    #[error("identifier base {received:#x} has more than 7 bits")]
    BaseId {
        /// The base.
        received: u8,
    },
    /// The sensor reports a force unit that is not in its manual.
    #[error("unknown force unit {code}")]
    ForceUnit {
        /// The code.
        code: u8,
    },
    /// The sensor reports a torque unit that is not in its manual.
    #[error("unknown torque unit {code}")]
    TorqueUnit {
        /// The code.
        code: u8,
    },
    /// The sensor reports counts per unit that no sensor has.
    #[error(
        "counts per unit must be 1 to {MAX_COUNTS_PER_UNIT}: force {}, torque {}",
        // Those of EtherCAT are signed.
        .force.cast_signed(), .torque.cast_signed()
    )]
    CountsPerUnit {
        /// Counts per unit of force.
        force: u32,
        /// Counts per unit of torque.
        torque: u32,
    },
    /// The sensor's calibration matrix is not finite.
    #[error("row {row} of the calibration matrix is not finite")]
    Matrix {
        /// Row: 0 to 5 for force X, Y, Z, torque X, Y, Z.
        row: u8,
    },
    /// The sensor now reports another scale than at start-up, so the calibration in use is not its own.
    #[error("the sensor's scale differs from the one read at start-up")]
    CalibrationChanged,
    /// EtherCAT: frames come back without having passed a SubDevice.
    #[error("no SubDevice is on the cable")]
    NoSubDevice,
    /// EtherCAT: there are more SubDevices than the sensor.
    #[error("{received} SubDevices are on the cable, expected the sensor alone")]
    SubDevices {
        /// So many.
        received: u16,
    },
    /// EtherCAT: a SubDevice of another maker.
    #[error("the SubDevice is of vendor {received:#x}, expected ATI ({ATI_VENDOR:#x})")]
    Vendor {
        /// Its vendor number.
        received: u32,
    },
    /// CAN: the controller's bit rate or sample point differs from the sensor's.
    #[error(
        "the CAN controller makes {bits_per_second} bit/s, sampled at {per_mille} ‰ of a bit, expected {} to {}: do its clock and divisors fit?",
        SAMPLE_POINT_PER_MILLE.0, SAMPLE_POINT_PER_MILLE.1
    )]
    BitTiming {
        /// Of the controller.
        bits_per_second: u32,
        /// Its sample point, ‰ of a bit.
        per_mille: u32,
    },
    /// EtherCAT: another product of the maker.
    #[error(
        "the SubDevice is product {received:#x}, expected {:#x} (EtherCAT F/T) or {:#x} (Axia80)",
        Product::EtherCatFt.code(), Product::Axia80.code()
    )]
    Product {
        /// Its product code.
        received: u32,
    },
    /// EtherCAT: process data of another size than those of the sensor.
    #[error(
        "process data of {inputs} bytes in and {outputs} out, expected {INPUT_BYTES} and {OUTPUT_BYTES}"
    )]
    PdoBytes {
        /// Bytes that the SubDevice sends.
        inputs: u16,
        /// Bytes that it takes.
        outputs: u16,
    },
    /// EtherCAT: an object of the calibration cannot be read.
    #[error("object {index:#06x} cannot be read")]
    Object {
        /// Its index.
        index: u16,
    },
    /// EtherCAT: the SubDevice does not come into this state.
    #[error("the SubDevice does not come into {0:?}")]
    StartUp(StartUp),
    /// EtherCAT: the SubDevice left OP: it was restarted, or reports an error of its own.
    #[error("the SubDevice left OP")]
    NotOperational,
    /// EtherCAT: the sensor's sample counter does not increase.
    #[error("the sensor's sample counter stands")]
    Standing,
    /// The settings name a sensor on a link that this firmware does not have.
    #[error(
        "the settings name a sensor on a link that this firmware does not have: `cargo firmware -- --help` lists the images"
    )]
    OtherLink,
}

/// Counters of a driver; each wraps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SensorCounters {
    /// Answers, or a stream, that did not come in time.
    pub timeouts: u32,
    /// Requests that were sent again.
    pub retries: u32,
    /// Frames that came after their timeout.
    pub late: u32,
    /// Frames whose counterparts are missing.
    pub unpaired: u32,
    /// Frames that do not belong to the sensor's protocol, or with a wrong length.
    pub unknown: u32,
    /// Readings with numbers that are not finite.
    pub invalid: u32,
}
