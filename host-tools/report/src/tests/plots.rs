//! Plots of any data.

use super::{elements, force_plot, noise, of};
use crate::{Band, Plot, Series, Style};
use proptest::prelude::*;

#[test]
fn a_plot_names_its_axes_series_and_windows() {
    let mut plot = force_plot(vec![
        Series::line("measured", vec![(0.0, 0.0), (1.0, 2.0)]),
        Series::dashed("model", vec![(0.0, 0.0), (1.0, 1.9)]),
    ]);
    plot.shaded.push(Band {
        from: 0.2,
        to: 0.7,
        label: "compression".to_owned(),
        hue: None,
    });
    plot.shaded.push(Band {
        from: 0.7,
        to: 0.701,
        label: "turning point".to_owned(),
        hue: None,
    });
    let svg = plot.to_svg().unwrap();
    elements(&svg);
    for text in [
        "Contact force",
        "time [s]",
        "force [N]",
        "measured",
        "model",
        "compression",
        "turning point",
    ] {
        assert!(svg.contains(text), "{text} is missing");
    }
    assert_eq!(
        svg.matches("stroke-dasharray").count(),
        2,
        "the dashed curve and its legend"
    );
    assert!(!svg.contains("#01"), "a stand-in colour was left");
}

#[test]
fn the_band_of_the_noise_is_in_view_and_in_the_legend() {
    let mut plot = force_plot(vec![Series::line("error", vec![(0.0, 0.0), (1.0, 0.1)])]);
    let band = |from, to| Band {
        from,
        to,
        label: "±2 σ".to_owned(),
        hue: None,
    };
    plot.corridor = Some(band(-2.0, 2.0));
    let svg = plot.to_svg().unwrap();
    assert!(svg.contains("±2 σ") && svg.contains(">\n−2\n<"), "{svg}");
    plot.corridor = Some(band(f64::NAN, f64::INFINITY));
    assert!(!plot.to_svg().unwrap().contains("±2 σ"));
}

#[test]
fn no_data_says_so() {
    let empty = force_plot(vec![]).to_svg().unwrap();
    let nothing_finite = force_plot(vec![Series::line("sensor", vec![(0.0, f64::NAN); 3])]);
    assert!(empty.contains("no data"));
    assert!(
        nothing_finite
            .to_svg()
            .unwrap()
            .contains("sensor (no data)")
    );
}

#[test]
fn a_missing_sample_splits_the_line_and_a_lonely_one_is_a_dot() {
    let points = vec![
        (0.0, 1.0),
        (1.0, 2.0),
        (2.0, f64::NAN),
        (3.0, 1.0),
        (4.0, f64::INFINITY),
        (5.0, 1.0),
        (6.0, 2.0),
    ];
    let with = |points| elements(&force_plot(vec![Series::line("", points)]).to_svg().unwrap());
    let whole = with(
        points
            .iter()
            .copied()
            .filter(|point| point.1.is_finite())
            .collect(),
    );
    let split = with(points);
    assert_eq!(of(&split, "polyline"), of(&whole, "polyline") + 1);
    assert_eq!((of(&whole, "circle"), of(&split, "circle")), (0, 1));
}

#[test]
fn constant_data_and_a_single_point_are_drawn() {
    for points in [
        vec![(1.0, 5.0)],
        vec![(0.0, 5.0), (1.0, 5.0)],
        vec![(2.0, 0.0); 4],
    ] {
        for style in [Style::Line, Style::Points, Style::Step, Style::Dashed] {
            let svg = force_plot(vec![Series::new("constant", style, points.clone())])
                .to_svg()
                .unwrap();
            assert!(!svg.contains("no data") && !svg.contains("NaN") && !svg.contains("inf"));
        }
    }
}

