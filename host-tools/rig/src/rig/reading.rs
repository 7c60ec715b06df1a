//! Hidden effects between the load of the sensor and what it reads.
//!
//! Mounting, cross-talk and gains act on the load; the sensor's own zero, and noise, are added by
//! the sensor. Range, resolution and lost samples act on what it sends.

use super::checks::prefixed;
use super::hidden::{self, Hidden};
use anyhow::Result;
use softdock_analysis::statistics::RandomStream;
use softdock_control::effects::Group;
use softdock_control::effects::sensor::ft_bias::Bias;
use softdock_control::effects::sensor::ft_bias_drift::BiasDrift;
use softdock_control::effects::sensor::ft_crosstalk::{self, Crosstalk};
use softdock_control::effects::sensor::ft_dropout::Dropout;
use softdock_control::effects::sensor::ft_latency::Latency;
use softdock_control::effects::sensor::ft_low_pass::LowPass;
use softdock_control::effects::sensor::ft_mounting::Mounting;
use softdock_control::effects::sensor::ft_quantisation::WrenchQuantisation;
use softdock_control::effects::sensor::ft_saturation::ForceSaturation;
use softdock_control::effects::sensor::ft_scale::Scale;
use softdock_control::frames::Wrench;

/// Integration steps that a latency can span.
const LATENCY_STEPS: usize = 512;
/// Names of the six components of an offset.
const OFFSET: [&str; 6] = ["fx_n", "fy_n", "fz_n", "tx_n_m", "ty_n_m", "tz_n_m"];
/// Names of the six gains.
const GAINS: [&str; 6] = ["fx", "fy", "fz", "tx", "ty", "tz"];

/// An effect without memory on the load.
#[derive(Clone, Debug)]
enum Distortion {
    Mounting(Mounting<f64>),
    Crosstalk(Box<Crosstalk<f64>>),
    Scale(Scale<f64>),
    Bias(Bias<f64>),
}

/// An effect on each sample.
#[derive(Clone, Debug)]
enum Sampling {
    Range(ForceSaturation),
    Resolution(WrenchQuantisation<f64>),
    Dropout(Dropout<f64>),
}

/// Hidden effects on the reading.
#[derive(Clone, Debug)]
pub(super) struct Reading {
    distortions: Vec<Distortion>,
    drift: Option<BiasDrift<f64>>,
    low_pass: Option<LowPass<f64>>,
    latency: Option<Box<Latency<f64, LATENCY_STEPS>>>,
    /// What filter and line deliver at the last integration step.
    felt: Wrench<f64>,
    samplings: Vec<Sampling>,
    noise: RandomStream,
}

impl Reading {
    pub(super) fn new(hidden: &[Hidden], step_s: f64, noise: RandomStream) -> Result<Self> {
        let mut reading = Self {
            distortions: Vec::new(),
            drift: None,
            low_pass: None,
            latency: None,
            felt: Wrench::zero(),
            samplings: Vec::new(),
            noise,
        };
        for (effect, hidden) in hidden::in_order(hidden, Group::Sensor) {
            let added = reading.add(hidden, step_s);
            prefixed(&format!("rig.hidden {}.", effect.id), added)?;
        }
        Ok(reading)
    }

