//! Polling, timeouts, and which answer belongs to which request.
//!
//! Answers carry nothing that names their request, so an answer that comes after its timeout looks like the answer to
//! the next request and would give an old force a new time. The sensor answers in order, which offers a way out: after
//! a timeout the driver sends a *fence*, a request whose answer has another opcode. Whatever comes before the fence's
//! answer is late and is dropped; what comes after it belongs to what was asked after it. Two kinds of fence take
//! turns, so that the late answer to one fence does not pass for the next one.

use super::calibration::AtiCalibration;
use super::protocol::{Answer, MAX_BASE_ID, Request};
use super::start_up::{AtiIdentity, Progress, Scale, StartUp};
use crate::can::Frame;
use crate::sensor::{SensorCounters, SensorFault, SensorReading, SensorState};

/// Timeout of a start-up query; reading the EEPROM may take longer than reading gauges.
const QUERY_TIMEOUT_US: u64 = 50_000;
/// Requests for a start-up query before the sensor counts as silent: 20 * 50 ms = 1 s.
const QUERY_ATTEMPTS: u8 = 20;
/// Requests for a query that the readings do not depend on.
const OPTIONAL_QUERY_ATTEMPTS: u8 = 2;
/// Pause before a silent sensor, or one that was reset, is asked again.
const RESTART_PAUSE_US: u64 = 1_000_000;

/// Settings of an [`AtiDriver`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AtiConfig {
    /// Identifier base, seven bits.
    pub base_id: u8,
    /// Time from one request for gauges to the next (µs). A request and its answer take about 350 µs at 1 Mbit/s.
    pub poll_period_us: u64,
    /// Time after which a reading that was asked for counts as lost (µs).
    pub answer_timeout_us: u64,
    /// Gauge counts, of either sign, from which a gauge counts as saturated.
    pub saturation_counts: i16,
}

impl Default for AtiConfig {
    /// ATI's default base; 1 kHz, four samples per 4 ms control cycle; half a control cycle of patience; 2 % below
    /// the end of the 16-bit range.
    fn default() -> Self {
        Self {
            base_id: 0x20,
            poll_period_us: 1_000,
            answer_timeout_us: 2_000,
            saturation_counts: 32_000,
        }
    }
}

/// State of the driver.
#[derive(Clone, Debug)]
enum Mode {
    Resetting,
    Starting {
        start_up: StartUp,
        attempts: u8,
    },
    Running {
        calibration: AtiCalibration,
        scale: Scale,
    },
    Silent,
    Refused(SensorFault),
}

/// Purpose of the pending request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Purpose {
    Query,
    Gauges,
    Fence,
}

/// The pending request.
#[derive(Clone, Copy, Debug)]
struct Pending {
    purpose: Purpose,
    sent_us: u64,
    deadline_us: u64,
}

/// Driver of one sensor; see [`SensorDriver`](crate::sensor::SensorDriver) for how to use it.
#[derive(Clone, Debug)]
pub struct AtiDriver {
    config: AtiConfig,
    mode: Mode,
    pending: Option<Pending>,
    next_send_us: u64,
    /// Kind of the fence that must be answered before anything else is asked.
    fence: Option<Request>,
    next_fence: Request,
    /// First half of a reading: status and gauges 0, 2, 4.
    even_gauges: Option<(u16, [i16; 3])>,
    readings: u32,
    identity: AtiIdentity,
    counters: SensorCounters,
}

impl AtiDriver {
    /// Driver that starts up at the first [`Self::poll_transmit`]. A base of more than seven bits is refused with
    /// [`SensorFault::BaseId`].
    pub fn new(config: AtiConfig) -> Self {
        let received = config.base_id;
        let mode = if received > MAX_BASE_ID {
            Mode::Refused(SensorFault::BaseId { received })
        } else {
            Mode::start()
        };
        Self {
            config,
            mode,
            pending: None,
            next_send_us: 0,
            fence: None,
            next_fence: Request::CountsPerUnit,
            even_gauges: None,
            readings: 0,
            identity: AtiIdentity::default(),
            counters: SensorCounters::default(),
        }
    }

