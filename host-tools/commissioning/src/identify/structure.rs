//! Which structure an axis has: the simplest that suffices.
//!
//! Every response (none, lag, servo) is fitted, with a pause if the axis reverses. The residual shows
//! how noisy the positions are, and all structures are fitted again with an allowance for the
//! uncertain instants of reversals. Where that leaves more than noise, limits of the acceleration and of
//! the velocity are tried as well. Each further parameter has to earn its price in 2 Δ log L. The
//! likelihood is that of the number of values that are independent of each other.

use super::answer::{Answer, mean_of_servo};
use super::judge::{Judge, leaves_more_than_noise, noise_of};
use super::misfit::{DELAY, Fit, Limit, Pause, Response, Structure, fit, residual};
use super::outcome::AxisActuator;
use super::track::Track;
use softdock_actuator::{Chain, PauseTrigger};

/// Longest delay that is looked for, s, and step of the first search, cycles.
const LONGEST_S: f64 = 0.24;
/// See [`LONGEST_S`].
const SCAN: f64 = 1.5;
/// Pauses of the first search, s.
const PAUSES_S: [f64; 4] = [0.0, 0.012, 0.03, 0.06];
/// Shares of the delay that are given to a lag at the beginning of a fit.
const SHARES: [f64; 2] = [0.3, 0.85];
/// Frequencies of a servo to begin with, Hz.
const SERVOS_HZ: [f64; 3] = [5.0, 10.0, 20.0];
/// Damping of a servo to begin with.
const DAMPING: f64 = 0.7;

/// The usual pause: it begins when the executed velocity changes sign, and the drive goes on meanwhile.
const USUAL: Pause = Pause {
    trigger: PauseTrigger::Output,
    restarts: false,
};
/// The same of an axis that executes jumps: it reverses when the command does, and that instant is
/// exact, while a crossing would be looked for between two instants of the simulation.
const OF_JUMPS: Pause = Pause {
    trigger: PauseTrigger::Command,
    restarts: false,
};
/// Pauses from which further fits begin, s. A short pause shows only by its square, so that a search that has come to zero stays
/// there.
const OTHER_PAUSES_S: [f64; 3] = [0.003, 0.009, 0.022];
/// The other forms.
const UNUSUAL: [Pause; 3] = [
    Pause {
        trigger: PauseTrigger::Output,
        restarts: true,
    },
    Pause {
        trigger: PauseTrigger::Command,
        restarts: false,
    },
    Pause {
        trigger: PauseTrigger::Command,
        restarts: true,
    },
];

/// The actuator of an axis.
pub(super) fn identify_structure(track: &Track) -> AxisActuator {
    let start = scanned(track);
    let certain = responses(track, Limit::None, &start, &[]);
    let noise = least(&certain).map_or(0.0, noise_of);
    let track = &track.with_uncertain_reversals(start.delay_s, noise);
    let again = |f: &Fit| fit(track, f.structure, &f.values);
    let mut fits: Vec<Fit> = certain.iter().map(again).collect();
    let mut judge = Judge::new(&fits);
    let mut chosen = judge.choose(&fits);
    if leaves_more_than_noise(&chosen) {
        for limit in [Limit::Planned, Limit::Executed, Limit::Velocity] {
            let limited = responses(track, limit, &start, &fits);
            fits.extend(limited);
        }
        judge = Judge::new(&fits);
        chosen = judge.choose(&fits);
    }
    let pause = chosen
        .structure
        .pause
        .map(|_| paused(track, &mut chosen, &judge));
    Answer {
        track,
        judge: &judge,
        fits: &fits,
        chosen: &chosen,
    }
    .written(pause)
}

/// Every response with a limit, or without; `before` holds those without.
fn responses(track: &Track, limit: Limit, start: &Start, before: &[Fit]) -> Vec<Fit> {
    let fitted = |response| {
        let usual = match (response, limit) {
            (Response::Direct, Limit::None) => OF_JUMPS,
            _ => USUAL,
        };
        let structure = Structure {
            response,
            pause: track.reverses().then_some(usual),
            limit,
        };
        best(track, structure, start, before)
    };
    [Response::Direct, Response::Lag, Response::Servo]
        .map(fitted)
        .into()
}

/// Delay and pause with the smallest residual.
struct Start {
    delay_s: f64,
    pause_s: f64,
}

fn scanned(track: &Track) -> Start {
    let pauses: &[f64] = if track.reverses() { &PAUSES_S } else { &[0.0] };
    let steps = (LONGEST_S / (SCAN * track.cycle_s)) as u32;
    let mut best = (f64::INFINITY, 0.0, 0.0);
    for pause_s in pauses {
        for step in 0..=steps {
            let delay_s = f64::from(step) * SCAN * track.cycle_s;
            let mut chain = Chain::nominal(delay_s, 0.0);
            chain.pause_s = *pause_s;
            chain.pause_trigger = OF_JUMPS.trigger;
            let squares: f64 = residual(track, &chain).iter().map(|r| r * r).sum();
            if squares < best.0 {
                best = (squares, delay_s, *pause_s);
            }
        }
    }
    Start {
        delay_s: best.1,
        pause_s: best.2,
    }
}

