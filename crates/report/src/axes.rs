//! Axes: from values to places, ticks with round numbers, frames with titles.

use crate::canvas::{Anchor, Canvas, PLAIN, Stroke, TextStyle};
use crate::palette::Ink;

/// From values to places on one axis.
#[derive(Debug, Clone, Copy)]
pub struct AxisScale {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
    log: bool,
}

impl AxisScale {
    /// Goes evenly from `low` to `high`, onto places `from` to `to`.
    pub fn linear((low, high): (f64, f64), (from, to): (f64, f64)) -> Self {
        let high = if high > low { high } else { low + 1.0 };
        AxisScale { low, high, from, to, log: false }
    }

    /// Returns a logarithmic scale for values above 0, with a little air on both sides.
    pub fn log((low, high): (f64, f64), (from, to): (f64, f64)) -> Self {
        AxisScale { low: low / 1.6, high: high * 1.6, from, to, log: true }
    }

    /// Returns the place of `value`; beyond an end, that end.
    pub fn at(&self, value: f64) -> f64 {
        let share = if self.log {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        self.from + share.clamp(0.0, 1.0) * (self.to - self.from)
    }

    /// Returns round values between the ends, some four to eight.
    pub fn ticks(&self) -> Vec<f64> {
        if self.log {
            let few = (self.high / self.low).log10() < 2.5;
            let steps: &[f64] = if few { &[1.0, 2.0, 5.0] } else { &[1.0] };
            let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
            let all = (first..=last).flat_map(|power| steps.iter().map(move |step| step * 10f64.powi(power)));
            return all.filter(|v| (self.low..=self.high).contains(v)).collect();
        }
        let rough = (self.high - self.low) / 7.0;
        let power = 10f64.powf(rough.log10().floor());
        let step =
            [1.0, 2.0, 5.0, 10.0].map(|s| s * power).into_iter().find(|s| *s >= rough).unwrap_or(rough);
        let first = (self.low / step - 1e-9).ceil() as i64;
        (first..).map(|i| i as f64 * step).take_while(|v| *v <= self.high + 1e-9 * step).collect()
    }

    /// Draws this scale as the x axis of a chart of rows: grid lines from `top` to `bottom`, numbers and title below.
    pub fn draw_grid(
        &self,
        canvas: &mut Canvas,
        (top, bottom): (f64, f64),
        title: &str,
        name: impl Fn(f64) -> String,
    ) {
        for value in self.ticks() {
            let at = self.at(value);
            canvas.line((at, top), (at, bottom), Stroke::of(Ink::Grid, 1.0));
            let look = TextStyle { ink: Ink::Muted, anchor: Anchor::Middle, ..PLAIN };
            canvas.text((at, bottom + 17.0), &name(value), look);
        }
        let look = TextStyle { anchor: Anchor::Middle, ..PLAIN };
        canvas.text(((self.from + self.to) / 2.0, bottom + 36.0), title, look);
    }

    /// Returns the places of both ends.
    pub fn ends(&self) -> (f64, f64) {
        (self.from, self.to)
    }
}

/// Two axes around an area.
pub struct PlotFrame {
    /// From left to right.
    pub x: AxisScale,
    /// From bottom to top.
    pub y: AxisScale,
}

impl PlotFrame {
    /// Returns the place of a point.
    pub fn at(&self, x: f64, y: f64) -> (f64, f64) {
        (self.x.at(x), self.y.at(y))
    }

    /// Draws grid lines and numbers of the y axis.
    pub fn draw_y(&self, canvas: &mut Canvas, name: impl Fn(f64) -> String) {
        let (left, right) = self.x.ends();
        for value in self.y.ticks() {
            let y = self.y.at(value);
            canvas.line((left, y), (right, y), Stroke::of(Ink::Grid, 1.0));
            let look = TextStyle { ink: Ink::Muted, anchor: Anchor::Right, ..PLAIN };
            canvas.text((left - 6.0, y + 4.0), &name(value), look);
        }
    }

    /// Draws marks and numbers at `values` of the x axis.
    pub fn draw_x(&self, canvas: &mut Canvas, values: &[f64], name: impl Fn(f64) -> String) {
        let (bottom, _) = self.y.ends();
        let (left, right) = self.x.ends();
        canvas.line((left, bottom), (right, bottom), Stroke::of(Ink::Muted, 1.0));
        for &value in values {
            let x = self.x.at(value);
            canvas.line((x, bottom), (x, bottom + 4.0), Stroke::of(Ink::Muted, 1.0));
            let look = TextStyle { ink: Ink::Muted, anchor: Anchor::Middle, ..PLAIN };
            canvas.text((x, bottom + 17.0), &name(value), look);
        }
    }

    /// Writes the titles of the axes: below the x axis, above the y axis.
    pub fn titles(&self, canvas: &mut Canvas, x: &str, y: &str) {
        let ((left, right), (bottom, top)) = (self.x.ends(), self.y.ends());
        let look = TextStyle { anchor: Anchor::Middle, ..PLAIN };
        canvas.text(((left + right) / 2.0, bottom + 36.0), x, look);
        canvas.text((left - 30.0, top - 12.0), y, PLAIN);
    }
}

/// Returns the least and the largest of `values`, widened by a tenth of their distance within `limits`.
pub fn widened(values: &[f64], limits: (f64, f64)) -> (f64, f64) {
    let finite = values.iter().copied().filter(|v| v.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return (0.0, 1.0);
    }
    let air = (0.1 * (high - low)).max(1e-6 * high.abs()).max(1e-9);
    ((low - air).max(limits.0), (high + air).min(limits.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let linear = AxisScale::linear((31.0, 97.0), (300.0, 0.0));
        assert_eq!(linear.ticks(), [40.0, 50.0, 60.0, 70.0, 80.0, 90.0]);
        assert_eq!((linear.at(31.0), linear.at(97.0), linear.at(64.0)), (300.0, 0.0, 150.0));
        let log = AxisScale::log((1.6, 62.5), (0.0, 100.0));
        assert_eq!(log.ticks(), [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0]);
        assert!((log.at(10.0) - 50.0).abs() < 1e-9);
        assert_eq!(AxisScale::log((1.0, 1e6), (0.0, 1.0)).ticks().len(), 7);
        assert!(AxisScale::linear((5.0, 5.0), (0.0, 1.0)).ticks().len() > 1, "one value alone");
    }
}
