//! Standard error: output beside a result.

use std::fmt::Arguments;
use std::io::Write;

/// Writes to standard error. A reader that has gone away (`2>&1 | head`) is no error: nobody could be told.
pub fn to_standard_error(text: Arguments<'_>) {
    drop(std::io::stderr().lock().write_fmt(text));
}

/// Writes a line to standard error. `eprintln!` does the same but panics when its reader has gone away.
#[macro_export]
macro_rules! say {
    ($($text:tt)*) => {
        $crate::to_standard_error(format_args!("{}\n", format_args!($($text)*)))
    };
}
