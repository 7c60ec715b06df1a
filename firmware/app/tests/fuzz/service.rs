//! A host's conversation with the parameter service, down to the flash.

use core::cell::Cell;
use embassy_futures::block_on;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embedded_io_async::{ErrorKind, ErrorType, Read, Write};
use embedded_storage_async::nor_flash::NorFlashErrorKind;
use softdock_app::board::Clock;
use softdock_app::image::{IMAGE_MAX_BYTES, Image, schema};
use softdock_app::service::{End, Service, Session};
use softdock_app::settings::BoardSettings;
use softdock_app::shared::Shared;
use softdock_app::store::{FlashWords, Store, WORD_BYTES, WordFlash};
use softdock_link::service::{Frame, FrameReader, Kind, PROTOCOL};

const SLOT: usize = 8192;

/// Two slots in memory.
struct Words(Vec<u8>);

impl FlashWords for &mut Words {
    const SLOT_BYTES: usize = SLOT;

    fn read_word(&mut self, offset: usize) -> Result<[u8; WORD_BYTES], NorFlashErrorKind> {
        let word = self.0.get(offset..offset + WORD_BYTES);
        let word = word.and_then(|word| word.try_into().ok());
        word.ok_or(NorFlashErrorKind::OutOfBounds)
    }

    async fn write_word(
        &mut self,
        offset: usize,
        word: &[u8; WORD_BYTES],
    ) -> Result<(), NorFlashErrorKind> {
        let place = &mut self.0[offset..offset + WORD_BYTES];
        if place.iter().any(|byte| *byte != 0xff) {
            return Err(NorFlashErrorKind::Other);
        }
        place.copy_from_slice(word);
        Ok(())
    }

    async fn erase_slot(&mut self, offset: usize) -> Result<(), NorFlashErrorKind> {
        self.0[offset..offset + SLOT].fill(0xff);
        Ok(())
    }
}

/// What the host sends; then the line ends.
struct Input(Vec<u8>);
/// What it receives.
struct Output<'a>(&'a mut Vec<u8>);

impl ErrorType for Input {
    type Error = ErrorKind;
}

impl Read for Input {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, ErrorKind> {
        let length = self.0.len().min(buffer.len());
        buffer[..length].copy_from_slice(&self.0[..length]);
        self.0.drain(..length);
        Ok(length)
    }
}

impl ErrorType for Output<'_> {
    type Error = ErrorKind;
}

impl Write for Output<'_> {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
        self.0.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    async fn flush(&mut self) -> Result<(), ErrorKind> {
        Ok(())
    }
}

/// Time that passes when somebody waits for it.
struct Quick(Cell<u64>);

impl Clock for Quick {
    fn now_us(&self) -> u64 {
        self.0.get()
    }

    async fn wait_until(&self, at_us: u64) {
        self.0.set(at_us.max(self.0.get()));
    }
}

/// The bytes as pieces: a length, and a frame's payload; or, with an odd length, bytes of the line.
fn line(input: &[u8]) -> Vec<u8> {
    let (mut line, mut rest) = (Vec::new(), input);
    for sequence in 1.. {
        let Some((length, tail)) = rest.split_first() else {
            break;
        };
        let (piece, tail) = tail.split_at(usize::from(length / 2).min(tail.len()));
        rest = tail;
        if length % 2 == 1 {
            line.extend_from_slice(piece);
            continue;
        }
        let frame = Frame {
            version: PROTOCOL,
            kind: Kind::Request,
            sequence,
            schema: schema(),
            payload: piece,
        };
        line.extend_from_slice(&frame.encode().unwrap());
    }
    line
}

/// Whatever is said: answers are frames, and the next start finds settings that may be used.
pub(crate) fn service_session(input: &[u8]) {
    let mut flash = Words(vec![0xff; 2 * SLOT]);
    let mut kept = BoardSettings::default();
    kept.rsi.robot_ip = "any".try_into().unwrap();
    let image = Image {
        sequence: 1,
        settings: kept,
    };
    image.encode(&mut flash.0).unwrap();
    let mut trial = None;
    // Settings on trial are a start of their own.
    for _ in 0..2 {
        let mut block = [0; IMAGE_MAX_BYTES];
        let mut store = Store::new(WordFlash::new(&mut flash));
        let boot = block_on(store.boot(trial.take(), &mut block));
        boot.settings.validate().expect("settings that may be used");
        let shared = Shared::<NoopRawMutex>::new();
        let mut session = Session::new(&boot, 7, "a board");
        let mut answers = Vec::new();
        let service = Service {
            shared: &shared,
            session: &mut session,
            store: &mut store,
            block: &mut block,
        };
        let clock = Quick(Cell::new(0));
        let end = block_on(service.run(Input(line(input)), Output(&mut answers), &clock));
        let mut frames = FrameReader::new();
        for byte in answers {
            assert!(
                !matches!(frames.push(byte), Some(Err(_))),
                "an answer that is no frame"
            );
        }
        let End::Restart(next) = end else {
            return;
        };
        trial = next;
    }
}