    /// See [`SensorDriver::poll_transmit`](crate::sensor::SensorDriver::poll_transmit).
    pub fn poll_transmit(&mut self, now_us: u64) -> Option<Frame> {
        self.expire(now_us);
        if self.pending.is_some() || now_us < self.next_send_us {
            return None;
        }
        if matches!(self.mode, Mode::Silent) {
            self.mode = Mode::start();
        }
        let (purpose, request, timeout_us) = match &mut self.mode {
            Mode::Refused(_) | Mode::Silent => return None,
            Mode::Resetting => {
                self.mode = Mode::start();
                self.next_send_us = now_us.saturating_add(RESTART_PAUSE_US);
                return Request::Reset.encode(self.config.base_id);
            }
            Mode::Starting { start_up, .. } => match self.fence {
                Some(fence) => (Purpose::Fence, fence, QUERY_TIMEOUT_US),
                None => (Purpose::Query, start_up.query()?, QUERY_TIMEOUT_US),
            },
            Mode::Running { .. } => match self.fence {
                Some(fence) => (Purpose::Fence, fence, self.config.answer_timeout_us),
                None => (
                    Purpose::Gauges,
                    Request::Gauges,
                    self.config.answer_timeout_us,
                ),
            },
        };
        self.pending = Some(Pending {
            purpose,
            sent_us: now_us,
            deadline_us: now_us.saturating_add(timeout_us),
        });
        request.encode(self.config.base_id)
    }

    /// See [`SensorDriver::next_deadline_us`](crate::sensor::SensorDriver::next_deadline_us).
    pub fn next_deadline_us(&self) -> u64 {
        match (&self.mode, &self.pending) {
            (Mode::Refused(_), _) => u64::MAX,
            (_, Some(pending)) => pending.deadline_us,
            (_, None) => self.next_send_us,
        }
    }

    /// See [`SensorDriver::receive`](crate::sensor::SensorDriver::receive).
    pub fn receive(&mut self, frame: &Frame, now_us: u64) -> Option<SensorReading> {
        self.expire(now_us);
        let Some(answer) = Answer::decode(self.config.base_id, frame) else {
            count(&mut self.counters.unknown);
            return None;
        };
        let Some(pending) = self.pending else {
            count(&mut self.counters.late);
            return None;
        };
        match pending.purpose {
            Purpose::Gauges => return self.accept_gauges(answer, pending, now_us),
            Purpose::Fence => self.accept_fence(answer, now_us),
            Purpose::Query => self.accept_query(answer, now_us),
        }
        None
    }

    /// See [`SensorDriver::expedite`](crate::sensor::SensorDriver::expedite).
    pub fn expedite(&mut self, now_us: u64) {
        if matches!(self.mode, Mode::Running { .. }) {
            self.next_send_us = self.next_send_us.min(now_us);
        }
    }

    /// State of the driver. [`SensorState::Resynchronising`] after a single lost answer is no reason to stop; the age of the last
    /// reading is.
    pub fn state(&self) -> SensorState {
        match (&self.mode, self.fence) {
            (Mode::Refused(fault), _) => SensorState::Failed(*fault),
            (Mode::Silent, _) => SensorState::Failed(SensorFault::NoAnswer),
            (Mode::Resetting | Mode::Starting { .. }, _) => SensorState::Starting,
            (Mode::Running { .. }, Some(_)) => SensorState::Resynchronising,
            (Mode::Running { .. }, None) => SensorState::Running,
        }
    }

    /// Counters of the driver.
    pub fn counters(&self) -> SensorCounters {
        self.counters
    }

    /// Identity that the sensor reported at start-up.
    pub fn identity(&self) -> AtiIdentity {
        self.identity
    }

    /// The calibration that was read from the sensor, while it is in use.
    pub fn calibration(&self) -> Option<&AtiCalibration> {
        match &self.mode {
            Mode::Running { calibration, .. } => Some(calibration),
            _ => None,
        }
    }

    /// Resets the sensor, which clears its status, and reads the calibration anew.
    pub fn restart(&mut self) {
        if matches!(self.mode, Mode::Refused(SensorFault::BaseId { .. })) {
            return;
        }
        self.mode = Mode::Resetting;
        self.pending = None;
        self.even_gauges = None;
        self.next_send_us = 0;
        self.raise_fence();
    }

