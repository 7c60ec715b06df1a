//! Duplicates, gaps, new runs, and what the robot reports about the answers.

use crate::bench::{Bench, CRUISE_COUNTS, CYCLE_US, START_CYCLES, counts, flying, robot};
use crate::sensor::Behaviour;
use softdock_control::io::Sequence;
use softdock_control::limits::LimitFlags;
use softdock_control::modes::{FaultCode, Mode};
use softdock_control::settings::CorrectionMode;

fn assert_cruise(correction: [i64; 6]) {
    assert!((correction[0] - CRUISE_COUNTS).abs() <= 1, "{correction:?}");
}

#[test]
fn a_duplicate_gets_the_same_bytes_and_no_cycle() {
    let mut bench = Bench::cruising(&flying());
    let (ipoc, telegram) = (bench.says.ipoc, bench.telegram());
    let first = bench.datagram(&telegram, robot()).unwrap();
    assert_cruise(counts(&bench.parse(&first)));
    let before = (bench.status().link, bench.last_record());
    for _ in 0..3 {
        let again = bench.datagram(&telegram, robot()).unwrap();
        assert_eq!(again.bytes, first.bytes);
    }
    assert_eq!(bench.last_record(), before.1);
    assert_eq!(bench.status().link.cycles, before.0.cycles);
    assert_eq!(bench.status().link.duplicates, before.0.duplicates + 3);
    // The next telegram continues from there.
    bench.says.ipoc = ipoc + CYCLE_US / 1000;
    assert_cruise(counts(&bench.cycle()));
    assert_eq!(bench.last_record().inputs.robot.sequence, Sequence::Next);
    assert_eq!(bench.status().link.lost, 0);
}

/// A telegram that was overtaken in the network does not begin a new run: an absolute offset is held.
#[test]
fn an_old_telegram_that_comes_late_changes_nothing() {
    let mut bench = Bench::cruising(&settings(CorrectionMode::Absolute));
    let (ipoc, old) = (bench.says.ipoc, bench.telegram());
    let held = counts(&bench.cycle());
    let held_now = counts(&bench.cycle());
    let before = (bench.status().link, bench.last_record());
    let answer = bench.datagram(&old, robot()).unwrap();
    let answer = bench.parse(&answer);
    assert_eq!((answer.ipoc, counts(&answer)), (ipoc, held_now));
    assert_eq!(bench.last_record(), before.1);
    let link = bench.status().link;
    assert_eq!(link.overtaken, before.0.overtaken + 1);
    assert_eq!(link.duplicates, before.0.duplicates);
    bench.says.ipoc = ipoc + 2 * CYCLE_US / 1000;
    let next = counts(&bench.cycle());
    assert_eq!(bench.last_record().inputs.robot.sequence, Sequence::Next);
    assert_cruise([next[0] - held_now[0], 0, 0, 0, 0, 0]);
    assert!(held[0] < held_now[0]);
    assert_eq!(bench.fault(), None);
}

#[test]
fn a_gap_is_counted_and_not_made_up_for() {
    let mut bench = Bench::cruising(&flying());
    for lost in [1, 3, 10] {
        let before = bench.status().link.lost;
        bench.lose(lost);
        assert_cruise(counts(&bench.cycle()));
        assert_eq!(u64::from(bench.status().link.lost - before), lost);
    }
    bench.lose(11);
    assert_eq!(counts(&bench.cycle()), [0; 6]);
    bench.assert_fault(FaultCode::TelegramsLost, 10.0, 11.0);
}

#[test]
fn a_time_stamp_that_jumps_is_a_new_run() {
    type Jump = fn(u64) -> u64;
    let jumps: [Jump; 3] = [|ipoc| ipoc - 20, |_| 0, |ipoc| ipoc + 4 * 200];
    for jump in jumps {
        let mut bench = Bench::new(&flying(), false);
        bench.cycles(3);
        bench.says.ipoc = jump(bench.says.ipoc);
        assert_eq!(counts(&bench.cycle()), [0; 6]);
        assert_eq!(bench.status().link.runs, 2);
        assert_eq!(bench.status().mode, Mode::Idle);

        let mut bench = Bench::cruising(&flying());
        bench.says.ipoc = jump(bench.says.ipoc);
        assert_eq!(counts(&bench.cycle()), [0; 6]);
        bench.assert_fault(FaultCode::RobotRestarted, 0.0, 0.0);
    }
}

/// The first telegram of a controller may contain only the counter: the box is then centred on the first pose that comes.
#[test]
fn a_run_that_begins_without_a_pose_has_its_box_where_the_robot_is() {
    let mut bench = Bench::new(&flying(), true);
    let pose = bench.says.actual_pose.take();
    bench.cycle();
    bench.says.actual_pose = pose.map(|[x, y, z, a, b, c]| [x + 3000.0, y, z, a, b, c]);
    bench.cycles(START_CYCLES);
    assert_cruise(counts(&bench.cycle()));
    let trace = bench.last_record().trace;
    assert_eq!(trace.limits, LimitFlags::default());
}

