//! What the segment does wrong.

use softdock_app::record::CycleRecord;
use softdock_app::shared::Status;
use softdock_control::modes::{Command, FaultCode, Mode};
use softdock_experiments::scenario::Scenario;
use softdock_link::can::ati::AtiCalibration;
use softdock_link::ethercat::Product;
use softdock_link::sensor::{SensorFault, SensorState};
use softdock_rig::board::virtual_time::{Simulation, simulate_disturbed};
use softdock_rig::ethercat::{AlState, Cable, Description, Segment, SubDevice};
use softdock_rig::rig::Rig;
use std::ops::{ControlFlow, RangeInclusive};

/// What was seen at each cycle.
struct Seen {
    records: Vec<CycleRecord>,
    status: Vec<Status>,
}

/// Cycles until the sensor runs and the loop is closed, and a little more.
const CRUISING: u64 = 250;
/// 3 s.
const CYCLES: u64 = 750;

/// A run in free flight. The board starts by itself, unless it is given commands; `happens` is called before each
/// telegram.
fn run(commands: &[(u64, Command)], happens: impl FnMut(u64, &mut Segment)) -> Seen {
    run_for(CYCLES, commands, happens)
}

fn run_for(
    cycles: u64,
    commands: &[(u64, Command)],
    happens: impl FnMut(u64, &mut Segment),
) -> Seen {
    let mut scenario = Scenario::spring_rod().unwrap();
    scenario.rig.mechanism.walls.clear();
    scenario.duration_s = cycles as f64 * scenario.board.control.robot.cycle_s;
    simulated(scenario, commands, happens)
}

fn simulated(
    scenario: Scenario,
    commands: &[(u64, Command)],
    happens: impl FnMut(u64, &mut Segment),
) -> Seen {
    let rig = Rig::new(&scenario.rig, scenario.start_pose(), 1).unwrap();
    simulated_on(rig, scenario, commands, happens)
}

fn simulated_on(
    rig: Rig,
    mut scenario: Scenario,
    commands: &[(u64, Command)],
    mut happens: impl FnMut(u64, &mut Segment),
) -> Seen {
    scenario.board.ethercat.enabled = true;
    let sensor = &scenario.rig.sensor;
    let simulation = Simulation {
        board: &scenario.board,
        rig,
        calibration: AtiCalibration {
            matrix: sensor.calibration,
            counts_per_force: sensor.counts_per_newton,
            counts_per_torque: sensor.counts_per_newton_metre,
        },
        duration_s: scenario.duration_s,
        commands: commands.to_vec(),
    };
    let mut seen = Seen {
        records: Vec::new(),
        status: Vec::new(),
    };
    let Seen { records, status } = &mut seen;
    simulate_disturbed(
        simulation,
        &mut |cycle, segment, now| {
            status.push(*now);
            happens(cycle, segment);
        },
        &mut |record, _| {
            records.push(*record);
            ControlFlow::Continue(())
        },
    )
    .unwrap();
    seen
}

impl Seen {
    fn mode(&self, cycle: u64) -> Mode {
        self.records[cycle as usize].trace.mode
    }

    fn end(&self) -> &Status {
        self.status.last().unwrap()
    }

    fn assert_zeros_from(&self, cycle: u64) {
        for record in &self.records[cycle as usize..] {
            assert_eq!(record.output.correction, [0; 6], "{:?}", record.trace.mode);
        }
    }
}

/// At the start of the run, in place of the Axia80.
fn with(description: Description) -> impl FnMut(u64, &mut Segment) {
    move |cycle, segment| {
        if cycle == 0 {
            segment.devices = vec![SubDevice::new(description.clone())];
        }
    }
}

/// Nothing arms, the robot is answered with zeros, and the state says why.
fn assert_never_starts(expected: SensorFault, happens: impl FnMut(u64, &mut Segment)) {
    let seen = run(&[], happens);
    assert_eq!(seen.records.len() as u64, CYCLES, "{expected}");
    assert_eq!(
        seen.end().sensor,
        Some(SensorState::Failed(expected)),
        "{expected}"
    );
    assert_eq!(seen.end().sample, None, "{expected}");
    assert!(seen.records.iter().all(|record| !record.trace.mode.moves()));
    seen.assert_zeros_from(0);
}