/// The best fit of a structure from several starts.
fn best(track: &Track, structure: Structure, start: &Start, before: &[Fit]) -> Fit {
    let mut starts = starts_of(structure, start);
    if structure.limit != Limit::None {
        starts = starts_with_limit(track, structure, &starts[0], before);
    }
    let fits: Vec<Fit> = starts.iter().map(|s| fit(track, structure, s)).collect();
    let best = least(&fits)
        .cloned()
        .unwrap_or_else(|| fit(track, structure, &vec![0.0; structure.count()]));
    if structure.pause.is_none() || structure.limit != Limit::None {
        return best;
    }
    let with_pause = |pause_s: &f64| {
        let mut values = best.values.clone();
        values[structure.pause_at()] = *pause_s;
        fit(track, structure, &values)
    };
    let mut all: Vec<Fit> = OTHER_PAUSES_S.iter().map(with_pause).collect();
    all.push(best);
    // There is one at least.
    least(&all).unwrap_or(&all[0]).clone()
}

/// Values from which the fits of a response with its pause begin.
fn starts_of(structure: Structure, start: &Start) -> Vec<Vec<f64>> {
    let delay_s = start.delay_s;
    let mut starts: Vec<Vec<f64>> = match structure.response {
        Response::Direct => vec![vec![delay_s]],
        Response::Lag => SHARES
            .iter()
            .map(|share| vec![(1.0 - share) * delay_s, share * delay_s])
            .collect(),
        Response::Servo => SERVOS_HZ
            .iter()
            .map(|hz| {
                let mean_s = mean_of_servo(*hz, DAMPING);
                vec![(delay_s - mean_s).max(0.0), *hz, DAMPING]
            })
            .collect(),
    };
    if structure.pause.is_some() {
        let pause_s = start.pause_s.max(0.004);
        starts.iter_mut().for_each(|values| values.push(pause_s));
    }
    starts
}

/// Initial values with a limit, from one that just acts to a much smaller one. The other values are those of the fit without a
/// limit in `before`, or, if there is none, `first`.
fn starts_with_limit(
    track: &Track,
    structure: Structure,
    first: &[f64],
    before: &[Fit],
) -> Vec<Vec<f64>> {
    let same = before
        .iter()
        .find(|f| f.structure.response == structure.response && f.structure.limit == Limit::None);
    let from = same.map_or_else(|| first.to_vec(), |f| f.values.clone());
    let most = structure.limit.never_acts(track);
    let with_limit = |share: f64| {
        let mut values = from.clone();
        values.push(share * most);
        // The ramp of the limit may have been taken for delay.
        values[DELAY] *= 0.8;
        values
    };
    [0.8, 0.3, 0.1, 0.03].map(with_limit).into()
}

/// The fit with the smallest residual.
fn least(fits: &[Fit]) -> Option<&Fit> {
    fits.iter()
        .min_by(|a, b| a.squares().total_cmp(&b.squares()))
}

/// The form of the pause in words; another form takes the place of the usual one only if it is
/// clearly better.
fn paused(track: &Track, chosen: &mut Fit, judge: &Judge) -> String {
    let pause_s = chosen.values[chosen.structure.pause_at()];
    // Shorter than this, forms do not differ.
    if pause_s < 0.5 * track.cycle_s {
        return "none".to_owned();
    }
    // Without lag or servo the forms are one.
    let direct =
        chosen.structure.response == Response::Direct && chosen.structure.limit == Limit::None;
    for form in UNUSUAL.into_iter().filter(|_| !direct) {
        let structure = Structure {
            pause: Some(form),
            ..chosen.structure
        };
        let other = fit(track, structure, &chosen.values);
        if judge.is_better(&other, chosen) {
            *chosen = other;
        }
    }
    match chosen.structure.pause {
        Some(_) if direct => "begins when the axis reverses",
        Some(Pause {
            trigger: PauseTrigger::Output,
            restarts: false,
        }) => "begins when the axis reverses, the command goes on meanwhile",
        Some(Pause {
            trigger: PauseTrigger::Output,
            restarts: true,
        }) => "begins when the axis reverses, which then starts from rest",
        Some(Pause {
            trigger: PauseTrigger::Command,
            restarts: false,
        }) => "begins when the command reverses, and goes on meanwhile",
        Some(Pause {
            trigger: PauseTrigger::Command,
            restarts: true,
        }) => "begins when the command reverses; the axis then starts from rest",
        None => "none",
    }
    .to_owned()
}
