//! Fewer points, same picture: what a screen cannot show is left out, what stands out stays.
//!
//! A recording has ten to a hundred points per pixel column. Drawing first, lowest, highest and last of each column
//! gives the same pixels as drawing all, so that a peak of one cycle survives.

use super::ticks::LARGEST;

/// A point in the units of the data.
pub(super) type Point = (f64, f64);

/// Above this many pieces, gaps narrower than a pixel are no longer shown as gaps.
const MAX_PIECES: usize = 200;

/// Points of a line that runs back and forth in x, where columns do not bound the number.
const MAX_LOOP_POINTS: usize = 4000;

/// Markers of a cloud of points.
const MAX_MARKERS: usize = 1000;

/// Whether a point can be drawn at all.
pub(super) fn drawable(point: &Point) -> bool {
    point.0.abs() <= LARGEST && point.1.abs() <= LARGEST
}

/// Splits a line at points that cannot be drawn, and thins each piece; `column` is the pixel column of an x.
pub(super) fn line(points: &[Point], column: impl Fn(f64) -> i64) -> Vec<Vec<Point>> {
    let mut pieces: Vec<Vec<Point>> = points
        .split(|point| !drawable(point))
        .filter(|piece| !piece.is_empty())
        .map(<[Point]>::to_vec)
        .collect();
    if pieces.len() > MAX_PIECES {
        pieces = bridge_invisible_gaps(pieces, &column);
    }
    pieces
        .into_iter()
        .map(|piece| thin(&piece, &column))
        .collect()
}

/// Thins a cloud of points: one marker per cell of a grid that is coarsened until few enough remain, plus the lowest
/// and the highest of each column of about one marker's width. `pixel` is the pixel that a point falls on.
pub(super) fn cloud(points: &[Point], pixel: impl Fn(Point) -> (i64, i64)) -> Vec<Point> {
    let points: Vec<Point> = points.iter().copied().filter(drawable).collect();
    if points.len() <= MAX_MARKERS {
        return points;
    }
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by_key(|&index| pixel(points[index]).0);
    let mut kept: Vec<usize> = order
        .chunk_by(|&a, &b| pixel(points[a]).0 / 8 == pixel(points[b]).0 / 8)
        .flat_map(|column| extremes(column.iter().map(|&index| (index, points[index].1))))
        .collect();
    kept.extend(one_per_cell(&points, &pixel));
    kept.sort_unstable();
    kept.dedup();
    kept.into_iter().map(|index| points[index]).collect()
}

fn one_per_cell(points: &[Point], pixel: &impl Fn(Point) -> (i64, i64)) -> Vec<usize> {
    let mut cell_px = 2;
    loop {
        let mut seen = std::collections::HashSet::new();
        let first_in_cell = points.iter().enumerate().filter(|&(_, &point)| {
            let (x, y) = pixel(point);
            seen.insert((x / cell_px, y / cell_px))
        });
        let kept: Vec<usize> = first_in_cell.map(|(index, _)| index).collect();
        // The second condition only ends the search for pixels that are not on any screen.
        if kept.len() <= MAX_MARKERS || cell_px > 1 << 20 {
            return kept;
        }
        cell_px *= 2;
    }
}

fn bridge_invisible_gaps(pieces: Vec<Vec<Point>>, column: &impl Fn(f64) -> i64) -> Vec<Vec<Point>> {
    let mut bridged: Vec<Vec<Point>> = Vec::new();
    for piece in pieces {
        match (bridged.last_mut(), piece.first()) {
            (Some(last), Some(&(start, _)))
                if last
                    .last()
                    .is_some_and(|&(end, _)| (column(start) - column(end)).abs() <= 1) =>
            {
                last.extend(piece);
            }
            _ => bridged.push(piece),
        }
    }
    bridged
}

