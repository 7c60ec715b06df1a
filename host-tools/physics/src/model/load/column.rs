//! A wrench over a log.

/// Six series, in the order fx fy fz tx ty tz. An empty one is zero throughout.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Column(pub [Vec<f64>; 6]);

impl Column {
    /// From a wrench for each cycle; series without any load are left empty.
    pub fn of(count: usize, mut wrench: impl FnMut(usize) -> [f64; 6]) -> Self {
        let mut column = Self::default();
        for n in 0..count {
            for (series, value) in column.0.iter_mut().zip(wrench(n)) {
                if series.is_empty() && value != 0.0 {
                    series.resize(count, 0.0);
                }
                if let Some(of_cycle) = series.get_mut(n) {
                    *of_cycle = value;
                }
            }
        }
        column
    }

    /// On one axis.
    pub fn on_axis(axis: usize, series: impl Iterator<Item = f64>) -> Self {
        let mut column = Self::default();
        let series: Vec<f64> = series.collect();
        if series.iter().any(|v| *v != 0.0) {
            column.0[axis] = series;
        }
        column
    }

    /// Value of an axis in a cycle.
    pub fn at(&self, axis: usize, n: usize) -> f64 {
        self.0[axis].get(n).copied().unwrap_or(0.0)
    }

    /// Whether all series are empty.
    pub fn is_zero(&self) -> bool {
        self.0.iter().all(Vec::is_empty)
    }

    /// All axes in a cycle.
    pub fn row(&self, n: usize) -> [f64; 6] {
        std::array::from_fn(|axis| self.at(axis, n))
    }

    /// Adds six series.
    pub fn add(&mut self, series: &[Vec<f64>; 6]) {
        for (own, other) in self.0.iter_mut().zip(series) {
            if own.is_empty() {
                own.clone_from(other);
            } else {
                own.iter_mut().zip(other).for_each(|(o, s)| *o += s);
            }
        }
    }

    /// Applies a function to each series that is not empty.
    pub fn each(&self, of: impl Fn(&[f64]) -> Vec<f64>) -> Self {
        let each = |series: &Vec<f64>| match series.is_empty() {
            true => Vec::new(),
            false => of(series),
        };
        Self(self.0.each_ref().map(each))
    }

    /// This column minus another; series that become zero are emptied.
    pub fn minus(mut self, other: &Self) -> Self {
        for (own, other) in self.0.iter_mut().zip(&other.0) {
            if own.is_empty() {
                *own = other.iter().map(|o| -o).collect();
            } else {
                own.iter_mut().zip(other).for_each(|(own, o)| *own -= o);
            }
            if own.iter().all(|value| *value == 0.0) {
                own.clear();
            }
        }
        self
    }

    /// Adds a constant to each axis of a column of so many cycles.
    pub(super) fn shift(&mut self, count: usize, by: [f64; 6]) {
        for (series, by) in self.0.iter_mut().zip(by).filter(|(_, by)| *by != 0.0) {
            series.resize(count, 0.0);
            series.iter_mut().for_each(|value| *value += by);
        }
    }

    /// Multiplies all series.
    pub fn scale(&mut self, factor: f64) {
        let all = self.0.iter_mut().flatten();
        all.for_each(|value| *value *= factor);
    }

    /// Adds a multiple of this column to other series.
    pub fn add_to(&self, factor: f64, series: &mut [Vec<f64>; 6]) {
        for (own, other) in self.0.iter().zip(series) {
            own.iter()
                .zip(other)
                .for_each(|(own, other)| *other += factor * own);
        }
    }
}
