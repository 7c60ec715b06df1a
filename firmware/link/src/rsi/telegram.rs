//! Content of the two telegrams.

use crate::decimal::Decimal;

/// Bits of POSCORR's `Stat` that say "the correction is being clamped": 1 to 3 lower X/Y/Z, 4 to 6 upper X/Y/Z,
/// 7 rotation. Bit 0 only says that the object is active.
const POSCORR_CLAMP_BITS: u32 = 0b1111_1110;

/// Whether the bits of POSCORR's `Stat` say that the correction is cut off at its box.
pub fn poscorr_clamps(stat: u32) -> bool {
    stat & POSCORR_CLAMP_BITS != 0
}

/// One telegram of the robot, `<Rob>`.
///
/// Everything but [`ipoc`](Self::ipoc) depends on the SEND list of the robot's configuration file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RobTelegram {
    /// Time stamp in ms, echoed unchanged by the answer. Rises by the sensor cycle.
    pub ipoc: u64,
    /// `RIst`: actual pose X, Y, Z (mm), A, B, C (deg) in the active base, with the RSI correction.
    pub actual_pose: Option<[f64; 6]>,
    /// `RSol`: setpoint pose X, Y, Z (mm), A, B, C (deg), without the RSI correction.
    pub setpoint_pose: Option<[f64; 6]>,
    /// `Delay D`: answers that the robot counted as late or rejected.
    pub late_answers: Option<u32>,
    /// Bits of POSCORR's `Stat`, where the configuration sends them. See [`poscorr_clamps`].
    pub poscorr_stat: Option<u32>,
}

impl RobTelegram {
    /// The actual pose: X, Y, Z in m, A, B, C in rad.
    pub fn pose_si(&self) -> Option<[f64; 6]> {
        let [x, y, z, a, b, c] = self.actual_pose?;
        let m = |mm: f64| mm * 1e-3;
        Some([
            m(x),
            m(y),
            m(z),
            a.to_radians(),
            b.to_radians(),
            c.to_radians(),
        ])
    }
}

/// Our answer, `<Sen>`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SenTelegram {
    /// `IPOC` of the telegram that is answered.
    pub ipoc: u64,
    /// Correction X, Y, Z (mm), A, B, C (deg): per cycle in `#RELATIVE`, from the start in `#ABSOLUTE`.
    pub correction: [Decimal; 6],
    /// Asks the robot to stop; written only if [`Tags::stop`](super::Tags::stop) has a name.
    pub stop: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_limit_bits_mean_clamped() {
        assert!(!poscorr_clamps(0b0000_0001));
        for bit in 1..=7 {
            assert!(poscorr_clamps(1 << bit));
        }
        assert!(!poscorr_clamps(1 << 8));
    }

    #[test]
    fn a_pose_is_told_in_metres_and_radians() {
        let robot = |actual_pose| RobTelegram {
            actual_pose,
            ..RobTelegram::default()
        };
        let [x, y, z, a, b, c] = robot(Some([1000.0, -500.0, 0.0, 180.0, -90.0, 0.0]))
            .pose_si()
            .unwrap();
        assert_eq!([x, y, z], [1.0, -0.5, 0.0]);
        use core::f64::consts::{FRAC_PI_2, PI};
        assert_eq!([a, b, c], [PI, -FRAC_PI_2, 0.0]);
        assert_eq!(robot(None).pose_si(), None);
    }
}
