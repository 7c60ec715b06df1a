//! Known answers of the actuator chain.

use super::*;

const TS: f64 = 0.004;

fn step(n: usize) -> Vec<f64> {
    (0..n).map(|k| if k >= 2 { 1.0 } else { 0.0 }).collect()
}

#[test]
fn whole_cycles_and_lag_follow_the_recursion_of_the_log_format() {
    let sent: Vec<f64> = (0..80).map(|k| (0.3 * f64::from(k)).sin()).collect();
    let chain = Chain::nominal(2.0 * TS, TS);
    let got = simulate(&chain, &sent, &Timing::uniform(TS), Reading::AtEnd);
    let e = (-1.0_f64).exp();
    let mut y = 0.0;
    for n in 1..80 {
        let u = if n >= 3 { sent[n - 3] } else { 0.0 };
        y = e * y + (1.0 - e) * u;
        assert!((got[n] - y).abs() < 1e-12, "{n}: {} {y}", got[n]);
    }
}

#[test]
fn a_fraction_of_a_cycle_shares_the_mean() {
    let got = simulate(
        &Chain::nominal(1.25 * TS, 0.0),
        &step(8),
        &Timing::uniform(TS),
        Reading::Mean,
    );
    for (got, expected) in got.iter().zip([0.0, 0.0, 0.0, 0.0, 0.75, 1.0, 1.0, 1.0]) {
        assert!((got - expected).abs() < 1e-12, "{got} {expected}");
    }
}

#[test]
fn stated_intervals_that_are_all_nominal_change_nothing() {
    let sent: Vec<f64> = (0..60).map(|k| (0.3 * f64::from(k)).sin()).collect();
    let intervals = vec![TS; 60];
    let timing = Timing {
        cycle_s: TS,
        intervals_s: &intervals,
    };
    for delay in [0.0, 0.3 * TS, TS, 2.7 * TS] {
        let mut chain = Chain::nominal(delay, 0.003);
        chain.pause_s = 0.006;
        let uniform = simulate(&chain, &sent, &Timing::uniform(TS), Reading::AtEnd);
        let stated = simulate(&chain, &sent, &timing, Reading::AtEnd);
        for n in 0..60 {
            assert!((uniform[n] - stated[n]).abs() < 1e-9, "{delay} {n}");
        }
    }
}

#[test]
fn a_pause_removes_exactly_its_own_duration() {
    // A triangle through zero, without lag: the output is zero for the pause, then the command.
    let sent: Vec<f64> = (0..100)
        .map(|k| 0.5 - 0.01 * f64::from(k) + 0.0005)
        .collect();
    let mut chain = Chain::nominal(0.0, 0.0);
    chain.pause_s = 0.010;
    let got = simulate(&chain, &sent, &Timing::uniform(TS), Reading::Mean);
    let without = simulate(
        &Chain::nominal(0.0, 0.0),
        &sent,
        &Timing::uniform(TS),
        Reading::Mean,
    );
    let still = got
        .iter()
        .zip(&without)
        .filter(|(g, w)| (*g - *w).abs() > 1e-9)
        .count();
    // 10 ms are two and a half cycles.
    assert_eq!(still, 3);
}

#[test]
fn a_rate_limit_has_the_slope_and_reaches_the_command() {
    let mut chain = Chain::nominal(0.0, 0.0);
    chain.drive.acceleration = 50.0;
    let got = simulate(&chain, &step(20), &Timing::uniform(TS), Reading::AtEnd);
    for (n, value) in got.iter().enumerate() {
        let expected = (0.2 * (n as f64 - 2.0)).clamp(0.0, 1.0);
        assert!((value - expected).abs() < 1e-9, "{n}: {value} {expected}");
    }
}

/// From rest to u in 2 √(u/j), half of it at half of the time, without overshoot; in the planner as
/// well.
#[test]
fn a_limit_of_jerk_makes_an_s_of_a_step() {
    let jerk = 100.0; // 200 ms to a velocity of 1
    for planner in [false, true] {
        let mut chain = Chain::nominal(0.0, 0.0);
        if planner {
            chain.planner.jerk = jerk;
        } else {
            chain.drive.jerk = jerk;
        }
        let got = simulate(&chain, &step(80), &Timing::uniform(TS), Reading::AtEnd);
        assert!((got[2 + 25] - 0.5).abs() < 0.05, "{planner}: {}", got[27]);
        assert!((got[2 + 50] - 1.0).abs() < 0.01, "{planner}: {}", got[52]);
        assert!(got.iter().all(|v| *v < 1.0 + 1e-9), "{planner}");
    }
}

#[test]
fn a_mode_overshoots_by_its_damping() {
    let mut chain = Chain::nominal(0.0, 0.0);
    chain.resonance = Some(Resonance {
        frequency_hz: 5.0,
        damping_ratio: 0.1,
    });
    let got = simulate(&chain, &step(200), &Timing::uniform(TS), Reading::AtEnd);
    let overshoot = got.iter().copied().fold(0.0, f64::max) - 1.0;
    let expected = (-std::f64::consts::PI * 0.1 / (1.0_f64 - 0.01).sqrt()).exp();
    assert!(
        (overshoot - expected).abs() < 0.01,
        "{overshoot} {expected}"
    );
}

