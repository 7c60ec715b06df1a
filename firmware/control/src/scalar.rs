//! The number type that the control code is generic over.
//!
//! The product uses `f64` (the STM32H743 has a double-precision FPU). `f32`, and the 64-bit fixed point of a processor without
//! FPU, exist to show that no result depends on the range of an exponent. The fixed-point type has 32 integer and 32 fraction
//! bits: range ±2.1e9, resolution 2.3e-10, in SI units. Every quantity of the cycle is limited long before that range ends.
//!
//! Functions that the fixed-point type does not support, and that generic code must therefore not use (`clippy.toml` of this
//! crate forbids it): `hypot`, `ln`, `powi` and seventeen more panic; atan2 overflows near ±90°, see [`Scalar::angle_of`]; the
//! square root of a negative number, or of one from 2^30 on, does not return, and the sine of a large angle takes a time that
//! grows with the angle.

#![expect(
    clippy::disallowed_methods,
    reason = "the one place where atan2 is called, with a quotient that fits"
)]

use nalgebra::{ComplexField, RealField};

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
    /// The angle (rad, −π to π) whose sine and cosine are in this proportion: atan2.
    fn angle_of(sine: Self, cosine: Self) -> Self;
    /// The product, rounded to the nearest number, ties to even; out of range saturates. The `*` of [`Fixed`] rounds downwards,
    /// which would accumulate in an orientation that is updated in every cycle.
    fn times(self, factor: Self) -> Self;
}

impl Scalar for f64 {
    fn of(value: f64) -> Self {
        value
    }
    fn get(self) -> f64 {
        self
    }
    fn angle_of(sine: Self, cosine: Self) -> Self {
        RealField::atan2(sine, cosine)
    }
    fn times(self, factor: Self) -> Self {
        self * factor
    }
}

impl Scalar for f32 {
    fn of(value: f64) -> Self {
        value as f32
    }
    fn get(self) -> f64 {
        f64::from(self)
    }
    fn angle_of(sine: Self, cosine: Self) -> Self {
        RealField::atan2(sine, cosine)
    }
    fn times(self, factor: Self) -> Self {
        self * factor
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
    /// The fixed-point atan2 divides sine by cosine, which overflows near ±90°; here the quotient
    /// stays within ±1.
    fn angle_of(sine: Self, cosine: Self) -> Self {
        if sine.abs() <= cosine.abs() {
            return RealField::atan2(sine, cosine);
        }
        let right_angle = Fixed::frac_pi_2();
        if sine > Fixed::from_num(0) {
            right_angle - RealField::atan2(cosine, sine)
        } else {
            RealField::atan2(cosine, -sine) - right_angle
        }
    }
    fn times(self, factor: Self) -> Self {
        let product = i128::from(self.to_bits()) * i128::from(factor.to_bits());
        let (below, rest) = (product >> 32, product & 0xffff_ffff);
        // Ties to even: halves of angles are often exact halves of a digit.
        let nearest = below + i128::from(rest + (below & 1) > 1 << 31);
        Self::from_bits(nearest.clamp(i64::MIN.into(), i64::MAX.into()) as i64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_is_rounded_to_the_nearest_and_saturates() {
        let smallest = Fixed::from_bits(1);
        let half = Fixed::of(0.5);
        assert_eq!((-smallest).times(half + smallest).to_bits(), -1);
        assert_eq!((-smallest).times(half - smallest).to_bits(), 0);
        let halves = [-3, -1, 1, 3, 5].map(|bits| Fixed::from_bits(bits).times(half).to_bits());
        assert_eq!(halves, [-2, 0, 0, 2, 2]);
        assert_eq!(Fixed::of(-3.0).times(half), Fixed::of(-1.5));
        let large = Fixed::of(1e6);
        assert_eq!(large.times(-large).to_bits(), i64::MIN);
    }

    /// All quadrants, and the four directions where sine or cosine vanishes or nearly does.
    #[test]
    fn an_angle_is_found_in_every_quadrant() {
        let around = (-1800..1800).map(|tenth| f64::from(tenth) * 1.745_329e-3);
        let corners = [0.0, 90.0, -90.0, 179.999_999].map(f64::to_radians);
        let near = corners
            .into_iter()
            .flat_map(|a| [-1e-9, -3e-10, 0.0, 3e-10, 1e-9].map(|d| a + d));
        for angle in around.chain(near) {
            let (sine, cosine) = angle.sin_cos();
            let found = Fixed::angle_of(Fixed::of(sine), Fixed::of(cosine)).get();
            assert!((found - angle).abs() < 1e-8, "{angle}: {found}");
            let found = f32::angle_of(sine as f32, cosine as f32).get();
            assert!((found - angle).abs() < 1e-6, "{angle}: {found}");
        }
    }
}