    /// Gives up the pending request if its time is over.
    fn expire(&mut self, now_us: u64) {
        if self
            .pending
            .is_none_or(|pending| now_us < pending.deadline_us)
        {
            return;
        }
        self.pending = None;
        self.next_send_us = now_us;
        count(&mut self.counters.timeouts);
        if self.even_gauges.take().is_some() {
            count(&mut self.counters.unpaired);
        }
        self.raise_fence();
        if let Mode::Starting { start_up, attempts } = &mut self.mode {
            *attempts += 1;
            if *attempts >= OPTIONAL_QUERY_ATTEMPTS && start_up.skip_optional() {
                *attempts = 0;
                return;
            }
            if *attempts >= QUERY_ATTEMPTS {
                self.mode = Mode::Silent;
                self.next_send_us = now_us.saturating_add(RESTART_PAUSE_US);
                return;
            }
        }
        count(&mut self.counters.retries);
    }

    /// Asks for a fence, unless one is already asked for.
    fn raise_fence(&mut self) {
        if self.fence.is_none() {
            self.fence = Some(self.next_fence);
            self.next_fence = match self.next_fence {
                Request::CountsPerUnit => Request::UnitCodes,
                _ => Request::CountsPerUnit,
            };
        }
    }

    fn accept_gauges(
        &mut self,
        answer: Answer,
        pending: Pending,
        now_us: u64,
    ) -> Option<SensorReading> {
        match answer {
            Answer::EvenGauges { status, gauges } => {
                if self.even_gauges.replace((status, gauges)).is_some() {
                    count(&mut self.counters.unpaired);
                }
                None
            }
            Answer::OddGauges([gauge_1, gauge_3, gauge_5]) => {
                let Some((status, [gauge_0, gauge_2, gauge_4])) = self.even_gauges.take() else {
                    count(&mut self.counters.unpaired);
                    return None;
                };
                self.pending = None;
                let due_us = pending.sent_us.saturating_add(self.config.poll_period_us);
                self.next_send_us = due_us.max(now_us);
                let gauges = [gauge_0, gauge_1, gauge_2, gauge_3, gauge_4, gauge_5];
                self.reading(status, gauges, pending.sent_us)
            }
            _ => {
                count(&mut self.counters.late);
                None
            }
        }
    }

    fn reading(&mut self, status: u16, gauges: [i16; 6], at_us: u64) -> Option<SensorReading> {
        let Mode::Running { calibration, .. } = &self.mode else {
            return None;
        };
        self.readings = self.readings.wrapping_add(1);
        let limit = self.config.saturation_counts.unsigned_abs();
        Some(SensorReading {
            wrench: calibration.wrench(&gauges),
            counts: gauges.map(i32::from),
            status: status.into(),
            counter: self.readings,
            at_us,
            saturated: gauges.iter().any(|gauge| gauge.unsigned_abs() >= limit),
        })
    }

    fn accept_fence(&mut self, answer: Answer, now_us: u64) {
        let unchanged = match (self.fence, answer, &self.mode) {
            (
                Some(Request::CountsPerUnit),
                Answer::CountsPerUnit { force, torque },
                Mode::Running { scale, .. },
            ) => (force, torque) == (scale.counts_per_force, scale.counts_per_torque),
            (
                Some(Request::UnitCodes),
                Answer::UnitCodes { force, torque },
                Mode::Running { scale, .. },
            ) => (force, torque) == (scale.force_unit, scale.torque_unit),
            (Some(Request::CountsPerUnit), Answer::CountsPerUnit { .. }, _)
            | (Some(Request::UnitCodes), Answer::UnitCodes { .. }, _) => true,
            _ => {
                count(&mut self.counters.late);
                return;
            }
        };
        self.pending = None;
        self.fence = None;
        self.next_send_us = now_us;
        if !unchanged {
            self.mode = Mode::Refused(SensorFault::CalibrationChanged);
        }
    }

    fn accept_query(&mut self, answer: Answer, now_us: u64) {
        let Mode::Starting { start_up, attempts } = &mut self.mode else {
            return;
        };
        match start_up.accept(answer) {
            Ok(Progress::NotAsked) => {
                count(&mut self.counters.late);
                return;
            }
            Ok(Progress::Partial) => return,
            Ok(Progress::Answered) => *attempts = 0,
            Ok(Progress::Complete(calibration, scale)) => {
                self.identity = start_up.identity;
                self.mode = Mode::Running { calibration, scale };
            }
            Err(fault) => self.mode = Mode::Refused(fault),
        }
        self.pending = None;
        self.next_send_us = now_us;
    }
}

impl Mode {
    fn start() -> Self {
        Self::Starting {
            start_up: StartUp::new(),
            attempts: 0,
        }
    }
}

fn count(counter: &mut u32) {
    *counter = counter.wrapping_add(1);
}
