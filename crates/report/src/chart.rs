//! A chart: drawn twice from one description, for the page in the colours of its theme and for files.

use crate::canvas::{Canvas, PLAIN, TextStyle};
use crate::palette::Paint;

/// A chart with all that is said about it.
pub struct Chart<'a> {
    /// Name of its files.
    pub name: String,
    /// Heading.
    pub title: String,
    /// How to read it; screen readers hear it in place of the drawing.
    pub reading: String,
    draw: Box<dyn Fn(Paint) -> Canvas + Sync + 'a>,
}

impl<'a> Chart<'a> {
    /// Returns a chart that `draw` draws.
    pub fn new(
        name: impl Into<String>,
        title: impl Into<String>,
        reading: impl Into<String>,
        draw: impl Fn(Paint) -> Canvas + Sync + 'a,
    ) -> Self {
        Chart { name: name.into(), title: title.into(), reading: reading.into(), draw: Box::new(draw) }
    }

    /// Returns the text for screen readers.
    pub fn label(&self) -> String {
        format!("{}. {}", self.title, self.reading)
    }

    /// Returns the drawing.
    pub fn canvas(&self, paint: Paint) -> Canvas {
        (self.draw)(paint)
    }
}

/// A heading inside a chart.
pub const HEADING: TextStyle = TextStyle { size: 13, bold: true, ..PLAIN };
