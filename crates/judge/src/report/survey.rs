//! The page of a data set: what it holds, drawn, before anything is trained on it.

use std::path::Path;

use maud::{Markup, html};
use taxel_data::{Carrier, ChannelRange};
use taxel_report::chart::Chart;
use taxel_report::files::write;
use taxel_report::html::{drawing, folded, frame, picture, scroll};
use taxel_report::numbers::{digits, tenth};
use taxel_report::palette::Paint;
use taxel_report::pictures::show;
use taxel_report::table::{Cell, Column, Table};

use super::charts::{CHANNELS, carrier, drift, lengths, ranges};
use super::names::table as names;
use super::page::label;
use crate::error::{Error, Result};
use crate::values::{ClassPictures, Survey};

/// Sets of copies that are listed.
const SETS: usize = 30;
/// Correlation of the mean with the recording order from which it is said.
const WANDERS: f64 = 0.5;

/// Writes the page of a data set to `path`: one file that needs no other.
///
/// # Errors
/// A file that cannot be written.
pub fn survey_page(survey: &Survey, path: &Path) -> Result<()> {
    let sections: Vec<(&str, &str, Markup)> = [
        ("recordings", "Recordings", recordings(survey)?),
        ("lengths", "Lengths", charted(lengths(survey), None)),
        ("channels", "Channels", channels(survey)?),
        ("order", "Over the recording order", order(survey)),
        ("confounds", "What the plainest numbers tell", confounds(survey)),
        ("copies", "Copies", copies(survey)),
    ]
    .into_iter()
    .filter_map(|(id, title, content)| Some((id, title, content?)))
    .collect();
    let body = html! {
        (header(survey))
        nav aria-label="Sections" {
            ul { @for (id, title, _) in &sections { li { a href={ "#" (id) } { (title) } } } }
        }
        main id="main" {
            @for (id, title, content) in &sections {
                section id=(id) { h2 { (title) } (content) }
            }
            section id="card" {
                h2 { "The card" }
                pre { (survey.card) }
            }
        }
    };
    let page = frame(&format!("{}: taxel data check", survey.card.name), &body).into_string();
    let folder = path.parent().unwrap_or(Path::new(""));
    let name = path.file_name().ok_or_else(|| Error::write(path, "is no file"))?;
    Ok(write(folder, &(name.to_string_lossy().into_owned(), page.into_bytes()))?)
}

/// Returns the name, size and warnings of the data set.
fn header(survey: &Survey) -> Markup {
    let card = &survey.card;
    let shape: Vec<String> = card.shape.iter().map(usize::to_string).collect();
    html! {
        header {
            p.kicker { "taxel data check" }
            h1 { (card.name) }
            p {
                (shape.join("×")) " " (card.layout)
                @if card.quantities.is_empty() {
                    ", " (card.classes.len()) " classes; always answering the largest scores "
                    (tenth(100.0 * card.majority_share)) " %."
                } @else { "." }
                @if let Some(rate) = survey.rate { " " (digits(rate)) " readings per second." }
                @if let Some(unit) = &survey.unit { " Readings in " (unit) "." }
            }
            @for quantity in &card.quantities { p { (quantity) "." } }
            @for how in &card.read_as { p { "Read as " (how) "." } }
            @for problem in &card.problems { p.warning role="alert" { strong { "Wrong: " } (problem) } }
            @for warning in &card.warnings { p.warning role="note" { (warning) } }
            @if card.problems.is_empty() && card.warnings.is_empty() { p { "Nothing was found that speaks against it." } }
        }
    }
}

fn recordings(survey: &Survey) -> Result<Option<Markup>> {
    let articles =
        survey.classes.iter().map(|pictures| class(survey, pictures)).collect::<Result<Vec<_>>>()?;
    let more = survey.card.classes.len().saturating_sub(articles.len());
    Ok((!articles.is_empty()).then(|| {
        html! {
            p.reading {
                "The first, the middle and the last sample of each class, each scaled from its least to its largest value."
                @if more > 0 { " " (more) " more classes are not shown." }
            }
            @for article in &articles { (article) }
        }
    }))
}

fn class(survey: &Survey, pictures: &ClassPictures) -> Result<Markup> {
    let samples =
        survey.card.classes.iter().find(|class| class.name == pictures.name).map_or(0, |class| class.samples);
    let drawn = pictures
        .recordings
        .iter()
        .map(|(origin, reading)| Ok((origin, show(reading, Paint::Page)?, label(reading))));
    let drawn = drawn.collect::<Result<Vec<_>>>()?;
    Ok(html! {
        article.example {
            h3 { (pictures.name) " " span.reading { (samples) " samples" } }
            div.pictures.three {
                @for (origin, shown, label) in &drawn {
                    figure { (picture(shown, label)) figcaption { (origin) } }
                }
            }
        }
    })
}