fn thin(piece: &[Point], column: &impl Fn(f64) -> i64) -> Vec<Point> {
    let kept: Vec<usize> = if piece.is_sorted_by(|a, b| a.0 <= b.0) {
        let indices: Vec<usize> = (0..piece.len()).collect();
        indices
            .chunk_by(|&a, &b| column(piece[a].0) == column(piece[b].0))
            .flat_map(|chunk| keep(chunk, piece, false))
            .collect()
    } else if piece.len() <= MAX_LOOP_POINTS {
        return piece.to_vec();
    } else {
        // Six points are kept of each chunk.
        let chunk_length = piece.len().div_ceil(MAX_LOOP_POINTS / 6);
        let indices: Vec<usize> = (0..piece.len()).collect();
        indices
            .chunks(chunk_length)
            .flat_map(|chunk| keep(chunk, piece, true))
            .collect()
    };
    kept.into_iter().map(|index| piece[index]).collect()
}

/// First, lowest, highest and last of a chunk (and leftmost and rightmost if asked), in their order.
fn keep(chunk: &[usize], points: &[Point], horizontal: bool) -> Vec<usize> {
    let mut kept: Vec<usize> = chunk
        .first()
        .into_iter()
        .chain(chunk.last())
        .copied()
        .collect();
    kept.extend(extremes(
        chunk.iter().map(|&index| (index, points[index].1)),
    ));
    if horizontal {
        kept.extend(extremes(
            chunk.iter().map(|&index| (index, points[index].0)),
        ));
    }
    kept.sort_unstable();
    kept.dedup();
    kept
}

/// Indices of the lowest and of the highest value.
fn extremes(values: impl Iterator<Item = (usize, f64)> + Clone) -> impl Iterator<Item = usize> {
    let lowest = values.clone().min_by(|a, b| a.1.total_cmp(&b.1));
    let highest = values.max_by(|a, b| a.1.total_cmp(&b.1));
    lowest.into_iter().chain(highest).map(|(index, _)| index)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_peak_of_one_sample_survives() {
        let mut points: Vec<Point> = (0..15_000).map(|i| (f64::from(i), 0.0)).collect();
        points[7_321].1 = 5.0;
        points[7_322].1 = -6.0;
        let thinned = line(&points, |x| (x / 20.0) as i64);
        assert_eq!(thinned.len(), 1);
        assert!(thinned[0].len() <= 4 * 751);
        assert!(thinned[0].contains(&(7_321.0, 5.0)) && thinned[0].contains(&(7_322.0, -6.0)));
    }

    #[test]
    fn a_line_breaks_at_what_cannot_be_drawn() {
        let points = [
            (0.0, 1.0),
            (1.0, f64::NAN),
            (2.0, 2.0),
            (3.0, 3.0),
            (f64::INFINITY, 1.0),
            (5.0, 1.0),
        ];
        let pieces = line(&points, |x| x as i64);
        assert_eq!(
            pieces,
            [
                vec![(0.0, 1.0)],
                vec![(2.0, 2.0), (3.0, 3.0)],
                vec![(5.0, 1.0)]
            ]
        );
    }

    #[test]
    fn a_gap_in_every_second_sample_does_not_make_thousands_of_pieces() {
        let points: Vec<Point> = (0..15_000)
            .map(|i| (f64::from(i), if i % 2 == 0 { 1.0 } else { f64::NAN }))
            .collect();
        assert_eq!(line(&points, |x| (x / 20.0) as i64).len(), 1);
    }

    #[test]
    fn a_loop_keeps_its_corners() {
        let points: Vec<Point> = (0..20_000)
            .map(|i| f64::from(i) * 0.01)
            .map(|angle| (angle.cos(), angle.sin()))
            .collect();
        let thinned = line(&points, |x| (x * 300.0) as i64);
        let widest = thinned[0].iter().map(|point| point.0).fold(0.0, f64::max);
        assert!(thinned[0].len() <= MAX_LOOP_POINTS + 6 && widest > 0.999_99);
    }

    proptest! {
        #[test]
        fn a_cloud_stays_small_and_keeps_its_extremes(seed in proptest::collection::vec((0.0..600.0, 0.0..200.0), 2000)) {
            let kept = cloud(&seed, |(x, y)| (x as i64, y as i64));
            let highest = |points: &[Point]| points.iter().map(|point| point.1).fold(f64::MIN, f64::max);
            prop_assert!(kept.len() <= MAX_MARKERS + 2 * 76);
            prop_assert!(highest(&kept) >= highest(&seed));
        }
    }
}
