//! A motion from which the robot's delay can be identified: the jog of the commissioning.
//!
//! One axis rests, moves forward with a velocity that switches between two levels at pseudo-random times, returns with the same
//! velocities reversed, then moves to and fro, and rests at its start. Within each of the first two parts the velocity keeps its
//! sign, so that a pause at a zero crossing acts only between them; the last part has many reversals. Both strokes begin and end
//! slowly, so that no jump of the velocity is larger than [`LARGEST_JUMP`]. The whole sequence is known before it begins.

/// Cycles of rest before and after.
const REST: u32 = 50;
/// Shortest and longest hold of a level, cycles.
const HOLDS: [u32; 2] = [3, 9];
/// The same in the part to and fro.
const REVERSALS: [u32; 2] = [12, 24];
/// Cycles of the part to and fro.
const TO_AND_FRO: u32 = 216;
/// Levels over the mean speed: those of the two strokes, and that of the part to and fro.
const LEVELS: [f64; 2] = [0.4, 1.6];
const REVERSED: f64 = 0.9;

/// Fewest and most cycles of the forward stroke: a shorter one has too few jumps of the velocity, and the part to and fro would
/// go farther than it.
pub const FORWARD: [u32; 2] = [125, 2500];
/// Fastest level over the mean speed.
pub const FASTEST: f64 = LEVELS[1];
/// Largest change of the velocity from one cycle to the next over the mean speed: a reversal.
pub const LARGEST_JUMP: f64 = 2.0 * REVERSED;

/// The velocities of a jog, one per cycle.
#[derive(Clone, Debug)]
pub struct Excitation {
    mean_speed: f64,
    /// Cycles of the forward stroke.
    forward: u32,
    part: Part,
    /// Cycles that are left of the part, and of the present level.
    left: u32,
    hold: u32,
    level: f64,
    /// Length of the last hold forward in the part to and fro.
    forward_hold: u32,
    /// State of the pseudo-random numbers at the start, and now.
    seed: u32,
    random: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    RestBefore,
    Forward,
    Back,
    ToAndFro,
    RestAfter,
    Over,
}

impl Excitation {
    /// A jog with this mean speed, m/s or rad/s, whose sign is the direction, and a forward stroke of so many cycles, clamped to
    /// [`FORWARD`]. The same `seed` gives the same jog.
    pub fn new(mean_speed: f64, forward: u32, seed: u32) -> Self {
        // The generator would never leave the state zero.
        let seed = seed.wrapping_mul(0x9e37_79b9).max(1);
        Self {
            mean_speed,
            forward: forward.clamp(FORWARD[0], FORWARD[1]),
            part: Part::RestBefore,
            left: REST,
            hold: 0,
            level: 0.0,
            forward_hold: 0,
            seed,
            random: seed,
        }
    }

    /// Cycles of the whole jog.
    pub fn cycles(&self) -> u32 {
        2 * REST + 2 * self.forward + TO_AND_FRO
    }

    /// Upper bound of the distance from the start, m or rad, of a stroke of so many cycles with this mean speed: that of the
    /// faster level throughout.
    pub fn reach(mean_speed: f64, forward: u32, cycle_s: f64) -> f64 {
        mean_speed * FASTEST * f64::from(forward) * cycle_s
    }

    /// Velocity of the next cycle, m/s or rad/s; `None` when the jog is over.
    pub fn next_velocity(&mut self) -> Option<f64> {
        while self.left == 0 {
            self.begin_next();
        }
        if self.part == Part::Over {
            return None;
        }
        if self.hold == 0 {
            self.choose();
        }
        self.left -= 1;
        self.hold = self.hold.saturating_sub(1);
        Some(self.level * self.mean_speed)
    }

    fn begin_next(&mut self) {
        (self.part, self.left) = match self.part {
            Part::RestBefore => (Part::Forward, self.forward),
            Part::Forward => {
                // The return stroke draws the same numbers as the forward stroke, and so ends where that began.
                self.random = self.seed;
                (Part::Back, self.forward)
            }
            Part::Back => (Part::ToAndFro, TO_AND_FRO),
            Part::ToAndFro => (Part::RestAfter, REST),
            Part::RestAfter | Part::Over => (Part::Over, u32::MAX),
        };
        self.hold = 0;
    }

    /// The next level and how long it is held.
    fn choose(&mut self) {
        let (level, holds) = match self.part {
            Part::RestBefore | Part::RestAfter | Part::Over => (0.0, [u32::MAX; 2]),
            Part::Forward => (self.stroke_level(), HOLDS),
            Part::Back => (-self.stroke_level(), HOLDS),
            // Every second hold is as long as the one before it, in the other direction.
            Part::ToAndFro if self.level > 0.0 => {
                self.level = -REVERSED;
                self.hold = self.forward_hold;
                return;
            }
            Part::ToAndFro => (REVERSED, REVERSALS),
        };
        self.level = level;
        let span = holds[1] - holds[0] + 1;
        self.hold = match span {
            0 | 1 => holds[0],
            _ => holds[0] + self.draw() % span,
        };
        if self.part == Part::ToAndFro {
            // The remaining cycles have to hold both directions.
            self.hold = self.hold.min(self.left / 2).max(1);
            self.forward_hold = self.hold;
        }
    }

