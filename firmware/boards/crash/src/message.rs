//! A message in memory whose content survives a reset.
#![allow(unsafe_code, reason = "a static outside of .bss, see `Memory`")]

use crate::memory::Memory;
use core::fmt::{Arguments, Write};

/// Longest message, bytes; the rest of a longer one is cut off.
pub const MESSAGE_BYTES: usize = 240;
/// Marks memory that holds a message: after power-up the content is arbitrary.
const MAGIC: [u8; 4] = *b"CRSH";
/// Magic, length, text.
const KEPT_BYTES: usize = 8 + MESSAGE_BYTES;

/// A message of the previous run.
pub type Message = heapless::String<MESSAGE_BYTES>;

#[unsafe(link_section = ".retained.SOFTDOCK_CRASH")]
static MEMORY: Memory<KEPT_BYTES> = Memory::new();

/// Keeps a message, unless there already is one: the first tells the cause. To be called with interrupts off, or in a fault
/// handler.
pub(crate) fn keep(arguments: Arguments<'_>) {
    if MEMORY.read().starts_with(&MAGIC) {
        return;
    }
    let mut message = Message::new();
    let _ = Cut(&mut message).write_fmt(arguments);
    let mut kept = [0; KEPT_BYTES];
    let length = (message.len() as u32).to_ne_bytes();
    let bytes = MAGIC.iter().chain(&length).chain(message.as_bytes());
    for (byte, value) in kept.iter_mut().zip(bytes) {
        *byte = *value;
    }
    MEMORY.write(&kept);
}

/// Takes the message of the previous run, if it left one.
pub fn take_message() -> Option<Message> {
    let kept = cortex_m::interrupt::free(|_| {
        let kept = MEMORY.read();
        MEMORY.write(&[0; KEPT_BYTES]);
        kept
    });
    let (magic, rest) = kept.split_first_chunk::<4>()?;
    let (length, text) = rest.split_first_chunk::<4>()?;
    let length = usize::try_from(u32::from_ne_bytes(*length)).ok()?;
    let text = text.get(..length).filter(|_| *magic == MAGIC)?;
    Message::try_from(core::str::from_utf8(text).ok()?).ok()
}

/// Writes as much as there is room for, on one line.
struct Cut<'a>(&'a mut Message);

impl Write for Cut<'_> {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        for character in text.chars() {
            let character = match character {
                '\n' => ' ',
                other => other,
            };
            self.0.push(character).map_err(|_| core::fmt::Error)?;
        }
        Ok(())
    }
}