    fn add(
        &mut self,
        hidden: &Hidden,
        step_s: f64,
    ) -> Result<(), softdock_control::range::SettingsError> {
        let value = |name| hidden.value(name);
        match hidden.id.as_str() {
            "ft_mounting" => {
                let turn = hidden.values(["rx_rad", "ry_rad", "rz_rad"]);
                let mounting = Mounting::new(&turn)?;
                self.distortions.push(Distortion::Mounting(mounting));
            }
            "ft_crosstalk" => {
                let crosstalk = Crosstalk::new(&couplings(hidden))?;
                self.distortions
                    .push(Distortion::Crosstalk(Box::new(crosstalk)));
            }
            "ft_scale" => {
                let scale = Scale::new(&hidden.values(GAINS))?;
                self.distortions.push(Distortion::Scale(scale));
            }
            "ft_bias" => {
                let bias = Bias::new(&hidden.values(OFFSET))?;
                self.distortions.push(Distortion::Bias(bias));
            }
            "ft_bias_drift" => {
                let last = hidden.values(OFFSET);
                self.drift = Some(BiasDrift::new(&last, value("time_constant_s"))?);
            }
            "ft_low_pass" => {
                self.low_pass = Some(LowPass::new(value("time_constant_s"), step_s)?);
            }
            "ft_saturation" => {
                let range = ForceSaturation::new(value("limit_n"))?;
                self.samplings.push(Sampling::Range(range));
            }
            "ft_quantisation" => {
                let steps = (value("lsb_force_n"), value("lsb_torque_n_m"));
                let lattice = WrenchQuantisation::new(steps.0, steps.1)?;
                self.samplings.push(Sampling::Resolution(lattice));
            }
            "ft_dropout" => {
                let dropout = Dropout::new(value("held_share"))?;
                self.samplings.push(Sampling::Dropout(dropout));
            }
            "ft_latency" => {
                let line = Latency::new(value("latency_s"), step_s)?;
                self.latency = Some(Box::new(line));
            }
            _ => {} // the load's: tool and base
        }
        Ok(())
    }

    /// Whether it has to see every integration step.
    pub(super) fn has_memory(&self) -> bool {
        self.low_pass.is_some() || self.latency.is_some()
    }

    /// What the turned, coupled and wrongly scaled sensor feels of a load.
    pub(super) fn distorted(&self, load: &Wrench<f64>) -> Wrench<f64> {
        let distortions = self.distortions.iter();
        distortions.fold(*load, |wrench, distortion| match distortion {
            Distortion::Mounting(effect) => effect.apply(&wrench),
            Distortion::Crosstalk(effect) => effect.apply(&wrench),
            Distortion::Scale(effect) => effect.apply(&wrench),
            Distortion::Bias(effect) => effect.apply(&wrench),
        })
    }

    /// Starts as if the wrench had been felt for a long time.
    pub(super) fn settle(&mut self, wrench: &Wrench<f64>) {
        if let Some(filter) = &mut self.low_pass {
            filter.settle(wrench);
        }
        if let Some(line) = &mut self.latency {
            (0..LATENCY_STEPS).for_each(|_| {
                line.advance(wrench);
            });
        }
        self.felt = *wrench;
    }

    /// One integration step of what remembers.
    pub(super) fn advance(&mut self, wrench: &Wrench<f64>) {
        let filtered = match &mut self.low_pass {
            Some(filter) => filter.advance(wrench),
            None => *wrench,
        };
        self.felt = match &mut self.latency {
            Some(line) => line.advance(&filtered),
            None => filtered,
        };
    }

    /// What filter and line deliver now.
    pub(super) fn felt(&self) -> Wrench<f64> {
        self.felt
    }

    /// Drift of the zero at a time, s.
    pub(super) fn drift(&self, time_s: f64) -> Wrench<f64> {
        let drift = self.drift.as_ref();
        drift.map_or_else(Wrench::zero, |drift| drift.at(time_s))
    }

    /// One sample as it is sent.
    pub(super) fn sampled(&mut self, wrench: Wrench<f64>) -> Wrench<f64> {
        let mut wrench = wrench;
        for sampling in &mut self.samplings {
            wrench = match sampling {
                Sampling::Range(effect) => effect.apply(&wrench),
                Sampling::Resolution(effect) => effect.apply(&wrench),
                // Uniform in (0, 1], so that a share of 0 never holds and one of 1 always does.
                Sampling::Dropout(effect) => effect.advance(&wrench, 1.0 - self.noise.uniform()),
            };
        }
        wrench
    }
}

/// The matrix of a hidden cross-talk.
fn couplings(hidden: &Hidden) -> [[f64; 6]; 6] {
    let mut matrix = [[0.0; 6]; 6];
    for (index, parameter) in ft_crosstalk::EFFECT.parameters.iter().enumerate() {
        let (row, column) = ft_crosstalk::row_and_column(index);
        matrix[row][column] = hidden.value(parameter.name);
    }
    matrix
}
