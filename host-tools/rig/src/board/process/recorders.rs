//! Where the record of each cycle goes.

use super::Shared;
use super::clock::RealClock;
use super::telemetry::{self, Telemetry};
use anyhow::{Result, anyhow};
use softdock_app::board::Recorder;
use softdock_app::record::CycleRecord;
use softdock_io::say;
use std::sync::Arc;
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::thread::{self, JoinHandle};

/// Records that wait for the recorder: 4 s of cycles, for a disk that takes its time.
const RECORD_QUEUE: usize = 1000;

/// Receiver of the records, on a thread of its own.
pub type Record = Box<dyn FnOnce(&mut dyn Iterator<Item = CycleRecord>) -> Result<()> + Send>;

/// Those who get the record of each cycle.
pub(super) struct Recorders {
    pub(super) file: QueueRecorder,
    pub(super) telemetry: Option<telemetry::Queue>,
}

/// The threads behind the recorders.
pub(super) struct Writers {
    file: JoinHandle<Result<()>>,
    telemetry: Option<JoinHandle<()>>,
}

impl Writers {
    /// Waits for the threads, which end when the recorders are dropped.
    pub(super) fn join(self) -> Result<()> {
        if let Some(telemetry) = self.telemetry {
            joined(telemetry, "telemetry")?;
        }
        joined(self.file, "recorder")?
    }
}

/// Result of a thread.
fn joined<T>(thread: JoinHandle<T>, whose: &str) -> Result<T> {
    let gave = thread.join();
    gave.map_err(|_| anyhow!("the {whose}'s thread ended unexpectedly"))
}

impl Recorders {
    /// Starts them.
    pub(super) fn start(
        record: Record,
        telemetry: Option<Telemetry>,
        clock: &RealClock,
        shared: &Arc<Shared>,
    ) -> (Self, Writers) {
        let (file, writer) = start_recorder(record);
        let start = |telemetry: Telemetry| telemetry.start(clock.clone(), shared.clone());
        let (telemetry, sender) = telemetry.map(start).unzip();
        let writers = Writers {
            file: writer,
            telemetry: sender,
        };
        (Self { file, telemetry }, writers)
    }

    /// After the last record.
    pub(super) async fn close(self) {
        if let Some(telemetry) = self.telemetry {
            telemetry.close().await;
        }
    }
}

impl Recorder for Recorders {
    fn record(&mut self, record: &CycleRecord) {
        self.file.record(record);
        if let Some(telemetry) = &mut self.telemetry {
            telemetry.record(record);
        }
    }
}

/// Hands records to the recorder's thread; a full queue loses the record, never the cycle.
pub(super) struct QueueRecorder {
    queue: SyncSender<CycleRecord>,
    lost: u64,
}

impl Recorder for QueueRecorder {
    fn record(&mut self, record: &CycleRecord) {
        if let Err(TrySendError::Full(_)) = self.queue.try_send(*record) {
            self.lost += 1;
        }
    }
}

impl Drop for QueueRecorder {
    fn drop(&mut self) {
        if self.lost > 0 {
            say!(
                "board: {} records were lost: the recorder was too slow",
                self.lost
            );
        }
    }
}

/// A thread that writes records until the queue's sender is gone. An error of the recorder stops
/// the recording, not the board.
fn start_recorder(record: Record) -> (QueueRecorder, JoinHandle<Result<()>>) {
    let (queue, records) = sync_channel(RECORD_QUEUE);
    let writer = thread::spawn(move || {
        let mut records = records.into_iter();
        let outcome = record(&mut records);
        if let Err(error) = &outcome {
            say!("board: the recording ends here, the board goes on: {error:#}");
        }
        records.for_each(drop);
        outcome
    });
    (QueueRecorder { queue, lost: 0 }, writer)
}
