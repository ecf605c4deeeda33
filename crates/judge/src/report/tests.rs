//! The report of a judgement made by hand.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use taxel_data::Source;
use taxel_learn::Leak;
use taxel_report::canvas::Canvas;
use taxel_report::palette::Paint;

use super::fixture::{HOSTILE, choice, judgement};
use super::tables::tables;
use super::{OverviewRun, Report, overview, report};
use crate::decide::across;
use crate::values::Judgement;

fn whole() -> &'static Report {
    static WHOLE: LazyLock<Report> = LazyLock::new(|| report(&judgement(), Some(&choice())).unwrap());
    &WHOLE
}

fn file<'a>(report: &'a Report, name: &str) -> &'a str {
    let (_, bytes) =
        report.files().iter().find(|(known, _)| known == name).unwrap_or_else(|| panic!("no {name}"));
    std::str::from_utf8(bytes).unwrap()
}

/// Reads the rows of a CSV by the names of its columns.
fn read(report: &Report, name: &str) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_reader(file(report, &format!("tables/{name}.csv")).as_bytes());
    reader.deserialize().map(|row| row.unwrap()).collect()
}

fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap()
}

#[test]
fn names_of_users_cannot_break_out_of_the_page() {
    let report = whole();
    let page = file(report, "report.html");
    assert!(!page.contains("<b>") && !page.contains("&\"x"), "unescaped");
    assert!(page.matches("&lt;b&gt;&amp;").count() > 10, "it is there, escaped");
    // What remains of the page without its raw parts is well-formed XML but for elements without an end.
    let mut xml = page.replace("<!DOCTYPE html>", "");
    for part in ["style", "script"] {
        let (start, end) =
            (xml.find(&format!("<{part}>")).unwrap(), xml.rfind(&format!("</{part}>")).unwrap());
        xml.replace_range(start..end + part.len() + 3, "");
    }
    let mut closed = String::new();
    for piece in xml.split_inclusive('>') {
        let tag = piece.rsplit('<').next().unwrap();
        let open = ["meta ", "link ", "img "].iter().any(|void| tag.starts_with(void));
        closed += &if open { piece.replace('>', "/>") } else { piece.to_string() };
    }
    let document = roxmltree::Document::parse(&closed).unwrap();
    let all = |tag: &str| document.descendants().filter(|n| n.has_tag_name(tag)).count();
    assert!(document.descendants().all(|n| !n.has_tag_name("b")));
    assert_eq!(all("h1"), 1);
    let tables = tables(&judgement(), Some(&choice())).unwrap();
    assert_eq!((all("table"), all("caption")), (tables.len(), tables.len()));
    let has = |tag: &'static str, attribute: &'static str| {
        let mut elements = document.descendants().filter(move |n| n.tag_name().name() == tag);
        elements.all(|n| n.attribute(attribute).is_some())
    };
    assert!(has("th", "scope") && has("img", "alt") && has("html", "lang"));
    let svg = document.descendants().filter(|n| n.tag_name().name() == "svg");
    assert!(svg.clone().count() > 8);
    assert!(svg.clone().all(|n| n.attribute("role") == Some("img") && n.attribute("aria-label").is_some()));
    let ids: Vec<&str> = document.descendants().filter_map(|n| n.attribute("id")).collect();
    for id in &ids {
        assert_eq!(ids.iter().filter(|other| other == &id).count(), 1, "{id} twice");
    }
    for link in document.descendants().filter_map(|n| n.attribute("href")).filter_map(|h| h.strip_prefix('#'))
    {
        assert!(ids.contains(&link), "#{link} leads nowhere");
    }
    for outside in ["http:", "https:", "src=\"/", "url("] {
        let allowed = "xmlns=\"http://www.w3.org/2000/svg\"";
        assert!(!page.replace(allowed, "").contains(outside), "{outside}: the page needs nothing else");
    }
}

#[test]
fn leaks_stand_at_the_top_of_the_page() {
    let mut doubtful = judgement();
    let example = ["a/1.csv", "b/2.csv"].map(String::from);
    doubtful.results.leaks = vec![Leak::Copies { copied: 3, tested: 60, example }];
    let report = report(&doubtful, None).unwrap();
    let page = file(&report, "report.html");
    let said = "Mind: 3 of 60 test samples are copies of training samples (a/1.csv of b/2.csv)";
    assert!(page.find(said).is_some_and(|at| at < page.find("<table").unwrap()), "{said}");
    assert!(!file(whole(), "report.html").contains("Mind: "));
}

