//! The records that wait for the encoder.

use crate::board::Recorder;
use crate::record::CycleRecord;
use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_sync::zerocopy_channel::Sender;

/// Room for a record. Slots are made once, at boot, as the buffer of a
/// [`zerocopy_channel::Channel`](embassy_sync::zerocopy_channel::Channel), of 1.3 kB each: a board has six, which
/// bridge 24 ms, a process 1000.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slot {
    /// The record; `None` ends the stream.
    pub(super) record: Option<CycleRecord>,
    /// Records that had no room since boot, when this one was taken.
    pub(super) lost: u32,
}

/// The control cycle's end of the telemetry. See [the module](super) for its cost.
#[derive(Debug)]
pub struct RecordQueue<'a, M: RawMutex> {
    slots: Sender<'a, M, Slot>,
    lost: u32,
}

impl<'a, M: RawMutex> RecordQueue<'a, M> {
    /// A queue of the slots of a channel; [`encode`](super::encode) has the channel's other end.
    pub fn new(slots: Sender<'a, M, Slot>) -> Self {
        Self { slots, lost: 0 }
    }

    /// Ends the stream: the tasks send waiting records, announce the board a last time, so that the recorder also notices a loss
    /// of the last records, and return. For boards whose run ends: a process does, a microcontroller does not.
    pub async fn close(mut self) {
        *self.slots.send().await = Slot {
            record: None,
            lost: self.lost,
        };
        self.slots.send_done();
    }
}

impl<M: RawMutex> Recorder for RecordQueue<'_, M> {
    fn record(&mut self, record: &CycleRecord) {
        let Some(slot) = self.slots.try_send() else {
            self.lost = self.lost.wrapping_add(1);
            return;
        };
        slot.record = Some(*record);
        slot.lost = self.lost;
        self.slots.send_done();
    }
}