/// Returns a chart, with the numbers behind it where they stand in a table.
fn charted(chart: Option<Chart>, numbers: Option<&Table>) -> Option<Markup> {
    let chart = chart?;
    Some(html! {
        figure {
            figcaption { h3 { (chart.title) } }
            (drawing(&chart.canvas(Paint::Page), &chart.label()))
            p.reading { (chart.reading) }
        }
        @if let Some(numbers) = numbers { (folded("Numbers", &scroll(numbers))) }
    })
}

fn channels(survey: &Survey) -> Result<Option<Markup>> {
    let all = survey.card.channels.len();
    let numbers = of_channels(&survey.card.channels);
    let drawn = charted(ranges(survey), Some(&numbers));
    let activity = match &survey.activity {
        Some(activity) => Some((picture(&show(activity, Paint::Page)?, &label(activity)), label(activity))),
        None => None,
    };
    Ok((drawn.is_some() || activity.is_some()).then(|| {
        html! {
            @if all > CHANNELS { p.reading { "The first " (CHANNELS) " of " (all) " channels; all are in the table." } }
            (drawn.unwrap_or_default())
            @if let Some((shown, about)) = &activity {
                figure { (shown) figcaption { (about) ". Black never changes." } }
            }
        }
    }))
}

fn of_channels(channels: &[ChannelRange]) -> Table {
    let share = |get: fn(&ChannelRange) -> f64| {
        move |channel: &ChannelRange| Cell::number(Some(100.0 * get(channel)), tenth)
    };
    let value = |get: fn(&ChannelRange) -> Option<f32>| {
        move |channel: &ChannelRange| Cell::number(get(channel).map(f64::from), digits)
    };
    let columns = vec![
        Column::count("channel", "channel", |channel: &ChannelRange| channel.channel as u64),
        Column::number("lowest", &["lowest"], value(|channel| channel.min)),
        Column::number("highest", &["highest"], value(|channel| channel.max)),
        Column::number("at the lowest, %", &["at_lowest_percent"], share(|channel| channel.at_min)),
        Column::number("at the highest, %", &["at_highest_percent"], share(|channel| channel.at_max)),
        Column::number("still in, % of samples", &["still_percent"], share(|channel| channel.stuck)),
    ];
    Table::new(names::CHANNELS, "Range of each channel over all samples".into(), columns, channels)
}

fn order(survey: &Survey) -> Option<Markup> {
    let chart = charted(drift(survey), None)?;
    let words = survey.drift.correlation.map(|correlation| {
        let size = digits(correlation.abs());
        if correlation.abs() >= WANDERS { format!(
                "Within classes the mean goes with the order (correlation {}{size}): samples next to each other are alike, \
                 so folds at random test on what was all but trained on. Groups by session or block keep them apart.",
                if correlation < 0.0 { "-" } else { "" }
            ) } else { format!("Within classes the mean hardly goes with the order (correlation {size}).") }
    });
    Some(html! { (chart) @if let Some(words) = words { p { (words) } } })
}

fn confounds(survey: &Survey) -> Option<Markup> {
    let shortcut = survey.card.shortcut.as_ref()?;
    let columns = vec![
        Column::text("number", "statistic", |carrier: &Carrier| Cell::text(carrier.statistic.clone())),
        Column::value("alone tells, %", "accuracy_percent", tenth, |carrier: &Carrier| {
            Some(100.0 * carrier.accuracy)
        }),
    ];
    let table = Table::new(
        names::CARRIERS,
        format!("Chance is {} %", tenth(100.0 * shortcut.chance)),
        columns,
        &survey.carriers,
    );
    Some(html! {
        p { (shortcut) "." }
        @if shortcut.is_suspicious() {
            p.warning role="note" {
                "That is half of the way to every sample, or more: lighting, offset, gain or the order of recording may \
                 tell the classes apart, and part of every score may be that and not touch."
            }
        }
        (charted(carrier(survey), None).unwrap_or_default())
        (scroll(&table))
    })
}

