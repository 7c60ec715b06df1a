//! The parameter service: a host on the board's serial line lists, reads and changes settings, reads the board's state, and gives
//! an operator's commands.
//!
//! [`Session`] decides; it takes frames and returns frames. [`Service::run`] is the task around it, with line, flash and clock.
//! It runs at the lowest priority of a board, and the control cycle never waits for it: it reads the shared state under short
//! locks, and puts commands into the queue from which each cycle takes one.
//!
//! Settings take effect when the board restarts, as everything built from them is then built anew. The task ends for that; how a
//! board restarts depends on the board.

mod log;
mod session;
mod state;

pub use log::Log;
pub use session::{IDENTITY_BYTES, Job, Now, Outcome, Session};

use crate::board::Clock;
use crate::shared::{Leds, Shared};
use crate::store::{Block, Origin, Store, Trial};
use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::raw::RawMutex;
use embedded_io_async::{Read, Write};
use embedded_storage_async::nor_flash::NorFlash;
use softdock_link::service::{FrameReader, LAMPS_S, Refusal, SelfTest};

/// Period of the check of log and trial, µs.
const PERIOD_US: u64 = 50_000;
/// Longest time for an answer on the line, µs: 1 kB takes 0.1 s at 115,200 bit/s. A host that does not read must not delay the
/// end of a trial.
const WRITE_US: u64 = 2_000_000;
/// Longest time for the sensor's task to test its bus, µs: nine frames of 2 ms at worst.
const BUS_TEST_US: u64 = 200_000;
/// Bytes that are taken from the line at once.
const INPUT_BYTES: usize = 64;

/// Why the service ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The board is to start over, with settings on trial if there are any.
    Restart(Option<Trial>),
    /// The board is to hang, so that its watchdog shows that it works.
    Hang,
    /// The line is gone for good.
    Closed,
}

/// What the service works on.
pub struct Service<'a, M: RawMutex, F> {
    /// State shared with the other tasks.
    pub shared: &'a Shared<M>,
    /// Its state.
    pub session: &'a mut Session,
    /// The settings in flash.
    pub store: &'a mut Store<F>,
    /// Room for a block of settings.
    pub block: &'a mut Block,
}

