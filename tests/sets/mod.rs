//! Small data sets that tests make, and writers of them in every form that taxel reads.

#![allow(dead_code, reason = "each test file uses its part")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

pub mod arrays;
pub mod files;
#[path = "../../crates/data/tests/writers/mod.rs"]
pub mod writers;

use taxel::Layout;

/// The classes of every set, in the order of their numbers.
pub const CLASSES: [&str; 3] = ["hard", "soft", "wet"];

/// A cell of a column beside the channels.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    Value(f64),
    Count(i64),
    Text(String),
}

/// A column beside the channels.
#[derive(Clone)]
pub struct Extra {
    pub name: String,
    /// `[sample][step]`; where a sample is one row the first step counts.
    pub cells: Vec<Vec<Cell>>,
}

/// Samples with labels, and perhaps groups and marks of test samples.
#[derive(Clone)]
pub struct Set {
    pub layout: Layout,
    /// Shape of one sample.
    pub shape: Vec<usize>,
    pub x: Vec<Vec<f32>>,
    pub y: Vec<usize>,
    pub groups: Option<Vec<usize>>,
    pub marks: Option<Vec<i64>>,
    pub classes: Vec<String>,
    /// Names of the channels of text columns; numbered where there are none.
    pub names: Vec<String>,
    pub extras: Vec<Extra>,
}

impl Set {
    /// Makes a set without groups and marks.
    pub fn new(layout: Layout, shape: &[usize], x: Vec<Vec<f32>>, y: Vec<usize>) -> Self {
        assert!(x.iter().all(|sample| sample.len() == shape.iter().product::<usize>()));
        Self {
            layout,
            shape: shape.to_vec(),
            x,
            y,
            groups: None,
            marks: None,
            classes: CLASSES.map(String::from).to_vec(),
            names: vec![],
            extras: vec![],
        }
    }

    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Takes these samples, in this order; one may be there more than once.
    pub fn select(&self, rows: &[usize]) -> Self {
        fn of<T: Clone>(all: &[T], rows: &[usize]) -> Vec<T> {
            rows.iter().map(|row| all[*row].clone()).collect()
        }
        let extra = |extra: &Extra| Extra { cells: of(&extra.cells, rows), ..extra.clone() };
        Self {
            x: of(&self.x, rows),
            y: of(&self.y, rows),
            groups: self.groups.as_ref().map(|groups| of(groups, rows)),
            marks: self.marks.as_ref().map(|marks| of(marks, rows)),
            extras: self.extras.iter().map(extra).collect(),
            ..self.clone()
        }
    }

    /// Lists the samples class by class, as a folder per class does.
    pub fn by_class(&self) -> Vec<usize> {
        let mut rows: Vec<usize> = (0..self.len()).collect();
        rows.sort_by_key(|row| self.y[*row]);
        rows
    }

    /// Returns the place of each sample among all class by class.
    pub fn ranks(&self) -> Vec<usize> {
        let mut ranks = vec![0; self.len()];
        for (rank, row) in self.by_class().into_iter().enumerate() {
            ranks[row] = rank;
        }
        ranks
    }

    pub fn class(&self, row: usize) -> &str {
        &self.classes[self.y[row]]
    }

    /// Returns the axis of time in a sample.
    pub fn time(&self) -> Option<usize> {
        match self.layout {
            Layout::Features | Layout::Image | Layout::Colour => None,
            Layout::Series => Some(1),
            Layout::Sequence => Some(0),
            Layout::Fingers => Some(2),
        }
    }

    /// Counts the time steps of a sample.
    pub fn steps(&self) -> usize {
        self.time().map_or(1, |axis| self.shape[axis])
    }

    /// Counts the channels of a time step.
    pub fn width(&self) -> usize {
        self.shape.iter().product::<usize>() / self.steps()
    }

    /// Returns the place in a sample of a channel at a time step.
    pub fn place(&self, channel: usize, step: usize) -> usize {
        match self.time() {
            Some(0) => step * self.width() + channel,
            Some(_) => channel * self.steps() + step,
            None => channel,
        }
    }

    /// Names the channels.
    pub fn channels(&self, count: usize) -> Vec<String> {
        if self.names.is_empty() {
            (0..count).map(|at| format!("p{at}")).collect()
        } else {
            self.names.clone()
        }
    }

    /// Returns the columns of one recording, extras first: a cell per time step.
    pub fn recording(&self, row: usize) -> Vec<(String, Vec<Cell>)> {
        let cell = |channel: usize, step: usize| Cell::Value(self.x[row][self.place(channel, step)].into());
        let extras = self.extras.iter().map(|extra| (extra.name.clone(), extra.cells[row].clone()));
        let channels = self.channels(self.width()).into_iter().enumerate();
        let steps = 0..self.steps();
        let channels = channels.map(|(at, name)| (name, steps.clone().map(|step| cell(at, step)).collect()));
        extras.chain(channels).collect()
    }

    /// Returns the columns of a table with a row per sample, extras first, without labels.
    pub fn row(&self, row: usize) -> Vec<(String, Cell)> {
        let extras = self.extras.iter().map(|extra| (extra.name.clone(), extra.cells[row][0].clone()));
        let names = self.channels(self.x[row].len());
        let values =
            names.into_iter().zip(&self.x[row]).map(|(name, value)| (name, Cell::Value((*value).into())));
        extras.chain(values).collect()
    }
}
