//! Colours, as CSS variables with a light and a dark value, and their stand-ins while a plot is drawn.
//!
//! Plotters writes fixed colours. A report wants colours that follow the reader's light or dark setting. So plots are
//! drawn in stand-in colours that occur nowhere else, and [`themed`] replaces them by `var(--name, light)`. The light
//! value after the comma keeps an SVG readable that somebody cut out of its page.

use plotters::style::RGBColor;

/// Colour of a series or a bar, from a palette that colour-blind readers can tell apart (after Okabe and Ito, 2008,
/// "Color Universal Design"; amber and purple darkened for contrast on white, all lightened for dark pages).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hue {
    /// First default colour.
    Blue,
    /// Second default colour.
    Vermilion,
    /// Third default colour.
    Green,
    /// Fourth default colour.
    Purple,
    /// Fifth default colour.
    Amber,
    /// Sixth default colour; also suits limits and references.
    Grey,
}

impl Hue {
    const ALL: [Self; 6] = [
        Self::Blue,
        Self::Vermilion,
        Self::Green,
        Self::Purple,
        Self::Amber,
        Self::Grey,
    ];

    /// Default colour of the series with this index; the palette repeats after six.
    pub fn of_series(index: usize) -> Self {
        Self::ALL[index % Self::ALL.len()]
    }

    /// Tint of the shaded windows with this label index; starts with the quiet colours.
    pub(super) fn of_band(index: usize) -> Self {
        let tints = [
            Self::Grey,
            Self::Amber,
            Self::Blue,
            Self::Purple,
            Self::Green,
        ];
        tints[index % tints.len()]
    }
}

/// What a mark is drawn with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Paint {
    /// Text.
    Ink,
    /// Axes, tick labels, secondary text.
    Muted,
    /// Grid lines.
    Grid,
    /// Background of the plot.
    Panel,
    /// Something got better.
    Good,
    /// Something got worse.
    Bad,
    /// A palette colour.
    Hue(Hue),
}

/// Each paint with its CSS variable, its light and its dark value.
const PAINTS: [(Paint, &str, &str, &str); 12] = [
    (Paint::Ink, "ink", "#1b2430", "#e4e9f0"),
    (Paint::Muted, "muted", "#566270", "#9fabb9"),
    (Paint::Grid, "grid", "#e4e8ed", "#2b333e"),
    (Paint::Panel, "panel", "#ffffff", "#171c23"),
    (Paint::Good, "good", "#00755a", "#35c79c"),
    (Paint::Bad, "bad", "#b8431a", "#ff8a55"),
    (Paint::Hue(Hue::Blue), "blue", "#0072b2", "#4aa8ec"),
    (
        Paint::Hue(Hue::Vermilion),
        "vermilion",
        "#d55e00",
        "#ff8a3d",
    ),
    (Paint::Hue(Hue::Green), "green", "#009e73", "#2fd0a0"),
    (Paint::Hue(Hue::Purple), "purple", "#b5558f", "#e59bc8"),
    (Paint::Hue(Hue::Amber), "amber", "#c98600", "#f2c94c"),
    (Paint::Hue(Hue::Grey), "grey", "#6b7785", "#a3afbd"),
];

/// Dash pattern of dashed lines, in drawing units (see `canvas::SCALE`).
const DASHES: &str = "20 14";

impl Paint {
    /// Stand-in for a solid mark.
    pub(super) fn solid(self) -> RGBColor {
        RGBColor(1, self.index(), 0)
    }

    /// Stand-in for a dashed line: drawn as one path and dashed by the browser, instead of one element per dash.
    pub(super) fn dashed(self) -> RGBColor {
        RGBColor(1, self.index(), 1)
    }

    fn index(self) -> u8 {
        let index = PAINTS.iter().position(|(paint, ..)| *paint == self);
        index.and_then(|i| u8::try_from(i).ok()).unwrap_or(0)
    }
}

/// Replaces the stand-in colours of a drawn SVG by theme variables.
///
/// A stand-in is only recognised as a whole quoted attribute; text has its quotes escaped, so it cannot be hit.
pub(super) fn themed(svg: &str) -> String {
    let mut themed = svg.to_owned();
    for (paint, name, light, _) in PAINTS {
        let index = paint.index();
        let variable = format!("\"var(--{name},{light})\"");
        themed = themed.replace(&format!("\"#01{index:02X}00\""), &variable);
        let dashed = format!("{variable} stroke-dasharray=\"{DASHES}\"");
        themed = themed.replace(&format!("\"#01{index:02X}01\""), &dashed);
    }
    themed
}

/// The variables as CSS: light by default and in print, dark on screens that ask for it.
pub(super) fn css() -> String {
    let variables =
        |value: fn(&(Paint, &str, &'static str, &'static str)) -> &'static str| -> String {
            PAINTS
                .iter()
                .map(|paint| format!("--{}:{};", paint.1, value(paint)))
                .collect()
        };
    format!(
        ":root{{color-scheme:light dark;{}}}\n@media screen and (prefers-color-scheme:dark){{:root{{{}}}}}\n",
        variables(|paint| paint.2),
        variables(|paint| paint.3)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// WCAG 2.1 contrast ratio of two `#rrggbb` colours.
    fn contrast(a: &str, b: &str) -> f64 {
        let luminance = |hex: &str| -> f64 {
            let channel = |at: usize| {
                let c = f64::from(u8::from_str_radix(&hex[at..at + 2], 16).unwrap()) / 255.0;
                if c <= 0.040_45 {
                    c / 12.92
                } else {
                    ((c + 0.055) / 1.055).powf(2.4)
                }
            };
            0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5)
        };
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn everything_drawn_is_readable_in_light_and_dark() {
        let panel = PAINTS
            .iter()
            .find(|(paint, ..)| *paint == Paint::Panel)
            .unwrap();
        for (paint, name, light, dark) in PAINTS {
            // WCAG 1.4.3 asks 4.5 of text, 1.4.11 asks 3 of graphics; grid lines are meant to be faint.
            let wanted = match paint {
                Paint::Panel | Paint::Grid => continue,
                Paint::Hue(_) => 3.0,
                _ => 4.5,
            };
            assert!(contrast(light, panel.2) >= wanted, "{name} on light");
            assert!(contrast(dark, panel.3) >= wanted, "{name} on dark");
        }
    }

    #[test]
    fn stand_ins_become_variables_with_a_fallback() {
        let Paint::Hue(_) = PAINTS[7].0 else {
            panic!("the eighth paint is a hue")
        };
        assert_eq!(
            themed("stroke=\"#010700\""),
            "stroke=\"var(--vermilion,#d55e00)\""
        );
        assert!(themed("stroke=\"#010701\"").contains("stroke-dasharray"));
        assert_eq!(themed("a #010700 b"), "a #010700 b");
    }
}
