//! The telemetry of one boot, written into recordings.

use super::assembly::Assembly;
use super::budget::Budget;
use super::stream_file::{FileSummary, Losses, StreamFile};
use super::window::Window;
use crate::recording::Header;
use anyhow::Result;
use softdock_app::image::Image;
use softdock_app::record::CycleRecord;
use softdock_app::telemetry::{Announcement, Kind, MessagePart, read_machine, read_record, schema};
use std::path::Path;

/// Cycles that are held back until the settings come, which are announced every second: 20 s, about 7 MB. Beyond that they
/// are written without settings.
const HELD: usize = 5000;

/// The board's announcement of itself.
struct Announced {
    /// Its bytes: if they change, the settings have changed.
    message: Vec<u8>,
    identity: String,
    /// Header of the recording, or why the settings cannot be read.
    header: Result<Header, String>,
}

/// The stream of one boot of one board.
pub(super) struct Stream {
    boot: u32,
    /// Pairs of a datagram's head and its payload.
    window: Window<(MessagePart<'static>, Vec<u8>)>,
    assembly: Assembly,
    announced: Option<Announced>,
    /// Schema of the records, if this program cannot read it.
    other_schema: Option<u32>,
    /// Records with the right schema that could not be read.
    unreadable: u64,
    /// Last value of the board's counter of lost records.
    lost_counter: Option<u32>,
    lost_on_board: u64,
    held: Vec<CycleRecord>,
    /// Cycles for which no file was allowed.
    dropped: u64,
    /// The cycle that was received last.
    pub(super) newest: Option<CycleRecord>,
    file: Option<StreamFile>,
    finished: Vec<FileSummary>,
    /// Remarks for the operator that were not taken yet.
    pub(super) notes: Vec<String>,
}

impl Stream {
    pub(super) fn new(boot: u32) -> Self {
        Self {
            boot,
            window: Window::default(),
            assembly: Assembly::default(),
            announced: None,
            other_schema: None,
            unreadable: 0,
            lost_counter: None,
            lost_on_board: 0,
            held: Vec::new(),
            dropped: 0,
            newest: None,
            file: None,
            finished: Vec::new(),
            notes: Vec::new(),
        }
    }

    pub(super) fn boot(&self) -> u32 {
        self.boot
    }

    /// Datagrams that came twice or too late.
    pub(super) fn repeated(&self) -> u64 {
        self.window.repeated()
    }

    /// Identity of the firmware; None before it was announced.
    pub(super) fn identity(&self) -> Option<&str> {
        let announced = self.announced.as_ref()?;
        Some(&announced.identity)
    }

    /// Summaries of the files so far.
    pub(super) fn files(&self) -> impl Iterator<Item = FileSummary> + '_ {
        let open = self.file.as_ref();
        let open = open.map(|file| file.summary(self.losses()));
        self.finished.iter().cloned().chain(open)
    }

    /// Why this program cannot record the stream; None if it can, or the sender is not known yet.
    pub(super) fn refusal(&self) -> Option<String> {
        let announced = self.announced.as_ref()?;
        if let Some(received) = self.other_schema {
            let expected = schema();
            return Some(format!(
                "its records have schema {received:08x}, those of this program {expected:08x}"
            ));
        }
        announced.header.as_ref().err().cloned()
    }

    /// Takes a datagram.
    pub(super) fn push(&mut self, part: &MessagePart<'_>, budget: &mut Budget) -> Result<()> {
        let payload = part.payload.to_vec();
        let head = MessagePart {
            payload: &[],
            ..*part
        };
        self.window.push(part.sequence, (head, payload));
        self.advance(false, budget)
    }

