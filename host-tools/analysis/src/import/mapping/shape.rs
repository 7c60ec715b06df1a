//! From rows to those that count: a low-pass, every n-th row.

use super::channels::{Channels, Rotation};
use super::file::Filter;
use super::times::{pieces, sample_time_s};
use crate::import::starter::NoiseFloors;
use crate::import::turns::Angles;
use anyhow::ensure;
use softdock_report::number;
use softdock_statistics::{LowPass, LowPassed, noise_let_through};
use std::f64::consts::PI;
use std::ops::Range;

/// Highest order whose sections are still well conditioned.
const HIGHEST_ORDER: u32 = 12;

/// Low-passes all measured channels alike, piece by piece between gaps, drops the ends of each piece and keeps every n-th row.
/// Rows that gaps cost are reported in `told`. Returns the noise that the filter leaves.
///
/// # Errors
///
/// A cutoff that the sampling rate does not allow, before or after decimation; an order out of
/// its range; ends that leave nothing.
pub(super) fn filter(
    channels: &mut Channels,
    filter: &Filter,
    name: &str,
    told: &mut Vec<String>,
) -> anyhow::Result<NoiseFloors> {
    let rate_hz = 1.0 / sample_time_s(&channels.time_s)?;
    let trimmed = rows_trimmed(filter, rate_hz, channels.len())?;
    let (decimate, trim_s) = (filter.decimate, filter.trim_s);
    let low_pass = LowPass::new(filter.order, filter.cutoff_hz / rate_hz);
    let pieces = pieces(&channels.time_s);
    unroll(channels);
    let filtered = filter.as_modelled().on_samples(1.0 / rate_hz);
    let noise = noise_behind(filtered, channels, &pieces);
    let by_piece = |signal: &mut Vec<f64>, of: &dyn Fn(&[f64]) -> Vec<f64>| {
        let parts = pieces.iter().map(|piece| of(&signal[piece.clone()]));
        *signal = parts.collect::<Vec<_>>().concat();
    };
    // Sent velocities are exact, and the drive received them unfiltered.
    let mut sent = channels.sent.take();
    for signal in sent.iter_mut().flatten() {
        by_piece(signal, &|sent| means_ahead(sent, decimate));
    }
    for signal in channels.signals_mut() {
        by_piece(signal, &|measured| low_pass.zero_phase(measured));
    }
    channels.sent = sent;
    let kept = rows_kept(&pieces, decimate, trimmed);
    let stretches = pieces.len();
    if trimmed > 0 && stretches > 1 {
        let left = rows_kept(&pieces, 1, trimmed);
        told.push(format!(
            "{name}: trim_s = {trim_s} is taken from both ends of each of {stretches} stretches between gaps, which leaves {} of \
             {} rows; `gaps = \"bridge\"` in [time] fills short gaps before",
            left.iter().filter(|left| **left).count(),
            left.len()
        ));
    }
    if decimate > 1 {
        less_than_half_a_turn(channels, &kept, decimate)?;
    }
    let proposed = fewer_rows(filter, rate_hz, kept.len());
    told.extend(proposed.filter(|note| !told.contains(note)));
    channels.keep(|n| kept[n]);
    normalise(channels);
    Ok(noise)
}

/// Proposes to keep fewer of so many rows, where they say no more than some of them do.
fn fewer_rows(filter: &Filter, rate_hz: f64, rows: usize) -> Option<String> {
    /// Rows for each period of the cutoff: differences of eighth order are then exact to (2π/6)⁸/630, a five-hundredth.
    const ENOUGH: f64 = 6.0;
    /// Fewer rows take no time.
    const MANY: usize = 5000;
    let most = (rate_hz / (ENOUGH * filter.cutoff_hz)) as usize;
    (filter.decimate == 1 && most > 1 && rows > MANY).then(|| {
        format!(
            "behind `cutoff_hz = {}` {} rows per second say no more than {} do: `decimate = {most}` in [filter] makes a \
             diagnosis {most} times as fast",
            filter.cutoff_hz,
            number::significant(rate_hz, 3),
            number::significant(rate_hz / most as f64, 3)
        )
    })
}

/// Mean of so many values from each row on: the velocity that was sent until the next row that is kept.
fn means_ahead(series: &[f64], rows: usize) -> Vec<f64> {
    let mean = |n: usize| {
        let ahead = &series[n..series.len().min(n + rows)];
        ahead.iter().sum::<f64>() / ahead.len() as f64
    };
    (0..series.len()).map(mean).collect()
}