    /// A level of the forward or return stroke: slow at both ends, where the last hold may be cut short.
    fn stroke_level(&mut self) -> f64 {
        let inside = self.left < self.forward && self.left > HOLDS[1];
        LEVELS[usize::from(inside && self.draw() & 1 == 1)]
    }

    /// The next pseudo-random number (Marsaglia's xorshift, 13 17 5).
    fn draw(&mut self) -> u32 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 17;
        self.random ^= self.random << 5;
        // The high bits are the better ones.
        self.random >> 8
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    const SPEED: f64 = 0.02;

    fn jog(forward: u32, seed: u32) -> Vec<f64> {
        let mut excitation = Excitation::new(SPEED, forward, seed);
        let cycles = excitation.cycles();
        let jog: Vec<f64> = core::iter::from_fn(|| excitation.next_velocity()).collect();
        assert_eq!(jog.len() as u32, cycles);
        jog
    }

    #[test]
    fn a_jog_ends_where_it_began_and_keeps_within_its_reach() {
        for seed in 0..200 {
            for forward in [FORWARD[0], 390, FORWARD[1]] {
                let jog = jog(forward, seed);
                let (mut place, mut least, mut most) = (0.0_f64, 0.0_f64, 0.0_f64);
                for velocity in &jog {
                    place += velocity * 0.004;
                    (least, most) = (least.min(place), most.max(place));
                }
                assert!(place.abs() < 1e-12, "seed {seed}: {place}");
                assert!(least > -1e-12, "seed {seed}: {least} on the other side");
                let reach = Excitation::reach(SPEED, forward, 0.004);
                // Farther than with the slower level alone.
                let slowest = reach * LEVELS[0] / LEVELS[1];
                assert!(most <= reach && most > slowest, "{most} of {reach}");
                let ends = jog[..50].iter().chain(&jog[jog.len() - 50..]);
                assert!(ends.into_iter().all(|v| *v == 0.0));
            }
        }
    }

    #[test]
    fn no_jump_and_no_speed_is_larger_than_said() {
        for seed in 0..200 {
            let jog = jog(390, seed);
            for pair in jog.windows(2) {
                let jump = (pair[1] - pair[0]).abs();
                assert!(jump <= LARGEST_JUMP * SPEED * (1.0 + 1e-12), "{jump}");
            }
            let fastest = jog.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            assert_eq!(fastest, FASTEST * SPEED, "seed {seed}");
        }
    }

    #[test]
    fn the_first_two_parts_have_one_direction_each_and_the_last_has_many() {
        let jog = jog(390, 3);
        assert!(jog[50..440].iter().all(|v| *v > 0.0));
        assert!(jog[440..830].iter().all(|v| *v < 0.0));
        let signs = jog[830..].windows(2).filter(|w| w[0] * w[1] < 0.0);
        assert!(signs.count() >= 5);
    }

    /// What identifies a delay: levels and times that do not repeat. In 200 strokes each level takes about half of the time,
    /// holds of every length occur, and no two strokes are equal.
    #[test]
    fn levels_and_their_times_are_irregular() {
        let forward = 390;
        let mut strokes: Vec<Vec<bool>> = Vec::new();
        let mut holds = [0; HOLDS[1] as usize + 1];
        for seed in 0..200 {
            let jog = jog(forward, seed);
            let fast: Vec<bool> = jog[50..][..forward as usize]
                .iter()
                .map(|v| *v > SPEED)
                .collect();
            let share = fast.iter().filter(|f| **f).count() as f64 / f64::from(forward);
            assert!((0.25..0.75).contains(&share), "seed {seed}: {share}");
            let runs: Vec<usize> = fast.chunk_by(|a, b| a == b).map(<[bool]>::len).collect();
            // The last takes what is left.
            for run in &runs[..runs.len() - 1] {
                if let Some(count) = holds.get_mut(*run) {
                    *count += 1;
                }
            }
            assert!(!strokes.contains(&fast), "seed {seed}");
            strokes.push(fast);
        }
        let [shortest, longest] = HOLDS.map(|hold| hold as usize);
        let seen = &holds[shortest..=longest];
        assert!(seen.iter().all(|count| *count > 200), "{holds:?}");
        assert!(holds[..shortest].iter().all(|count| *count == 0));
    }

    /// Each direction lasts long enough for a drive that reverses slowly.
    #[test]
    fn to_and_fro_no_direction_is_short() {
        let jog = jog(390, 1);
        let part = &jog[830..][..TO_AND_FRO as usize];
        let runs: Vec<usize> = part.chunk_by(|a, b| a == b).map(<[f64]>::len).collect();
        // The last two take what is left.
        let whole = &runs[..runs.len().saturating_sub(2)];
        let range = REVERSALS[0] as usize..=REVERSALS[1] as usize;
        assert!(whole.iter().all(|run| range.contains(run)), "{runs:?}");
    }
}