    /// Writes everything that is in order. With `give_up` it does not wait for missing datagrams.
    pub(super) fn advance(&mut self, give_up: bool, budget: &mut Budget) -> Result<()> {
        while let Some((head, payload)) = self.window.take(give_up) {
            let counter = self.lost_counter.replace(head.lost).unwrap_or(head.lost);
            self.lost_on_board += u64::from(head.lost.wrapping_sub(counter));
            self.other_schema = (head.schema != schema()).then_some(head.schema);
            let part = MessagePart {
                payload: &payload,
                ..head
            };
            match self.assembly.push(&part) {
                Some((Kind::Announcement, message)) => self.announce(message, budget)?,
                Some((Kind::Record, message)) if self.other_schema.is_none() => {
                    self.record(&message, budget)?;
                }
                Some((Kind::Machine, message)) => {
                    if let (Ok(machine), Some(file)) = (read_machine(&message), &mut self.file) {
                        file.note_machine(machine);
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn announce(&mut self, message: Vec<u8>, budget: &mut Budget) -> Result<()> {
        let known = self.announced.as_ref();
        if known.is_some_and(|known| known.message == message) {
            return Ok(());
        }
        let Ok(Announcement { image, identity }) = Announcement::read(&message) else {
            self.unreadable += 1;
            return Ok(());
        };
        let identity = identity.to_owned();
        let header = header(image, &identity);
        self.announced = Some(Announced {
            header: header.map_err(|error| format!("{error:#}")),
            identity,
            message,
        });
        if let Some(file) = self.file.take() {
            let losses = self.losses();
            self.finished.push(file.finish(losses, budget)?);
            self.notes.push(
                "the board's settings are others from here on: the next cycles get a file of \
                 their own"
                    .to_owned(),
            );
        }
        match self.held.is_empty() {
            true => Ok(()),
            false => self.open(budget).map(drop),
        }
    }

    fn record(&mut self, message: &[u8], budget: &mut Budget) -> Result<()> {
        let Ok(record) = read_record(message) else {
            self.unreadable += 1;
            return Ok(());
        };
        self.newest = Some(record);
        if self.file.as_ref().is_some_and(|file| file.is_full(budget)) {
            self.go_on(budget)?;
        }
        if let Some(file) = &mut self.file {
            return file.push(&record, budget);
        }
        self.held.push(record);
        match self.announced.is_some() || self.held.len() >= HELD {
            true => self.open(budget),
            false => Ok(()),
        }
    }

    /// Begins a file and writes the cycles that were held back. If no file is allowed, they are dropped.
    fn open(&mut self, budget: &mut Budget) -> Result<()> {
        let first = self.finished.is_empty();
        let Some(path) = budget.begin_file() else {
            if self.dropped == 0 {
                self.notes.push(format!(
                    "boot {:08x} is not recorded: as many files as are allowed were begun; start `softdock record` anew",
                    self.boot
                ));
            }
            self.dropped += self.held.len() as u64;
            self.held.clear();
            return Ok(());
        };
        let before = match first {
            // Losses before the first file lie among the cycles that were held back for it.
            true => Losses::default(),
            false => self.losses(),
        };
        let mut file = self.create(&path, false, before)?;
        for record in self.held.drain(..) {
            file.push(&record, budget)?;
        }
        self.file = Some(file);
        Ok(())
    }

    /// Ends the file, which has reached its limit, and begins the next one.
    fn go_on(&mut self, budget: &mut Budget) -> Result<()> {
        let losses = self.losses();
        if let Some(file) = self.file.take() {
            self.finished.push(file.finish(losses, budget)?);
        }
        self.file = Some(self.create(&budget.next_file(), true, losses)?);
        Ok(())
    }

    fn create(&mut self, path: &Path, continues: bool, before: Losses) -> Result<StreamFile> {
        let announced = self.announced.as_ref();
        let header = announced.and_then(|announced| announced.header.as_ref().ok());
        let file = StreamFile::create(path, self.boot, header, continues, before)?;
        self.notes.push(format!(
            "boot {:08x} of {}: recording into {}",
            self.boot,
            self.identity().unwrap_or("a board without a name"),
            path.display()
        ));
        Ok(file)
    }

    /// Ends the stream: writes all that came, without what is missing. Returns the files, the number of cycles for which no
    /// file was allowed, and the first error.
    pub(super) fn finish(mut self, budget: &mut Budget) -> (Vec<FileSummary>, u64, Result<()>) {
        let mut outcome = self.advance(true, budget);
        self.assembly.tear();
        if !self.held.is_empty() {
            outcome = outcome.and(self.open(budget));
        }
        let losses = self.losses();
        if let Some(file) = self.file.take() {
            let so_far = file.summary(losses);
            let ended = file.finish(losses, budget);
            self.finished.push(so_far);
            outcome = outcome.and(ended.map(drop));
        }
        (self.finished, self.dropped, outcome)
    }

    fn losses(&self) -> Losses {
        Losses {
            on_board: self.lost_on_board,
            datagrams: self.window.lost(),
            torn: self.assembly.torn() + self.unreadable,
        }
    }
}

/// Header of a recording with the settings in this image.
fn header(image: &[u8], identity: &str) -> Result<Header> {
    let settings = Image::decode(image)?.settings;
    Ok(Header {
        identity: identity.to_owned(),
        settings_toml: toml_edit::ser::to_string_pretty(&settings)?,
        ..Header::default()
    })
}
