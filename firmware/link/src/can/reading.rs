//! One reading of a force/torque sensor.

/// One reading, as it comes from the sensor: without bias, gravity or tool inertia removed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorReading {
    /// Force X, Y, Z (N) and torque X, Y, Z (N·m) in the sensor frame S. For the log; to act on it use
    /// [`Self::valid_wrench`].
    pub wrench: [f64; 6],
    /// Raw strain gauge counts; zeros for a sensor that does not show them.
    pub gauges: [i16; 6],
    /// Raw status word; zero for a sensor that has none.
    pub status: u16,
    /// Rises by one with every reading, wrapping.
    pub counter: u32,
    /// The reading was not taken before this time: when it was asked for, or, from a streaming sensor, when its first
    /// frame came in.
    pub at_us: u64,
    /// What is wrong with it.
    pub flags: ReadingFlags,
}

/// What is wrong with a [`SensorReading`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReadingFlags {
    /// A gauge or an axis is at the end of its range. The calibration couples the gauges, so no axis is valid.
    pub saturated: bool,
    /// Any status bit is set.
    pub fault: bool,
    /// A status bit is set that the maker calls critical.
    pub critical: bool,
}

impl SensorReading {
    /// The wrench if nothing is wrong with the reading. A reading is valid in all axes or in none.
    pub fn valid_wrench(&self) -> Option<[f64; 6]> {
        (self.flags == ReadingFlags::default()).then_some(self.wrench)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_flag_invalidates_all_axes() {
        let wrench = [1.0; 6];
        let reading = |saturated, fault, critical| SensorReading {
            wrench,
            flags: ReadingFlags {
                saturated,
                fault,
                critical,
            },
            ..Default::default()
        };
        assert_eq!(reading(false, false, false).valid_wrench(), Some(wrench));
        for (saturated, fault, critical) in [
            (true, false, false),
            (false, true, false),
            (false, false, true),
        ] {
            assert_eq!(reading(saturated, fault, critical).valid_wrench(), None);
        }
    }
}
