//! One sample of any layout as a matrix of sensing elements over time.
//!
//! # Reference
//!
//! None.

use crate::sensor::Sensor;
use crate::{Error, Result};
use ndarray::{Array2, ArrayViewD, ArrayViewMutD, Axis, Dimension};
use rand::RngExt;
use taxel_base::Layout;
use taxel_base::seed::Rng;

/// A sample while faults act on it.
pub(crate) struct FaultySample<'a> {
    /// `[elements, times]`; an element is a channel or a taxel. Of a colour image, each pixel has
    /// its three planes in place of times.
    pub x: Array2<f32>,
    /// Elements stand in `rows` × `columns`: taxels as they lie, `F` × `C` channels of fingers,
    /// or 1 × `C`.
    pub rows: usize,
    pub columns: usize,
    pub sensor: &'a Sensor,
    pub rng: Rng,
}

impl<'a> FaultySample<'a> {
    pub fn new(x: ArrayViewD<f32>, sensor: &'a Sensor, rng: Rng, sample: usize) -> Result<Self> {
        let wrong = |reason| Err(Error::Sample { sample, reason });
        if !sensor.layout.fits(x.shape()) || x.is_empty() {
            return wrong(format!("shape {:?} is not {}", x.shape(), sensor.layout.describe()));
        }
        if let Some((at, value)) = x.indexed_iter().find(|(_, v)| !v.is_finite()) {
            let reason = format!("reading {:?} is {value}; drop or interpolate bad taxels first", at.slice());
            return wrong(reason);
        }
        let (rows, columns, times) = grid(sensor.layout, x.shape());
        sensor.check(rows * columns)?;
        let mut matrix = Array2::zeros((rows * columns, times));
        if time_first(sensor.layout) {
            matrix.view_mut().reversed_axes().iter_mut().zip(x.iter()).for_each(|(to, v)| *to = *v);
        } else {
            matrix.iter_mut().zip(x.iter()).for_each(|(to, v)| *to = *v);
        }
        Ok(Self { x: matrix, rows, columns, sensor, rng })
    }

    /// Writes the readings back, within the sensor's range.
    pub fn write(self, x: &mut ArrayViewMutD<f32>) {
        let (low, high) = (self.sensor.low, self.sensor.high);
        let matrix = if time_first(self.sensor.layout) { self.x.reversed_axes() } else { self.x };
        x.iter_mut().zip(&matrix).for_each(|(to, v)| *to = v.clamp(low, high));
    }

    pub fn elements(&self) -> usize {
        self.rows * self.columns
    }

    pub fn times(&self) -> usize {
        self.x.len_of(Axis(1))
    }

    /// Returns the reading of an element without contact.
    pub fn rest(&self, element: usize) -> f32 {
        self.sensor.rest[if self.sensor.rest.len() == 1 { 0 } else { element }]
    }

    /// Sets an element to its rest value for good.
    pub fn kill(&mut self, element: usize) {
        let rest = self.rest(element);
        self.x.row_mut(element).fill(rest);
    }

    pub fn row(&self, row: usize) -> Vec<usize> {
        (0..self.columns).map(|column| row * self.columns + column).collect()
    }

    pub fn column(&self, column: usize) -> Vec<usize> {
        (0..self.rows).map(|row| row * self.columns + column).collect()
    }

    /// Returns `0..n` in random order.
    pub fn order(&mut self, n: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..n).collect();
        for i in (1..n).rev() {
            order.swap(i, self.rng.random_range(0..=i));
        }
        order
    }

    /// Draws a whole number that is `expected` on average: 0.1 is 1 in every tenth sample.
    pub fn round(&mut self, expected: f64) -> usize {
        (expected + self.rng.random::<f64>()) as usize
    }

    /// Draws 1 or -1.
    pub fn sign(&mut self) -> f64 {
        if self.rng.random() { 1.0 } else { -1.0 }
    }
}

/// Returns rows, columns and times of a sample of this shape, which fits the layout.
pub(crate) fn grid(layout: Layout, shape: &[usize]) -> (usize, usize, usize) {
    match layout {
        Layout::Features => (1, 1, shape[0]),
        Layout::Series => (1, shape[0], shape[1]),
        Layout::Image => (shape[0], shape[1], 1),
        Layout::Sequence | Layout::Colour => (shape[1], shape[2], shape[0]),
        Layout::Fingers => (shape[0], shape[1], shape[2]),
    }
}

fn time_first(layout: Layout) -> bool {
    matches!(layout, Layout::Sequence | Layout::Colour)
}
