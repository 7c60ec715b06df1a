//! The commands to the robot in its own axes.
//!
//! A robot that takes corrections of X, Y, Z and of KUKA's angles A, B, C moves each of them separately: its drives act (by
//! rounding, limits, play) on the rates of these angles, not on components of the angular velocity. The wire carries whole
//! digits, so the velocity that was sent is that of the rounded correction.

use super::Six;
use softdock_app::record::CycleRecord;
use softdock_control::settings::{CorrectionMode, Settings};
use std::f64::consts::{PI, TAU};

/// Meaning of the counts on the wire, for X Y Z and the angles about x (C), y (B) and z (A).
#[derive(Clone, Debug)]
pub struct RobotAxes {
    cycle_s: f64,
    mode: CorrectionMode,
    /// Length and angle of the last digit, m and rad.
    digit: [f64; 2],
}

impl RobotAxes {
    /// For a board with these settings.
    pub fn new(settings: &Settings) -> Self {
        let robot = &settings.robot;
        let digit = 0.1_f64.powi(robot.correction_decimals.into());
        Self {
            cycle_s: robot.cycle_s,
            mode: robot.correction_mode,
            digit: [1e-3 * digit, digit * PI / 180.0],
        }
    }

    /// Rates that the wire carried in a cycle, m/s and rad/s; `None` if the answer does not match the motion that the board sent.
    pub fn sent_rates(&self, last: Option<&CycleRecord>, cycle: &CycleRecord) -> Option<Six> {
        let counts = cycle.output.correction;
        let before = match self.mode {
            CorrectionMode::Relative => [0; 6],
            CorrectionMode::Absolute => last?.output.correction,
        };
        let rate = |place: usize, digit: f64| {
            (counts[place] - before[place]) as f64 * digit / self.cycle_s
        };
        let [length, angle] = self.digit;
        // The wire has A, B, C; they turn about z, y and x.
        let sent = [
            rate(0, length),
            rate(1, length),
            rate(2, length),
            rate(5, angle),
            rate(4, angle),
            rate(3, angle),
        ];
        let meant = cycle.trace.sent_velocity;
        let rounded = |i: usize| (sent[i] - meant[i]).abs() <= 1.5 * length / self.cycle_s;
        (0..3).all(rounded).then_some(sent)
    }
}

/// Map between the rates of the angles about x, y and z and an angular velocity in axes of M.
#[derive(Clone, Copy, Debug)]
pub struct AngleRateMap {
    sin_b: f64,
    cos_b: f64,
    sin_c: f64,
    cos_c: f64,
}

impl AngleRateMap {
    /// Half-way between two telegrams; `None` if one of them has no pose.
    pub fn between(last: &CycleRecord, cycle: &CycleRecord) -> Option<Self> {
        let (from, to) = (last.inputs.robot.pose?, cycle.inputs.robot.pose?);
        let middle = |place: usize| {
            let change = to[place] - from[place];
            to[place] - 0.5 * (change - TAU * (change / TAU).round())
        };
        let (b, c) = (middle(4), middle(5));
        let ((sin_b, cos_b), (sin_c, cos_c)) = (b.sin_cos(), c.sin_cos());
        Some(Self {
            sin_b,
            cos_b,
            sin_c,
            cos_c,
        })
    }

    /// Linear and angular velocity for these rates.
    pub fn velocity(&self, rates: &Six) -> Six {
        let [vx, vy, vz, dc, db, da] = *rates;
        [
            vx,
            vy,
            vz,
            dc - da * self.sin_b,
            db * self.cos_c + da * self.cos_b * self.sin_c,
            da * self.cos_b * self.cos_c - db * self.sin_c,
        ]
    }

    /// Rates for a linear and angular velocity. The board keeps away from B = ±90°, where the axes of A and C coincide.
    pub fn rates(&self, velocity: &Six) -> Six {
        let [vx, vy, vz, wx, wy, wz] = *velocity;
        let da = (wy * self.sin_c + wz * self.cos_c) / self.cos_b;
        let db = wy * self.cos_c - wz * self.sin_c;
        [vx, vy, vz, wx + da * self.sin_b, db, da]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_control::frames::orientation_from_abc;

    fn at([a, b, c]: [f64; 3]) -> CycleRecord {
        let mut cycle = CycleRecord::default();
        cycle.inputs.robot.pose = Some([0.0, 0.0, 0.0, a, b, c]);
        cycle
    }

    /// The velocity of rates agrees with the difference of two orientations, and gives the rates back; A passes through 180°
    /// meanwhile.
    #[test]
    fn rates_and_velocity_belong_together() {
        let (from, to) = ([PI - 0.001, -0.5, 0.6], [PI + 0.002 - TAU, -0.502, 0.604]);
        let rates = [0.1, 0.2, 0.3, 0.004, -0.002, 0.003];
        let turned = AngleRateMap::between(&at(from), &at(to)).unwrap();
        let velocity = turned.velocity(&rates);
        let [from, to] = [from, to].map(|abc| orientation_from_abc::<f64>(&abc));
        let exact = (from.inverse() * to).scaled_axis();
        for i in 0..3 {
            assert!(
                (velocity[i + 3] - exact[i]).abs() < 1e-7,
                "{velocity:?} {exact}"
            );
        }
        for (back, rate) in turned.rates(&velocity).iter().zip(rates) {
            assert!((back - rate).abs() < 1e-12);
        }
    }

    /// A rounded correction counts as rounded; one that the board did not send does not count.
    #[test]
    fn the_wire_says_what_was_sent() {
        let axes = RobotAxes::new(&Settings::default());
        let mut cycle = CycleRecord::default();
        cycle.trace.sent_velocity[0] = 0.01; // 40 µm in a cycle
        cycle.output.correction = [400, 0, 0, 100, 0, 0];
        let sent = axes.sent_rates(None, &cycle).unwrap();
        assert!((sent[0] - 0.01).abs() < 1e-12);
        assert!((sent[5] - 0.01_f64.to_radians() / 0.004).abs() < 1e-12);
        cycle.output.correction[0] = 390;
        assert_eq!(axes.sent_rates(None, &cycle), None);
    }
}
