//! The service's thread.

use super::Shared;
use super::clock::RealClock;
use super::line::Line;
use crate::board::block_on::block_on;
use crate::board::flash::FileFlash;
use softdock_app::service::{End, Service, Session};
use softdock_app::store::{Block, Boot, Store};
use std::hash::{BuildHasher, Hasher, RandomState};

/// Runs the service of a board that has started with `boot` until it is to start over or the line is
/// closed.
pub(super) fn run(
    shared: &Shared,
    boot: &Boot,
    line: Line,
    clock: &RealClock,
    store: &mut Store<FileFlash>,
    block: &mut Block,
    identity: &str,
) -> End {
    let mut session = Session::new(boot, boot_number(), identity);
    let service = Service {
        shared,
        session: &mut session,
        store,
        block,
    };
    let (reader, writer) = line.halves();
    block_on(service.run(reader, writer, clock))
}

/// A number that no other boot has: the keys of a hash map are drawn at random.
fn boot_number() -> u32 {
    RandomState::new().build_hasher().finish() as u32
}
