//! Declared ranges of the settings.
//!
//! They are also the declared ranges of the fixed-point build: with every setting and every input
//! at its limit, no product of the cycle leaves ±2.1e9.

use crate::range::{FieldName, LARGEST_QUATERNION, SettingsError, all_within, in_range};
use crate::settings::{BodySettings, FrameSettings, SensorSettings, Settings, StartSettings};

/// Largest mass, kg, and moment of inertia, kg·m²: with these the fixed-point build keeps four
/// digits of an acceleration and cannot overflow.
const HEAVIEST: f64 = 1.0e6;
/// Largest distance of anything from the origin of its frame, m.
const FARTHEST_M: f64 = 1.0e3;
/// Largest initial rate, rad/s: 0.1 rad per cycle, where the small-motion series end.
const FASTEST_RAD_S: f64 = 5.0;
/// Largest stiffness of the manipulator over the mass, 1/s²: 1.6 Hz, far slower than a cycle.
const STIFFEST_PER_S2: f64 = 100.0;
/// Largest damping of the manipulator over the mass, 1/s: a time constant of 25 cycles of 4 ms.
const STRONGEST_PER_S: f64 = 10.0;

/// Dotted names of a spacecraft's fields.
struct BodyNames {
    mass: FieldName,
    inertia: FieldName,
    ratio: FieldName,
    arm: FieldName,
    arm_angular: FieldName,
    arm_stiffness: FieldName,
    arm_damping: FieldName,
    position: FieldName,
    orientation: FieldName,
    velocity: FieldName,
    angular_velocity: FieldName,
}

/// The names of one of the two spacecraft.
macro_rules! body_names {
    ($body:literal) => {
        BodyNames {
            mass: concat!($body, ".mass_kg"),
            inertia: concat!($body, ".inertia_kg_m2"),
            ratio: concat!($body, ".inertia_kg_m2 ratio of moments"),
            arm: concat!($body, ".arm_acceleration_m_s2"),
            arm_angular: concat!($body, ".arm_angular_acceleration_rad_s2"),
            arm_stiffness: concat!($body, ".arm_stiffness_n_per_m"),
            arm_damping: concat!($body, ".arm_damping_n_s_per_m"),
            position: concat!($body, ".position_m"),
            orientation: concat!($body, ".orientation_wxyz"),
            velocity: concat!($body, ".velocity_m_s"),
            angular_velocity: concat!($body, ".angular_velocity_rad_s"),
        }
    };
}
impl Settings {
    /// Checks every field; the first that does not fit is the error.
    pub fn validate(&self) -> Result<(), SettingsError> {
        self.robot.check_ranges()?;
        self.sensor.validate()?;
        self.body_k.validate(&body_names!("body_k"))?;
        self.body_q.validate(&body_names!("body_q"))?;
        self.frames.validate()?;
        self.delay.validate()?;
        self.limits.check_ranges()?;
        self.start.validate(self.robot.cycle_s)?;
        self.jog.validate(&self.limits, self.robot.cycle_s)
    }
}

impl FrameSettings {
    fn validate(&self) -> Result<(), SettingsError> {
        all_within("frames.j_position_m", &self.j_position_m, FARTHEST_M)?;
        all_within("frames.p_position_m", &self.p_position_m, FARTHEST_M)?;
        let (j, p) = (&self.j_orientation_wxyz, &self.p_orientation_wxyz);
        all_within("frames.j_orientation_wxyz", j, LARGEST_QUATERNION)?;
        all_within("frames.p_orientation_wxyz", p, LARGEST_QUATERNION)
    }
}

impl StartSettings {
    fn validate(&self, cycle_s: f64) -> Result<(), SettingsError> {
        self.check_ranges()?;
        in_range("start.stop_time_s", self.stop_time_s, cycle_s, 10.0)
    }
}

impl SensorSettings {
    fn validate(&self) -> Result<(), SettingsError> {
        self.check_ranges()?;
        let stale = f64::from(self.stale_after_cycles);
        let fault = f64::from(self.fault_after_cycles);
        in_range("sensor.fault_after_cycles", fault, stale, 1000.0)
    }
}

