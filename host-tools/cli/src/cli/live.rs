//! Shared code of the commands that work with a connected board.

use super::progress::Progress;
use anyhow::{Context, Result};
use softdock_commissioning::fragment::Fragment;
use softdock_commissioning::live::LiveBoard;
use softdock_io::say;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A flag that Ctrl-C raises.
pub(super) fn raised_by_ctrl_c() -> Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = flag.clone();
    ctrlc::set_handler(move || raised.store(true, Ordering::Relaxed))
        .context("cannot watch for Ctrl-C")?;
    Ok(flag)
}

/// Writes the result into the board's settings, and says what changed.
pub(super) fn upload(board: &mut LiveBoard, found: &Fragment) -> Result<()> {
    let bar = Progress::new();
    let progress = |count: u16, of: u16| {
        bar.show(f64::from(count) / f64::from(of), "reading settings");
    };
    let changes = board.write(found, progress, &mut |step| say!("{step} .."))?;
    drop(bar);
    for change in &changes {
        say!("{}: {} -> {}", change.name, change.board, change.wanted);
    }
    say!(
        "{} settings of the board changed and confirmed",
        changes.len()
    );
    Ok(())
}
