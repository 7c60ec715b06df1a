//! Decides which exchange gives a reading, and when to restart the SubDevice.
//!
//! Process data look the same whether the sensor measured them or not: a frame also comes back from a SubDevice that was
//! restarted and has lost its set-up, with the earlier inputs. So an exchange counts only if its working counter shows that the
//! SubDevice read and wrote, if the SubDevice reports OP, and if the sensor's own sample counter has increased.

use super::WORKING_COUNTER;
use super::exchange::{Exchange, Setup};
use super::process_data::{Control, INPUT_BYTES, Inputs};
use super::product::{Product, Scale};
use crate::sensor::{SensorCounters, SensorDriver, SensorFault, SensorReading, SensorState};

/// Consecutive exchanges that may fail before the SubDevice is restarted: at 1 kHz shorter than the 8 ms after which the cycle
/// calls a sample stale, so that a disturbed frame has no effect.
const MOST_FAILED: u8 = 5;
/// Time for which the sample counter may stay unchanged, µs. At the slowest rate of an Axia80, 488 Hz, it increases every 2 ms.
const MOST_STANDING_US: u64 = 50_000;
/// Pause before a SubDevice that could not be started is tried again, µs.
const RETRY_PAUSE_US: u64 = 100_000;
/// Time for which the bit that clears the sensor's bias is set, µs: ten samples at its slowest rate.
const CLEAR_BIAS_US: u64 = 20_000;
/// Settling time after that bit before readings are accepted, µs.
const SETTLE_US: u64 = 5_000;

/// Settings of an [`AtiSubDevice`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EtherCatConfig {
    /// Time from one exchange to the next, µs. Frequent exchanges keep the SubDevice's watchdog of 100 ms from expiring.
    pub poll_period_us: u64,
    /// Time after which an exchange counts as lost, µs.
    pub answer_timeout_us: u64,
    /// Control word of the sensor; [`Control::clear_bias`] is set by the driver.
    pub control: Control,
}

/// State of the driver.
#[derive(Clone, Copy, Debug)]
enum Mode {
    /// No SubDevice; time of the next start.
    Down { start_us: u64 },
    /// The bus starts it.
    StartingUp,
    /// Exchanges.
    Operational(Running),
}

/// A SubDevice in OP.
#[derive(Clone, Copy, Debug)]
struct Running {
    product: Product,
    scale: Scale,
    /// When it came into OP.
    since_us: u64,
    /// When the last exchange was asked for.
    asked_us: u64,
    /// The answer to it is pending.
    pending: bool,
    next_us: u64,
    failed: u8,
    /// The newest sample counter and the time when it was first seen; `None` before the first exchange.
    sample: Option<(u32, u64)>,
    /// A reading was handed out.
    measured: bool,
}

impl Running {
    /// Takes in a sample counter. `Some`: time at which the previous sample was first seen, µs, if this one is new and the bias
    /// has settled. An error if none has been new for too long.
    fn take(&mut self, sample: u32, now_us: u64) -> Result<Option<u64>, SensorFault> {
        let Some((last, seen_us)) = self.sample else {
            // The next one shows whether it is new.
            self.sample = Some((sample, now_us));
            return Ok(None);
        };
        // A frame that comes twice, or late, holds an older sample.
        if sample.wrapping_sub(last).cast_signed() <= 0 {
            return match now_us.saturating_sub(seen_us) >= MOST_STANDING_US {
                true => Err(SensorFault::Standing),
                false => Ok(None),
            };
        }
        self.sample = Some((sample, now_us));
        let settled_us = self.since_us.saturating_add(CLEAR_BIAS_US + SETTLE_US);
        Ok((now_us >= settled_us).then_some(seen_us))
    }
}

/// Driver of one sensor; see [`SensorDriver`] for how to use it.
#[derive(Clone, Debug)]
pub struct AtiSubDevice {
    config: EtherCatConfig,
    mode: Mode,
    /// Why the last start or run ended.
    fault: Option<SensorFault>,
    readings: u32,
    counters: SensorCounters,
}

impl AtiSubDevice {
    /// Driver that starts the SubDevice at the first [`SensorDriver::poll_transmit`].
    pub fn new(config: EtherCatConfig) -> Self {
        Self {
            config,
            mode: Mode::Down { start_us: 0 },
            fault: None,
            readings: 0,
            counters: SensorCounters::default(),
        }
    }

    fn down(&mut self, fault: SensorFault, start_us: u64) {
        self.fault = Some(fault);
        self.mode = Mode::Down { start_us };
    }

    fn ready(&mut self, setup: &Setup, now_us: u64) {
        let units = (setup.force_unit, setup.torque_unit);
        let counts = (setup.counts_per_force, setup.counts_per_torque);
        let scale = Product::identify(setup.vendor, setup.product)
            .and_then(|product| Ok((product, product.scale(units, counts)?)));
        match scale {
            Err(fault) => self.down(fault, now_us.saturating_add(RETRY_PAUSE_US)),
            Ok((product, scale)) => {
                self.mode = Mode::Operational(Running {
                    product,
                    scale,
                    since_us: now_us,
                    asked_us: now_us,
                    pending: false,
                    next_us: now_us,
                    failed: 0,
                    sample: None,
                    measured: false,
                });
            }
        }
    }

