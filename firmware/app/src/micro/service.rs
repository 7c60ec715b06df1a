//! The parameter service of a microcontroller: its memory and its start.

use super::SHARED;
use super::clock::UptimeClock;
use super::identity::Identity;
use crate::image::IMAGE_MAX_BYTES;
use crate::service::{End, IDENTITY_BYTES, Service, Session};
use crate::store::{Block, Boot, Store, Trial};
use core::fmt::Write;
use embassy_futures::block_on;
use embedded_storage_async::nor_flash::NorFlash;
use static_cell::{ConstStaticCell, StaticCell};

/// State of the service from the start of the board on.
pub struct Prepared<F: 'static> {
    session: &'static mut Session,
    store: &'static mut Store<F>,
    block: &'static mut Block,
}

/// Reads the settings to start with; `None` if called more than once. `number` differs from start to start, `crash` is the
/// message of the run before. Reading flash must not wait for anything.
pub(super) fn prepare<F: NorFlash>(
    store: &'static mut Store<F>,
    trial: Option<Trial>,
    number: u32,
    identity: &Identity,
    crash: Option<&str>,
) -> Option<(Boot, Prepared<F>)> {
    static SESSION: StaticCell<Session> = StaticCell::new();
    static BLOCK: ConstStaticCell<Block> = ConstStaticCell::new([0; IMAGE_MAX_BYTES]);
    let block = BLOCK.try_take()?;
    let boot = block_on(store.boot(trial, block));
    let mut text = heapless::String::<IDENTITY_BYTES>::new();
    // A longer one is cut off.
    let _ = write!(text, "{identity}");
    let session = SESSION.init_with(|| Session::new(&boot, number, &text));
    session.run_on(identity.processor);
    if let Some(crash) = crash {
        session.note(0, format_args!("started over after: {crash}"));
    }
    let prepared = Prepared {
        session,
        store,
        block,
    };
    Some((boot, prepared))
}

/// Runs the service on a line until the board is to restart. Returns the settings on trial, if any. `hang` is called if the board
/// is to hang instead. Must run at the lowest priority, as it formats texts and writes flash.
pub async fn serve<F: NorFlash>(
    prepared: Prepared<F>,
    reader: impl embedded_io_async::Read,
    writer: impl embedded_io_async::Write,
    hang: fn() -> !,
) -> Option<Trial> {
    let Prepared {
        session,
        store,
        block,
    } = prepared;
    let service = Service {
        shared: &SHARED,
        session,
        store,
        block,
    };
    let end = service.run(reader, writer, &UptimeClock).await;
    // The last answer is still being sent.
    embassy_time::Timer::after_millis(LINE_MS).await;
    match end {
        End::Restart(trial) => trial,
        End::Hang => hang(),
        // A board's line is never closed.
        End::Closed => core::future::pending().await,
    }
}

/// Time for the longest answer on a line of 115,200 bit/s, ms.
const LINE_MS: u64 = 150;
