//! The number type that the control code is generic over.
//!
//! `f64` is the product (the STM32H743 has a double-precision FPU); `f32` and the 64-bit fixed
//! point of a processor without FPU exist to show that nothing depends on a lucky exponent. The
//! fixed-point type has 32 integer and 32 fraction bits: range ±2.1e9, resolution 2.3e-10, in SI
//! units. Every quantity of the cycle is limited long before that range ends.

use nalgebra::RealField;

/// Signed 64-bit fixed point, 32 integer and 32 fraction bits.
pub type Fixed = simba::scalar::FixedI64<fixed::types::extra::U32>;

/// Largest magnitude that conversion into [`Fixed`] lets through: half of its range, so that the
/// sum of two converted numbers still fits.
const FIXED_LIMIT: f64 = 1_073_741_824.0;

/// A real number of the control code: `f64`, `f32` or [`Fixed`].
///
/// ```
/// use softdock_control::scalar::{Fixed, Scalar};
/// assert_eq!(Fixed::of(0.25).get(), 0.25);
/// assert_eq!(Fixed::of(f64::NAN).get(), 0.0); // saturates, never becomes NaN
/// ```
pub trait Scalar: RealField + Copy {
    /// The nearest representable number; out of range saturates. For [`Fixed`], NaN becomes 0;
    /// the cycle rejects non-finite input before it converts.
    fn of(value: f64) -> Self;
    /// The number as `f64`, for the trace and for the wire.
    fn get(self) -> f64;
}

impl Scalar for f64 {
    fn of(value: f64) -> Self {
        value
    }
    fn get(self) -> f64 {
        self
    }
}

impl Scalar for f32 {
    fn of(value: f64) -> Self {
        value as f32
    }
    fn get(self) -> f64 {
        f64::from(self)
    }
}

impl Scalar for Fixed {
    fn of(value: f64) -> Self {
        if value.is_nan() {
            return Fixed::from_num(0);
        }
        Fixed::from_num(value.clamp(-FIXED_LIMIT, FIXED_LIMIT))
    }
    fn get(self) -> f64 {
        self.0.to_num::<f64>()
    }
}
