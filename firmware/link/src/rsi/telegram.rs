//! What the two telegrams carry.

use crate::decimal::Decimal;

/// Bits of POSCORR's `Stat` that say "the correction is being clamped": 1 to 3 lower X/Y/Z, 4 to 6 upper X/Y/Z,
/// 7 rotation. Bit 0 only says that the object is active.
const POSCORR_CLAMP_BITS: u32 = 0b1111_1110;

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
    /// Bits of POSCORR's `Stat`, where the configuration sends them. See [`Self::is_correction_clamped`].
    pub poscorr_stat: Option<u32>,
}

impl RobTelegram {
    /// Whether the robot says that POSCORR cuts the correction off at its box; `false` where it does not say.
    pub fn is_correction_clamped(&self) -> bool {
        self.poscorr_stat
            .is_some_and(|stat| stat & POSCORR_CLAMP_BITS != 0)
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
        let clamped = |poscorr_stat| {
            RobTelegram {
                poscorr_stat,
                ..Default::default()
            }
            .is_correction_clamped()
        };
        assert!(!clamped(None));
        assert!(!clamped(Some(0b0000_0001)));
        for bit in 1..=7 {
            assert!(clamped(Some(1 << bit)));
        }
        assert!(!clamped(Some(1 << 8)));
    }
}
