//! Confusion matrices.

use taxel_learn::metrics::Confusion;
use taxel_report::canvas::{Anchor, Canvas, PLAIN, TextStyle, short, width_of};
use taxel_report::chart::Chart;
use taxel_report::files::slug;
use taxel_report::palette::{Ink, Paint};

use super::look::shown;
use crate::report::names::chart;
use crate::values::Judgement;

/// Classes up to which counts are written into the cells.
const WRITTEN: usize = 14;
/// Characters of a class name.
const NAME: usize = 18;

/// Draws one matrix per network; with several attributes one per network and attribute.
pub(super) fn charts(judgement: &Judgement) -> Vec<Chart<'_>> {
    let mut all = vec![];
    for (number, n) in shown(judgement).enumerate() {
        let name = &n.results.network;
        let reading = "Rows: true class; columns: predicted class; all folds together. The fuller the colour, \
                       the larger the share of the row.";
        let mut add = |file: String, title: String, counts: &'_ Confusion, classes: &'_ [String]| {
            let (counts, classes) = (counts.counts().to_vec(), classes.to_vec());
            all.push(Chart::new(file, title, reading, move |paint| draw(&counts, &classes, paint)));
        };
        if let Some(confusion) = &n.results.confusion {
            let file = format!("{}{number:02}-{}", chart::CONFUSION, slug(name));
            add(file, name.clone(), confusion, &judgement.results.task.output_names());
        }
        for (attribute, scores) in judgement.results.task.attributes().iter().zip(&n.results.attributes) {
            let file = format!("{}{number:02}-{}-{}", chart::CONFUSION, slug(name), slug(&attribute.name));
            add(file, format!("{name}: {}", attribute.name), &scores.confusion, &attribute.classes);
        }
    }
    all
}

fn draw(counts: &[Vec<u64>], classes: &[String], paint: Paint) -> Canvas {
    let written = classes.len() <= WRITTEN;
    let cell = if written { 46.0 } else { (600.0 / classes.len() as f64).clamp(9.0, 28.0) };
    let size = if written { 12 } else { (cell as u32).saturating_sub(2).clamp(7, 11) };
    let names: Vec<String> = classes.iter().map(|class| short(class, NAME)).collect();
    let longest = names.iter().map(|name| width_of(name, size)).fold(24.0, f64::max);
    let (left, top) = (longest + 34.0, longest + 34.0);
    let side = cell * classes.len() as f64;
    let mut canvas = Canvas::new(left + side + 16.0, top + side + 8.0, paint);
    let quiet = TextStyle { size: 11, ink: Ink::Muted, anchor: Anchor::Middle, ..PLAIN };
    canvas.text((left + side / 2.0, 14.0), "predicted", quiet);
    canvas.upright((14.0, top + side / 2.0), "true", quiet);
    for (i, name) in names.iter().enumerate() {
        let middle = cell * (i as f64 + 0.5);
        let look = TextStyle { size, ..PLAIN };
        canvas.upright((left + middle + 4.0, top - 7.0), name, look);
        canvas.text((left - 7.0, top + middle + 4.0), name, TextStyle { anchor: Anchor::Right, ..look });
    }
    for (i, row) in counts.iter().enumerate() {
        let all: u64 = row.iter().sum();
        for (k, &count) in row.iter().enumerate() {
            let share = if all > 0 { count as f64 / all as f64 } else { 0.0 };
            let (x, y) = (left + cell * k as f64, top + cell * i as f64);
            let about = format!("{} taken for {}: {count} of {all}", classes[i], classes[k]);
            canvas.hover(&about, |canvas| {
                let air = if written { 1.0 } else { 0.5 };
                let area = (x + air, y + air, cell - 2.0 * air, cell - 2.0 * air);
                let ink = if i == k { Ink::Accent } else { Ink::Heat };
                canvas.block(area, ink, 0.05 + 0.5 * share);
                if written && count > 0 {
                    let look = TextStyle { anchor: Anchor::Middle, ..PLAIN };
                    canvas.text((x + cell / 2.0, y + cell / 2.0 + 4.0), &count.to_string(), look);
                }
            });
        }
    }
    canvas
}
