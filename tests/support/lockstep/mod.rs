//! The firmware's session in QEMU, one step after the other, with virtual time that counts instructions, compared with the
//! same session on the host.

mod emulated;
mod story;

pub use emulated::{Emulated, function_costs, instructions};
pub use story::story;

use softdock_app::settings::BoardSettings;
use softdock_io::recording::Comparison;
use softdock_lockstep::{Done, Session, Step};
use softdock_rig::board::qemu::Chip;

/// A board that takes datagrams and readings.
pub trait Board {
    /// Runs a step and returns its results.
    fn take(&mut self, step: Step) -> Done;
}

impl Board for Session<f64> {
    fn take(&mut self, step: Step) -> Done {
        Session::take(self, &step, &mut ())
    }
}

/// The same session on the Cortex-M7 and on the host.
#[derive(Debug)]
pub struct Twins {
    emulated: Emulated,
    host: Session<f64>,
    judge: SameBits,
}

impl Twins {
    /// Starts both. `test` must be unique to each pair.
    ///
    /// # Panics
    /// If the settings are not valid, or the program cannot be built.
    pub fn start(test: &str, settings: &BoardSettings) -> Self {
        Self {
            emulated: Emulated::start(test, Chip::An500, settings),
            host: Session::new(settings).expect("usable settings"),
            judge: SameBits::default(),
        }
    }
}

impl Board for Twins {
    /// # Panics
    /// If a bit differs.
    fn take(&mut self, step: Step) -> Done {
        let host = Session::take(&mut self.host, &step, &mut ());
        let board = self.emulated.take(step);
        self.judge.judge(&board, &host);
        board
    }
}

/// Compares the results of the same steps.
#[derive(Debug, Default)]
pub struct SameBits {
    comparison: Comparison,
    steps: usize,
}

impl SameBits {
    /// Compares the next step.
    ///
    /// # Panics
    /// If a bit of the answers or records differs.
    pub fn judge(&mut self, board: &Done, host: &Done) {
        let n = self.steps;
        self.steps += 1;
        if let (Some(board), Some(host)) = (&board.record, &host.record)
            && let Some(difference) = self.comparison.first_difference([board, host])
        {
            panic!("step {n}, board and host: {difference:?}");
        }
        let text = |done: &Done| String::from_utf8_lossy(&done.answer).into_owned();
        assert_eq!(text(board), text(host), "step {n}");
        assert_eq!(board.record.is_some(), host.record.is_some(), "step {n}");
    }
}
