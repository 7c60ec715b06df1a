//! A CAN controller that goes bus-off, and one whose transmit queue stays full.

use crate::bench::{Bench, flying};
use crate::sensor::opcode;
use crate::world::Event;
use softdock_app::board::IoError;
use softdock_control::modes::{Command, FaultCode, Mode};
use softdock_link::sensor::{SensorFault, SensorState};

const PAUSE_US: u64 = 100_000;
const RETRIES: usize = 10;
const NO_ANSWER: Option<SensorState> = Some(SensorState::Failed(SensorFault::NoAnswer));

#[test]
fn the_controller_is_brought_back_after_a_pause() {
    let mut bench = Bench::cruising(&flying());
    let off_us = bench.world().now_us;
    bench.world().go_bus_off();
    bench.cycles(10);
    assert_eq!(bench.status().sensor, NO_ANSWER);
    assert_eq!(bench.fault(), Some(FaultCode::SensorStale));
    bench.cycles(30);
    assert_eq!(bench.world().recoveries_us, [off_us + PAUSE_US]);
    assert_eq!(bench.status().bus_offs, 1);
    assert_eq!(bench.status().sensor, Some(SensorState::Running));
    // The fault stays until the operator resets it.
    assert_eq!(bench.status().mode, Mode::Fault);
    assert_eq!(bench.command(Command::Reset).trace.mode, Mode::Hold);
}

#[test]
fn after_some_retries_only_the_operator_helps() {
    let mut bench = Bench::new(&flying(), false);
    bench.cycle();
    bench.world().cable_broken = true;
    bench.world().go_bus_off();
    bench.cycles(1000);
    let recoveries = bench.world().recoveries_us.clone();
    assert_eq!(recoveries.len(), RETRIES);
    assert!(
        recoveries
            .windows(2)
            .all(|pair| pair[1] - pair[0] >= PAUSE_US)
    );
    assert_eq!(bench.status().bus_offs as usize, RETRIES + 1);
    assert_eq!(bench.status().sensor, NO_ANSWER);

    bench.command(Command::Reset);
    bench.cycles(1000);
    assert_eq!(bench.world().recoveries_us.len(), 2 * RETRIES);

    bench.world().cable_broken = false;
    bench.cycles(10);
    assert_eq!(bench.world().recoveries_us.len(), 2 * RETRIES);
    bench.command(Command::Reset);
    bench.cycles(400);
    assert_eq!(bench.world().recoveries_us.len(), 2 * RETRIES + 1);
    let world = bench.world();
    let resets = world.requests.iter().filter(|(_, f)| opcode(f) == 0xC);
    assert_eq!(resets.count(), 1, "the sensor starts over, too");
    drop(world);
    assert_eq!(bench.status().sensor, Some(SensorState::Running));
}

#[test]
fn a_frame_makes_the_retries_start_over() {
    let mut bench = Bench::new(&flying(), false);
    bench.cycle();
    for times in 1..=3 * RETRIES {
        bench.world().go_bus_off();
        bench.cycles(40);
        assert_eq!(bench.world().recoveries_us.len(), times);
        assert_eq!(bench.status().sensor, Some(SensorState::Running));
    }
}

/// If no node acknowledges, the transmit queue stays full: neither the answers nor the reset wait for it.
#[test]
fn a_full_transmit_queue_holds_nothing_up() {
    let mut bench = Bench::cruising(&flying());
    bench.world().transmit_full = true;
    bench.cycles(20);
    assert_eq!(bench.fault(), Some(FaultCode::SensorStale));
    assert_eq!(bench.status().sensor, Some(SensorState::Resynchronising));
    bench.command(Command::Reset);
    bench.cycles(20);
    assert_eq!(bench.status().sensor, Some(SensorState::Starting));
    bench.world().transmit_full = false;
    bench.cycles(600);
    assert_eq!(bench.status().sensor, Some(SensorState::Running));
}

#[test]
fn lost_frames_are_counted() {
    let mut bench = Bench::new(&flying(), false);
    for _ in 0..3 {
        let event = Event::Frame(Err(IoError::Lost));
        bench.world().schedule(bench.next_at_us + 2_000, event);
        bench.cycle();
    }
    assert_eq!(bench.status().can_losses, 3);
    assert_eq!(bench.status().sensor, Some(SensorState::Running));
}
