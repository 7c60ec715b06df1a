//! The Ethernet's PHY: its advertisement, and whether there is a link.
//!
//! Reading a register takes 27 µs of waiting on the management bus. It is therefore read every [`PERIOD_US`], or every
//! [`WAIT_US`] without a link, and cached in between. A PHY that has lost its configuration, by a dip of its supply or a
//! discharge at the plug, is configured again. Nothing here waits: a board boots without a cable, and with a PHY that does not
//! answer.

/// Polling period with a link, µs.
pub const PERIOD_US: u64 = 100_000;
/// Polling period without a link, µs: half of the 10 cycles of 4 ms within which the robot is answered again.
pub const WAIT_US: u64 = 20_000;

// Registers and their bits: IEEE 802.3, clause 22.2.4.
const CONTROL: u8 = 0;
const STATUS: u8 = 1;
const ADVERTISEMENT: u8 = 4;
/// In the control register: reset, which clears itself.
const RESET: u16 = 1 << 15;
/// In the control register: negotiate, and begin now.
const NEGOTIATE: u16 = 1 << 12 | 1 << 9;
/// In the status register: negotiation complete, and link. The link bit stays cleared after a loss until it is read.
const UP: u16 = 1 << 5 | 1 << 2;
/// The MAC is set to 100 Mbit/s, full duplex, so nothing else is offered (and that it is IEEE 802.3).
const ONLY_100_FULL: u16 = 1 << 8 | 1;
/// In the advertisement: all rates and duplexes.
const RATES: u16 = 0b11111 << 5;
/// Value of a management bus that nobody drives.
const NOBODY: u16 = 0xffff;

/// The management registers of a PHY.
pub trait Management {
    /// Reads a register.
    fn read(&mut self, register: u8) -> u16;
    /// Writes a register.
    fn write(&mut self, register: u8, value: u16);
}

/// State of the link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PhyMonitor {
    up: bool,
    /// Times that the link was lost.
    losses: u32,
    next_us: u64,
}

impl PhyMonitor {
    /// Begins to reset the PHY.
    pub fn reset(&mut self, phy: &mut impl Management) {
        phy.write(CONTROL, RESET);
    }

    /// Whether there is a link; polls the PHY when it is due.
    pub fn is_up(&mut self, phy: &mut impl Management, now_us: u64) -> bool {
        if now_us >= self.next_us {
            let up = look(phy);
            self.next_us = now_us + if up { PERIOD_US } else { WAIT_US };
            self.losses = self.losses.saturating_add(u32::from(self.up && !up));
            self.up = up;
        }
        self.up
    }

    /// Time of the next poll, µs.
    pub fn next_us(&self) -> u64 {
        self.next_us
    }

    /// Times that the link was lost since boot.
    pub fn losses(&self) -> u32 {
        self.losses
    }
}

fn look(phy: &mut impl Management) -> bool {
    let control = phy.read(CONTROL);
    // NOBODY has the bit set as well.
    if control & RESET != 0 {
        return false;
    }
    if phy.read(ADVERTISEMENT) & RATES != ONLY_100_FULL & RATES {
        phy.write(ADVERTISEMENT, ONLY_100_FULL);
        phy.write(CONTROL, NEGOTIATE);
        return false;
    }
    let status = phy.read(STATUS);
    status != NOBODY && status & UP == UP
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A PHY with a cable, or without.
    #[derive(Default)]
    struct Phy {
        registers: [u16; 32],
        absent: bool,
        reads: usize,
    }

    impl Phy {
        fn plug(&mut self, plugged: bool) {
            self.registers[usize::from(STATUS)] = match plugged {
                true => UP,
                false => 0,
            };
        }

        /// State after a reset: everything is offered.
        fn forget(&mut self) {
            self.registers[usize::from(CONTROL)] = 0;
            self.registers[usize::from(ADVERTISEMENT)] = 0x01e1;
        }
    }

    impl Management for Phy {
        fn read(&mut self, register: u8) -> u16 {
            self.reads += 1;
            match self.absent {
                true => NOBODY,
                false => self.registers[usize::from(register)],
            }
        }

        fn write(&mut self, register: u8, value: u16) {
            self.registers[usize::from(register)] = value;
        }
    }

    /// A PHY after its configuration, with the time of the next poll.
    fn told(plugged: bool) -> (Phy, PhyMonitor, u64) {
        let (mut phy, mut monitor) = (Phy::default(), PhyMonitor::default());
        monitor.reset(&mut phy);
        assert_ne!(phy.registers[usize::from(CONTROL)] & RESET, 0);
        assert!(!monitor.is_up(&mut phy, 0), "it is being reset");
        phy.forget();
        phy.plug(plugged);
        assert!(!monitor.is_up(&mut phy, WAIT_US), "it is being told");
        (phy, monitor, 2 * WAIT_US)
    }

    #[test]
    fn only_what_the_mac_can_do_is_offered() {
        let (phy, ..) = told(true);
        assert_eq!(phy.registers[usize::from(ADVERTISEMENT)], 0x0101);
        assert_eq!(phy.registers[usize::from(CONTROL)], 0x1200);
    }

    #[test]
    fn a_cable_that_comes_late_goes_and_comes_back_is_seen_within_a_period() {
        let (mut phy, mut monitor, start) = told(false);
        assert_eq!(monitor.losses(), 0);
        let mut looks = (0..).map(|n| start + n * PERIOD_US);
        for plugged in [false, true, true, true, true, false, true, false] {
            phy.plug(plugged);
            let now_us = looks.next().unwrap();
            assert_eq!(monitor.is_up(&mut phy, now_us), plugged);
            let period_us = if plugged { PERIOD_US } else { WAIT_US };
            assert_eq!(monitor.next_us(), now_us + period_us);
        }
        assert_eq!(monitor.losses(), 2);
    }

    #[test]
    fn a_link_that_comes_is_seen_within_ten_cycles() {
        let (mut phy, mut monitor, start) = told(false);
        assert!(!monitor.is_up(&mut phy, start));
        phy.plug(true);
        let seen = (start + 1..).find(|now_us| monitor.is_up(&mut phy, *now_us));
        assert!(
            seen.is_some_and(|at_us| at_us - start <= 10 * 4_000),
            "{seen:?}"
        );
    }

    #[test]
    fn between_two_looks_nothing_is_asked() {
        let (mut phy, mut monitor, start) = told(true);
        assert!(monitor.is_up(&mut phy, start));
        let reads = phy.reads;
        for later in 1..PERIOD_US {
            assert!(monitor.is_up(&mut phy, start + later));
        }
        assert_eq!(phy.reads, reads);
    }

    #[test]
    fn a_phy_that_has_forgotten_is_told_again() {
        let (mut phy, mut monitor, start) = told(true);
        assert!(monitor.is_up(&mut phy, start));
        phy.forget();
        assert!(!monitor.is_up(&mut phy, start + PERIOD_US));
        assert_eq!(phy.registers[usize::from(ADVERTISEMENT)], 0x0101);
        assert!(monitor.is_up(&mut phy, start + PERIOD_US + WAIT_US));
    }

    #[test]
    fn a_phy_that_does_not_answer_is_no_link_and_no_wait() {
        let (mut phy, mut monitor, start) = told(true);
        phy.absent = true;
        assert!(!monitor.is_up(&mut phy, start));
    }
}
