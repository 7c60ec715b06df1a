//! Where the record of each cycle goes.

use super::telemetry;
use anyhow::Result;
use softdock_app::board::Recorder;
use softdock_app::record::CycleRecord;
use softdock_io::say;
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::thread;

/// Records that wait for the recorder: 4 s of cycles, for a disk that takes its time.
const RECORD_QUEUE: usize = 1000;

/// Gets the records as they come, on a thread of its own.
pub type Record = Box<dyn FnOnce(&mut dyn Iterator<Item = CycleRecord>) -> Result<()> + Send>;

/// Those who get the record of each cycle.
pub(super) struct Recorders {
    pub(super) file: QueueRecorder,
    pub(super) telemetry: Option<telemetry::Queue>,
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
pub(super) fn start_recorder(record: Record) -> (QueueRecorder, thread::JoinHandle<Result<()>>) {
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
