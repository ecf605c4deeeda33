//! The canvas of charts: lines, marks and text in inks, with values to hover over; SVG and PNG.

use std::io::Cursor;

use kuva::backend::raster::RasterBackend;
use kuva::backend::svg::SvgBackend;
use kuva::render::color::Color;
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor};

use crate::error::{Error, Result};
use crate::palette::{Ink, Paint};

/// Pixels of a PNG per unit of a chart.
const SCALE: u32 = 2;
/// It is drawn so many times larger and then made smaller: kuva's upright text is coarse.
const FINER: u32 = 2;
/// Pixels of the largest drawing that is made finer.
const MOST_PIXELS: f64 = 5e7;
/// Widths of characters as shares of the size of their font (DejaVu Sans, wider than most), and of all others.
const WIDTHS: [(&str, f64); 3] = [("ijlI.,:;'|!", 0.33), ("-frt()[] 1", 0.42), ("mwMWQ%@—…", 0.96)];
const WIDTH: f64 = 0.63;

/// Where a text begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// At its left end.
    Left,
    /// In its middle.
    Middle,
    /// At its right end.
    Right,
}

/// How a text looks.
#[derive(Debug, Clone, Copy)]
pub struct TextStyle {
    /// Size of the font, in CSS pixels.
    pub size: u32,
    /// Its colour.
    pub ink: Ink,
    /// Which of its points is placed.
    pub anchor: Anchor,
    /// Whether it is bold.
    pub bold: bool,
}

/// The usual text of a chart.
pub const PLAIN: TextStyle = TextStyle { size: 12, ink: Ink::Text, anchor: Anchor::Left, bold: false };

/// How a line looks.
#[derive(Debug, Clone, Copy)]
pub struct Stroke {
    /// Its colour.
    pub ink: Ink,
    /// Its width, in CSS pixels.
    pub width: f64,
    /// Lengths of a stroke and of the gap behind it; a gap of 0: one line.
    pub dash: (f64, f64),
}

impl Stroke {
    /// Returns an unbroken line.
    pub fn of(ink: Ink, width: f64) -> Self {
        Stroke { ink, width, dash: (0.0, 0.0) }
    }

    /// Returns the line with strokes and gaps of these lengths.
    pub fn dashed(self, dash: (f64, f64)) -> Self {
        Stroke { dash, ..self }
    }
}

/// A drawing in units of CSS pixels, from the top left.
pub struct Canvas {
    scene: Scene,
    family: &'static str,
    paint: Paint,
}

impl Canvas {
    /// Returns an empty drawing.
    pub fn new(width: f64, height: f64, paint: Paint) -> Self {
        let mut scene = Scene::new(width, height);
        let family = match paint {
            Paint::Page => "system-ui, sans-serif",
            Paint::Print => "DejaVu Sans, Verdana, sans-serif",
        };
        scene.font_family = Some(family.into());
        scene.background_color = (paint == Paint::Print).then(|| "#ffffff".into());
        Canvas { scene, family, paint }
    }

    fn colour(&self, ink: Ink) -> Color {
        ink.colour(self.paint)
    }

