//! Properties of a series of numbers: noise floor, autocorrelation, spectrum, low-pass part, and dependence on another
//! quantity.
//!
//! A missing value is NaN. It is left out, and the values on its two sides do not count as neighbours.

mod correlation;
mod dependence;
mod digits;
mod groups;
mod low_pass;
mod noise_band;
mod noise_floor;
mod products;
mod random;
mod sample_time;
mod significance;
mod spectrum;

pub use correlation::{Whiteness, autocorrelation, correlated_cycles, whiteness};
pub use dependence::{Dependence, dependence};
pub use digits::digit_of;
pub use groups::{Fit, Groups};
pub use low_pass::LowPass;
pub use noise_band::{NoiseBand, incoherent_band, noise_band};
pub use noise_floor::{LowPassed, Noise, median, noise_floor, noise_let_through};
pub use products::{dot, rms};
pub use random::RandomStream;
pub use sample_time::sample_time;
pub use significance::{DEVIATIONS_95, chi_square_p, f_p, normal_p};
pub use spectrum::{periodogram, shape_of};
