//! The commands of one axis on their way through the transport delay.

/// All commands of a run, each held from its arrival to the next one's.
#[derive(Clone, Debug)]
pub(super) struct Pipeline {
    delay_s: f64,
    cycle_s: f64,
    commands: Vec<f64>,
    /// Cycles by which the command that is read at an edge is newer than the one due.
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

    /// The command of the next cycle.
    pub(super) fn push(&mut self, command: f64, shift: i8) {
        self.commands.push(command);
        self.shifts.push(shift);
    }

    /// The newest command; zero before the first.
    pub(super) fn newest(&self) -> f64 {
        self.commands.last().copied().unwrap_or(0.0)
    }

    /// When the command of a cycle arrives, s.
    pub(super) fn edge_s(&self, cycle: usize) -> f64 {
        cycle as f64 * self.cycle_s + self.delay_s
    }

    /// What is executed after the edge of a cycle. A command that is not there yet is replaced by
    /// the newest one.
    pub(super) fn after_edge(&self, cycle: usize) -> f64 {
        let shift = self.shifts.get(cycle).copied().unwrap_or(0);
        let newest = self.commands.len() as i64 - 1;
        let due = (cycle as i64 + i64::from(shift)).min(newest);
        usize::try_from(due).map_or(0.0, |due| self.commands[due])
    }
}
