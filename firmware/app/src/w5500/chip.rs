//! Registers and buffers of the W5500 (WIZnet, W5500 data sheet 1.1.0): whole Ethernet frames by its socket 0, which
//! gets all of its memory.

use super::FRAME_BYTES;
use embedded_hal_async::spi::{Operation, SpiDevice};

/// Address and control byte before what a transaction carries.
const HEADER_BYTES: usize = 3;
/// Length of a frame before the frame, itself included.
const LENGTH_BYTES: u16 = 2;
/// Shortest valid frame: addresses and type.
const SHORTEST_FRAME: u16 = 14;
/// Memory for received frames, and as much for those to be sent.
pub(super) const MEMORY_BYTES: u16 = 16 << 10;
/// Only a flood leaves more than this waiting: it would be 100 ms of a robot's telegrams.
const FLOODED_BYTES: u16 = MEMORY_BYTES / 4 * 3;
/// Maximum number of reads of a length until it is stable.
const READS: usize = 3;
const SOCKETS: u8 = 8;

/// Data exchanged with the chip, in memory that the bus's DMA can reach.
pub type Buffer = [u8; HEADER_BYTES + FRAME_BYTES];

/// A part of the chip's address space, by its number.
#[derive(Clone, Copy)]
struct Block(u8);

const COMMON: Block = Block(0);
const SOCKET: Block = Block(1);
const TO_SEND: Block = Block(2);
const RECEIVED: Block = Block(3);

type Register = (Block, u16);

const HARDWARE_ADDRESS: Register = (COMMON, 0x09);
const SOCKET_INTERRUPTS: Register = (COMMON, 0x18);
const PHY: Register = (COMMON, 0x2E);
const VERSION: Register = (COMMON, 0x39);
const MODE: Register = (SOCKET, 0x00);
const COMMAND: Register = (SOCKET, 0x01);
const INTERRUPT: Register = (SOCKET, 0x02);
const STATUS: Register = (SOCKET, 0x03);
const RECEIVE_KB: u16 = 0x1E;
const SEND_KB: u16 = 0x1F;
const SEND_FREE: Register = (SOCKET, 0x20);
const SEND_READ: Register = (SOCKET, 0x22);
const SEND_WRITE: Register = (SOCKET, 0x24);
const RECEIVED_BYTES: Register = (SOCKET, 0x26);
const RECEIVED_READ: Register = (SOCKET, 0x28);
const INTERRUPT_MASK: Register = (SOCKET, 0x2C);

/// Version number that every W5500 reports.
const W5500: u8 = 4;
/// In [`PHY`].
const LINKED: u8 = 1;
/// In [`MODE`]: whole frames; those for other hardware addresses are left out.
const WHOLE_FRAMES: u8 = 1 << 7 | 1 << 2;
/// In [`STATUS`].
const OPEN_FOR_FRAMES: u8 = 0x42;
/// In [`INTERRUPT`] and [`INTERRUPT_MASK`].
const FRAME_CAME: u8 = 1 << 2;

/// For [`COMMAND`].
#[derive(Clone, Copy)]
enum Command {
    Open = 0x01,
    Close = 0x10,
    Send = 0x20,
    Received = 0x40,
}

/// Why the chip did not behave as expected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Trouble {
    /// The bus failed, the chip does not answer, or it has lost its configuration.
    NoAnswer,
    /// Its information on a frame is inconsistent.
    OutOfStep,
}

/// What is waiting in the receive memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Received {
    Nothing,
    /// A frame of this length, which was taken.
    Frame(usize),
    /// So much that it is useless by now.
    Flood,
}

/// State of the chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Look {
    pub(super) link: bool,
    /// Its socket is open for frames.
    pub(super) open: bool,
    /// Address of the first frame in its memory that was not sent; `None`: all were.
    pub(super) unsent: Option<u16>,
}

/// The chip.
pub struct Chip<'b, S> {
    spi: S,
    buffer: &'b mut Buffer,
    address: [u8; 6],
    /// Where the next frame is to be read, and written.
    read_at: u16,
    write_at: u16,
}

impl<'b, S: SpiDevice> Chip<'b, S> {
    /// With the hardware address to be used.
    pub fn new(spi: S, buffer: &'b mut Buffer, address: [u8; 6]) -> Self {
        Self {
            spi,
            buffer,
            address,
            read_at: 0,
            write_at: 0,
        }
    }

    /// Configures it completely and begins with empty memory, whatever its state was.
    pub(super) async fn open(&mut self) -> Result<(), Trouble> {
        if self.byte(VERSION).await? != W5500 {
            return Err(Trouble::NoAnswer);
        }
        self.command(Command::Close).await?;
        let address = self.address;
        self.write(HARDWARE_ADDRESS, &address).await?;
        for socket in 0..SOCKETS {
            let kilobytes = match socket {
                0 => (MEMORY_BYTES >> 10) as u8,
                _ => 0,
            };
            let block = Block(4 * socket + SOCKET.0);
            self.write((block, RECEIVE_KB), &[kilobytes]).await?;
            self.write((block, SEND_KB), &[kilobytes]).await?;
        }
        self.write(SOCKET_INTERRUPTS, &[1]).await?;
        self.write(INTERRUPT_MASK, &[FRAME_CAME]).await?;
        self.write(MODE, &[WHOLE_FRAMES]).await?;
        self.command(Command::Open).await?;
        self.read_at = self.word(RECEIVED_READ).await?;
        self.write_at = self.word(SEND_WRITE).await?;
        match self.byte(STATUS).await? {
            OPEN_FOR_FRAMES => Ok(()),
            _ => Err(Trouble::NoAnswer),
        }
    }

