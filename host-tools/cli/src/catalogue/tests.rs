//! Every effect of the catalogue has a picture that shows it.

use super::*;
use softdock_physics::effects::{CATALOGUE, by_id};
use softdock_report::Plot;

/// Largest difference of two curves, as a share of the range that both cover.
fn contrast(picture: &Picture) -> f64 {
    let pairs = picture.without.iter().zip(&picture.with);
    let largest = |difference: fn(&(f64, f64), &(f64, f64)) -> f64, of: fn(&(f64, f64)) -> f64| {
        let values = || picture.without.iter().chain(&picture.with).map(of);
        let span = values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min);
        let worst = pairs.clone().map(|(a, b)| difference(a, b).abs());
        worst.fold(0.0, f64::max) / span
    };
    largest(|a, b| a.0 - b.0, |p| p.0).max(largest(|a, b| a.1 - b.1, |p| p.1))
}

#[test]
fn every_effect_is_seen_in_its_picture() {
    for effect in CATALOGUE {
        let picture = picture(effect).unwrap();
        assert_eq!(picture.without.len(), picture.with.len(), "{}", effect.id);
        let finite = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite();
        assert!(picture.with.iter().all(finite), "{}", effect.id);
        let seen = contrast(&picture);
        assert!(seen > 0.05, "{}: {seen}", effect.id);
    }
}

#[test]
fn every_picture_can_be_drawn_and_fits_a_terminal() {
    for effect in CATALOGUE {
        let picture = picture(effect).unwrap();
        let text = terminal::draw(&picture);
        for line in text.lines() {
            assert!(line.chars().count() <= 80, "{}: {line}", effect.id);
        }
        assert!(
            text.contains('·') && text.contains("with"),
            "{}\n{text}",
            effect.id
        );
        let plot: Plot = picture.to_plot(effect);
        assert!(plot.to_svg().unwrap().starts_with("<svg"), "{}", effect.id);
    }
}

#[test]
fn a_lesson_holds_everything_that_the_catalogue_knows() {
    for effect in CATALOGUE {
        let picture = picture(effect).unwrap();
        let (text, html) = (
            lesson(effect, &picture),
            page(effect, &picture).unwrap().to_html(),
        );
        let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words(&text).contains(&words(effect.equation)), "{text}");
        for parameter in effect.parameters {
            assert!(text.contains(parameter.name) && html.contains(parameter.name));
        }
        for rival in effect.confused_with {
            assert!(text.contains(rival) && html.contains(rival), "{text}");
        }
    }
}

/// A pause of 30 ms is 60 simulation steps of exactly zero velocity after the reversal, which begins at 0.304 s.
#[test]
fn the_picture_of_the_pause_is_the_equation() {
    let picture = picture(by_id("zero_cross_pause").unwrap()).unwrap();
    let still = |curve: &[(f64, f64)]| {
        let inside = curve.iter().filter(|(t, _)| (0.29..0.35).contains(t));
        inside.filter(|(_, v)| *v == 0.0).count()
    };
    assert_eq!(still(&picture.with) - still(&picture.without), 60);
}

#[test]
fn all_effects_are_in_the_overview() {
    let text: String = Group::ALL.map(|group| overview(group).to_string()).concat();
    for effect in CATALOGUE {
        assert!(text.contains(effect.id) && text.contains(effect.title));
    }
    assert!(
        text.contains("30 parameters, fx_from_fy to tz_from_ty"),
        "{text}"
    );
}
