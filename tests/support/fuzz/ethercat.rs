//! EtherCAT: frames to the simulated SubDevice, and the board's MainDevice with a SubDevice that misbehaves.

use super::Script;
use softdock_control::io::SensorSample;
use softdock_control::modes::Mode;
use softdock_experiments::scenario::Scenario;
use softdock_link::ethercat::Product;
use softdock_rig::board::virtual_time::{Simulation, simulate_disturbed};
use softdock_rig::ethercat::{Cable, Description, Segment, SubDevice};
use softdock_rig::rig::{Rig, RsiStopped};
use std::ops::ControlFlow;

/// Cycles of a session: two start-ups and a closed loop.
const CYCLES: u64 = 200;

/// Frames, each after its length: an answer is as long as its frame, or there is none.
pub(super) fn frames(input: &[u8]) {
    let devices = Product::ALL.map(|product| SubDevice::new(Description::of(product)));
    let mut segment = Segment::new(devices.to_vec());
    let mut script = Script(input);
    while let Some(frame) = script.piece() {
        let n = script.0.len() as f64;
        segment.measure([n, -n, 2.0 * n, 0.0, 0.1 * n, 0.0], 0);
        for (_, back) in segment.pass(frame) {
            assert_eq!(back.len(), frame.len().max(60));
        }
    }
}

/// A board whose segment behaves as the bytes say before each telegram. Each telegram is answered until the board asks the
/// robot to stop, which it does only in a fault, and in a fault the robot does not move.
pub(super) fn session(input: &[u8]) {
    let mut scenario = Scenario::spring_rod().unwrap();
    scenario.board.ethercat.enabled = true;
    let simulation = Simulation {
        board: &scenario.board,
        rig: Rig::new(&scenario.rig, scenario.start_pose(), 1).unwrap(),
        calibration: scenario.rig.sensor.calibration(),
        duration_s: CYCLES as f64 * scenario.board.control.robot.cycle_s,
        commands: Vec::new(),
    };
    let mut script = Script(input);
    let (mut telegrams, mut cycles) = (0, 0);
    let mut last = SensorSample::default();
    let mut mode = Mode::Hold;
    let rig = simulate_disturbed(
        simulation,
        &mut |before, segment, _| {
            telegrams = before;
            disturb(segment, &mut script);
        },
        &mut |record, _| {
            cycles += 1;
            let fresh = record.inputs.sensor;
            assert!(fresh.wrench.iter().all(|part| part.is_finite()));
            assert!(fresh.counter >= last.counter, "a sample of the past");
            last = fresh;
            mode = record.trace.mode;
            assert!(mode != Mode::Fault || record.output.correction == [0; 6]);
            ControlFlow::Continue(())
        },
    )
    .unwrap();
    assert_eq!(cycles, telegrams, "a telegram without an answer");
    match rig.stopped() {
        None => assert_eq!(cycles, CYCLES),
        Some(reason) => assert_eq!((reason, mode), (RsiStopped::Requested, Mode::Fault)),
    }
}

fn disturb(segment: &mut Segment, script: &mut Script<'_>) {
    const CABLES: [Cable; 10] = [
        Cable::Good,
        Cable::Out,
        Cable::Loses,
        Cable::Repeats,
        Cable::Delays(1_500),
        Cable::Foreign,
        Cable::Cuts,
        Cable::Echoes,
        Cable::Passes,
        Cable::Garbles,
    ];
    let Some(event) = script.byte() else {
        segment.cable = Cable::Good;
        return;
    };
    let Some(device) = segment.devices.first_mut() else {
        return;
    };
    match event % 32 {
        0 => segment.cable = script.choose(&CABLES),
        1 => segment.noise = u64::from_le_bytes(script.bytes()) | 1,
        2 => device.spoil_eeprom(
            usize::from(u16::from_le_bytes(script.bytes())),
            script.byte().unwrap_or_default(),
        ),
        3 => device.remove_object(u16::from_le_bytes(script.bytes())),
        4 => device.send_emergency(),
        5 => device.fall_to_safe_op(),
        6 => device.stands = !device.stands,
        7 => device.deaf = !device.deaf,
        8 => device.restart(),
        9 => segment.devices = vec![SubDevice::new(described(script))],
        _ => {}
    }
}

/// A SubDevice whose description comes from the bytes.
fn described(script: &mut Script<'_>) -> Description {
    let entries = |script: &mut Script<'_>| {
        (0..script.byte().unwrap_or_default() % 12)
            .map(|_| u32::from_le_bytes(script.bytes()))
            .collect()
    };
    let axia = Description::of(Product::Axia80);
    Description {
        vendor: axia.vendor ^ u32::from(script.byte().unwrap_or_default() / 128),
        inputs: entries(script),
        outputs: entries(script),
        units: script.bytes::<2>().into(),
        counts_per_unit: (
            i32::from_le_bytes(script.bytes()),
            i32::from_le_bytes(script.bytes()),
        ),
        ..axia
    }
}
