//! The log of a machine with one axis that follows its commands, with the force that this needs.

use softdock_app::record::CycleRecord;
use softdock_io::recording::{Header, Recording};
use softdock_statistics::RandomStream;

/// An oscillating axis.
#[derive(Clone, Copy, Debug)]
pub struct OneAxis {
    /// Cycle time, s.
    pub cycle_s: f64,
    /// Whether it turns about x instead of sliding along it.
    pub turns: bool,
    /// Oscillations that do not repeat together: amplitude in m or rad, and rad/s.
    pub swings: [(f64, f64); 3],
    /// Noise of the position, m or rad, and of the force, N or N·m.
    pub noise: (f64, f64),
    /// Time from the command of a force to its effect, s.
    pub late_s: f64,
}

impl OneAxis {
    /// Position, velocity and acceleration at a time.
    fn motion(&self, t: f64, phase: f64) -> [f64; 3] {
        self.swings
            .iter()
            .fold([0.0; 3], |[x, v, a], (size, rate)| {
                let (sin, cos) = (rate * t + phase * rate).sin_cos();
                [
                    x + size * sin,
                    v + size * rate * cos,
                    a - size * rate * rate * sin,
                ]
            })
    }

    /// Records a log. `force` gives N or N·m from the motion and is called row by row. The velocity is the difference of two
    /// positions.
    pub fn record(
        &self,
        seconds: f64,
        phase: f64,
        seed: u64,
        mut force: impl FnMut([f64; 3]) -> f64,
    ) -> Recording {
        let axis = if self.turns { 3 } else { 0 };
        let mut random = RandomStream::new(seed, 0);
        let mut last = None;
        let record = |n: usize| {
            let t = n as f64 * self.cycle_s;
            let (motion, later) = (self.motion(t, phase), self.motion(t + self.late_s, phase));
            let position = motion[0] + self.noise.0 * random.normal();
            let mut cycle = CycleRecord::default();
            cycle.trace.cycle = n as u64;
            cycle.trace.time_s = t;
            cycle.trace.pose = self.pose(position);
            let before = last
                .replace(position)
                .unwrap_or(position - motion[1] * self.cycle_s);
            cycle.trace.executed_velocity[axis] = (position - before) / self.cycle_s;
            cycle.inputs.sensor.wrench = [0.0; 6];
            cycle.inputs.sensor.wrench[axis] = -force(later) + self.noise.1 * random.normal();
            cycle
        };
        Recording {
            header: Header {
                identity: "imported from a test".to_owned(),
                settings_toml: String::new(),
                ..Header::default()
            },
            cycles: (0..(seconds / self.cycle_s) as usize).map(record).collect(),
            ..Recording::default()
        }
    }

    /// Position and quaternion.
    fn pose(&self, position: f64) -> [f64; 7] {
        if !self.turns {
            return [position, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
        }
        let (sin, cos) = (0.5 * position).sin_cos();
        [0.0, 0.0, 0.0, cos, sin, 0.0, 0.0]
    }
}
