//! A picture: one quantity without and with an effect.

use super::excitation::Excitation;
use super::size::Size;
use softdock_physics::effects::Effect;
use softdock_report::{Hue, Plot, Series};

/// Points of a curve, in the units of the axes.
pub(super) type Curve = Vec<(f64, f64)>;

/// Two curves of one quantity over another.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// What the rig does.
    pub excitation: Excitation,
    /// How large the effect is, as `pause_s = 0.03`.
    pub size: String,
    /// Quantity and unit of x, as in `time [s]`.
    pub x_label: &'static str,
    /// Quantity and unit of y.
    pub y_label: &'static str,
    /// The quantity without the effect.
    pub without: Vec<(f64, f64)>,
    /// The quantity with the effect.
    pub with: Vec<(f64, f64)>,
}

impl Picture {
    /// A picture of an effect of this size. `labels` are those of x and y; `curves` are the quantity without and with the
    /// effect.
    pub(super) fn new(
        excitation: Excitation,
        size: &Size,
        labels: [&'static str; 2],
        curves: [Curve; 2],
    ) -> Self {
        let ([x_label, y_label], [without, with]) = (labels, curves);
        Self {
            excitation,
            size: size.describe(),
            x_label,
            y_label,
            without,
            with,
        }
    }

    /// The picture as a plot for a report.
    pub fn to_plot(&self, effect: &Effect) -> Plot {
        let title = format!("{}: {}", effect.title, self.excitation.describe());
        let mut plot = Plot::new(title, self.x_label, self.y_label);
        plot.series = vec![
            Series::dashed("without", self.without.clone()).colored(Hue::Grey),
            Series::line(format!("with {}", self.size), self.with.clone()).colored(Hue::Vermilion),
        ];
        plot
    }
}
