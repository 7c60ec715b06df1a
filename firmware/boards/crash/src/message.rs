//! A message in memory that outlives a reset.
#![allow(unsafe_code, reason = "one static outside of .bss, see `Store`")]

use core::cell::UnsafeCell;
use core::fmt::{Arguments, Write};
use core::mem::MaybeUninit;

/// Longest message, bytes; the rest of a longer one is cut off.
pub const MESSAGE_BYTES: usize = 240;
/// Marks memory that holds a message: after power-up it holds anything.
const MAGIC: u32 = 0x4352_5348;

/// A message of the run before.
pub type Message = heapless::String<MESSAGE_BYTES>;

/// Memory that start-up code neither clears nor fills.
#[repr(C)]
struct Kept {
    magic: u32,
    length: usize,
    text: [u8; MESSAGE_BYTES],
}

struct Store(UnsafeCell<MaybeUninit<Kept>>);

// SAFETY: there is one core, and nobody is interrupted in here: `keep` runs with interrupts off or
// in a fault handler, `take_message` in a critical section.
unsafe impl Sync for Store {}

#[unsafe(link_section = ".uninit.SOFTDOCK_CRASH")]
static STORE: Store = Store(UnsafeCell::new(MaybeUninit::uninit()));

/// Keeps a message, unless there is one already: the first is the cause.
pub(crate) fn keep(arguments: Arguments<'_>) {
    let mut message = Message::new();
    let _ = Cut(&mut message).write_fmt(arguments);
    let kept = STORE.0.get().cast::<Kept>();
    // SAFETY: `kept` is valid and aligned, any bytes are a `Kept`, and nobody else uses it, see
    // `Store`. Volatile, as what is read here was written before the reset.
    unsafe {
        if (&raw const (*kept).magic).read_volatile() == MAGIC {
            return;
        }
        let mut text = [0; MESSAGE_BYTES];
        for (byte, value) in text.iter_mut().zip(message.as_bytes()) {
            *byte = *value;
        }
        kept.write_volatile(Kept {
            magic: MAGIC,
            length: message.len(),
            text,
        });
    }
}

/// Takes the message of the run before, if it ended with one.
pub fn take_message() -> Option<Message> {
    let Kept {
        magic,
        length,
        text,
    } = cortex_m::interrupt::free(|_| {
        let kept = STORE.0.get().cast::<Kept>();
        // SAFETY: as in `keep`.
        unsafe {
            let found = kept.read_volatile();
            (&raw mut (*kept).magic).write_volatile(0);
            found
        }
    });
    let text = text.get(..length).filter(|_| magic == MAGIC)?;
    let text = core::str::from_utf8(text).ok()?;
    Message::try_from(text).ok()
}

/// Writes what there is room for, on one line.
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
