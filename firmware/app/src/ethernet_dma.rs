//! Whether the DMA of an Ethernet controller still moves frames, and what to do if not.
//!
//! The controller of the STM32H7 is known to fall silent: its DMA suspends itself when no buffer is free, and stops at a bus
//! error, without any notification (STM32CubeH7 #222, stm32h7xx-hal #448, NuttX #10065). So it is checked every [`PERIOD_US`]. A
//! flood also suspends it, again and again; that needs no action as long as frames come through.
//! #10065). So it is looked at every [`PERIOD_US`]. A flood suspends it as well, again and again; that is
//! no reason for anything as long as frames come through.

/// Period of the check, µs: the robot is answered again within 10 cycles of 4 ms.
pub const PERIOD_US: u64 = 10_000;
/// Checks without a frame after which a suspended channel is restarted.
const RESTART_AFTER: u32 = 2;
/// Checks without a frame after which the board restarts: a tenth of a second without the robot, which has given up by then.
const START_OVER_AFTER: u32 = 10;

/// State of a channel of the DMA.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// It works, or waits for work.
    Running,
    /// It waits for a buffer.
    Suspended,
    /// It does nothing until it is started.
    Stopped,
}

/// Action that may bring it back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cure {
    /// Tell it that there are buffers.
    Resume,
    /// Stop and start it.
    Restart,
    /// A reset of the chip.
    StartOver,
}

/// State of the monitor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DmaMonitor {
    frames: u32,
    stuck: u32,
    /// Times that reception was found suspended, or either direction stopped.
    overruns: u32,
}

impl DmaMonitor {
    /// Checks reception and transmission; `frames` is the count of received frames, which may wrap. Returns the action to take;
    /// `None` if all is well.
    pub fn look(&mut self, receive: Channel, transmit: Channel, frames: u32) -> Option<Cure> {
        let moves = frames != self.frames;
        self.frames = frames;
        // A transmitter without work is suspended.
        let stopped = receive == Channel::Stopped || transmit == Channel::Stopped;
        if receive == Channel::Running && !stopped {
            self.stuck = 0;
            return None;
        }
        self.overruns = self.overruns.saturating_add(1);
        self.stuck = match moves {
            true => 0,
            false => self.stuck + 1,
        };
        Some(match self.stuck {
            START_OVER_AFTER.. => Cure::StartOver,
            RESTART_AFTER.. => Cure::Restart,
            _ if stopped => Cure::Restart,
            _ => Cure::Resume,
        })
    }

    /// Times that reception was found suspended, or either direction stopped, since boot.
    pub fn overruns(&self) -> u32 {
        self.overruns
    }
}

#[cfg(test)]
mod tests {
    use super::Channel::{Running, Stopped, Suspended};
    use super::*;

    #[test]
    fn a_controller_that_works_is_left_alone() {
        let mut monitor = DmaMonitor::default();
        for look in 0..100 {
            assert_eq!(monitor.look(Running, Suspended, look / 3), None);
        }
        assert_eq!(monitor.overruns(), 0);
    }

    /// Within 10 cycles of 4 ms the first two cures have been tried.
    #[test]
    fn a_suspended_receiver_is_resumed_then_restarted_then_the_board_starts_over() {
        let mut monitor = DmaMonitor::default();
        let cures: Vec<_> = (0..10)
            .map(|_| monitor.look(Suspended, Running, 0).unwrap())
            .collect();
        assert_eq!(cures[0], Cure::Resume);
        assert!(cures[1..9].iter().all(|cure| *cure == Cure::Restart));
        assert_eq!(cures[9], Cure::StartOver);
        let tried = cures
            .iter()
            .position(|cure| *cure == Cure::Restart)
            .unwrap() as u64
            + 1;
        assert!(tried * PERIOD_US <= 10 * 4000, "{tried} looks");
    }

    #[test]
    fn a_stopped_channel_is_restarted_at_once() {
        for (receive, transmit) in [(Stopped, Running), (Running, Stopped)] {
            let mut monitor = DmaMonitor::default();
            assert_eq!(monitor.look(receive, transmit, 0), Some(Cure::Restart));
            assert_eq!(monitor.look(Running, Running, 0), None);
            assert_eq!(monitor.overruns(), 1);
        }
    }

    /// Number of telegrams, one every 4 ms, until one comes through a receiver that has fallen silent and needs a given action.
    /// The first check is after `look_us`.
    fn cycles_until_answered(silent: Channel, wants: Cure, mut look_us: u64) -> u64 {
        let (mut monitor, mut receive) = (DmaMonitor::default(), silent);
        // One has come since the last check, before it fell silent.
        let frames = 1;
        for cycle in 1..100 {
            while look_us <= cycle * 4000 {
                if monitor.look(receive, Suspended, frames) == Some(wants) {
                    receive = Running;
                }
                look_us += PERIOD_US;
            }
            if receive == Running {
                return cycle;
            }
        }
        panic!("{silent:?} for ever");
    }

    #[test]
    fn whatever_brings_it_back_the_robot_is_answered_within_ten_cycles() {
        let cures = [
            (Suspended, Cure::Resume),
            (Suspended, Cure::Restart),
            (Stopped, Cure::Restart),
        ];
        for (silent, wants) in cures {
            for look_us in (0..=PERIOD_US).step_by(1000) {
                let cycles = cycles_until_answered(silent, wants, look_us);
                assert!(cycles <= 10, "{wants:?}: {cycles}");
            }
        }
    }

    #[test]
    fn a_flood_that_comes_through_is_no_reason_to_restart() {
        let mut monitor = DmaMonitor::default();
        for look in 0..1000_u32 {
            let frames = (u32::MAX - 500).wrapping_add(look);
            assert_eq!(monitor.look(Suspended, Running, frames), Some(Cure::Resume));
        }
    }
}