/// Noise that a filter will leave on the measured channels, estimated in the longest of the `pieces`; of orientations only if
/// they are angles.
fn noise_behind(filter: LowPassed, channels: &Channels, pieces: &[Range<usize>]) -> NoiseFloors {
    let longest = pieces.iter().max_by_key(|piece| piece.len());
    let largest = |signals: &[Vec<f64>]| {
        let noise = |signal: &Vec<f64>| noise_let_through(&signal[longest?.clone()], filter);
        let above_0 = |noise: &f64| *noise > 0.0;
        signals
            .iter()
            .filter_map(noise)
            .filter(above_0)
            .reduce(f64::max)
    };
    let of_axes = |signals: &Option<[Vec<f64>; 6]>| {
        let halves = signals.as_ref().map(|signals| signals.split_at(3));
        halves.map_or([None; 2], |(linear, angular)| {
            [linear, angular].map(largest)
        })
    };
    let angle = match &channels.orientation {
        Some(Rotation::Angles(angles)) => largest(std::slice::from_ref(&angles.rad)),
        _ => None,
    };
    NoiseFloors {
        wrench: of_axes(&channels.wrench),
        velocity: of_axes(&channels.executed),
        pose: [channels.position.as_ref().and_then(|p| largest(p)), angle],
    }
}

/// Checks a filter for so many rows. Returns how many it leaves out at each end.
fn rows_trimmed(filter: &Filter, rate_hz: f64, rows: usize) -> anyhow::Result<usize> {
    let Filter {
        cutoff_hz,
        order,
        decimate,
        trim_s,
    } = *filter;
    ensure!(
        decimate >= 1 && decimate < rows,
        "[filter] decimate is {decimate}; allowed is 1 to {}",
        rows.saturating_sub(1)
    );
    let highest = 0.5 * rate_hz / decimate as f64;
    ensure!(
        cutoff_hz > 0.0 && cutoff_hz < highest,
        "[filter] cutoff_hz is {cutoff_hz}; allowed is above 0 and below {} Hz, half of the rate \
         after decimation",
        number::significant(highest, 3)
    );
    ensure!(
        (1..=HIGHEST_ORDER).contains(&order),
        "[filter] order is {order}; allowed is 1 to {HIGHEST_ORDER}"
    );
    let trimmed = (trim_s * rate_hz).round();
    let most = (rows / decimate).saturating_sub(2) as f64 * 0.5 * decimate as f64;
    ensure!(
        (0.0..=most).contains(&trimmed),
        "[filter] trim_s is {trim_s}; allowed is 0 to {} s, so that two rows are left",
        number::significant(most / rate_hz, 3)
    );
    Ok(trimmed as usize)
}

/// Whether a row is kept: every n-th row of each piece without its ends.
fn rows_kept(pieces: &[Range<usize>], decimate: usize, trimmed: usize) -> Vec<bool> {
    let kept = |count: usize| {
        (0..count).map(move |n| n % decimate == 0 && n >= trimmed && n + trimmed < count)
    };
    pieces.iter().flat_map(|piece| kept(piece.len())).collect()
}

/// Refuses a decimation that leaves rotations of half a turn or more between kept rows. A pose does not tell their direction, and
/// the angles and velocities in between, which do, would be lost.
fn less_than_half_a_turn(
    channels: &Channels,
    kept: &[bool],
    decimate: usize,
) -> anyhow::Result<()> {
    let (most, _) = largest_turn(channels, |n| kept[n]);
    let (of_rows, _) = largest_turn(channels, |_| true);
    ensure!(
        decimate == 1 || most < PI,
        "[filter] decimate is {decimate}: from a row that is kept to the next it turns by up to {} rad, and of half a turn or more \
         nobody can tell which way; allowed is up to {}",
        number::significant(most, 3),
        ((PI / of_rows).ceil() as usize).saturating_sub(1).max(1)
    );
    Ok(())
}

/// Largest rotation between successive `kept` rows of a piece, rad, and the time of the first of them, s. 0 for quaternions; also
/// for a velocity without an orientation in a log without commands, as it continues to tell how far the axis turned.
pub(super) fn largest_turn(channels: &Channels, kept: impl Fn(usize) -> bool) -> (f64, f64) {
    let times = &channels.time_s;
    let speed = |[.., rx, ry, rz]: &[Vec<f64>; 6], n: usize| rx[n].hypot(ry[n]).hypot(rz[n]);
    let turn = |from: usize, to: usize| match (&channels.orientation, &channels.executed) {
        (Some(Rotation::Angles(angles)), _) => (angles.rad[to] - angles.rad[from]).abs(),
        // The motion of a log with commands is simulated: it turns by another velocity than the measured one.
        (None, Some(velocity)) if channels.sent.is_some() => {
            0.5 * (speed(velocity, from) + speed(velocity, to)) * (times[to] - times[from])
        }
        _ => 0.0,
    };
    let of_piece = |piece: Range<usize>| {
        let rows: Vec<usize> = piece.filter(|n| kept(*n)).collect();
        let turns = rows
            .windows(2)
            .map(|pair| (turn(pair[0], pair[1]), times[pair[0]]));
        turns.collect::<Vec<_>>()
    };
    let turns = pieces(times).into_iter().flat_map(of_piece);
    turns.fold(
        (0.0, 0.0),
        |most, turn| if turn.0 > most.0 { turn } else { most },
    )
}

