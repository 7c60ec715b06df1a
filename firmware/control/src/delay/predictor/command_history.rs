//! The velocities that were sent, as far back as the longest dead time needs.

use super::V6;
use super::tuning::*;

/// The velocities commanded in the last cycles.
#[derive(Clone, Debug)]
pub(super) struct CommandHistory {
    ring: [V6; COMMAND_HISTORY],
    /// Number of the next command.
    pub(super) next: usize,
}

impl CommandHistory {
    pub(super) fn new() -> Self {
        Self {
            ring: [V6::zeros(); COMMAND_HISTORY],
            next: 0,
        }
    }

    pub(super) fn push(&mut self, velocity: &V6) {
        if let Some(slot) = self.ring.get_mut(self.next % COMMAND_HISTORY) {
            *slot = *velocity;
        }
        self.next += 1;
    }

    /// The command that is executed in a cycle after a delay; zero before the first, and the newest
    /// one in place of one that is not sent yet.
    pub(super) fn of(&self, cycle: usize, delay: usize) -> V6 {
        let Some(cycle) = cycle.checked_sub(delay) else {
            return V6::zeros();
        };
        let cycle = cycle.min(self.next.saturating_sub(1));
        let kept = cycle + COMMAND_HISTORY >= self.next;
        let slot = self.ring.get(cycle % COMMAND_HISTORY).filter(|_| kept);
        slot.copied().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The last 76 are kept; before the first one the command is zero, and one that is not sent yet is replaced by the newest.
    #[test]
    fn commands_are_remembered_for_as_long_as_the_longest_dead_time() {
        let mut commands = CommandHistory::new();
        assert_eq!(commands.of(0, 0), V6::zeros());
        for n in 0..200 {
            commands.push(&V6::from_fn(|axis, _| f64::from(n) + axis as f64 / 8.0));
        }
        for (cycle, delay, newest) in [
            (199, 0, Some(199)),
            (230, 2, Some(199)),
            (230, 40, Some(190)),
            (199, 75, Some(124)),
            (199, 76, None),
            (10, 20, None),
        ] {
            let expected =
                |axis: usize, _| newest.map_or(0.0, |n| f64::from(n) + axis as f64 / 8.0);
            assert_eq!(commands.of(cycle, delay), V6::from_fn(expected));
        }
    }
}
