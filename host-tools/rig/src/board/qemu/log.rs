//! The firmware's log as text: the board sends numbers, the text stands in its ELF file.

use anyhow::{Context, Result, anyhow};
use defmt_decoder::{DecodeError, Frame, Table};
use softdock_io::say;
use std::io::Read;
use std::path::Path;

/// The firmware's last line before robot and sensor may come.
const READY: &str = "ready";

/// The decoder.
pub(super) struct Log {
    table: Table,
}

impl Log {
    /// Reads the texts of an ELF file.
    ///
    /// # Errors
    /// It has none.
    pub(super) fn of(elf: &Path) -> Result<Self> {
        let bytes = std::fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))?;
        let table = Table::parse(&bytes)
            .with_context(|| format!("in {}", elf.display()))?
            .ok_or_else(|| anyhow!("{} has no texts for its log", elf.display()))?;
        Ok(Self { table })
    }

    /// Writes lines to standard error until the stream ends; and `addresses` as soon as the
    /// firmware serves them.
    ///
    /// # Errors
    /// The stream cannot be read.
    pub(super) fn print(&self, mut stream: impl Read, addresses: &str) -> Result<()> {
        let mut decoder = self.table.new_stream_decoder();
        let mut buffer = [0; 1024];
        let mut announced = false;
        loop {
            let length = stream.read(&mut buffer).context("cannot read the log")?;
            if length == 0 {
                return Ok(());
            }
            decoder.received(&buffer[..length]);
            loop {
                match decoder.decode() {
                    Ok(frame) => {
                        say!("board: {}", line(&frame));
                        if !announced && frame.display_message().to_string() == READY {
                            say!("board: {addresses}");
                            announced = true;
                        }
                    }
                    Err(DecodeError::UnexpectedEof) => break,
                    // The next line is readable again.
                    Err(DecodeError::Malformed) => say!("board: (a damaged line of the log)"),
                }
            }
        }
    }
}

/// Time since boot in seconds, level, message.
fn line(frame: &Frame<'_>) -> String {
    let time = frame
        .display_timestamp()
        .map(|time| time.to_string())
        .unwrap_or_default();
    let level = frame.level().map_or("", |level| level.as_str());
    format!("{time:>12} {level:<5} {}", frame.display_message())
}
