//! Runs a scenario into a recording on disk, in files of limited size.

use super::run::{RunStatistics, header, run};
use super::scenario::Scenario;
use anyhow::{Result, anyhow};
use cpu_time::ProcessTime;
use softdock_app::record::CycleRecord;
use softdock_io::recording::TruthRecord;
use softdock_io::say;
use softdock_io::telemetry::FileSeries;
use std::ops::ControlFlow;
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

/// Number of cycles that are passed to the writing thread at a time, and number of such batches that may wait.
const BATCH: usize = 256;
const QUEUED_BATCHES: usize = 64;

/// Cycles on their way to the writing thread. The thread returns the memory for reuse: the kernel would have to find and
/// clear new memory.
#[derive(Default)]
struct Batch {
    records: Vec<CycleRecord>,
    truths: Vec<TruthRecord>,
}

impl Batch {
    fn clear(&mut self) {
        self.records.clear();
        self.truths.clear();
    }
}

/// Passes cycles to the writing thread, in batches.
struct Handover {
    batch: Batch,
    queue: SyncSender<Batch>,
    /// Written batches, whose memory is reused.
    empty: Receiver<Batch>,
    /// Total time for which the simulation waited for a full queue.
    waited: Duration,
}

impl Handover {
    /// Appends a cycle. Breaks if the writing thread has ended.
    fn push(&mut self, record: &CycleRecord, truth: &TruthRecord) -> ControlFlow<()> {
        self.batch.records.push(*record);
        self.batch.truths.push(*truth);
        if self.batch.records.len() < BATCH {
            return ControlFlow::Continue(());
        }
        let next = self.empty.try_recv().unwrap_or_default();
        let full = std::mem::replace(&mut self.batch, next);
        self.batch.clear();
        let before = Instant::now();
        let sent = self.queue.send(full);
        self.waited += before.elapsed();
        // The queue is closed if writing failed; the thread returns the error.
        match sent {
            Ok(()) => ControlFlow::Continue(()),
            Err(_) => ControlFlow::Break(()),
        }
    }

    /// Passes on the remaining cycles. Returns the time spent waiting.
    fn finish(self) -> Duration {
        let _ = self.queue.send(self.batch);
        self.waited
    }
}

/// Writes batches until the queue is closed, and returns each batch for reuse.
fn write(
    series: &mut FileSeries,
    batches: Receiver<Batch>,
    give_back: &Sender<Batch>,
) -> Result<()> {
    for batch in batches {
        for (record, truth) in batch.records.iter().zip(&batch.truths) {
            series.push(record, Some(truth))?;
            for warning in series.take_warnings() {
                say!("{warning}");
            }
        }
        let _ = give_back.send(batch);
    }
    series.finish()
}

/// Runs a scenario and records it. `on_cycle` sees each cycle and decides whether the run goes on. A separate thread writes
/// the file; the time for which the simulation waits for it is not counted as the simulation's.
///
/// # Errors
/// The scenario cannot be run, or the file cannot be written.
pub fn record_file(
    scenario: &Scenario,
    series: &mut FileSeries,
    on_cycle: &mut dyn FnMut(&CycleRecord, &TruthRecord) -> ControlFlow<()>,
) -> Result<RunStatistics> {
    let begin = ProcessTime::now();
    series.begin(header(scenario)?)?;
    let (queue, batches) = sync_channel::<Batch>(QUEUED_BATCHES);
    let (give_back, empty) = channel();
    thread::scope(|scope| {
        let disk = scope.spawn(move || write(series, batches, &give_back));
        let mut handover = Handover {
            batch: Batch::default(),
            queue,
            empty,
            waited: Duration::ZERO,
        };
        let statistics = run(scenario, &mut |record, truth| {
            let goes_on = on_cycle(record, truth);
            match handover.push(record, truth) {
                ControlFlow::Continue(()) => goes_on,
                ended => ended,
            }
        });
        let waited = handover.finish();
        let written = disk
            .join()
            .map_err(|_| anyhow!("the writing thread ended unexpectedly"))?;
        written.and(statistics.map(|statistics| RunStatistics {
            elapsed: statistics.elapsed.saturating_sub(waited),
            processor: begin.elapsed(),
            ..statistics
        }))
    })
}