/// Lists exact copies, and whether their labels agree.
fn copies(survey: &Survey) -> Option<Markup> {
    type Row = (String, &'static str);
    let card = &survey.card;
    let torn = card.contradictions.iter().map(|contradiction| {
        let named = contradiction
            .sources
            .iter()
            .zip(&contradiction.labels)
            .map(|(source, label)| format!("{source} ({label})"));
        (named.collect::<Vec<_>>().join(" = "), "different")
    });
    let same = card
        .duplicates
        .iter()
        .map(|rows| (rows.iter().map(usize::to_string).collect::<Vec<_>>().join(" = "), "the same"));
    let all: Vec<Row> = torn.chain(same).collect();
    let columns = vec![
        Column::text("samples", "samples", |row: &Row| Cell::text(row.0.clone())),
        Column::text("labels", "labels", |row: &Row| Cell::text(row.1)),
    ];
    let shown = &all[..all.len().min(SETS)];
    let table = Table::new(names::COPIES, "Samples that are exact copies".into(), columns, shown);
    (!all.is_empty()).then(|| {
        html! {
            @if all.len() > SETS { p.reading { "The first " (SETS) " of " (all.len()) " sets; --format json lists all." } }
            (scroll(&table))
        }
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::survey_page;
    use crate::report::fixture::HOSTILE;
    use crate::survey;
    use std::path::Path;
    use taxel_data::{ReadOptions, Survey};
    use tempfile::tempdir;

    /// Writes forty recordings of two classes and three channels: one never moves, one hits its ceiling, all rise from
    /// sample to sample, and the mean tells the classes apart. The last is a copy of the one before.
    fn set(folder: &Path, unequal: bool) {
        for (class, offset) in [("soft", 0.0), (HOSTILE, 5.0)] {
            let class = class.replace('|', "");
            std::fs::create_dir_all(folder.join(&class)).unwrap();
            for sample in 0..20 {
                let level = if sample == 19 { 18 } else { sample };
                let readings = if unequal { 6 + level % 4 } else { 8 };
                let line = |t: usize| {
                    let value = offset + level as f64 / 10.0 + (t as f64).sin();
                    format!("{value},7,{}\n", value.min(offset + 1.5))
                };
                let text: String = (0..readings).map(line).collect();
                std::fs::write(folder.join(&class).join(format!("{sample:02}.csv")), text).unwrap();
            }
        }
    }

    fn surveyed(folder: &Path) -> Survey {
        taxel_data::survey(folder, &ReadOptions::default()).unwrap()
    }

    fn page(surveyed: Survey) -> String {
        let folder = tempdir().unwrap();
        let path = folder.path().join("card.html");
        survey_page(&survey(surveyed), &path).unwrap();
        std::fs::read_to_string(path).unwrap()
    }

    #[test]
    fn a_page_shows_what_a_card_says() {
        let folder = tempdir().unwrap();
        set(folder.path(), false);
        let looked_at = survey(surveyed(folder.path()));
        assert!(looked_at.drift.correlation.unwrap() > 0.9);
        assert_eq!(looked_at.carriers[0].accuracy, 1.0);
        assert_eq!(
            looked_at.card.channels.iter().map(|channel| channel.stuck).collect::<Vec<_>>(),
            [0.0, 1.0, 0.0]
        );
        assert!(looked_at.lengths.is_empty(), "equal lengths need no chart");
        let page = page(surveyed(folder.path()));
        for part in ["Recordings", "Ranges of the channels", "Means in recording order", "Copies", "The card"]
        {
            assert!(page.contains(part), "{part}");
        }
        for part in
            ["Within classes the mean goes with the order (correlation 0.9", "soft/00.csv", "soft/19.csv"]
        {
            assert!(page.contains(part), "{part}");
        }
        assert!(
            !page.contains("<b>") && !page.contains("Lengths of the recordings"),
            "unescaped, or needless"
        );
        assert_eq!(page, self::page(surveyed(folder.path())), "equal sets, equal bytes");
    }

    #[test]
    fn lengths_are_drawn_and_damaged_sets_as_well() {
        let folder = tempdir().unwrap();
        set(folder.path(), true);
        let unequal = page(surveyed(folder.path()));
        assert!(unequal.contains("Lengths of the recordings") && unequal.contains("Wrong: "));
        // Values that are not finite, labels with a gap, one sample per class.
        let files = [("set/a/1.csv", "1,NaN\n2,inf\n"), ("set/b/1.csv", "NaN,NaN\nNaN,NaN\n")];
        for (name, text) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        let damaged = page(surveyed(&folder.path().join("set")));
        assert!(damaged.contains("Wrong: ") && !damaged.contains("cx=\"NaN\"") && !damaged.contains("inf,"));
    }
}
