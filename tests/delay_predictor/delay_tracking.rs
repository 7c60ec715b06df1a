//! A robot whose delay changes between two contacts.

use super::case::{OMEGA, PURE, noise};
use super::repeated::{between, between_walls, speeds};
use super::run::Run;
use softdock_app::record::CycleRecord;
use softdock_control::delay::status::LawFlags;
use softdock_delay_plants::{Actuator, DelayChange, Measurement};

/// The change, s: between the first contact and the second.
const AT_S: f64 = 1.3;
const CYCLE_MS: f64 = 4.0;

fn changed(pause_s: f64, cycles: i8, measurement: Measurement) -> Run {
    let robot = Actuator {
        pause_s,
        delay_change: Some(DelayChange { at_s: AT_S, cycles }),
        ..PURE
    };
    between_walls(robot, OMEGA, measurement)
}

/// Speed after each contact over that before it.
fn restitutions(run: &Run) -> Vec<f64> {
    let all: Vec<f64> = core::iter::once(1.0).chain(speeds(run)).collect();
    all.windows(2).map(|pair| pair[1] / pair[0]).collect()
}

/// Believed delay at the end, ms.
fn delay_ms(run: &Run) -> f64 {
    let last = run.records.last();
    last.map_or(f64::NAN, |r| r.trace.law_status.delay_s * 1e3)
}

fn follows(run: &Run) -> usize {
    let flag = LawFlags::DELAY_FOLLOWED;
    let with = |r: &&CycleRecord| r.trace.law_status.flags.has(flag);
    run.records.iter().filter(with).count()
}

#[test]
fn a_changed_delay_is_found_in_the_next_contacts() {
    for pause_s in [0.0, 0.016] {
        for cycles in [-3, -2, -1, 1, 2, 4] {
            let run = changed(pause_s, cycles, noise(0.0, 0.0));
            let (e, delay_ms) = (restitutions(&run), delay_ms(&run));
            println!("pause {pause_s}, {cycles:+} cycles: {e:.4?}, {delay_ms:.2} ms");
            let truth_ms = 32.0 + CYCLE_MS * f64::from(cycles);
            // The contact is identified where the robot is measured to be, and a rebound that is right shows little of
            // the rest of a large change.
            let most_ms = if cycles > 2 { 2.5 } else { 0.6 };
            assert!((delay_ms - truth_ms).abs() < most_ms, "{delay_ms}");
            // It shows, and it is never energy.
            assert!(follows(&run) > 0 && e.iter().all(|e| (0.97..1.01).contains(e)));
            assert!(
                e[e.len() - 2..].iter().all(|e| (e - 1.0).abs() < 0.007),
                "{e:?}"
            );
        }
    }
}

/// With 0.5 N and 5 µm a single contact shows the delay to a quarter of a cycle.
#[test]
fn noise_makes_it_slower_but_no_runaway() {
    for cycles in [-2, -1, 1, 2, 4] {
        let run = changed(0.016, cycles, noise(0.5, 5e-6));
        let (e, delay_ms) = (restitutions(&run), delay_ms(&run));
        println!("noise, {cycles:+} cycles: {e:.4?}, {delay_ms:.2} ms");
        let truth_ms = 32.0 + CYCLE_MS * f64::from(cycles);
        assert!((delay_ms - truth_ms).abs() < 0.5 * CYCLE_MS, "{delay_ms}");
        assert!(e.iter().all(|e| (0.8..1.03).contains(e)), "{e:?}");
    }
}

/// A pause of another length moves an offset; it must not pass for a delay.
#[test]
fn a_wrong_pause_is_no_delay() {
    for (believed, truth) in [(0.016, 0.0), (0.016, 0.024), (0.0, 0.016)] {
        let robot = |pause_s| Actuator { pause_s, ..PURE };
        let run = between(robot(truth), robot(believed), OMEGA, noise(0.0, 0.0));
        let (e, delay_ms) = (restitutions(&run), delay_ms(&run));
        println!("pause {truth}, believed {believed}: {e:.4?}, {delay_ms:.2} ms");
        assert!((delay_ms - 32.0).abs() < 0.2 * CYCLE_MS, "{delay_ms}");
        assert!(e.iter().all(|e| (0.95..1.01).contains(e)), "{e:?}");
    }
}