impl<M: RawMutex, F: NorFlash> Service<'_, M, F> {
    /// Runs until the board is to start over. Reader and writer are the two directions of the line;
    /// their `read` and `write` lose nothing when they are dropped.
    pub async fn run(
        mut self,
        mut reader: impl Read,
        mut writer: impl Write,
        clock: &impl Clock,
    ) -> End {
        let mut frames = FrameReader::new();
        let mut bytes = [0; INPUT_BYTES];
        loop {
            let now = self.now(clock);
            self.session.watch(&now);
            if self.session.trial_is_over(&now) && self.holds_still(clock).await {
                return End::Restart(None);
            }
            let pause = clock.wait_until(now.us + PERIOD_US);
            let length = match select(reader.read(&mut bytes), pause).await {
                Either::First(Ok(0)) => return End::Closed,
                Either::First(Ok(length)) => length,
                // Bytes were lost; the frame that they belong to is damaged.
                Either::First(Err(_)) | Either::Second(()) => continue,
            };
            for byte in bytes.get(..length).unwrap_or_default() {
                let outcome = match frames.push(*byte) {
                    None => continue,
                    Some(Err(_)) => {
                        self.session.count_damaged();
                        continue;
                    }
                    Some(Ok(frame)) => {
                        let now = self.now(clock);
                        self.session.take(&frame, &now, self.block)
                    }
                };
                let end = match outcome {
                    Outcome::Ignore => continue,
                    Outcome::Answer => None,
                    Outcome::Job(job) => self.carry_out(job, clock).await,
                };
                let answer = writer.write_all(self.session.line());
                select(answer, clock.wait_until(clock.now_us() + WRITE_US)).await;
                if let Some(end) = end {
                    return end;
                }
            }
        }
    }

    fn now(&self, clock: &impl Clock) -> Now {
        Now {
            us: clock.now_us(),
            status: self.shared.status(),
        }
    }

    /// Carries out a job that needs flash or the other tasks; the session then has the answer. `Some`: the service ends with it.
    /// It is never cancelled half-way.
    async fn carry_out(&mut self, job: Job, clock: &impl Clock) -> Option<End> {
        match job {
            Job::Operator(command) => {
                let sent = self.shared.commands.try_send(command);
                self.session.finish(sent.map_err(|_| Refusal::Busy));
                None
            }
            Job::Confirm(trial) => {
                let kept = self.store.confirm(&trial, self.block).await;
                self.session.confirmed(kept);
                None
            }
            Job::Previous => {
                let origin = *self.session.origin();
                let previous = self.store.previous(&origin, self.block).await;
                self.session.previous(previous);
                None
            }
            Job::Slots => {
                let slots = self.store.slots(self.block).await;
                self.session.slots(&slots);
                None
            }
            Job::Machine => {
                self.session.machine(&self.shared.machine());
                None
            }
            Job::EndTrial => self.ends_with(End::Restart(None), clock).await,
            Job::SelfTest(test) => self.self_test(test, clock).await,
            Job::Commit { confirm_within_s } => self.commit(confirm_within_s, clock).await,
        }
    }

    async fn self_test(&mut self, test: SelfTest, clock: &impl Clock) -> Option<End> {
        match test {
            SelfTest::Can => {
                self.shared.bus_tested.reset();
                self.shared.bus_test.signal(());
                let too_late = clock.wait_until(clock.now_us() + BUS_TEST_US);
                let outcome = match select(self.shared.bus_tested.wait(), too_late).await {
                    Either::First(outcome) => outcome,
                    Either::Second(()) => None,
                };
                self.shared.bus_test.reset();
                self.session.loop_back(outcome);
                None
            }
            SelfTest::Lamps(lit) => {
                let until_us = clock.now_us() + u64::from(LAMPS_S) * 1_000_000;
                self.shared
                    .light(lit.map(|lit| (Leds::from(lit), until_us)));
                self.session.finish(Ok(()));
                None
            }
            SelfTest::Hang => self.ends_with(End::Hang, clock).await,
        }
    }

    /// Whether the robot rests, and stays at rest: from here on it takes no command that could begin a motion, and the effect of
    /// an earlier one shows after a cycle. If it moves, commands are taken again.
    async fn holds_still(&mut self, clock: &impl Clock) -> bool {
        self.shared.set_restarting(true);
        clock.wait_until(clock.now_us() + PERIOD_US).await;
        let rests = !self.session.moves(&self.now(clock));
        self.shared.set_restarting(rests);
        rests
    }

    async fn ends_with(&mut self, end: End, clock: &impl Clock) -> Option<End> {
        if self.holds_still(clock).await {
            self.session.restarting();
            return Some(end);
        }
        self.session.finish(Err(Refusal::Moves));
        None
    }

    async fn commit(&mut self, confirm_within_s: u16, clock: &impl Clock) -> Option<End> {
        let origin = *self.session.origin();
        let draft = self.session.draft()?;
        // From here on the robot task takes no command that could begin a motion.
        self.shared.set_restarting(true);
        let written = self
            .store
            .write(draft, &origin, confirm_within_s, self.block)
            .await;
        // A motion that began before shows by now: writing takes longer than a cycle.
        let now = self.now(clock);
        match written {
            Ok(trial) if !self.session.moves(&now) => {
                self.session.restarting();
                Some(End::Restart(Some(trial)))
            }
            Ok(_) => {
                self.shared.set_restarting(false);
                self.session.finish(Err(Refusal::Moves));
                None
            }
            Err(error) => {
                self.shared.set_restarting(false);
                self.session.failed(&error);
                None
            }
        }
    }
}

/// Sequence number of settings that are kept or on trial; 0 for defaults.
pub fn sequence(origin: &Origin) -> u32 {
    match origin {
        Origin::Flash { sequence, .. } => *sequence,
        Origin::Trial(trial) => trial.sequence,
        Origin::Defaults(_) => 0,
    }
}

#[cfg(test)]
mod tests;