#[test]
fn lost_motion_swallows_its_width() {
    let mut sent = vec![0.25; 40];
    sent.extend(vec![-0.25; 40]);
    let mut chain = Chain::nominal(0.0, 0.0);
    chain.backlash_m = 0.0035;
    let got = simulate(&chain, &sent, &Timing::uniform(TS), Reading::Mean);
    let displacement: f64 = got.iter().skip(41).sum::<f64>() * TS;
    assert!(
        (displacement - (-0.25 * 39.0 * TS + 0.0035)).abs() < 1e-9,
        "{displacement}"
    );
}

#[test]
fn an_axis_that_restarts_does_so_when_its_pause_ends() {
    // A step through zero is executed by a lag from rest, 4.7 ms after it has arrived.
    let sent: Vec<f64> = (0..40).map(|k| if k < 20 { 1.0 } else { -1.0 }).collect();
    let mut chain = Chain::nominal(0.0, TS);
    chain.pause_s = 0.0047;
    chain.pause_trigger = PauseTrigger::Command;
    chain.pause_kind = PauseKind::RestartsFromRest;
    let got = simulate(&chain, &sent, &Timing::uniform(TS), Reading::AtEnd);
    for (n, got) in got.iter().enumerate().skip(21) {
        let moving_s = ((n - 20) as f64 * TS - chain.pause_s).max(0.0);
        let expected = (-moving_s / TS).exp() - 1.0;
        assert!((got - expected).abs() < 1e-9, "{n}: {got} {expected}");
    }
}

/// Each kind of actuator, with a motion that rests, reverses, and meets the limits.
#[test]
fn segments_at_once_are_their_parts_one_after_the_other() {
    let sent: Vec<f64> = (0..600)
        .map(f64::from)
        .map(|k| {
            if k < 40.0 {
                0.0
            } else {
                (0.05 * k).sin() * (0.013 * k).cos()
            }
        })
        .collect();
    let jittered: Vec<f64> = (0..600)
        .map(|k| TS * (1.0 + 0.2 * (1.7 * f64::from(k)).sin()))
        .collect();
    type Change = fn(&mut Chain);
    let changes: [(&str, Change); 8] = [
        ("nominal", |_| {}),
        ("extra lag", |c| c.extra_lag_s = 0.011),
        ("mode", |c| {
            c.resonance = Some(Resonance {
                frequency_hz: 11.0,
                damping_ratio: 0.05,
            });
        }),
        ("acceleration", |c| c.drive.acceleration = 5.0),
        ("velocity", |c| c.drive.velocity = 0.6),
        ("jerk", |c| c.drive.jerk = 300.0),
        ("pause of the output", |c| c.pause_s = 0.013),
        ("pause of the command", |c| {
            c.pause_s = 0.013;
            c.pause_trigger = PauseTrigger::Command;
            c.pause_kind = PauseKind::RestartsFromRest;
        }),
    ];
    for intervals_s in [&[][..], &jittered] {
        let timing = Timing {
            cycle_s: TS,
            intervals_s,
        };
        for (first, a) in &changes {
            for (second, b) in &changes {
                for (delay, lag) in [(0.0, 0.0), (2.3 * TS, 0.0), (1.5 * TS, 0.007)] {
                    let mut chain = Chain::nominal(delay, lag);
                    a(&mut chain);
                    b(&mut chain);
                    for reading in [Reading::AtEnd, Reading::Mean] {
                        let of = |steps_exactly| {
                            simulated(&chain, &sent, &timing, reading, steps_exactly)
                        };
                        for (n, (at_once, parts)) in of(true).iter().zip(of(false)).enumerate() {
                            // Durations that occur once are right to some picoseconds.
                            assert!(
                                (at_once - parts).abs() < 1e-8,
                                "{first}, {second}, {delay} s, {lag} s, cycle {n}: {at_once} {parts}"
                            );
                        }
                    }
                }
            }
        }
    }
}

/// A telegram rounds what was sent; the planner limits the rounded velocity, and the gain acts on the planned one.
#[test]
fn rounding_planner_and_gain_act_in_this_order() {
    let mut chain = Chain::nominal(0.0, 0.0);
    (chain.command_step, chain.planner.velocity, chain.gain) = (0.04, 0.03, 0.5);
    let got = simulate(&chain, &[0.025; 5], &Timing::uniform(TS), Reading::AtEnd);
    assert!((got[4] - 0.015).abs() < 1e-12, "{got:?}");
}

/// A valve's overlap takes its part of what was rounded, and each direction has its own gain of the rest.
#[test]
fn what_is_beyond_a_dead_zone_moves_by_the_gain_of_its_direction() {
    let mut chain = Chain::nominal(0.0, 0.0);
    (chain.command_step, chain.dead_zone, chain.asymmetry) = (0.5, [-0.5, 0.25], 0.5);
    let last = |sent: f64| {
        let got = simulate(&chain, &[sent; 5], &Timing::uniform(TS), Reading::AtEnd);
        got.last().copied().unwrap_or(f64::NAN)
    };
    let expected = [(1.1, 1.125), (0.2, 0.0), (-0.4, 0.0), (-1.1, -0.25)];
    for (sent, expected) in expected {
        assert_eq!(last(sent), expected, "{sent}");
    }
}
