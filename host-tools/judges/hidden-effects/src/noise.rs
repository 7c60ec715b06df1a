//! Reproducible random numbers and the measurement noise of one log.

use nalgebra::{Vector3, Vector6};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

use crate::meta::NoiseSigma;

/// One independent stream of random numbers.
#[derive(Clone, Debug)]
pub(crate) struct Noise {
    generator: ChaCha8Rng,
    spare: Option<f64>,
}

impl Noise {
    /// Streams of one seed are independent: draws from one do not change another.
    pub(crate) fn new(seed: u64, stream: u64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(stream);
        Self {
            generator,
            spare: None,
        }
    }

    /// Uniform in [0, 1), with 53 random bits.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.generator.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in [`low`, `high`).
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// True with the probability `p`.
    pub(crate) fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }

    /// +1 or -1.
    pub(crate) fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    /// Integer in 0..`n`; 0 when `n` is 0.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        ((self.unit() * n as f64) as usize).min(n.saturating_sub(1))
    }

    /// One of the values.
    pub(crate) fn pick<T: Copy, const N: usize>(&mut self, values: [T; N]) -> T {
        values[self.below(N)]
    }

    /// Standard normal (Box-Muller).
    pub(crate) fn normal(&mut self) -> f64 {
        if let Some(value) = self.spare.take() {
            return value;
        }
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        let (sin, cos) = (core::f64::consts::TAU * self.unit()).sin_cos();
        self.spare = Some(radius * sin);
        radius * cos
    }

    /// Three standard normals.
    pub(crate) fn normal3(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.normal())
    }

    /// Six standard normals.
    pub(crate) fn normal6(&mut self) -> Vector6<f64> {
        Vector6::from_fn(|_, _| self.normal())
    }
}

/// Difference between the real noise and the data sheet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NoiseCharacter {
    /// Real sigma of the wrench divided by that of the data sheet.
    pub(crate) wrench_factor: f64,
    /// Real sigma of velocity and pose divided by that of the data sheet.
    pub(crate) motion_factor: f64,
    /// Coefficient of the first-order autoregression of the wrench noise, 0 = white.
    pub(crate) ar_coefficient: f64,
    /// Coefficient of the first-order autoregression of the velocity noise, 0 = white.
    pub(crate) motion_ar_coefficient: f64,
}

/// Range of the noise of a case, relative to the data sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NoiseRange {
    /// A third of the logs up to 1.3 times as large, a quarter with an autoregressive wrench.
    #[default]
    Usual,
    /// All logs: up to 1.6 times as large, the wrench autoregressive.
    Wide,
    /// As `Wide`, with the velocity autoregressive too. The model multiplies the difference of the velocity by the mass of
    /// the tool, so the residuals of both channels contain the same noise.
    ColouredVelocity,
}

impl NoiseCharacter {
    /// No noise at all.
    pub(crate) const SILENCE: Self = Self {
        wrench_factor: 0.0,
        motion_factor: 0.0,
        ar_coefficient: 0.0,
        motion_ar_coefficient: 0.0,
    };

    /// Draws the character of the noise for both logs of a case.
    pub(crate) fn draw(range: NoiseRange, noise: &mut Noise) -> Self {
        match range {
            NoiseRange::Usual => Self::usual(noise),
            NoiseRange::Wide => Self::wide(noise),
            NoiseRange::ColouredVelocity => Self {
                motion_ar_coefficient: noise.between(0.1, 0.3),
                ..Self::wide(noise)
            },
        }
    }

    fn wide(noise: &mut Noise) -> Self {
        Self {
            wrench_factor: noise.between(1.0, 1.6),
            motion_factor: noise.between(1.0, 1.6),
            ar_coefficient: noise.between(-0.3, 0.8),
            motion_ar_coefficient: 0.0,
        }
    }