#[test]
fn both_products_run() {
    for product in Product::ALL {
        let seen = run(&[], with(Description::of(product)));
        assert_eq!(seen.mode(CYCLES - 1), Mode::Running, "{product:?}");
        assert_eq!(seen.end().sensor, Some(SensorState::Running));
        let counters = seen.end().sensor_counters;
        assert_eq!(counters, Default::default(), "{product:?}");
    }
}

#[test]
fn a_wrong_sensor_is_named() {
    let axia = Description::of(Product::Axia80);
    let vendor = Description {
        vendor: 2,
        ..axia.clone()
    };
    assert_never_starts(SensorFault::Vendor { received: 2 }, with(vendor));
    let product = Description {
        product: 0x2648_3099,
        ..axia.clone()
    };
    assert_never_starts(
        SensorFault::Product {
            received: 0x2648_3099,
        },
        with(product),
    );
    let mut longer = axia.clone();
    longer.inputs.push(0x6030_0020);
    let bytes = SensorFault::PdoBytes {
        inputs: 36,
        outputs: 8,
    };
    assert_never_starts(bytes, with(longer));
    let mut shorter = axia.clone();
    shorter.outputs.pop();
    let bytes = SensorFault::PdoBytes {
        inputs: 32,
        outputs: 4,
    };
    assert_never_starts(bytes, with(shorter));
    let mut far_longer = axia.clone();
    far_longer.inputs.extend([0x6030_0020; 40]);
    let seen = run(&[], with(far_longer));
    assert!(
        matches!(
            seen.end().sensor,
            Some(SensorState::Failed(SensorFault::PdoBytes { .. }))
        ),
        "{:?}",
        seen.end().sensor
    );
    for (counts, force, torque) in [
        ((0, 1_000_000), 0, 1_000_000),
        ((1_000_000, -5), 1_000_000, (-5_i32).cast_unsigned()),
        ((i32::MAX, 1), i32::MAX.cast_unsigned(), 1),
    ] {
        let absurd = Description {
            counts_per_unit: counts,
            ..axia.clone()
        };
        assert_never_starts(SensorFault::CountsPerUnit { force, torque }, with(absurd));
    }
    let unit = Description {
        units: (9, 2),
        ..axia.clone()
    };
    assert_never_starts(SensorFault::ForceUnit { code: 9 }, with(unit));
    assert_never_starts(SensorFault::Object { index: 0x2021 }, |cycle, segment| {
        if cycle == 0 {
            segment.devices[0].remove_object(0x2021);
        }
    });
}

#[test]
fn a_segment_that_is_not_the_sensor_alone_is_named() {
    let axia = || SubDevice::new(Description::of(Product::Axia80));
    for count in 2..5 {
        assert_never_starts(
            SensorFault::SubDevices { received: count },
            |cycle, segment| {
                if cycle == 0 {
                    segment.devices = (0..count).map(|_| axia()).collect();
                }
            },
        );
    }
    assert_never_starts(SensorFault::NoSubDevice, |_, segment| {
        segment.devices.clear()
    });
    assert_never_starts(SensorFault::NoSubDevice, |_, segment| {
        segment.cable = Cable::Passes
    });
    for cable in [Cable::Out, Cable::Echoes, Cable::Cuts] {
        assert_never_starts(SensorFault::NoAnswer, |_, segment| segment.cable = cable);
    }
}

/// Over the whole way from the process data to the interlock; what a bit means is tested with the driver.
#[test]
fn a_status_bit_of_the_sensor_arms_nothing() {
    for status in [1, 1 << 2, 1 << 15] {
        let scenario = Scenario::spring_rod().unwrap();
        let mut rig = Rig::new(&scenario.rig, scenario.start_pose(), 1).unwrap();
        rig.set_sensor_status(status);
        let seen = simulated_on(rig, scenario, &[], |_, _| {});
        assert_eq!(seen.end().sensor, Some(SensorState::Running));
        let told = seen.end().sample.map(|sample| sample.status);
        assert_eq!(told, Some(status.into()));
        assert!(seen.records.iter().all(|record| !record.trace.mode.moves()));
        seen.assert_zeros_from(0);
    }
}

