//! Detects frames for which a driver's queue had no room. The interrupt of embassy-stm32 0.6 takes frames out of the controller
//! and silently drops those that do not fit into the queue of the sensor's task. Therefore the frames taken out are counted here
//! as well.

/// Elements of a FIFO of the controller.
const DEPTH: u8 = 3;

/// A FIFO of the controller: how many frames wait in it, and which of its elements is the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fifo {
    /// Frames that wait, 3 at most.
    pub fill: u8,
    /// Index of the next one, 0 to 2.
    pub next: u8,
}

impl Fifo {
    /// Frames that were taken out between this state and `after`. It includes frames that arrived in between, if there were at
    /// most two: on a bus of 1 Mbit/s each takes 47 µs.
    pub fn frames_taken_until(self, after: Self) -> u32 {
        let moved = (after.next + DEPTH).wrapping_sub(self.next);
        let came = (moved + DEPTH).wrapping_sub(self.fill) % DEPTH;
        u32::from(self.fill + came)
    }
}

/// Number of frames that the sensor's task has received.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Handed(u32);

impl Handed {
    /// It got a frame.
    pub fn count(&mut self) {
        self.0 = self.0.wrapping_add(1);
    }

    /// Whether frames were dropped since the last call. To be called when the queue is empty; `taken` is the number of frames
    /// taken out since boot, read before the queue was found empty.
    pub fn misses(&mut self, taken: u32) -> bool {
        let missing = taken != self.0;
        self.0 = taken;
        missing
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_taken_out_is_counted_whatever_comes_meanwhile() {
        for next in 0..DEPTH {
            for fill in 0..=DEPTH {
                for came in 0..DEPTH {
                    let before = Fifo { fill, next };
                    let after = Fifo {
                        fill: 0,
                        next: (next + fill + came) % DEPTH,
                    };
                    assert_eq!(
                        before.frames_taken_until(after),
                        u32::from(fill + came),
                        "{before:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn what_was_taken_out_and_not_handed_over_is_missed_once() {
        let mut handed = Handed(u32::MAX - 1);
        for _ in 0..3 {
            handed.count();
        }
        assert!(!handed.misses(1));
        handed.count();
        assert!(handed.misses(4), "of three it got one");
        assert!(!handed.misses(4));
    }
}
