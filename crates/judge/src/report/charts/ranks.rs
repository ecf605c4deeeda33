//! The critical-difference diagram (Demsar 2006, section 3.2.4): mean ranks over several data sets.

use taxel_report::axes::AxisScale;
use taxel_report::canvas::{Anchor, Canvas, PLAIN, Stroke, TextStyle, ends, width_of};
use taxel_report::chart::Chart;
use taxel_report::palette::{Ink, Paint};

use crate::report::names::chart;
use crate::values::Across;

const WIDTH: f64 = 860.0;
/// Room for names on either side, at least and at most.
const NAMES: (f64, f64) = (200.0, 300.0);
/// Characters of a name.
const LONG: usize = 34;
const ROW: f64 = 22.0;
const AXIS: f64 = 64.0;

/// Draws mean ranks with what Nemenyi's test cannot tell apart joined.
pub(in crate::report) fn ranks(across: &Across) -> Chart<'_> {
    let reading = format!(
        "Mean rank of each network over {} data sets, 1 is the best. Bars join networks whose ranks differ by \
         less than the critical difference of {:.2} (Nemenyi, level {}).",
        across.runs.len(),
        across.critical_difference,
        across.alpha
    );
    Chart::new(chart::CRITICAL_DIFFERENCE, "Ranks over data sets", reading, move |paint| draw(across, paint))
}

fn draw(across: &Across, paint: Paint) -> Canvas {
    let ranks = &across.friedman.ranks;
    let (count, groups) = (ranks.len(), groups(ranks, across.critical_difference));
    let half = count.div_ceil(2);
    let below = AXIS + 14.0 + 9.0 * groups.len() as f64;
    let label = |(name, rank): (&String, &f64)| format!("{} {rank:.2}", ends(name, LONG));
    let labels: Vec<String> = across.networks.iter().zip(ranks).map(label).collect();
    let longest = labels.iter().map(|label| width_of(label, PLAIN.size)).fold(0.0, f64::max);
    let names = (longest + 24.0).clamp(NAMES.0, NAMES.1);
    let mut canvas = Canvas::new(WIDTH, below + ROW * half as f64 + 16.0, paint);
    let x = AxisScale::linear((1.0, count as f64), (names, WIDTH - names));
    canvas.line((x.at(1.0), AXIS), (x.at(count as f64), AXIS), Stroke::of(Ink::Text, 1.0));
    for rank in 1..=count {
        let at = x.at(rank as f64);
        canvas.line((at, AXIS - 5.0), (at, AXIS), Stroke::of(Ink::Text, 1.0));
        canvas.text(
            (at, AXIS - 9.0),
            &rank.to_string(),
            TextStyle { anchor: Anchor::Middle, ink: Ink::Muted, ..PLAIN },
        );
    }
    let wide = (x.at(1.0 + across.critical_difference) - x.at(1.0)).min(WIDTH - 2.0 * names);
    canvas.line((names, 22.0), (names + wide, 22.0), Stroke::of(Ink::Heat, 3.0));
    let label = format!("critical difference {:.2}", across.critical_difference);
    canvas.text((names, 14.0), &label, PLAIN);
    for (i, &(first, last)) in groups.iter().enumerate() {
        let y = AXIS + 9.0 * (i + 1) as f64;
        let ends = (x.at(ranks[first]) - 4.0, x.at(ranks[last]) + 4.0);
        canvas.line((ends.0, y), (ends.1, y), Stroke::of(Ink::Accent, 4.0));
    }
    for (i, (name, &rank)) in across.networks.iter().zip(ranks).enumerate() {
        // The better half to the left, from the top; the others to the right, from the bottom.
        let (left, row) = if i < half { (true, i) } else { (false, count - 1 - i) };
        let y = below + ROW * row as f64 + 8.0;
        let at = x.at(rank);
        let (end, anchor) =
            if left { (names - 12.0, Anchor::Right) } else { (WIDTH - names + 12.0, Anchor::Left) };
        canvas.hover(&format!("{name}: mean rank {rank:.2}"), |canvas| {
            canvas.line((at, AXIS), (at, y), Stroke::of(Ink::Muted, 1.0));
            canvas.line((at, y), (end, y), Stroke::of(Ink::Muted, 1.0));
            let away = if left { -4.0 } else { 4.0 };
            canvas.text((end + away, y + 4.0), &labels[i], TextStyle { anchor, ..PLAIN });
        });
    }
    canvas
}

/// Returns the first and the last of every longest run of ascending `ranks` that spans less than `difference`.
fn groups(ranks: &[f64], difference: f64) -> Vec<(usize, usize)> {
    let mut found: Vec<(usize, usize)> = vec![];
    for first in 0..ranks.len() {
        let last = (first..ranks.len()).rev().find(|&last| ranks[last] - ranks[first] < difference);
        let last = last.unwrap_or(first);
        if last > first && found.last().is_none_or(|&(_, before)| last > before) {
            found.push((first, last));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_join_what_cannot_be_told_apart() {
        assert_eq!(groups(&[1.0, 2.0, 2.9, 4.0], 1.95), [(0, 2), (2, 3)]);
        assert_eq!(groups(&[1.0, 4.0], 2.0), []);
        assert_eq!(groups(&[1.0, 1.5, 2.0], 5.0), [(0, 2)]);
    }
}
