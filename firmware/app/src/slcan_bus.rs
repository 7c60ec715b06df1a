//! A CAN bus behind a serial line: the board is an SLCAN adapter, and the client at the other end plays the bus. For boards
//! without a CAN controller, and for tests.

use crate::board::{IoError, SensorBus};
use embassy_futures::select::{Either, select};
use embedded_io_async::{Read, Write};
use heapless::{Deque, Vec};
use softdock_link::can::Frame;
use softdock_link::slcan::{MAX_LINE_BYTES, Slcan, SlcanEvent};

/// Bytes that are taken from the line at once.
const INPUT_BYTES: usize = 64;
/// Bytes that may wait for the line: eight frames.
const OUTPUT_BYTES: usize = 8 * MAX_LINE_BYTES;

/// The bus. Reader and writer are the two directions of one line; their `read` and `write` must
/// lose nothing when they are dropped, as those of a buffered port do.
#[derive(Debug)]
pub struct SlcanBus<R, W> {
    reader: R,
    writer: W,
    adapter: Slcan,
    input: Vec<u8, INPUT_BYTES>,
    /// Bytes of `input` that the adapter has seen.
    seen: usize,
    output: Deque<u8, OUTPUT_BYTES>,
}

impl<R: Read, W: Write> SlcanBus<R, W> {
    /// A bus with a closed channel.
    pub fn new(reader: R, writer: W) -> Self {
        Self {
            reader,
            writer,
            adapter: Slcan::new(),
            input: Vec::new(),
            seen: 0,
            output: Deque::new(),
        }
    }

    /// The next frame in what was read already.
    fn next_frame(&mut self) -> Option<Frame> {
        while let Some(byte) = self.input.get(self.seen) {
            self.seen += 1;
            let output = &mut self.output;
            let event = self.adapter.push(*byte, &mut |reply| {
                // Replies that a client does not read are dropped.
                let _ = queue(output, reply);
            });
            if let Some(SlcanEvent::Frame(frame)) = event {
                return Some(frame);
            }
        }
        None
    }

    /// Reads input and writes pending output at the same time; writing has priority, so that a flood from the client does not
    /// delay the answers.
    async fn exchange(&mut self) -> Result<(), IoError> {
        let mut bytes = [0; INPUT_BYTES];
        let read = self.reader.read(&mut bytes);
        let (waiting, _) = self.output.as_slices();
        let outcome = match waiting.is_empty() {
            true => Either::Second(read.await),
            false => select(self.writer.write(waiting), read).await,
        };
        match outcome {
            Either::First(written) => {
                self.written(written.map_err(|_| IoError::Lost)?);
            }
            Either::Second(Ok(0)) => return Err(IoError::Closed),
            Either::Second(Ok(length)) => {
                self.input =
                    Vec::from_slice(bytes.get(..length).unwrap_or_default()).unwrap_or_default();
                self.seen = 0;
            }
            Either::Second(Err(_)) => return Err(IoError::Lost),
        }
        Ok(())
    }

    /// Removes bytes that were written.
    fn written(&mut self, length: usize) {
        for _ in 0..length {
            self.output.pop_front();
        }
    }
}

impl<R: Read, W: Write> SensorBus for SlcanBus<R, W> {
    type Frame = Frame;

    async fn send(&mut self, frame: &Frame) -> Result<(), IoError> {
        let mut line = Vec::<u8, MAX_LINE_BYTES>::new();
        if self.adapter.encode(frame, &mut line).is_err() {
            // With a closed channel the frame is not acknowledged, which the driver's timeout reports.
            return Ok(());
        }
        while !queue(&mut self.output, &line) {
            let (waiting, _) = self.output.as_slices();
            let written = self.writer.write(waiting).await;
            self.written(written.map_err(|_| IoError::Lost)?);
        }
        Ok(())
    }

    async fn receive(&mut self) -> Result<Frame, IoError> {
        loop {
            if let Some(frame) = self.next_frame() {
                return Ok(frame);
            }
            self.exchange().await?;
        }
    }

    async fn recover(&mut self) -> Result<(), IoError> {
        Ok(())
    }
}

/// Appends a line if there is room for all of it, as half a line would corrupt the next one. Returns whether it was appended.
fn queue(output: &mut Deque<u8, OUTPUT_BYTES>, line: &[u8]) -> bool {
    let room = output.capacity() - output.len() >= line.len();
    if room {
        for byte in line {
            let _ = output.push_back(*byte);
        }
    }
    room
}
