//! Canned excitations: what the rig does while a picture is taken.

use std::f64::consts::TAU;

/// Time between two points of a simulated picture, s.
pub(super) const STEP_S: f64 = 0.0005;
/// Time for which a command is held, s.
pub(super) const CYCLE_S: f64 = 0.004;
/// Steps in a cycle.
pub(super) const STEPS_PER_CYCLE: usize = 8;

/// Kinds of excitation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Excitation {
    /// A step of the velocity, a slow reversal and a stop.
    VelocityReversal,
    /// Sliding to and fro without contact.
    Slide,
    /// A bounce of the tip off a wall, as a stiff robot executes it.
    Bounce,
    /// Slow motion between two walls, into each of them.
    BothWalls,
    /// Slow turning of the sensor with its tool by half a turn, without contact.
    TiltSweep,
    /// A minute without motion.
    StillLog,
    /// Two short pushes on the simulated spacecraft, which floats freely.
    Push,
    /// Jogs of constant velocity.
    SteadyJog,
}

impl Excitation {
    /// What happens, in words.
    pub const fn describe(self) -> &'static str {
        match self {
            Self::VelocityReversal => "a velocity step, a slow reversal, a stop",
            Self::Slide => "sliding to and fro without contact",
            Self::Bounce => "a bounce off a wall",
            Self::BothWalls => "slow motion between two walls, into each of them",
            Self::TiltSweep => "slow turning of the sensor by half a turn, without contact",
            Self::StillLog => "a minute without motion",
            Self::Push => "two short pushes on the floating spacecraft",
            Self::SteadyJog => "jogs of constant velocity",
        }
    }
}

/// Instants of a simulated picture of this length, s.
pub(super) fn instants(duration_s: f64) -> impl Iterator<Item = f64> {
    let steps = (duration_s / STEP_S).round() as u32;
    (0..=steps).map(|k| f64::from(k) * STEP_S)
}

/// Length of [`reversal_command`], s.
pub(super) const REVERSAL_S: f64 = 0.7;

/// Command (m/s) of [`Excitation::VelocityReversal`], held for a cycle.
pub(super) fn reversal_command(time_s: f64) -> f64 {
    let held = (time_s / CYCLE_S + 1e-6).floor() * CYCLE_S;
    match held {
        t if t < 0.04 => 0.0,
        t if t < 0.2 => 0.02,
        t if t < 0.4 => 0.02 - 0.2 * (t - 0.2),
        t if t < 0.55 => -0.02,
        _ => 0.0,
    }
}

/// Position (m), velocity (m/s) and acceleration (m/s²).
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    pub(super) position: f64,
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
}

/// Length of two periods of [`slide`], s.
pub(super) const SLIDE_S: f64 = 2.0;

/// [`Excitation::Slide`]: 3 mm to each side, once per second, 19 mm/s at most.
pub(super) fn slide(time_s: f64) -> Motion {
    let (amplitude, rate) = (0.003, TAU);
    let (sin, cos) = (rate * time_s).sin_cos();
    Motion {
        position: amplitude * sin,
        velocity: amplitude * rate * cos,
        acceleration: -amplitude * rate * rate * sin,
    }
}

/// Stiffness of the wall in [`bounce`], N/m.
pub(super) const WALL_N_PER_M: f64 = 5000.0;
/// Length of [`bounce`], s.
pub(super) const BOUNCE_S: f64 = 0.5;

/// [`Excitation::Bounce`]: penetration (negative outside) of 50 kg that meet the wall at 30 mm/s.
pub(super) fn bounce(time_s: f64) -> Motion {
    let (speed, rate, touch_s) = (0.03, 10.0, 0.09);
    let phase = rate * (time_s - touch_s);
    let half_turn = TAU / 2.0;
    let beyond = phase - phase.clamp(0.0, half_turn);
    let (sin, cos) = phase.clamp(0.0, half_turn).sin_cos();
    // Outside, the tip moves on with the speed that it has at touch.
    Motion {
        position: (sin + cos * beyond) * speed / rate,
        velocity: cos * speed,
        acceleration: if beyond == 0.0 {
            -sin * speed * rate
        } else {
            0.0
        },
    }
}

/// Force of the nominal wall on the tip in [`bounce`], N, as push.
pub(super) fn wall_push(penetration_m: f64) -> f64 {
    WALL_N_PER_M * penetration_m.max(0.0)
}

/// Distance of each wall of [`Excitation::BothWalls`] from the middle, m.
pub(super) const WALL_AT_M: f64 = 0.02;

/// Positions (m) of [`Excitation::BothWalls`].
pub(super) fn between_walls() -> impl Iterator<Item = f64> {
    (-240..=240).map(|k| f64::from(k) * 1e-4)
}

/// Angles (rad) of [`Excitation::TiltSweep`].
pub(super) fn tilts() -> impl Iterator<Item = f64> {
    (0..=180).map(|degree| f64::from(degree - 90).to_radians())
}

/// Length of [`push`], s.
pub(super) const PUSH_S: f64 = 4.0;

/// Force (N) or torque (N·m) of [`Excitation::Push`].
pub(super) fn push(time_s: f64) -> f64 {
    match time_s {
        t if (0.3..0.7).contains(&t) => 20.0,
        t if (2.3..2.5).contains(&t) => -20.0,
        _ => 0.0,
    }
}

/// Length of [`steady_jog`], s.
pub(super) const JOG_S: f64 = 1.2;

/// Velocity (m/s) of [`Excitation::SteadyJog`].
pub(super) fn steady_jog(time_s: f64) -> f64 {
    match time_s {
        t if t < 0.2 => 0.0,
        t if t < 0.6 => 0.005,
        t if t < 1.0 => 0.02,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Velocity and acceleration are the derivatives of position and velocity.
    #[test]
    fn motions_are_consistent() {
        for motion in [slide, bounce] {
            let h = 1e-6;
            for t in (1..450).map(|k| f64::from(k) / 1000.0 + 3e-4) {
                let (a, b, m) = (motion(t - h), motion(t + h), motion(t));
                let velocity = (b.position - a.position) / (2.0 * h);
                let acceleration = (b.velocity - a.velocity) / (2.0 * h);
                assert!((velocity - m.velocity).abs() < 1e-7, "{t}");
                assert!((acceleration - m.acceleration).abs() < 1e-4, "{t}");
            }
        }
    }
}
