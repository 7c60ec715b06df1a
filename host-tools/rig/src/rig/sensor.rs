//! The force/torque sensor: from its load to gauge counts.

use super::checks::{check, check_all, prefixed};
use super::gauge_quantisation::{GaugeError, GaugeQuantisation};
use super::load::{Load, ToolLoad};
use super::reading::Reading;
use super::settings::{RigSettings, SensorSettings};
use anyhow::{Result, anyhow};
use softdock_control::frames::{Wrench, vector};
use softdock_physics::effects::{DelayAndLag, DelayLine};
use softdock_statistics::RandomStream;
use std::f64::consts::TAU;

/// One reading of all gauges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SensorSampleSim {
    /// Gauges 0 to 5, saturated to 16 bit.
    pub counts: [i16; 6],
    /// Status word of the sensor; 0 unless a fault was set.
    pub status: u16,
}

/// Sensor and tool.
#[derive(Clone, Debug)]
pub(super) struct Sensor {
    tool: ToolLoad,
    feels_inertia: bool,
    reading: Reading,
    bias: Wrench<f64>,
    drift_per_s: Wrench<f64>,
    /// The sensor's own filter, and its integration step, s.
    low_pass: Option<(DelayAndLag, DelayLine)>,
    step_s: f64,
    gauges: GaugeQuantisation,
    noise_sigma: [f64; 6],
    noise: RandomStream,
    /// Status word that readings carry.
    pub(super) status: u16,
}

impl Sensor {
    /// `noise` is that of the reading, `losses` that of lost samples.
    pub(super) fn new(
        settings: &RigSettings,
        noise: RandomStream,
        losses: RandomStream,
    ) -> Result<Self> {
        let s = &settings.sensor;
        check_sensor(s)?;
        let six = |force: &[f64; 3], torque: &[f64; 3]| Wrench {
            force: vector(force),
            torque: vector(torque),
        };
        let (force, torque) = (s.noise_force_n, s.noise_torque_nm);
        let step_s = settings.substep_s();
        let low_pass = |cutoff: f64| {
            check("rig.sensor.low_pass_hz", cutoff, 0.1, 1e5)?;
            let lag = DelayAndLag {
                delay_s: 0.0,
                lag_s: 1.0 / (TAU * cutoff),
            };
            anyhow::Ok((lag, DelayLine::new(lag, step_s, [0.0; 6])))
        };
        let tool = ToolLoad::new(settings)?;
        Ok(Self {
            feels_inertia: tool.has_inertia(),
            tool,
            reading: Reading::new(&settings.hidden, step_s, losses),
            bias: six(&s.bias_n, &s.bias_nm),
            drift_per_s: six(&s.drift_n_per_s, &s.drift_nm_per_s),
            low_pass: s.low_pass_hz.map(low_pass).transpose()?,
            step_s,
            gauges: gauges(s)?,
            noise_sigma: [force, force, force, torque, torque, torque],
            noise,
            status: 0,
        })
    }

    /// Whether the sensor has a state that has to follow every integration step.
    pub(super) fn has_memory(&self) -> bool {
        self.low_pass.is_some() || self.reading.has_memory()
    }

    /// Whether the sensor feels acceleration.
    pub(super) fn feels_inertia(&self) -> bool {
        self.feels_inertia
    }

    /// Sets the states as if this load had been there for a long time.
    pub(super) fn settle(&mut self, load: &Load) {
        let wrench = self.strain(load);
        if let Some((lag, filter)) = &mut self.low_pass {
            *filter = DelayLine::new(*lag, self.step_s, wrench.get());
        }
        self.reading.settle(&wrench);
    }

    /// Advances filters and delays by an integration step.
    pub(super) fn advance(&mut self, load: &Load) {
        let wrench = self.strain(load);
        let filtered = match &mut self.low_pass {
            Some((_, filter)) => Wrench::of(&filter.advance(wrench.get())),
            None => wrench,
        };
        self.reading.advance(&filtered);
    }

    /// A reading at `time_s`.
    pub(super) fn read(&mut self, load: &Load, time_s: f64) -> SensorSampleSim {
        let filtered = self.low_pass.as_ref();
        let filtered = filtered.map(|(_, filter)| Wrench::of(&filter.value()));
        let felt = self.reading.felt().or(filtered);
        let felt = felt.unwrap_or_else(|| self.strain(load));
        let zero = self.bias + self.drift_per_s * time_s + self.reading.zero(time_s);
        let mut wrench = (felt + zero).get();
        for (value, sigma) in wrench.iter_mut().zip(self.noise_sigma) {
            *value = self.noise.around(*value, sigma);
        }
        let sample = self.reading.sampled(Wrench::of(&wrench));
        SensorSampleSim {
            counts: self.gauges.counts(&sample),
            status: self.status,
        }
    }

    /// What the gauges feel of a load.
    fn strain(&self, load: &Load) -> Wrench<f64> {
        self.reading.distorted(&self.tool.wrench(load))
    }
}

fn gauges(s: &SensorSettings) -> Result<GaugeQuantisation> {
    let built = GaugeQuantisation::new(
        &s.calibration,
        s.counts_per_newton,
        s.counts_per_newton_metre,
    );
    match built {
        Err(GaugeError::OutOfRange(error)) => prefixed("rig.sensor.", Err(error)),
        other => other.map_err(|error| anyhow!("rig.sensor.{error}")),
    }
}

fn check_sensor(s: &SensorSettings) -> Result<()> {
    check_all("rig.sensor.position_m", &s.position_m, -10.0, 10.0)?;
    check_all(
        "rig.sensor.orientation_abc_rad",
        &s.orientation_abc_rad,
        -10.0,
        10.0,
    )?;
    check_all("rig.sensor.bias_n", &s.bias_n, -1e5, 1e5)?;
    check_all("rig.sensor.bias_nm", &s.bias_nm, -1e5, 1e5)?;
    check_all("rig.sensor.drift_n_per_s", &s.drift_n_per_s, -1e3, 1e3)?;
    check_all("rig.sensor.drift_nm_per_s", &s.drift_nm_per_s, -1e3, 1e3)?;
    check("rig.sensor.noise_force_n", s.noise_force_n, 0.0, 1e3)?;
    check("rig.sensor.noise_torque_nm", s.noise_torque_nm, 0.0, 1e3)
}