impl BodySettings {
    fn validate(&self, names: &BodyNames) -> Result<(), SettingsError> {
        in_range(names.mass, self.mass_kg, 0.1, HEAVIEST)?;
        let i = &self.inertia_kg_m2;
        for (row, diagonal) in i.iter().enumerate() {
            all_within(names.inertia, diagonal, HEAVIEST)?;
            in_range(names.inertia, diagonal[row], 1e-3, HEAVIEST)?;
        }
        positive_definite(names, i)?;
        all_within(names.arm, &self.arm_acceleration_m_s2, 100.0)?;
        let alpha = &self.arm_angular_acceleration_rad_s2;
        all_within(names.arm_angular, alpha, 100.0)?;
        let stiffest = STIFFEST_PER_S2 * self.mass_kg;
        in_range(
            names.arm_stiffness,
            self.arm_stiffness_n_per_m,
            0.0,
            stiffest,
        )?;
        let strongest = STRONGEST_PER_S * self.mass_kg;
        in_range(
            names.arm_damping,
            self.arm_damping_n_s_per_m,
            0.0,
            strongest,
        )?;
        let orientation = &self.orientation_wxyz;
        all_within(names.orientation, orientation, LARGEST_QUATERNION)?;
        all_within(names.position, &self.position_m, FARTHEST_M)?;
        all_within(names.velocity, &self.velocity_m_s, 10.0)?;
        let omega = &self.angular_velocity_rad_s;
        all_within(names.angular_velocity, omega, FASTEST_RAD_S)
    }
}

/// Largest ratio of moments of inertia: beyond it, fixed point could not hold the inverse tensor.
const LARGEST_RATIO: f64 = 1.0e4;

/// An inertia tensor is symmetric, has positive principal minors and is well conditioned.
fn positive_definite(names: &BodyNames, i: &[[f64; 3]; 3]) -> Result<(), SettingsError> {
    let field = names.inertia;
    let asymmetry = [i[0][1] - i[1][0], i[0][2] - i[2][0], i[1][2] - i[2][1]];
    all_within(field, &asymmetry, 1e-9 * i[0][0].max(i[1][1]))?;
    let minor = i[0][0] * i[1][1] - i[0][1] * i[1][0];
    let tensor = nalgebra::Matrix3::from_fn(|r, c| i[r][c]);
    in_range(field, minor, f64::MIN_POSITIVE, f64::MAX)?;
    in_range(field, tensor.determinant(), f64::MIN_POSITIVE, f64::MAX)?;
    let inverse = tensor.try_inverse().map_or(f64::MAX, |inv| inv.amax());
    in_range(names.ratio, inverse * tensor.amax(), 0.0, LARGEST_RATIO)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passes(change: impl FnOnce(&mut BodySettings)) -> bool {
        let mut settings = Settings::default();
        change(&mut settings.body_q);
        settings.validate().is_ok()
    }

    #[test]
    fn a_space_manipulator_is_as_stiff_as_the_mass_allows() {
        for (share, expected) in [(0.999, true), (1.001, false)] {
            let mass_kg = 8.0;
            assert_eq!(
                [
                    passes(|body| {
                        body.mass_kg = mass_kg;
                        body.arm_stiffness_n_per_m = STIFFEST_PER_S2 * mass_kg * share;
                    }),
                    passes(|body| {
                        body.mass_kg = mass_kg;
                        body.arm_damping_n_s_per_m = STRONGEST_PER_S * mass_kg * share;
                    }),
                ],
                [expected; 2]
            );
        }
    }

    #[test]
    fn an_inertia_tensor_is_symmetric_to_its_rounding() {
        let with = |row: usize, column: usize, by: f64| {
            passes(|body| {
                body.inertia_kg_m2 = [[100.0, 20.0, -3.0], [20.0, 100.0, 5.0], [-3.0, 5.0, 100.0]];
                body.inertia_kg_m2[row][column] += by;
            })
        };
        for (row, column) in [(0, 1), (1, 0), (0, 2), (2, 0), (1, 2), (2, 1)] {
            assert!(with(row, column, 0.0) && with(row, column, 5e-8));
            assert!(!with(row, column, 2e-7), "{row} {column}");
        }
    }

    /// All principal minors: the second has two negative eigenvalues, but a positive determinant.
    #[test]
    fn an_inertia_tensor_is_positive_definite() {
        let tensor = |diagonal: f64, product: f64| {
            passes(|body| {
                body.inertia_kg_m2 = [[product; 3]; 3];
                (0..3).for_each(|i| body.inertia_kg_m2[i][i] = diagonal);
            })
        };
        assert!(tensor(4.0, 3.0));
        assert!(!tensor(3.0, 4.0));
        assert!(!tensor(4.0, -3.0), "a negative determinant");
    }
}