#[test]
fn a_minute_of_cycles_stays_below_100_kb_and_keeps_its_peak() {
    // 60 s of 4 ms cycles of wide-band noise: no column is flat.
    let mut points: Vec<(f64, f64)> = (0..15_000)
        .map(|i| (f64::from(i) * 0.004, noise(i)))
        .collect();
    points[9_876].1 = 40.0;
    let with_gaps = points
        .iter()
        .enumerate()
        .map(|(i, &(x, y))| (x, if i % 2 == 0 { y } else { f64::NAN }));
    let mut plots = vec![force_plot(vec![Series::line("gaps", with_gaps.collect())])];
    for style in [Style::Line, Style::Points, Style::Step, Style::Dashed] {
        plots.push(force_plot(vec![Series::new(
            "noise",
            style,
            points.clone(),
        )]));
    }
    for plot in &plots {
        let svg = plot.to_svg().unwrap();
        assert!(
            svg.len() < 100_000,
            "{} is {} bytes",
            plot.series[0].name,
            svg.len()
        );
    }
    let peak_only = |points: &[(f64, f64)]| {
        let plot = force_plot(vec![Series::line("", points.to_vec())]);
        highest(&plot.to_svg().unwrap())
    };
    let alone = [(0.0, 0.0), (30.0, 40.0), (59.996, 0.0)];
    assert!(
        (peak_only(&points) - peak_only(&alone)).abs() <= 8,
        "the peak has lost height"
    );
}

#[test]
fn the_legend_stands_above_the_curves() {
    let height_and_top = |name: &str| {
        let plot = force_plot(vec![Series::line(name, vec![(0.0, 0.0), (1.0, 1.0)])]);
        let svg = plot.to_svg().unwrap();
        (svg.matches("measured").count(), highest(&svg))
    };
    let (named, unnamed) = (height_and_top("measured"), height_and_top(""));
    assert_eq!((named.0, unnamed.0), (1, 0));
    assert!(named.1 >= unnamed.1 + 80, "{named:?} {unnamed:?}");
}

/// Vertical position of the highest point of the blue curve, in quarters of a pixel from the top.
fn highest(svg: &str) -> i32 {
    let mut curves = svg
        .lines()
        .filter(|line| line.contains("polyline") && line.contains("--blue"));
    // Samples in the legend come first.
    let (_, points) = curves.next_back().unwrap().split_once("points=\"").unwrap();
    let pairs = points.split(' ').filter_map(|pair| pair.split_once(','));
    pairs.map(|(_, y)| y.parse::<i32>().unwrap()).min().unwrap()
}

#[test]
fn zero_is_shown_where_it_is_asked_for() {
    let mut plot = force_plot(vec![Series::line("", vec![(0.0, 50.0), (1.0, 60.0)])]);
    assert!(
        !plot.to_svg().unwrap().contains(">\n0\n<"),
        "the x axis has only decimals and y starts near 50"
    );
    plot.y_from_zero = true;
    assert!(plot.to_svg().unwrap().contains(">\n0\n<"));
}

fn any_plot() -> impl Strategy<Value = Plot> {
    let number = proptest::num::f64::ANY;
    let style = prop_oneof![
        Just(Style::Line),
        Just(Style::Points),
        Just(Style::Step),
        Just(Style::Dashed)
    ];
    let points = proptest::collection::vec((number, number), 0..20);
    let series =
        (".*", style, points).prop_map(|(name, style, points)| Series::new(name, style, points));
    let band = (number, number, ".*").prop_map(|(from, to, label)| Band {
        from,
        to,
        label,
        hue: None,
    });
    let corridor = proptest::option::of(band.clone());
    let parts = (
        (".*", corridor),
        proptest::collection::vec(series, 0..4),
        proptest::collection::vec(band, 0..4),
    );
    (parts, any::<u32>(), any::<bool>()).prop_map(
        |(((text, corridor), series, shaded), height, zero)| Plot {
            series,
            shaded,
            corridor,
            height,
            y_from_zero: zero,
            ..Plot::new(text.clone(), text.clone(), text)
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_plot_is_drawn_and_well_formed(plot in any_plot()) {
        elements(&plot.to_svg().unwrap());
    }
}
