//! The commands of one axis in its transport delay.

/// All commands of a run; each is held from its arrival to the arrival of the next.
#[derive(Clone, Debug)]
pub(super) struct Pipeline {
    delay_s: f64,
    cycle_s: f64,
    commands: Vec<f64>,
    /// Number of cycles by which the command read at an arrival is newer than the one due (jitter).
    shifts: Vec<i8>,
}

impl Pipeline {
    pub(super) fn new(delay_s: f64, cycle_s: f64) -> Self {
        Self {
            delay_s,
            cycle_s,
            commands: Vec::new(),
            shifts: Vec::new(),
        }
    }

    /// Appends the command of the next cycle, and its jitter.
    pub(super) fn push(&mut self, command: f64, shift: i8) {
        self.commands.push(command);
        self.shifts.push(shift);
    }

    /// The newest command; zero before the first.
    pub(super) fn newest(&self) -> f64 {
        self.commands.last().copied().unwrap_or(0.0)
    }

    /// Arrival of the command of a cycle, s.
    pub(super) fn edge_s(&self, cycle: usize) -> f64 {
        cycle as f64 * self.cycle_s + self.delay_s
    }

    /// The command that acts after the arrival of a cycle. If jitter asks for a command that was not sent yet, it is the
    /// newest one.
    pub(super) fn after_edge(&self, cycle: usize) -> f64 {
        let shift = self.shifts.get(cycle).copied().unwrap_or(0);
        let newest = self.commands.len() as i64 - 1;
        let due = (cycle as i64 + i64::from(shift)).min(newest);
        usize::try_from(due).map_or(0.0, |due| self.commands[due])
    }
}
