//! A question on the terminal.

use anyhow::{Result, bail};
use std::io::{BufRead, Write};

/// Asks, and fails with `otherwise` unless the answer is yes.
pub(super) fn agree(question: &str, otherwise: &str) -> Result<()> {
    eprint!("{question} [y/N] ");
    std::io::stderr().flush()?;
    let mut answer = String::new();
    std::io::stdin().lock().read_line(&mut answer)?;
    match answer.trim().to_lowercase().as_str() {
        "y" | "yes" => Ok(()),
        _ => bail!("{otherwise}"),
    }
}