#[test]
fn drawings_are_well_formed_and_say_their_values() {
    let report = whole();
    let drawings = report.files().iter().filter(|(name, _)| name.ends_with(".svg"));
    let mut count = 0;
    for (name, bytes) in drawings {
        let text = std::str::from_utf8(bytes).unwrap();
        let document = roxmltree::Document::parse(text).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(!text.contains("var(--"), "{name}: a file has no style sheet");
        assert!(!text.contains("NaN") && !text.contains("inf\""), "{name}");
        let numbers = document.descendants().flat_map(|n| n.attributes().collect::<Vec<_>>());
        for attribute in numbers.filter(|a| ["cx", "cy", "x", "y", "x1", "y2", "width"].contains(&a.name())) {
            attribute.value().trim_end_matches('%').parse::<f64>().unwrap();
        }
        let png = name.replace(".svg", ".png");
        assert!(
            report.files().iter().any(|(known, bytes)| *known == png && bytes.starts_with(b"\x89PNG")),
            "{png}"
        );
        count += 1;
    }
    assert!(count >= 12, "{count} drawings");
    let chart = file(report, "charts/accuracy-latency.svg");
    assert!(
        chart.contains("<title>small-1d: 91.2 % [87.2, 94.2], 0.0200 ms (p95 0.0300 ms)</title>"),
        "{chart}"
    );
    let size = file(report, "charts/accuracy-size.svg");
    assert!(size.contains(
        "<title>published, own recordings: small-1d (Kaewrakmuk and Srinonchat 2026, Table 5): 87.94 ± 1.42 %, 62.9 kB"
    ));
    assert!(!chart.contains("published"), "no paper printed a latency");
    let matrix = file(report, "charts/confusion-00-small-1d.svg");
    assert!(
        matrix.contains("<title>soft taken for &lt;b&gt;&amp;&quot;x|$a_1$: 3 of 27</title>"),
        "{matrix}"
    );
}

#[test]
fn files_hold_the_numbers_of_the_judgement() {
    let (report, judgement) = (whole(), judgement());
    let rows = read(report, "networks");
    assert_eq!(rows.len(), judgement.networks.len());
    for (row, n) in rows.iter().zip(&judgement.networks) {
        assert_eq!(row["network"], n.results.network);
        let (mean, speed) = (n.results.mean.clone().unwrap(), n.speed.unwrap());
        assert_eq!(number(row, "accuracy_percent"), mean.get("accuracy").unwrap());
        assert_eq!(number(row, "accuracy_low_percent"), n.results.interval.unwrap()[0]);
        assert_eq!(number(row, "accuracy_high_percent"), n.results.interval.unwrap()[1]);
        assert_eq!(number(row, "macro_f1_percent"), mean.get("f1").unwrap());
        assert_eq!(number(row, "latency_p50_ms"), speed.whole.p50_ms);
        assert_eq!(number(row, "latency_p95_ms"), speed.whole.p95_ms);
        assert_eq!(number(row, "bytes"), n.results.costs.bytes as f64);
        assert_eq!(number(row, "macs"), n.results.costs.macs as f64);
    }
    for (row, n) in read(report, "speed").iter().zip(&judgement.networks) {
        let speed = n.speed.unwrap();
        assert_eq!(number(row, "encoding_p50_ms"), speed.encoding.p50_ms);
        assert_eq!(
            (number(row, "network_p50_ms"), number(row, "network_p95_ms")),
            (speed.network.p50_ms, speed.network.p95_ms)
        );
        assert_eq!(number(row, "samples_per_second"), speed.samples_per_second);
    }
}

#[test]
fn files_hold_the_numbers_under_faults() {
    let (report, judgement) = (whole(), judgement());
    let stress = judgement.stress.as_ref().unwrap();
    let mut curves = read(report, "fault-curves").into_iter();
    for n in &stress.networks {
        for (curve, info) in n.curves.iter().zip(&stress.faults) {
            for (severity, score) in &curve.points {
                let row = curves.next().unwrap();
                assert_eq!(
                    (row["network"].as_str(), row["fault"].as_str()),
                    (n.network.as_str(), info.fault.name())
                );
                assert_eq!(number(&row, "severity"), f64::from(*severity));
                assert_eq!(number(&row, "level"), f64::from(info.levels[usize::from(*severity) - 1]));
                assert_eq!(number(&row, "accuracy_percent"), score.score);
                assert_eq!(
                    number(&row, "calibration_error_percent"),
                    100.0 * score.calibration_error.unwrap()
                );
                assert_eq!(row["broken"], curve.breaks_at.is_some_and(|at| *severity >= at).to_string());
            }
        }
    }
    assert!(curves.next().is_none());
    let losses = &read(report, "fault-losses")[1];
    assert_eq!((number(losses, "gain_loss_points"), number(losses, "gain_breaks_at")), (30.0, 3.0));
    assert_eq!((number(losses, "noise_loss_points"), losses["noise_breaks_at"].as_str()), (3.0, ""));
}

