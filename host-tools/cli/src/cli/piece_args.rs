//! Options that bound the files of a recording.

use anyhow::{Result, ensure};
use clap::Args;
use softdock_io::telemetry::Bounds;

/// What a recording may take.
#[derive(Clone, Copy, Debug, Args)]
pub(super) struct PieceArgs {
    /// End each file after so many MB and go on in the next; they are replayed together
    #[arg(long, value_name = "MB", default_value_t = PieceArgs::default().piece_mb)]
    piece_mb: u64,
    /// Likewise after so many cycles (15000 are a minute at 4 ms)
    #[arg(long, value_name = "N")]
    piece_cycles: Option<u64>,
    /// End the recording after so many GB in all
    #[arg(long, value_name = "GB", default_value_t = PieceArgs::default().max_gb)]
    max_gb: u64,
}

impl Default for PieceArgs {
    fn default() -> Self {
        Self {
            piece_mb: 1024,
            piece_cycles: None,
            max_gb: 100,
        }
    }
}

impl PieceArgs {
    pub(super) fn bounds(&self) -> Result<Bounds> {
        for (name, value) in [
            ("--piece-mb", self.piece_mb),
            ("--piece-cycles", self.piece_cycles.unwrap_or(1)),
            ("--max-gb", self.max_gb),
        ] {
            ensure!(
                (1..=1_000_000_000).contains(&value),
                "{name} is {value}; expected is at least 1, at most 1000000000"
            );
        }
        let usual = Bounds::default();
        Ok(Bounds {
            file_bytes: self.piece_mb << 20,
            file_cycles: self.piece_cycles.unwrap_or(usual.file_cycles),
            total_bytes: self.max_gb << 30,
            ..usual
        })
    }
}