/// After the disturbance of `cycles` cycles the loop goes on as if nothing had been.
fn assert_survives(cycles: u64, happens: impl Fn(&mut Segment, bool)) {
    let seen = run(&[], |cycle, segment| {
        if cycle == CRUISING {
            happens(segment, true);
        } else if cycle == CRUISING + cycles {
            happens(segment, false);
        }
    });
    assert_eq!(seen.mode(CRUISING), Mode::Running);
    assert_eq!(seen.mode(CYCLES - 1), Mode::Running);
}

/// The samples are too old, which is a fault; the sensor comes back by itself, and so the board into hold with a reset,
/// and into the loop again.
fn assert_faults_and_recovers(state: Option<SensorFault>, happens: impl Fn(&mut Segment, bool)) {
    const OVER: u64 = CRUISING + 100;
    const RESET: u64 = OVER + 150;
    let start = [Command::Hold, Command::Arm, Command::Start];
    let mut commands: Vec<_> = (0..).map(|n| 150 + 10 * n).zip(start).collect();
    commands.push((RESET, Command::Reset));
    let seen = run(&commands, |cycle, segment| {
        if cycle == CRUISING {
            happens(segment, true);
        } else if cycle == OVER {
            happens(segment, false);
        }
    });
    assert_eq!(seen.mode(CRUISING), Mode::Running);
    assert_eq!(seen.mode(CRUISING + 7), Mode::Fault);
    let fault = seen.records[CRUISING as usize + 7].trace.fault.unwrap();
    assert_eq!(fault.code, FaultCode::SensorStale);
    let age = |cycle: u64| seen.records[cycle as usize].trace.sensor_age;
    // What happened once is over as soon as the sensor was started anew, which takes longer than this.
    let until = if state.is_some() { OVER } else { CRUISING + 10 };
    for cycle in CRUISING + 2..until {
        assert!(
            u64::from(age(cycle)) >= cycle - CRUISING - 1,
            "taken for fresh at {cycle}"
        );
    }
    if let Some(fault) = state {
        let during = seen.status[OVER as usize].sensor;
        assert_eq!(during, Some(SensorState::Failed(fault)));
    }
    let recovered = seen.status[RESET as usize].sensor;
    assert_eq!(recovered, Some(SensorState::Running), "by itself");
    assert_eq!(seen.mode(RESET), Mode::Hold);
    assert_eq!(age(RESET), 0);
    seen.assert_zeros_from(CRUISING + 7);
}

#[test]
fn a_disturbed_frame_costs_nothing() {
    for cable in [Cable::Loses, Cable::Cuts, Cable::Passes, Cable::Echoes] {
        assert_survives(1, |segment, on| {
            segment.cable = if on { cable } else { Cable::Good }
        });
    }
    // For the rest of the run: each frame twice, with others in between, in a flood at line rate, or late but in time.
    for cable in [
        Cable::Repeats,
        Cable::Foreign,
        Cable::Floods,
        Cable::Delays(300),
    ] {
        assert_survives(CYCLES, |segment, on| {
            segment.cable = if on { cable } else { Cable::Good }
        });
    }
}

#[test]
fn a_cable_that_is_out_is_a_fault_and_comes_back() {
    for (cable, state) in [
        (Cable::Out, SensorFault::NoAnswer),
        (Cable::Cuts, SensorFault::NoAnswer),
        (Cable::Passes, SensorFault::NoSubDevice),
        (Cable::Delays(20_000), SensorFault::NoAnswer),
    ] {
        assert_faults_and_recovers(Some(state), |segment, on| {
            segment.cable = if on { cable } else { Cable::Good };
        });
    }
}

#[test]
fn a_cable_that_is_plugged_in_after_boot_is_found() {
    let seen = run(&[], |cycle, segment| {
        segment.cable = if cycle < 200 { Cable::Out } else { Cable::Good };
    });
    let waiting = SensorState::Failed(SensorFault::NoAnswer);
    assert_eq!(seen.status[200].sensor, Some(waiting));
    assert_eq!(seen.mode(CYCLES - 1), Mode::Running);
}

