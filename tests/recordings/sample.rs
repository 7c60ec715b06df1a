//! Recordings for the tests.

use softdock_app::record::{CycleRecord, Inputs, Output, RobotReport};
use softdock_control::delay::status::{ConfidenceLevel, LawFlags, LawStatus};
use softdock_control::io::{BodyTrace, SensorSample, Sequence, Trace};
use softdock_control::limits::LimitFlags;
use softdock_control::modes::{Command, Fault, FaultCode, Mode, Refusal};
use softdock_io::recording::{Beginning, Header, Recording, TruthRecord, WallClock};

const MODES: [Mode; 5] = [
    Mode::Idle,
    Mode::Hold,
    Mode::Armed,
    Mode::Running,
    Mode::Fault,
];

const LEVELS: [ConfidenceLevel; 4] = [
    ConfidenceLevel::NotAssessed,
    ConfidenceLevel::Unverified,
    ConfidenceLevel::Verified,
    ConfidenceLevel::Fallback,
];

const REFUSALS: [Refusal; 7] = [
    Refusal::WrongMode,
    Refusal::SensorStale,
    Refusal::SensorUnhealthy,
    Refusal::NoPose,
    Refusal::ForceTooLarge,
    Refusal::OrientationSingular,
    Refusal::StillMoving,
];

const FAULTS: [FaultCode; 13] = [
    FaultCode::SensorStale,
    FaultCode::SensorFrozen,
    FaultCode::SensorStatus,
    FaultCode::SensorSaturated,
    FaultCode::Overload,
    FaultCode::ContactAtStart,
    FaultCode::Numeric,
    FaultCode::TelegramsLost,
    FaultCode::RobotRestarted,
    FaultCode::LateAnswers,
    FaultCode::SustainedClamp,
    FaultCode::PoseLost,
    FaultCode::ActuatorUnlike,
];

const SPECIAL: [f64; 8] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    -0.0,
    f64::MIN_POSITIVE / 8.0,
    f64::MAX,
    f64::EPSILON,
    0.1,
];

/// Numbers that look random (splitmix64).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source(pub(crate) u64);

impl Source {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    pub(crate) fn below(&mut self, limit: usize) -> usize {
        (self.bits() % limit as u64) as usize
    }

    /// Any bits, now and then a special number.
    fn real(&mut self) -> f64 {
        match self.below(8) {
            0 => SPECIAL[self.below(SPECIAL.len())],
            _ => f64::from_bits(self.bits()),
        }
    }

    fn reals<const N: usize>(&mut self) -> [f64; N] {
        core::array::from_fn(|_| self.real())
    }

    fn any<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.below(values.len())]
    }

    fn maybe<T>(&mut self, value: impl FnOnce(&mut Self) -> T) -> Option<T> {
        (self.below(2) == 0).then(|| value(self))
    }

    /// A cycle with any content. Each field is named here, so that a new one is not forgotten.
    pub(crate) fn cycle(&mut self, number: u64) -> CycleRecord {
        let gap = Sequence::Gap(self.bits() as u32);
        CycleRecord {
            inputs: Inputs {
                robot: RobotReport {
                    counter: self.bits(),
                    sequence: self.any(&[Sequence::NewRun, Sequence::Next, gap]),
                    pose: self.maybe(Self::reals),
                    late_answers: self.bits() as u32,
                    status: self.bits() as u32,
                },
                sensor: SensorSample {
                    counter: self.bits() as u32,
                    wrench: self.reals(),
                    counts: core::array::from_fn(|_| self.bits() as i32),
                    status: self.bits() as u32,
                    saturated: self.below(2) == 0,
                },
                command: self.maybe(|s| s.any(&Command::WORDS).1),
            },
            output: Output {
                correction: core::array::from_fn(|_| self.bits() as i64),
                stop: self.below(2) == 0,
            },
            trace: self.trace(number),
        }
    }

    fn trace(&mut self, cycle: u64) -> Trace {
        Trace {
            cycle,
            time_s: cycle as f64 * 0.004,
            mode: self.any(&MODES),
            fault: self.maybe(|s| Fault {
                code: s.any(&FAULTS),
                expected: s.real(),
                received: s.real(),
            }),
            refusal: self.maybe(|s| s.any(&REFUSALS)),
            limits: LimitFlags(self.bits() as u16),
            sensor_age: self.bits() as u32,
            wrench_at_m: self.reals(),
            removed: self.reals(),
            pose: self.reals(),
            executed_velocity: self.reals(),
            body_k: self.body(),
            body_q: self.body(),
            docking: self.body(),
            model_velocity: self.reals(),
            law_parts: core::array::from_fn(|_| self.reals()),
            law_status: LawStatus {
                confidence: self.any(&LEVELS),
                flags: LawFlags(self.bits() as u16),
                stiffness_n_per_m: self.real(),
                damping_n_s_per_m: self.real(),
                delay_s: self.real(),
                latency_cycles: self.bits() as u16,
                misfit: self.real(),
            },
            unaccounted_impulse: self.reals(),
            law_velocity: self.reals(),
            sent_velocity: self.reals(),
            command_pose: self.reals(),
        }
    }

    fn body(&mut self) -> BodyTrace {
        BodyTrace {
            pose: self.reals(),
            velocity: self.reals(),
        }
    }

    fn truth(&mut self) -> TruthRecord {
        TruthRecord {
            time_s: self.real(),
            pose: self.reals(),
            velocity: self.reals(),
            contact_wrench: self.reals(),
        }
    }

    /// A recording with any content.
    pub(crate) fn recording(&mut self, cycles: usize, truth: bool) -> Recording {
        Recording {
            header: Header {
                identity: "softdock 0.1.0 (0123abc, dirty)".into(),
                settings_toml: "[control.robot]\ncycle_s = 0.004 # \"quoted\", µ\n".into(),
                scenario_toml: truth.then(|| "speed_m_s = 0.015\n".into()),
                whole_turns: -3,
                began: Some(Beginning {
                    time_s: -0.25,
                    pose: [0.1, -0.2, 1.0 / 3.0, 0.5, 0.5, -0.5, 0.5],
                    whole_turns: -4,
                }),
            },
            cycles: (0..cycles as u64).map(|i| self.cycle(i)).collect(),
            truth: (0..if truth { cycles } else { 0 })
                .map(|_| self.truth())
                .collect(),
            cut: None,
            rounded: None,
            wall_clock: self.maybe(|s| WallClock {
                unix_s: s.below(2_000_000_000) as f64,
                at_time_s: s.below(1000) as f64 / 8.0,
            }),
        }
    }
}

/// The bytes of its file.
pub(crate) fn file_of(recording: &Recording) -> Vec<u8> {
    recording.write_to(Vec::new()).unwrap()
}

/// What is read from the bytes of a file.
pub(crate) fn read(file: &[u8]) -> anyhow::Result<Recording> {
    Recording::read_from(file, file.len() as u64)
}

/// Everything in it, down to the sign of zero; all NaN are one. The shortest text that reads
/// back to a number differs if a bit differs.
pub(crate) fn exact<T: core::fmt::Debug>(value: &T) -> String {
    format!("{value:?}")
}
