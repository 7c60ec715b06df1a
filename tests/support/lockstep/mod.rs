//! The firmware's session in QEMU, one step after the other, with virtual time that counts
//! instructions, beside the same session on the host.

mod emulated;
mod story;

pub use emulated::{Emulated, instructions};
pub use story::story;
