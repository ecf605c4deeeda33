//! The parts that decisions rest on, as a picture over sensors and window for each class.

use taxel_report::canvas::{Anchor, Canvas, PLAIN, TextStyle, short, width_of};
use taxel_report::chart::Chart;
use taxel_report::palette::{Ink, Paint};

use crate::report::names::chart;
use crate::values::{ClassImportance, Importance, Judgement, Primary};

const WIDTH: f64 = 860.0;
/// Most classes that get a picture, those with the most samples first.
const CLASSES: usize = 12;
/// Characters of a sensor's name.
const NAME: usize = 22;

/// Draws one picture for each class.
pub(super) fn parts(judgement: &Judgement) -> Option<Chart<'_>> {
    let found = judgement.importance.as_ref().filter(|found| !found.classes.is_empty())?;
    let primary = judgement.primary();
    let reading = format!(
        "{}: each field is a part of a sample, of which {} test samples were predicted with the part replaced by its mean over the training \
         samples. The fuller the colour, the more {} is lost without it.",
        found.network,
        found.samples,
        lost(&primary)
    );
    Some(Chart::new(chart::IMPORTANCE, "What mattered", reading, move |paint| draw(found, &primary, paint)))
}

fn lost(primary: &Primary) -> String {
    if primary.is_percent() {
        "of the true class's probability".into()
    } else {
        format!("{} is added", primary.title())
    }
}

fn draw(found: &Importance, primary: &Primary, paint: Paint) -> Canvas {
    let mut classes: Vec<&ClassImportance> = found.classes.iter().collect();
    classes.sort_by_key(|class| std::cmp::Reverse(class.samples));
    classes.truncate(CLASSES);
    let names: Vec<String> = found.rows.iter().map(|row| short(row, NAME)).collect();
    let left = names.iter().map(|name| width_of(name, 11)).fold(24.0, f64::max) + 14.0;
    let cell = (280.0 / found.columns.len().max(1) as f64).clamp(12.0, 28.0);
    let height = if found.rows.len() > 32 { 9.0 } else { 18.0 };
    let panel = (cell * found.columns.len() as f64 + 16.0, height * found.rows.len() as f64 + 46.0);
    let across = (((WIDTH - left) / panel.0) as usize).clamp(1, classes.len());
    let lines = classes.len().div_ceil(across);
    let mut canvas = Canvas::new(WIDTH, 8.0 + panel.1 * lines as f64, paint);
    let cells = || classes.iter().flat_map(|class| class.cells.iter().flatten());
    let most = cells().fold(1e-9, |most: f64, loss| most.max(*loss));
    for (number, class) in classes.iter().enumerate() {
        let (x, y) = (left + panel.0 * (number % across) as f64, 26.0 + panel.1 * (number / across) as f64);
        let title = if class.class.is_empty() { "all samples".into() } else { short(&class.class, NAME) };
        canvas.text((x, y - 8.0), &title, PLAIN);
        for (row, losses) in class.cells.iter().enumerate() {
            let middle = y + height * (row as f64 + 0.5);
            if number % across == 0 {
                let look = TextStyle { size: height.min(11.0) as u32, anchor: Anchor::Right, ..PLAIN };
                canvas.text((left - 6.0, middle + 4.0), &names[row], look);
            }
            for (column, loss) in losses.iter().enumerate() {
                let part = [found.rows[row].as_str(), found.columns[column].as_str()];
                let part =
                    part.iter().filter(|name| !name.is_empty()).copied().collect::<Vec<_>>().join(", ");
                let about = format!("{title} without {part}: {} lost", primary.difference(*loss));
                canvas.hover(&about, |canvas| {
                    let area = (
                        x + cell * column as f64 + 0.5,
                        middle - height / 2.0 + 0.5,
                        cell - 1.0,
                        height - 1.0,
                    );
                    canvas.block(area, Ink::Heat, 0.04 + 0.8 * (loss / most).clamp(0.0, 1.0));
                });
            }
        }
        let quiet = TextStyle { size: 11, ink: Ink::Muted, ..PLAIN };
        if let [first, .., last] = found.columns.as_slice() {
            let ends = format!("{first} … {last}");
            canvas.text((x, y + height * found.rows.len() as f64 + 13.0), &short(&ends, 40), quiet);
        }
    }
    canvas
}