/// The rate falls to zero while the spring pushes hardest, and the robot stands.
#[test]
fn a_cable_that_is_pulled_in_contact_stops_the_robot() {
    let scenario = Scenario::spring_rod().unwrap();
    let force = |record: &CycleRecord| record.trace.wrench_at_m[0].abs();
    let whole = simulated(scenario.clone(), &[], |_, _| {});
    let hardest = whole.records.iter().enumerate();
    let hardest = hardest.max_by(|a, b| force(a.1).total_cmp(&force(b.1)));
    let pulled = hardest.unwrap().0 as u64;
    let seen = simulated(scenario, &[], |cycle, segment| {
        if cycle == pulled {
            segment.cable = Cable::Out;
        }
    });
    assert!(force(&seen.records[pulled as usize - 1]) > 10.0);
    assert_eq!(seen.mode(pulled), Mode::Running);
    assert_eq!(seen.mode(pulled + 7), Mode::Fault);
    seen.assert_zeros_from(pulled + 7);
}

#[test]
fn a_sensor_that_is_restarted_gives_no_sample_until_it_is_set_up() {
    assert_faults_and_recovers(None, |segment, _| segment.devices[0].restart());
}

#[test]
fn a_sensor_that_falls_to_safe_op_gives_no_sample() {
    assert_faults_and_recovers(None, |segment, _| segment.devices[0].fall_to_safe_op());
}

#[test]
fn a_sample_counter_that_stands_is_no_sample() {
    assert_faults_and_recovers(Some(SensorFault::Standing), |segment, on| {
        segment.devices[0].stands = on;
    });
}

#[test]
fn a_second_subdevice_is_a_fault_until_it_has_gone() {
    assert_faults_and_recovers(
        Some(SensorFault::SubDevices { received: 2 }),
        |segment, on| match on {
            true => {
                let axia = SubDevice::new(Description::of(Product::Axia80));
                segment.devices.insert(0, axia);
                segment.devices[1].restart();
            }
            false => segment.devices.truncate(1),
        },
    );
}

#[test]
fn an_emergency_message_does_not_end_the_firmware() {
    let seen = run(&[], |cycle, segment| {
        if (1..40).contains(&cycle) {
            segment.devices[0].send_emergency();
        }
    });
    assert_eq!(seen.mode(CYCLES - 1), Mode::Running);
}

/// Whatever it says: the robot is answered in every cycle, and when the nonsense is over the sensor runs, after the
/// longest start-up at the latest.
fn nonsense_is_survived(seeds: RangeInclusive<u64>) {
    const NONSENSE: u64 = 500;
    const LONG: u64 = NONSENSE + 1000;
    for seed in seeds {
        let seen = run_for(LONG, &[], |cycle, segment| {
            segment.noise ^= seed << 32;
            segment.cable = match cycle < NONSENSE {
                true => Cable::Garbles,
                false => Cable::Good,
            };
        });
        assert_eq!(seen.records.len() as u64, LONG, "seed {seed}");
        let running = SensorState::Running;
        assert_eq!(seen.end().sensor, Some(running), "seed {seed}");
    }
}

#[test]
fn a_subdevice_that_answers_nonsense_is_survived() {
    nonsense_is_survived(1..=15);
}

#[test]
#[ignore = "long: 60 SubDevices that answer nonsense"]
fn any_nonsense_is_survived() {
    nonsense_is_survived(1..=60);
}

/// Any byte of the EEPROM may be wrong.
#[test]
fn an_eeprom_that_holds_nonsense_is_survived() {
    // One start-up.
    const SHORT: u64 = 60;
    let spoiled = |at: usize, by: u8| {
        let seen = run_for(SHORT, &[], |cycle, segment| {
            if cycle == 0 {
                segment.devices[0].spoil_eeprom(at, by);
            }
        });
        assert_eq!(seen.records.len() as u64, SHORT, "byte {at} is {by}");
    };
    for at in 0..320 {
        spoiled(at, 0xFF);
        spoiled(at, (7 * at % 256) as u8);
    }
}

#[test]
fn the_sensors_bias_is_cleared_before_the_first_sample() {
    let mut told = Vec::new();
    run(&[], |_, segment| {
        let device = &segment.devices[0];
        if device.state() == AlState::Op {
            told.push(device.outputs()[0]);
        }
    });
    assert!(told.starts_with(&[4]), "{told:?}");
    assert_eq!(told.last(), Some(&0));
}