    fn usual(noise: &mut Noise) -> Self {
        let noisier = noise.between(1.0, 1.3);
        let (wrench_factor, motion_factor) = match noise.below(9) {
            0 | 1 => (noisier, 1.0),
            2 => (noisier, noisier),
            _ => (1.0, 1.0),
        };
        let ar_coefficient = noise.between(0.1, 0.5);
        Self {
            wrench_factor,
            motion_factor,
            ar_coefficient: if noise.chance(0.25) {
                ar_coefficient
            } else {
                0.0
            },
            motion_ar_coefficient: 0.0,
        }
    }
}

/// Noise of one tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Disturbance {
    /// Noise of the wrench, N (3x), Nm (3x).
    pub(crate) wrench: Vector6<f64>,
    /// Noise of the velocity, m/s (3x), rad/s (3x).
    pub(crate) twist: Vector6<f64>,
    /// Noise of the position, m.
    pub(crate) position: Vector3<f64>,
    /// Noise of the orientation, rad, a rotation vector in the body.
    pub(crate) angle: Vector3<f64>,
}

/// Source of the measurement noise. A log and its reference run get the same draws.
#[derive(Clone, Debug)]
pub(crate) struct MeasurementNoise {
    stream: Noise,
    character: NoiseCharacter,
    sigma: NoiseSigma,
    wrench: Vector6<f64>,
    twist: Vector6<f64>,
}

impl MeasurementNoise {
    /// Begins in the stationary state of the wrench's autoregression.
    pub(crate) fn new(seed: u64, character: NoiseCharacter, sigma: NoiseSigma) -> Self {
        let mut stream = Noise::new(seed, 1);
        let wrench = stream.normal6();
        Self {
            stream,
            character,
            sigma,
            wrench,
            twist: Vector6::zeros(),
        }
    }

    /// Draws the noise of one tick.
    pub(crate) fn tick(&mut self) -> Disturbance {
        let (sigma, character) = (self.sigma, self.character);
        self.wrench = coloured(self.wrench, character.ar_coefficient, &mut self.stream);
        self.twist = coloured(
            self.twist,
            character.motion_ar_coefficient,
            &mut self.stream,
        );
        let split = |linear: f64, angular: f64, factor: f64| {
            Vector6::from_fn(|i, _| factor * if i < 3 { linear } else { angular })
        };
        let motion = character.motion_factor;
        Disturbance {
            wrench: self.wrench.component_mul(&split(
                sigma.force_n,
                sigma.torque_nm,
                character.wrench_factor,
            )),
            twist: self
                .twist
                .component_mul(&split(sigma.velocity_m_s, sigma.rate_rad_s, motion)),
            position: self.stream.normal3() * (sigma.position_m * motion),
            angle: self.stream.normal3() * (sigma.angle_rad * motion),
        }
    }
}

/// `x(n) = a x(n-1) + sqrt(1 - a²) e(n)`: its sigma does not depend on `a`.
fn coloured(last: Vector6<f64>, a: f64, stream: &mut Noise) -> Vector6<f64> {
    last * a + stream.normal6() * (1.0 - a * a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn autoregressive_noise_keeps_its_sigma_and_its_correlation() {
        let character = NoiseCharacter {
            wrench_factor: 1.2,
            motion_factor: 1.0,
            ar_coefficient: 0.4,
            motion_ar_coefficient: 0.0,
        };
        let sigma = NoiseSigma::DATA_SHEET;
        let mut noise = MeasurementNoise::new(3, character, sigma);
        let x: Vec<f64> = (0..50_000).map(|_| noise.tick().wrench[0]).collect();
        let power = x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64;
        let lagged = x.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / x.len() as f64;
        assert!((power.sqrt() / (1.2 * sigma.force_n) - 1.0).abs() < 0.02);
        assert!((lagged / power - 0.4).abs() < 0.02);
    }

    #[test]
    fn streams_differ_and_seeds_repeat() {
        let draw = |seed, stream| Noise::new(seed, stream).unit();
        assert_eq!(draw(1, 0), draw(1, 0));
        assert_ne!(draw(1, 0), draw(1, 1));
        assert_ne!(draw(1, 0), draw(2, 0));
    }
}
