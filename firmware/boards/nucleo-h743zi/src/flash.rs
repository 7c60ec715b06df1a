//! The last two sectors of flash: two slots for settings.
//!
//! The program runs from the first bank and the sectors lie in the second, so the processor keeps running while one of them
//! is erased, which takes a second or two (STM32H743 data sheet, flash memory characteristics). The driver waits for that
//! without blocking other tasks: Embassy's own driver waits in a critical section.
//!
//! A word of 32 bytes whose writing was interrupted has a wrong check code, and reading it is a bus fault (RM0433, 4.3.12,
//! error code correction). Therefore words are read with bus faults ignored.
#![allow(
    unsafe_code,
    reason = "flash is memory that the compiler does not know of"
)]

use core::arch::asm;
use core::ptr;
use cortex_m::peripheral::SCB;
use embassy_stm32::Peri;
use embassy_stm32::pac::FLASH as REGISTERS;
use embassy_stm32::pac::flash::Bank;
use embassy_stm32::peripherals::FLASH;
use embassy_time::{Duration, Instant, Timer};
use embedded_storage_async::nor_flash::NorFlashErrorKind;
use softdock_app::store::{FlashWords, WORD_BYTES};

/// Start of the region SETTINGS of memory.x.
const START: usize = 0x081C_0000;
/// Size of a sector.
const SLOT_BYTES: usize = 128 << 10;
/// Number of the first of the two sectors in the second bank, which begins at 0x0810_0000.
const FIRST_SECTOR: u8 = 6;
/// Longest time for a sector to be erased: 4 s at the slowest parallelism.
const ERASE: Duration = Duration::from_secs(6);
/// Longest time for a word to be written.
const WRITE: Duration = Duration::from_millis(10);

/// The two sectors, a slot each.
pub(crate) struct Sectors(Peri<'static, FLASH>);

impl Sectors {
    pub(crate) fn new(flash: Peri<'static, FLASH>) -> Self {
        Self(flash)
    }
}

impl FlashWords for Sectors {
    const SLOT_BYTES: usize = SLOT_BYTES;

    fn read_word(&mut self, offset: usize) -> Result<[u8; WORD_BYTES], NorFlashErrorKind> {
        read_word(START + offset).ok_or(NorFlashErrorKind::Other)
    }

    async fn write_word(
        &mut self,
        offset: usize,
        word: &[u8; WORD_BYTES],
    ) -> Result<(), NorFlashErrorKind> {
        let bank = unlocked();
        bank.cr().modify(|w| {
            w.set_pg(true);
            w.set_psize(3);
        });
        barrier();
        let address = START + offset;
        for (at, bytes) in (address..).step_by(4).zip(word.as_chunks::<4>().0) {
            // SAFETY: the address is that of a word of the slots, which nobody has a reference
            // into. The eighth write begins the programming.
            unsafe { ptr::write_volatile(at as *mut u32, u32::from_le_bytes(*bytes)) }
        }
        barrier();
        let outcome = finished(bank, WRITE, Duration::from_micros(50)).await;
        bank.cr().modify(|w| w.set_pg(false));
        lock(bank);
        outcome
    }

    async fn erase_slot(&mut self, offset: usize) -> Result<(), NorFlashErrorKind> {
        let sector = match offset {
            0 => FIRST_SECTOR,
            _ => FIRST_SECTOR + 1,
        };
        let bank = unlocked();
        bank.cr().modify(|w| {
            w.set_ser(true);
            w.set_snb(sector);
            // 64 bits at once, which is fastest.
            w.set_psize(3);
        });
        bank.cr().modify(|w| w.set_start(true));
        let outcome = finished(bank, ERASE, Duration::from_millis(5)).await;
        bank.cr().modify(|w| w.set_ser(false));
        lock(bank);
        outcome
    }
}

fn barrier() {
    cortex_m::asm::isb();
    cortex_m::asm::dsb();
}

/// The second bank, ready for a change and with earlier errors cleared.
fn unlocked() -> Bank {
    let bank = REGISTERS.bank(1);
    if bank.cr().read().lock() {
        // The keys (RM0433, 4.5.1).
        bank.keyr().write_value(0x4567_0123);
        bank.keyr().write_value(0xCDEF_89AB);
    }
    clear_errors(bank);
    bank
}

fn lock(bank: Bank) {
    bank.cr().modify(|w| w.set_lock(true));
}

fn clear_errors(bank: Bank) {
    bank.ccr().write(|w| {
        w.set_clr_eop(true);
        w.set_clr_wrperr(true);
        w.set_clr_pgserr(true);
        w.set_clr_strberr(true);
        w.set_clr_incerr(true);
        w.set_clr_operr(true);
        w.set_clr_rdperr(true);
        w.set_clr_rdserr(true);
        w.set_clr_sneccerr(true);
        w.set_clr_dbeccerr(true);
    });
}

/// Waits until the bank has finished.
async fn finished(bank: Bank, longest: Duration, pause: Duration) -> Result<(), NorFlashErrorKind> {
    let give_up = Instant::now() + longest;
    loop {
        let state = bank.sr().read();
        if !state.bsy() && !state.qw() {
            let failed = state.wrperr() || state.pgserr() || state.incerr() || state.operr();
            return match failed {
                true => Err(NorFlashErrorKind::Other),
                false => Ok(()),
            };
        }
        if Instant::now() > give_up {
            return Err(NorFlashErrorKind::Other);
        }
        Timer::after(pause).await;
    }
}

/// Reads a word of flash; none if its check code is wrong.
fn read_word(address: usize) -> Option<[u8; WORD_BYTES]> {
    const IGNORE_BUS_FAULTS: u32 = 1 << 8;
    const BUS_FAULTS: u32 = 0xff00;
    let bank = REGISTERS.bank(1);
    clear_errors(bank);
    let mut word = [0; WORD_BYTES];
    // SAFETY: the address is that of a word of the slots. In a critical section nobody else changes these
    // registers; with FAULTMASK set, BFHFNMIGN makes the processor go on behind a bus fault
    // (Armv7-M Architecture Reference Manual, B3.2.8), and the fault that it noted is cleared.
    cortex_m::interrupt::free(|_| unsafe {
        let scb = &*SCB::PTR;
        scb.ccr.modify(|control| control | IGNORE_BUS_FAULTS);
        asm!("cpsid f", "dsb", "isb");
        for (at, byte) in (address..).zip(&mut word) {
            *byte = ptr::read_volatile(at as *const u8);
        }
        asm!("dsb", "isb");
        scb.cfsr.write(BUS_FAULTS);
        scb.ccr.modify(|control| control & !IGNORE_BUS_FAULTS);
        asm!("cpsie f");
    });
    let torn = bank.sr().read().dbeccerr();
    clear_errors(bank);
    (!torn).then_some(word)
}