    /// Draws a straight line.
    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), stroke: Stroke) {
        self.path(vec![from, to], stroke);
    }

    /// Draws a line through all `points`.
    pub fn path(&mut self, points: Vec<(f64, f64)>, stroke: Stroke) {
        // Cut here: kuva's PNG knows no dashes along a path.
        for points in dashes(points, stroke.dash) {
            let (ink, stroke_width) = (self.colour(stroke.ink), stroke.width);
            let line = Primitive::PolyLine { points, stroke: ink, stroke_width, stroke_dasharray: None };
            self.scene.elements.push(line);
        }
    }

    /// Draws a filled circle of radius `r`.
    pub fn circle(&mut self, (cx, cy): (f64, f64), r: f64, fill: Ink, edge: Ink) {
        let (fill, stroke) = (self.colour(fill), Some(self.colour(edge)));
        let stroke_width = Some(1.6);
        self.scene.elements.push(Primitive::Circle {
            cx,
            cy,
            r,
            fill,
            fill_opacity: None,
            stroke,
            stroke_width,
        });
    }

    /// Draws a square that stands on a corner.
    pub fn diamond(&mut self, (x, y): (f64, f64), r: f64, fill: Ink, edge: Ink) {
        let d = format!("M {} {y} L {x} {} L {} {y} L {x} {} Z", x - r, y - r, x + r, y + r);
        let (fill, stroke) = (Some(self.colour(fill)), self.colour(edge));
        let path = PathData { d, fill, stroke, stroke_width: 1.6, opacity: None, stroke_dasharray: None };
        self.scene.elements.push(Primitive::Path(Box::new(path)));
    }

    /// Draws a filled rectangle `(x, y, width, height)`.
    pub fn block(&mut self, (x, y, width, height): (f64, f64, f64, f64), fill: Ink, opacity: f64) {
        let (fill, opacity) = (self.colour(fill), Some(opacity));
        self.scene.elements.push(Primitive::Rect {
            x,
            y,
            width,
            height,
            fill,
            stroke: None,
            stroke_width: None,
            opacity,
        });
    }

    /// Writes `text`, its base line at `at`.
    pub fn text(&mut self, at: (f64, f64), text: &str, look: TextStyle) {
        self.write(at, text, look, None);
    }

    /// Writes text that runs from the bottom to the top.
    pub fn upright(&mut self, at: (f64, f64), text: &str, look: TextStyle) {
        self.write(at, text, look, Some(-90.0));
    }

    fn write(&mut self, (x, y): (f64, f64), text: &str, look: TextStyle, rotate: Option<f64>) {
        if text.is_empty() {
            return;
        }
        let anchor = match look.anchor {
            Anchor::Left => TextAnchor::Start,
            Anchor::Middle => TextAnchor::Middle,
            Anchor::Right => TextAnchor::End,
        };
        // Between two dollars kuva would set formulas.
        let content = clean(text).replace('$', "\\$");
        let (size, bold, color) = (look.size, look.bold, Some(self.colour(look.ink)));
        self.scene.elements.push(Primitive::Text { x, y, content, size, anchor, rotate, bold, color });
    }

    /// Adds the drawing of `draw`, with `title` shown while the pointer is over it.
    pub fn hover(&mut self, title: &str, draw: impl FnOnce(&mut Self)) {
        let title = Some(clean(title));
        self.scene.elements.push(Primitive::GroupStart { transform: None, title, extra_attrs: None });
        draw(self);
        self.scene.elements.push(Primitive::GroupEnd);
    }

    /// Returns the drawing as SVG; screen readers hear `label`.
    pub fn svg(&self, label: &str) -> String {
        let svg = SvgBackend::new().render_scene(&self.scene);
        #[expect(clippy::expect_used, reason = "the backend writes an svg element")]
        let (_, body) = svg.split_once('>').expect("the end of the opening tag");
        let (width, height) = (self.scene.width, self.scene.height);
        let family = self.family;
        let size = match self.paint {
            // Wider than a phone it scrolls, on a large screen it grows a little.
            Paint::Page => {
                let (least, most) = ((0.8 * width).round(), (1.25 * width).round());
                format!(r#"style="min-width:{least}px;max-width:{most}px""#)
            }
            Paint::Print => format!(r#"width="{width}" height="{height}""#),
        };
        format!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" {size} font-family="{family}" role="img" aria-label="{}">{body}"#,
            attribute(label)
        )
    }

    /// Returns the drawing as PNG, with a font of its own.
    ///
    /// # Errors
    /// A drawing that kuva cannot turn into pixels.
    pub fn png(&self) -> Result<Vec<u8>> {
        let fine = self.scene.width * self.scene.height * f64::from((SCALE * FINER).pow(2));
        let finer = if fine > MOST_PIXELS { 1 } else { FINER };
        let large =
            RasterBackend { scale: (SCALE * finer) as f32 }.render_scene(&self.scene).map_err(refuse)?;
        let mut reader = image::ImageReader::with_format(Cursor::new(large), image::ImageFormat::Png);
        // The limits are meant for pictures of others.
        reader.no_limits();
        let large = reader.decode().map_err(refuse)?.to_rgb8();
        let (width, height) = (large.width() / finer, large.height() / finer);
        let small = image::imageops::thumbnail(&large, width, height);
        let mut png = Cursor::new(vec![]);
        small.write_to(&mut png, image::ImageFormat::Png).map_err(refuse)?;
        Ok(png.into_inner())
    }
}

