//! The session on QEMU's MPS2 boards. Messages come and go through two files of the host, read and written by semihosting
//! calls, during which virtual time stands still. If virtual time counts instructions, each run does the same at the same
//! times.
//!
//! First comes a block of settings ([`softdock_app::image`]), then steps; a length of 0 ends the run. Without settings, the
//! program returns the cost of mathematical functions.
#![no_std]
#![no_main]

mod functions;

use semihosting::fs::File;
use semihosting::io::{Error, ErrorKind, Read, Result, Write};
use semihosting::process::exit;
use softdock_app::image::Image;
use softdock_lockstep::{Counter, MESSAGE_BYTES, Session, Step, frame, unframe};

/// Fixed point, as there is no floating-point unit.
#[cfg(target_abi = "eabi")]
type Number = softdock_control::scalar::Fixed;
/// The number type of the product.
#[cfg(target_abi = "eabihf")]
type Number = f64;

/// The host's files, in QEMU's working directory.
const INPUT: &core::ffi::CStr = c"to_board";
const OUTPUT: &core::ffi::CStr = c"from_board";

#[cortex_m_rt::entry]
fn main() -> ! {
    // The exit code tells the host that the conversation failed.
    exit(i32::from(converse().is_err()))
}

fn converse() -> Result<()> {
    let mut input = File::open(INPUT)?;
    let mut output = File::create(OUTPUT)?;
    let mut buffer = [0; MESSAGE_BYTES];
    let Some(settings) = next(&mut input, &mut buffer)? else {
        let costs = functions::costs(&mut Ticks);
        return output.write_all(frame(&costs, &mut buffer).map_err(|_| invalid())?);
    };
    let settings = Image::decode(settings).map_err(|_| invalid())?.settings;
    let mut session = Session::<Number>::new(&settings).map_err(|_| invalid())?;
    while let Some(message) = next(&mut input, &mut buffer)? {
        let step: Step = unframe(message).map_err(|_| invalid())?;
        let done = session.take(&step, &mut Ticks);
        output.write_all(frame(&done, &mut buffer).map_err(|_| invalid())?)?;
    }
    Ok(())
}

/// The next message; none if the host has ended the run.
fn next<'a>(input: &mut File, buffer: &'a mut [u8]) -> Result<Option<&'a [u8]>> {
    let mut length = [0; 2];
    input.read_exact(&mut length)?;
    let length = usize::from(u16::from_le_bytes(length));
    if length == 0 {
        return Ok(None);
    }
    let body = buffer.get_mut(..length).ok_or(invalid())?;
    input.read_exact(body)?;
    Ok(Some(body))
}

fn invalid() -> Error {
    ErrorKind::InvalidData.into()
}

/// The free-running counter of the board's FPGA at 25 MHz: a tick is 40 ns of virtual time.
struct Ticks;

impl Counter for Ticks {
    #[allow(unsafe_code, reason = "a register")]
    fn count(&mut self) -> u32 {
        const COUNTER: *const u32 = 0x4002_8018 as *const u32;
        // SAFETY: an aligned register of the board that may be read at any time (QEMU's
        // hw/misc/mps2-fpgaio.c).
        unsafe { COUNTER.read_volatile() }
    }
}