    /// An exchange failed; after too many the SubDevice is restarted.
    fn failed(&mut self, fault: SensorFault, now_us: u64) {
        let Mode::Operational(running) = &mut self.mode else {
            return;
        };
        running.pending = false;
        running.failed += 1;
        if running.failed >= MOST_FAILED {
            self.down(fault, now_us);
        }
    }

    /// Gives up the pending exchange if its time is over.
    fn expire(&mut self, now_us: u64) {
        let Mode::Operational(running) = &self.mode else {
            return;
        };
        let deadline_us = running
            .asked_us
            .saturating_add(self.config.answer_timeout_us);
        if running.pending && now_us >= deadline_us {
            count(&mut self.counters.timeouts);
            self.failed(SensorFault::NoAnswer, now_us);
        }
    }

    fn inputs(
        &mut self,
        (working_counter, operational): (u16, bool),
        bytes: &[u8; INPUT_BYTES],
        now_us: u64,
    ) -> Option<SensorReading> {
        let Mode::Operational(running) = &mut self.mode else {
            count(&mut self.counters.late);
            return None;
        };
        if !running.pending {
            count(&mut self.counters.late);
            return None;
        }
        if working_counter != WORKING_COUNTER || !operational {
            count(&mut self.counters.unpaired);
            self.failed(SensorFault::NotOperational, now_us);
            return None;
        }
        running.pending = false;
        running.failed = 0;
        let inputs = Inputs::decode(bytes);
        let seen_us = match running.take(inputs.sample, now_us) {
            Ok(seen_us) => seen_us?,
            Err(fault) => {
                self.down(fault, now_us);
                return None;
            }
        };
        running.measured = true;
        self.fault = None;
        self.readings = self.readings.wrapping_add(1);
        Some(SensorReading {
            wrench: running.scale.wrench(inputs.counts),
            counts: inputs.counts,
            status: inputs.status,
            counter: self.readings,
            // This sample did not exist yet when the previous one was first seen.
            at_us: seen_us,
            saturated: running.product.saturates(inputs.status),
        })
    }
}

impl SensorDriver for AtiSubDevice {
    type Frame = Exchange;

    fn poll_transmit(&mut self, now_us: u64) -> Option<Exchange> {
        self.expire(now_us);
        match &mut self.mode {
            Mode::Down { start_us } if now_us >= *start_us => {
                self.mode = Mode::StartingUp;
                Some(Exchange::StartUp)
            }
            Mode::Operational(running) if !running.pending && now_us >= running.next_us => {
                running.pending = true;
                running.asked_us = now_us;
                running.next_us = now_us.saturating_add(self.config.poll_period_us);
                let clear_bias = now_us < running.since_us.saturating_add(CLEAR_BIAS_US);
                let control = Control {
                    clear_bias,
                    ..self.config.control
                };
                Some(Exchange::Outputs(control.encode()))
            }
            _ => None,
        }
    }

    fn next_deadline_us(&self) -> u64 {
        match &self.mode {
            Mode::Down { start_us } => *start_us,
            // The bus has its own timeouts.
            Mode::StartingUp => u64::MAX,
            Mode::Operational(running) if running.pending => running
                .asked_us
                .saturating_add(self.config.answer_timeout_us),
            Mode::Operational(running) => running.next_us,
        }
    }

    fn receive(&mut self, frame: &Exchange, now_us: u64) -> Option<SensorReading> {
        self.expire(now_us);
        match (frame, self.mode) {
            (Exchange::Ready(setup), Mode::StartingUp) => self.ready(setup, now_us),
            (Exchange::Failed(fault), Mode::StartingUp) => {
                self.down(*fault, now_us.saturating_add(RETRY_PAUSE_US));
            }
            (
                Exchange::Inputs {
                    working_counter,
                    operational,
                    bytes,
                },
                _,
            ) => return self.inputs((*working_counter, *operational), bytes, now_us),
            _ => count(&mut self.counters.late),
        }
        None
    }

    fn expedite(&mut self, now_us: u64) {
        if let Mode::Operational(running) = &mut self.mode {
            running.next_us = running.next_us.min(now_us);
        }
    }

    fn state(&self) -> SensorState {
        match (&self.mode, self.fault) {
            (Mode::Operational(running), _) if running.measured && running.failed == 0 => {
                SensorState::Running
            }
            (Mode::Operational(running), _) if running.measured => SensorState::Resynchronising,
            // The fault remains until a reading shows that it is over.
            (_, Some(fault)) => SensorState::Failed(fault),
            (_, None) => SensorState::Starting,
        }
    }

    fn counters(&self) -> SensorCounters {
        self.counters
    }

    fn restart(&mut self) {
        // A bus that is already starting the SubDevice will report the result.
        if !matches!(self.mode, Mode::StartingUp) {
            self.mode = Mode::Down { start_us: 0 };
        }
    }
}

fn count(counter: &mut u32) {
    *counter = counter.wrapping_add(1);
}
