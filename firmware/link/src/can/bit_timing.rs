//! Timing of a bit on the bus: how it is made of time quanta, and where it is sampled.

use crate::sensor::SensorFault;

/// Segments of a bit in time quanta, without the synchronisation segment of one quantum.
///
/// ```
/// use softdock_link::can::BitTiming;
/// let timing = BitTiming { prescaler: 4, seg1: 16, seg2: 3, jump: 3 };
/// assert_eq!(timing.bits_per_second(80_000_000), 1_000_000);
/// assert_eq!(timing.sample_point_per_mille(), 850);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitTiming {
    /// Cycles of the controller's clock that make a quantum.
    pub prescaler: u16,
    /// Propagation and phase segment 1: up to the sample point.
    pub seg1: u8,
    /// Phase segment 2: after the sample point.
    pub seg2: u8,
    /// Most quanta by which a bit is made longer or shorter to follow another node's clock.
    pub jump: u8,
}

/// Range of the sample point at 1 Mbit/s, ‰ of a bit: from both sensors' manuals and CiA 301 (87.5 %).
pub const SAMPLE_POINT_PER_MILLE: (u32, u32) = (850, 875);

impl BitTiming {
    /// From FDCAN's nominal bit timing register NBTP (RM0433, 56.5.7), whose fields hold the values minus one.
    pub const fn from_nbtp(register: u32) -> Self {
        Self {
            prescaler: (register >> 16 & 0x1ff) as u16 + 1,
            seg1: (register >> 8 & 0xff) as u8 + 1,
            seg2: (register & 0x7f) as u8 + 1,
            jump: (register >> 25 & 0x7f) as u8 + 1,
        }
    }

    const fn quanta(self) -> u32 {
        1 + self.seg1 as u32 + self.seg2 as u32
    }

    /// Bits per second with a clock of `clock_hz`.
    pub const fn bits_per_second(self, clock_hz: u32) -> u32 {
        clock_hz / (self.prescaler as u32 * self.quanta())
    }

    /// Sample point, ‰ of a bit.
    pub const fn sample_point_per_mille(self) -> u32 {
        1000 * (1 + self.seg1 as u32) / self.quanta()
    }

    /// Whether the bit rate is right, the sample point lies in the range of `SAMPLE_POINT_PER_MILLE`, and the jump is at most
    /// segment 2.
    pub const fn is_as_expected(self, clock_hz: u32, bits_per_second: u32) -> bool {
        let (from, to) = SAMPLE_POINT_PER_MILLE;
        let sampled = self.sample_point_per_mille();
        self.bits_per_second(clock_hz) == bits_per_second
            && from <= sampled
            && sampled <= to
            && self.jump <= self.seg2
    }

    /// # Errors
    /// [`SensorFault::BitTiming`] if it is not [as expected](Self::is_as_expected).
    pub const fn check(self, clock_hz: u32, bits_per_second: u32) -> Result<(), SensorFault> {
        if self.is_as_expected(clock_hz, bits_per_second) {
            return Ok(());
        }
        Err(SensorFault::BitTiming {
            bits_per_second: self.bits_per_second(clock_hz),
            per_mille: self.sample_point_per_mille(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOCK_HZ: u32 = 80_000_000;

    #[test]
    fn the_register_says_what_was_meant() {
        // jump 3, prescaler 4, seg1 16, seg2 3.
        let timing = BitTiming::from_nbtp(2 << 25 | 3 << 16 | 15 << 8 | 2);
        let meant = BitTiming {
            prescaler: 4,
            seg1: 16,
            seg2: 3,
            jump: 3,
        };
        assert_eq!(timing, meant);
        assert!(timing.is_as_expected(CLOCK_HZ, 1_000_000));
    }

    /// Ten quanta with the sample point at 90 %, as a driver chose it: the receiver has only a tenth of a bit left for the cable
    /// and for the other node's clock.
    #[test]
    fn a_late_sample_point_is_not_expected() {
        let late = BitTiming {
            prescaler: 8,
            seg1: 8,
            seg2: 1,
            jump: 1,
        };
        let (bits_per_second, per_mille) = (1_000_000, 900);
        assert_eq!(
            late.check(CLOCK_HZ, bits_per_second),
            Err(SensorFault::BitTiming {
                bits_per_second,
                per_mille
            })
        );
        let slow = BitTiming {
            prescaler: 8,
            seg1: 16,
            seg2: 3,
            jump: 3,
        };
        assert!(!slow.is_as_expected(CLOCK_HZ, 1_000_000));
        assert!(slow.is_as_expected(2 * CLOCK_HZ, 1_000_000));
    }

    /// The sample point may be 85 to 87.5 %, and a jump longer than segment 2 is invalid.
    #[test]
    fn the_edges_of_what_is_expected() {
        for (seg1, seg2, jump, expected) in [
            (15, 4, 1, false),
            (16, 3, 3, true),
            (13, 2, 2, true),
            (16, 3, 4, false),
            (14, 2, 1, false),
        ] {
            let timing = BitTiming {
                prescaler: 1,
                seg1,
                seg2,
                jump,
            };
            let quanta = 1 + u32::from(seg1) + u32::from(seg2);
            assert_eq!(
                timing.is_as_expected(quanta * 1_000_000, 1_000_000),
                expected,
                "{timing:?}"
            );
        }
    }
}