fn refuse(reason: impl ToString) -> Error {
    Error::Write { path: "a drawing as PNG".into(), reason: reason.to_string() }
}

/// Returns the strokes of a dashed path.
fn dashes(points: Vec<(f64, f64)>, (stroke, gap): (f64, f64)) -> Vec<Vec<(f64, f64)>> {
    if stroke <= 0.0 || gap <= 0.0 {
        return vec![points];
    }
    let (mut pieces, mut piece) = (vec![], vec![]);
    // Whether a stroke is drawn, and how much of it or of the gap is left.
    let (mut drawn, mut left) = (true, stroke);
    piece.extend(points.first());
    for ends in points.windows(2) {
        let ((mut x, mut y), (to_x, to_y)) = (ends[0], ends[1]);
        loop {
            let length = (to_x - x).hypot(to_y - y);
            if length <= left {
                left -= length;
                if drawn {
                    piece.push((to_x, to_y));
                }
                break;
            }
            (x, y) = (x + (to_x - x) * left / length, y + (to_y - y) * left / length);
            piece.push((x, y));
            if drawn {
                pieces.push(std::mem::take(&mut piece));
            }
            drawn = !drawn;
            left = if drawn { stroke } else { gap };
        }
    }
    if drawn && piece.len() > 1 {
        pieces.push(piece);
    }
    pieces
}

/// Returns the width that `text` takes at most, nearly.
pub fn width_of(text: &str, size: u32) -> f64 {
    let width = |c: char| WIDTHS.iter().find(|(all, _)| all.contains(c)).map_or(WIDTH, |(_, width)| *width);
    f64::from(size) * text.chars().map(width).sum::<f64>()
}

/// Returns at most `most` characters of `text`.
pub fn short(text: &str, most: usize) -> String {
    if text.chars().count() > most {
        text.chars().take(most.saturating_sub(1)).chain(['…']).collect()
    } else {
        text.into()
    }
}

/// Returns at most `most` characters of `text`, of its beginning and of its end: of names that differ in their last
/// word.
pub fn ends(text: &str, most: usize) -> String {
    let chars: Vec<char> = text.chars().collect();
    if chars.len() <= most {
        return text.into();
    }
    let tail = most / 2;
    let head = most.saturating_sub(tail + 1);
    chars[..head].iter().chain(&['…']).chain(&chars[chars.len() - tail..]).collect()
}

/// Returns `text` without characters that no XML may hold.
fn clean(text: &str) -> String {
    let allowed = |c: char| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}');
    text.chars().map(|c| if allowed(c) { c } else { ' ' }).collect()
}

fn attribute(text: &str) -> String {
    clean(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_end_otherwise_are_told_apart() {
        assert_eq!(ends("mlp train.lr=0.1", 16), "mlp train.lr=0.1");
        assert_eq!(ends("mlp train.lr=0.1", 11), "mlp t…r=0.1");
        assert_eq!(ends("äöü", 1), "…");
    }

    #[test]
    fn dashes_go_round_corners() {
        let path = vec![(0.0, 0.0), (5.0, 0.0), (5.0, 6.0)];
        let expected = [
            vec![(0.0, 0.0), (3.0, 0.0)],
            vec![(4.0, 0.0), (5.0, 0.0), (5.0, 2.0)],
            vec![(5.0, 3.0), (5.0, 6.0)],
        ];
        assert_eq!(dashes(path.clone(), (3.0, 1.0)), expected);
        assert_eq!(dashes(path.clone(), (0.0, 0.0)), [path]);
    }
}