/// A cause of a fault.
type Cause = (FaultCode, fn(&mut Bench));

const CAUSES: [Cause; 7] = [
    (FaultCode::TelegramsLost, |bench| bench.lose(50)),
    (FaultCode::LateAnswers, |bench| {
        bench.says.late_answers = Some(26);
    }),
    (FaultCode::PoseLost, |bench| bench.says.actual_pose = None),
    (FaultCode::SensorStatus, |bench| {
        bench.world().sensor.status = 0x4000;
    }),
    (FaultCode::SensorSaturated, |bench| {
        bench.world().sensor.gauges[1] = i16::MIN;
    }),
    (FaultCode::Overload, |bench| {
        // 31 N·m; 20 are allowed.
        bench.world().sensor.gauges[3] = 31_000;
    }),
    (FaultCode::SensorStale, |bench| {
        bench.world().sensor.behaviour = Behaviour::Silent;
        bench.cycles(5);
    }),
];

/// Settings with which every cause of [`CAUSES`] is a fault.
fn settings(mode: CorrectionMode) -> softdock_app::settings::BoardSettings {
    let mut settings = flying();
    settings.control.robot.correction_mode = mode;
    settings.control.limits.torque_n_m = 20.0;
    settings
}

#[test]
fn every_telegram_is_answered_in_every_fault() {
    for (code, cause) in CAUSES {
        let mut bench = Bench::cruising(&settings(CorrectionMode::Relative));
        cause(&mut bench);
        for _ in 0..100 {
            let answer = bench.cycle();
            assert_eq!(bench.fault(), Some(code));
            assert_eq!(counts(&answer), [0; 6], "{code:?}");
            assert_eq!(answer.stop, code == FaultCode::Overload);
        }
    }
}

#[test]
fn an_absolute_offset_is_held_in_every_fault() {
    for (code, cause) in CAUSES {
        let mut bench = Bench::cruising(&settings(CorrectionMode::Absolute));
        let before = counts(&bench.cycle());
        assert!(before[0] > 10 * CRUISE_COUNTS);
        cause(&mut bench);
        let held = counts(&bench.cycle());
        assert_eq!(bench.fault(), Some(code));
        // A silent sensor is detected after some cycles, in which the motion fades out.
        let cycles = if code == FaultCode::SensorStale { 5 } else { 0 };
        let moved = held[0] - before[0];
        assert!(
            (0..=cycles * CRUISE_COUNTS).contains(&moved),
            "{code:?} {moved}"
        );
        for _ in 0..100 {
            assert_eq!(counts(&bench.cycle()), held, "{code:?}");
        }
    }
}

#[test]
fn a_new_run_forgets_the_absolute_offset() {
    let mut bench = Bench::cruising(&settings(CorrectionMode::Absolute));
    assert_ne!(counts(&bench.cycle()), [0; 6]);
    bench.says.ipoc = 0;
    for _ in 0..10 {
        assert_eq!(counts(&bench.cycle()), [0; 6]);
    }
    assert_eq!(bench.fault(), Some(FaultCode::RobotRestarted));
}

#[test]
fn late_answers_fault_by_their_rise_only() {
    let mut bench = Bench::new(&flying(), true);
    bench.says.late_answers = Some(1000);
    bench.cycles(50);
    bench.says.late_answers = Some(1025);
    bench.cycle();
    assert_eq!(bench.status().mode, Mode::Running);
    bench.says.late_answers = Some(1026);
    assert_eq!(counts(&bench.cycle()), [0; 6]);
    bench.assert_fault(FaultCode::LateAnswers, 25.0, 26.0);
}

#[test]
fn a_clamping_robot_freezes_the_model_and_then_faults() {
    let mut bench = Bench::cruising(&flying());
    let before = bench.last_record().trace.body_k;
    bench.says.poscorr_stat = Some(1 | 1 << 4);
    for _ in 0..25 {
        bench.cycle();
        let trace = bench.last_record().trace;
        assert!(trace.limits.has(LimitFlags::ROBOT_CLAMP));
        assert_eq!(trace.body_k, before);
        assert_eq!(trace.mode, Mode::Running);
    }
    bench.cycle();
    bench.assert_fault(FaultCode::SustainedClamp, 25.0, 26.0);

    // Bit 0 only says that POSCORR is active.
    let mut bench = Bench::cruising(&flying());
    bench.says.poscorr_stat = Some(1);
    bench.cycle();
    assert_eq!(bench.last_record().trace.limits, LimitFlags::default());
}