#[test]
fn files_hold_the_numbers_of_early_decisions() {
    let (report, judgement) = (whole(), judgement());
    let early = judgement.early.as_ref().unwrap();
    for (row, n) in read(report, "early").iter().zip(&early.networks) {
        assert_eq!(row["network"], n.network);
        for point in &n.points {
            assert_eq!(number(row, &format!("accuracy_at_{}_percent", point.seen)), point.score);
        }
    }
    let decisions = &read(report, "early-decisions")[1];
    assert_eq!((decisions["network"].as_str(), number(decisions, "confidence")), ("large-2d", 0.9));
    assert_eq!((number(decisions, "accuracy_percent"), number(decisions, "seen_percent")), (92.25, 62.5));
    let chart = file(report, "charts/early.svg");
    assert!(chart.contains("<title>small-1d, 10 % seen: 46.2 %</title>"), "{chart}");
    assert!(!chart.contains("majority"), "it is the line of chance");
    assert!(
        file(report, "report.html").contains("40 of 120 test samples of 50 readings, filled up with zeros")
    );
    let without = Judgement { early: None, ..judgement };
    let page = super::report(&without, None).unwrap();
    assert!(!file(&page, "report.html").contains("Early decisions"));
}

#[test]
fn files_hold_mistakes_and_evidence() {
    let report = whole();
    let matrix = read(report, "confusion");
    let wrong = matrix.iter().find(|row| row["true"] == "soft" && row["predicted"] == HOSTILE).unwrap();
    assert_eq!(wrong["samples"], "3");
    let published = &read(report, "published")[0];
    assert_eq!(
        (number(published, "published_accuracy_percent"), number(published, "published_gflops")),
        (87.94, 0.0002)
    );
    let evidence = &read(report, "evidence")[0];
    assert_eq!(
        (number(evidence, "difference_points"), number(evidence, "difference_low_points")),
        (-2.25, -3.25)
    );
    assert_eq!((number(evidence, "p"), number(evidence, "p_holm")), (0.25, 0.5));
}

#[test]
fn markdown_has_as_many_cells_in_each_row_as_in_its_head() {
    let report = whole();
    let tables = report.files().iter().filter(|(name, _)| name.ends_with(".md"));
    for (name, bytes) in tables {
        let text = std::str::from_utf8(bytes).unwrap().replace("\\|", "");
        let cells = |line: &str| line.matches('|').count();
        let lines: Vec<&str> = text.lines().skip(2).collect();
        assert!(lines.iter().all(|line| cells(line) == cells(lines[0])), "{name}: {text}");
        assert!(!text.contains("<b>"), "{name}");
    }
    let first = file(report, "tables/networks.md");
    assert!(
        first.contains(
            "| small-1d | network | 91.2 [87.2, 94.2] | 1.5 | 88.2 | 0.0200 | 0.0300 | 55.7 kB | 557 k |"
        ),
        "{first}"
    );
}

#[test]
fn networks_stand_without_a_guard_beside_with_one() {
    let table = file(whole(), "tables/guard.md");
    let row = "| small-1d | 91.2 → 90.8 | 16.5 → 7.5 | 3.0 → 3.0 | 30.0 → 12.0 |";
    assert!(table.contains(row), "{table}");
    let alarms = "replaced something in 2 of 40 (5.0 %), 1.5 of 5 channels or taxels each on average";
    assert!(table.contains(alarms), "{table}");
    assert!(file(whole(), "report.html").contains("<h3>Behind a guard</h3>"));
    let mut judgement = judgement();
    judgement.stress.as_mut().unwrap().networks.iter_mut().for_each(|network| network.other = None);
    assert!(!file(&report(&judgement, None).unwrap(), "report.html").contains("Behind a guard"));
}

#[test]
fn published_and_measured_numbers_share_no_column() {
    for table in tables(&judgement(), Some(&choice())).unwrap() {
        let published =
            table.heads.iter().flat_map(|head| &head.csv).filter(|name| name.starts_with("published"));
        let expected = if table.name == "published" { 7 } else { 0 };
        assert_eq!(published.count(), expected, "{}", table.name);
    }
}

#[test]
fn the_heading_names_run_and_data_and_nothing_is_published_that_nobody_printed() {
    let mut judgement = judgement();
    judgement.results.title = Some("Which net for the glove".into());
    let with = report(&judgement, None).unwrap();
    let heading = "<h1>Which net for the glove <span class=\"source\">simulated: fingertip</span></h1>";
    let page = file(&with, "report.html");
    assert!(page.contains(heading), "{page}");
    assert!(page.contains("<title>Which net for the glove, simulated: fingertip: taxel report</title>"));
    assert!(page.contains("What the papers print") && page.contains("real and published numbers"));
    judgement.results.title = None;
    judgement.results.name = "glove".into();
    judgement.results.source = Source::real("glove28");
    judgement.networks.iter_mut().for_each(|n| n.results.published = None);
    let without = report(&judgement, None).unwrap();
    let page = file(&without, "report.html");
    assert!(page.contains("<h1>glove <span class=\"source\">real: glove28</span></h1>"), "{page}");
    assert!(page.contains("real readings") && !page.contains("simulated: "));
    for (name, bytes) in without.files().iter().filter(|(name, _)| !name.ends_with(".png")) {
        let text = std::str::from_utf8(bytes).unwrap();
        assert!(!name.contains("published") && !text.contains("ublished"), "{name}");
    }
}

