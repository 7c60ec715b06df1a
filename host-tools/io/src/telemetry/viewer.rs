//! Passes on what a board sends, as it comes, without recording it.

use super::assembly::Assembly;
use super::window::Window;
use softdock_app::record::CycleRecord;
use softdock_app::telemetry::{Announcement, Kind, MessagePart, read_machine, read_record, schema};
use softdock_link::service::Machine;

/// A message of a board.
#[derive(Clone, Debug)]
pub enum BoardMessage {
    /// The firmware's identity.
    Firmware(String),
    /// A cycle.
    Cycle(Box<CycleRecord>),
    /// The board's measurements of itself.
    Machine(Box<Machine>),
}

/// Reads the datagrams of one board. Another boot starts anew.
#[derive(Debug, Default)]
pub struct Viewer {
    boot: Option<u32>,
    window: Window<(MessagePart<'static>, Vec<u8>)>,
    assembly: Assembly,
    /// The board's own counter of records that it dropped for lack of room.
    lost_on_board: u32,
    /// Datagrams that are not of softdock, damaged, or of another version.
    unreadable: u64,
}

impl Viewer {
    /// Takes a datagram; `see` is called with each message that it completes.
    pub fn accept(&mut self, datagram: &[u8], see: &mut dyn FnMut(BoardMessage)) {
        let part = match MessagePart::read(datagram) {
            Ok(part) if part.schema == schema() => part,
            _ => {
                self.unreadable += 1;
                return;
            }
        };
        if self.boot != Some(part.boot) {
            *self = Self {
                boot: Some(part.boot),
                unreadable: self.unreadable,
                ..Self::default()
            };
        }
        let head = MessagePart {
            payload: &[],
            ..part
        };
        self.window
            .push(part.sequence, (head, part.payload.to_vec()));
        self.advance(false, see);
    }

    /// Called when nothing has come for a while: gives up the datagrams that are missing.
    pub fn give_up_missing(&mut self, see: &mut dyn FnMut(BoardMessage)) {
        self.advance(true, see);
    }

    /// Numbers of messages that the board dropped, of datagrams lost or records torn on the network, and of unreadable
    /// datagrams.
    pub fn losses(&self) -> [u64; 3] {
        let torn = self.window.lost() + self.assembly.torn();
        [u64::from(self.lost_on_board), torn, self.unreadable]
    }

    fn advance(&mut self, give_up: bool, see: &mut dyn FnMut(BoardMessage)) {
        while let Some((head, payload)) = self.window.take(give_up) {
            self.lost_on_board = head.lost;
            let part = MessagePart {
                payload: &payload,
                ..head
            };
            let seen = match self.assembly.push(&part) {
                Some((Kind::Announcement, message)) => Announcement::read(&message)
                    .ok()
                    .map(|announced| BoardMessage::Firmware(announced.identity.to_owned())),
                Some((Kind::Record, message)) => read_record(&message)
                    .ok()
                    .map(|r| BoardMessage::Cycle(Box::new(r))),
                Some((Kind::Machine, message)) => read_machine(&message)
                    .ok()
                    .map(|m| BoardMessage::Machine(Box::new(m))),
                None => None,
            };
            seen.into_iter().for_each(&mut *see);
        }
    }
}
