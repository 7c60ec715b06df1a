//! A question on the terminal.

use anyhow::{Result, bail};
use softdock_io::to_standard_error;
use std::io::BufRead;

/// Asks, and fails with `otherwise` unless the answer is yes.
pub(super) fn agree(question: &str, otherwise: &str) -> Result<()> {
    to_standard_error(format_args!("{question} [y/N] "));
    let mut answer = String::new();
    std::io::stdin().lock().read_line(&mut answer)?;
    match answer.trim().to_lowercase().as_str() {
        "y" | "yes" => Ok(()),
        _ => bail!("{otherwise}"),
    }
}