#[test]
fn equal_judgements_make_equal_bytes_and_old_files_go() {
    let first = whole();
    assert_eq!(*first, report(&judgement(), Some(&choice())).unwrap());
    let folder = tempfile::tempdir().unwrap();
    let page = first.write(folder.path()).unwrap();
    assert_eq!(std::fs::read(&page).unwrap(), first.files()[0].1);
    // Without a stress test there is no chart of faults; the earlier one must not stay beside the new page.
    let mut judgement = judgement();
    judgement.stress = None;
    std::fs::write(folder.path().join("charts/notes.txt"), "mine").unwrap();
    report(&judgement, None).unwrap().write(folder.path()).unwrap();
    assert!(!folder.path().join("charts/fault-curves.svg").exists());
    assert!(!folder.path().join("tables/evidence.csv").exists());
    assert!(folder.path().join("charts/notes.txt").exists(), "a user's own file stays");
    assert!(std::fs::read_to_string(page).unwrap().contains("Not tested."));
}

#[test]
fn a_learning_curve_shows_its_last_row_in_the_table_and_all_in_the_chart() {
    let mut judgement = judgement();
    let mut all = vec![];
    for mut n in judgement.networks.drain(..2) {
        for (count, less) in [(2, 30.0), (5, 10.0)] {
            n.results.per_class = Some(count);
            n.results.network = format!("{}.n{count}", n.results.zoo);
            let mean = n.results.mean.as_mut().unwrap();
            mean.set("accuracy", mean.primary().unwrap() - less);
            all.push(n.clone());
        }
    }
    judgement.networks = all;
    let report = report(&judgement, None).unwrap();
    assert_eq!(read(&report, "networks").len(), 2);
    let rows = read(&report, "few-samples");
    let names: Vec<(&str, &str)> =
        rows.iter().map(|r| (r["network"].as_str(), r["per_class"].as_str())).collect();
    assert_eq!(names, [("small-1d", "2"), ("small-1d", "5"), ("large-2d", "2"), ("large-2d", "5")]);
    assert!(file(&report, "charts/few-samples.svg").contains("small-1d, 2 of each class: 61.2 %"));
}

#[test]
fn several_runs_share_a_page_of_ranks() {
    let sets: Vec<Judgement> = (0..6)
        .map(|i| {
            let mut judgement = judgement();
            judgement.results.name = format!("run-{i}");
            judgement.results.data_digest = format!("{i}");
            judgement
        })
        .collect();
    let entries: Vec<OverviewRun> = sets
        .iter()
        .map(|judgement| OverviewRun {
            page: "a/report.html".into(),
            judgement: judgement.clone(),
            choice: None,
        })
        .collect();
    let ranked = across(&sets.iter().collect::<Vec<_>>(), 0.05).unwrap().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let page = overview(&entries, Some(&ranked), folder.path()).unwrap();
    let page = std::fs::read_to_string(page).unwrap();
    assert!(page.contains("critical difference"), "{page}");
    assert!(!page.contains(HOSTILE));
    // Six runs on the same readings, one of them worse.
    let mut worse = sets.clone();
    let mean = worse[2].networks[0].results.mean.as_mut().unwrap();
    mean.set("accuracy", mean.primary().unwrap() - 12.5);
    let entries: Vec<OverviewRun> = worse
        .into_iter()
        .map(|judgement| OverviewRun { page: String::new(), judgement, choice: None })
        .collect();
    overview(&entries, None, folder.path()).unwrap();
    let rows = std::fs::read_to_string(folder.path().join("tables/same-readings-1.csv")).unwrap();
    let first = rows.lines().nth(1).unwrap();
    assert!(first.starts_with("small-1d,91.25,91.25,78.75,") && first.ends_with(",12.5"), "{rows}");
    for name in ["charts/critical-difference.svg", "charts/critical-difference.png"] {
        assert!(folder.path().join(name).is_file(), "{name}");
    }
}

/// Draws a chart of 12,000 units: so tall are the layers of eleven deep networks.
#[test]
fn a_drawing_may_be_very_tall() {
    let canvas = Canvas::new(760.0, 12_000.0, Paint::Print);
    let png =
        image::ImageReader::new(std::io::Cursor::new(canvas.png().unwrap())).with_guessed_format().unwrap();
    assert_eq!(png.into_dimensions().unwrap(), (1520, 24_000));
}