/// Prepares orientations to be filtered or interpolated. Rotations about one axis become angles: a joint may turn fast, and its
/// quaternion then oscillates. Other quaternions are kept from jumping to their negatives, which are the same orientation, but
/// not to a filter.
pub(super) fn unroll(channels: &mut Channels) {
    let Some(Rotation::Quaternions(parts)) = &mut channels.orientation else {
        return;
    };
    if let Some(angles) = Angles::of_quaternions(parts) {
        channels.orientation = Some(Rotation::Angles(angles));
        return;
    }
    // Rows without a quaternion are skipped.
    let mut last = 0;
    for n in 0..parts[0].len() {
        let along: f64 = parts.iter().map(|part| part[n] * part[last]).sum();
        if along < 0.0 {
            parts.iter_mut().for_each(|part| part[n] = -part[n]);
        }
        if parts.iter().all(|part| part[n].is_finite()) {
            last = n;
        }
    }
}

/// Normalises quaternions after a filter or an interpolation.
pub(super) fn normalise(channels: &mut Channels) {
    let Some(Rotation::Quaternions(parts)) = &mut channels.orientation else {
        return;
    };
    for n in 0..parts[0].len() {
        let squares: f64 = parts.iter().map(|part| part[n] * part[n]).sum();
        if squares > 0.0 {
            let length = squares.sqrt();
            parts.iter_mut().for_each(|part| part[n] /= length);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fewer_rows_are_proposed_where_they_say_as_much() {
        let proposed = |rate_hz: f64, rows: usize, decimate: usize| {
            let low_pass = Filter {
                cutoff_hz: 10.0,
                order: 4,
                decimate,
                trim_s: 0.0,
            };
            fewer_rows(&low_pass, rate_hz, rows)
        };
        let told = proposed(250.0, 9000, 1).unwrap();
        assert!(
            told.contains("250 rows per second say no more than 62.5 do")
                && told.contains("`decimate = 4`"),
            "{told}"
        );
        for nothing in [(100.0, 9000, 1), (250.0, 900, 1), (250.0, 9000, 4)] {
            let (rate_hz, rows, decimate) = nothing;
            assert_eq!(proposed(rate_hz, rows, decimate), None, "{nothing:?}");
        }
    }

    /// A spindle at 300 rad/s: the parts of its quaternion swing at 24 Hz, above the cutoff, and its angle is a ramp.
    #[test]
    fn a_fast_turn_is_filtered_as_its_angle() {
        let half = |n: usize| 0.5 * 300.0 * 1e-3 * n as f64;
        let part =
            |of: fn(f64) -> f64, scale: f64| (0..1000).map(|n| scale * of(half(n))).collect();
        let mut channels = Channels {
            rows: Vec::new(),
            time_s: (0..1000).map(|n| 1e-3 * f64::from(n)).collect(),
            running: vec![false; 1000],
            position: None,
            orientation: Some(Rotation::Quaternions([
                part(f64::cos, 1.0),
                part(f64::sin, 0.6),
                part(f64::sin, 0.0),
                part(f64::sin, -0.8),
            ])),
            sent: None,
            executed: None,
            model_velocity: None,
            wrench: None,
        };
        let expected = channels.orientation.clone().unwrap();
        let low_pass = Filter {
            cutoff_hz: 10.0,
            order: 4,
            decimate: 1,
            trim_s: 0.1,
        };
        filter(&mut channels, &low_pass, "log.csv", &mut Vec::new()).unwrap();
        let filtered = channels.orientation.unwrap();
        for n in 0..channels.time_s.len() {
            let [a, b] = [filtered.quaternion(n), expected.quaternion(n + 100)];
            let along: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
            assert!(along.abs() > 1.0 - 1e-9, "{n}: {along}");
        }
    }

    /// 1 rad per row: three rows together are less than half a turn, four are more. A velocity without an angle tells the
    /// rotation at any spacing of rows.
    #[test]
    fn rows_between_which_turns_are_lost_are_kept() {
        let turning = |by_velocity: bool, decimate: usize| {
            let half = |of: fn(f64) -> f64| (0..1000).map(|n| of(0.5 * f64::from(n))).collect();
            let still = vec![0.0; 1000];
            let mut velocity = [(); 6].map(|()| still.clone());
            velocity[3].fill(1000.0);
            let mut channels = Channels {
                rows: Vec::new(),
                time_s: (0..1000).map(|n| f64::from(n) * 0.001).collect(),
                running: vec![true; 1000],
                position: None,
                orientation: (!by_velocity).then(|| {
                    let parts = [half(f64::cos), half(f64::sin), still.clone(), still];
                    Rotation::Quaternions(parts)
                }),
                sent: None,
                executed: by_velocity.then_some(velocity),
                model_velocity: None,
                wrench: None,
            };
            let low_pass = Filter {
                cutoff_hz: 20.0,
                order: 2,
                decimate,
                trim_s: 0.0,
            };
            filter(&mut channels, &low_pass, "log.csv", &mut Vec::new())
        };
        assert!(turning(false, 1).is_ok() && turning(false, 3).is_ok());
        let refused = turning(false, 4).unwrap_err().to_string();
        assert!(refused.ends_with("allowed is up to 3"), "{refused}");
        assert!(turning(true, 4).is_ok());
    }
}
