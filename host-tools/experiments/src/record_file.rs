//! Runs a scenario into a recording on disk, in files of a bounded size.

use super::run::{RunStatistics, header, run};
use super::scenario::Scenario;
use anyhow::{Result, anyhow};
use cpu_time::ProcessTime;
use softdock_app::record::CycleRecord;
use softdock_io::recording::TruthRecord;
use softdock_io::say;
use softdock_io::telemetry::Pieces;
use std::ops::ControlFlow;
use std::sync::mpsc::{channel, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

/// Cycles that are handed to the writing thread at a time, and how many such batches may wait.
const BATCH: usize = 256;
const QUEUED_BATCHES: usize = 64;

/// Cycles on their way to the writing thread. It gives their memory back: what is new to a program, the kernel has to
/// find and to clear first.
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

/// Runs and records; `on_cycle` sees each cycle and says whether there is to be another. A thread of its own writes the file; the time for which
/// the simulation waits for it is not the simulation's.
///
/// # Errors
/// The scenario cannot be run, or the file cannot be written.
pub fn record_file(
    scenario: &Scenario,
    pieces: &mut Pieces,
    on_cycle: &mut dyn FnMut(&CycleRecord, &TruthRecord) -> ControlFlow<()>,
) -> Result<RunStatistics> {
    let begin = ProcessTime::now();
    pieces.begin(header(scenario)?)?;
    let (queue, batches) = sync_channel::<Batch>(QUEUED_BATCHES);
    let (give_back, empty) = channel();
    thread::scope(|scope| {
        let disk = scope.spawn(move || -> Result<()> {
            for batch in batches {
                for (record, truth) in batch.records.iter().zip(&batch.truths) {
                    pieces.push(record, Some(truth))?;
                    for warning in pieces.take_warnings() {
                        say!("{warning}");
                    }
                }
                let _ = give_back.send(batch);
            }
            pieces.finish()
        });
        let mut batch = Batch::default();
        let mut waited = Duration::ZERO;
        let statistics = run(scenario, &mut |record, truth| {
            let goes_on = on_cycle(record, truth);
            batch.records.push(*record);
            batch.truths.push(*truth);
            if batch.records.len() < BATCH {
                return goes_on;
            }
            let full = std::mem::replace(&mut batch, empty.try_recv().unwrap_or_default());
            batch.clear();
            let before = Instant::now();
            let sent = queue.send(full);
            waited += before.elapsed();
            // The queue is closed when the disk failed; the thread says why.
            match sent {
                Ok(()) => goes_on,
                Err(_) => ControlFlow::Break(()),
            }
        });
        let _ = queue.send(batch);
        drop(queue);
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