    pub(super) async fn look(&mut self) -> Result<Look, Trouble> {
        if self.byte(VERSION).await? != W5500 {
            return Err(Trouble::NoAnswer);
        }
        Ok(Look {
            link: self.byte(PHY).await? & LINKED != 0,
            open: self.byte(STATUS).await? == OPEN_FOR_FRAMES,
            unsent: self.unsent().await?,
        })
    }

    async fn unsent(&mut self) -> Result<Option<u16>, Trouble> {
        Ok(match self.word(SEND_FREE).await? {
            MEMORY_BYTES => None,
            _ => Some(self.word(SEND_READ).await?),
        })
    }

    /// Clears the interrupt, so that the next frame raises it again: to be called before checking what waits.
    pub(super) async fn clear_interrupt(&mut self) -> Result<(), Trouble> {
        self.write(INTERRUPT, &[FRAME_CAME]).await
    }

    /// Takes the next frame, if there is one.
    pub(super) async fn receive(&mut self, frame: &mut [u8]) -> Result<Received, Trouble> {
        match self.waiting().await? {
            0 => return Ok(Received::Nothing),
            FLOODED_BYTES.. => return Ok(Received::Flood),
            _ => {}
        }
        let with_length = self.word((RECEIVED, self.read_at)).await?;
        let length = with_length.wrapping_sub(LENGTH_BYTES);
        let room = frame.get_mut(..length.into());
        let Some(frame) = room.filter(|_| length >= SHORTEST_FRAME) else {
            return Err(Trouble::OutOfStep);
        };
        let at = self.read_at.wrapping_add(LENGTH_BYTES);
        frame.copy_from_slice(self.read((RECEIVED, at), frame.len()).await?);
        self.read_at = self.read_at.wrapping_add(with_length);
        self.write(RECEIVED_READ, &self.read_at.to_be_bytes())
            .await?;
        self.command(Command::Received).await?;
        Ok(Received::Frame(length.into()))
    }

    /// Number of waiting bytes, which the chip may be changing.
    async fn waiting(&mut self) -> Result<u16, Trouble> {
        let mut waiting = self.word(RECEIVED_BYTES).await?;
        for _ in 1..READS {
            let again = self.word(RECEIVED_BYTES).await?;
            if again == waiting {
                break;
            }
            waiting = again;
        }
        Ok(waiting)
    }

    /// Sends a frame, if there is room for it.
    pub(super) async fn send(&mut self, frame: &[u8]) -> Result<(), Trouble> {
        // At most as long as an Ethernet frame.
        let length = frame.len() as u16;
        if self.word(SEND_FREE).await? < length {
            return Ok(());
        }
        self.write((TO_SEND, self.write_at), frame).await?;
        self.write_at = self.write_at.wrapping_add(length);
        self.write(SEND_WRITE, &self.write_at.to_be_bytes()).await?;
        self.command(Command::Send).await
    }

    async fn command(&mut self, command: Command) -> Result<(), Trouble> {
        self.write(COMMAND, &[command as u8]).await
    }

    async fn byte(&mut self, register: Register) -> Result<u8, Trouble> {
        let bytes = self.read(register, 1).await?;
        bytes.first().copied().ok_or(Trouble::NoAnswer)
    }

    async fn word(&mut self, register: Register) -> Result<u16, Trouble> {
        let bytes = self.read(register, 2).await?;
        let word = bytes.first_chunk().ok_or(Trouble::NoAnswer)?;
        Ok(u16::from_be_bytes(*word))
    }

    async fn read(&mut self, register: Register, length: usize) -> Result<&[u8], Trouble> {
        const READ: u8 = 0;
        let bytes = self.exchange(register, READ, length, &[]).await?;
        Ok(bytes)
    }

    async fn write(&mut self, register: Register, bytes: &[u8]) -> Result<(), Trouble> {
        const WRITE: u8 = 1 << 2;
        self.exchange(register, WRITE, bytes.len(), bytes).await?;
        Ok(())
    }

    /// One transaction without interruption: the clock of the bus must not rest in it longer than necessary.
    async fn exchange(
        &mut self,
        (block, offset): Register,
        direction: u8,
        length: usize,
        written: &[u8],
    ) -> Result<&[u8], Trouble> {
        let [high, low] = offset.to_be_bytes();
        let header = [high, low, block.0 << 3 | direction];
        let (place, data) = self.buffer.split_at_mut(HEADER_BYTES);
        place.copy_from_slice(&header);
        for (place, byte) in data.iter_mut().zip(written) {
            *place = *byte;
        }
        let whole = self.buffer.get_mut(..HEADER_BYTES + length);
        let whole = whole.ok_or(Trouble::OutOfStep)?;
        let mut exchange = [Operation::TransferInPlace(whole)];
        let exchanged = self.spi.transaction(&mut exchange).await;
        exchanged.map_err(|_| Trouble::NoAnswer)?;
        let data = self.buffer.get(HEADER_BYTES..HEADER_BYTES + length);
        data.ok_or(Trouble::OutOfStep)
    }
}
