//! A comparison as people read it.

use taxel::base::thousands;
use taxel::judge::{Place, SideBySide, SideCosts, Test, rounded};

use crate::terminal::tables;

/// Level at which a difference is said to be there.
const ALPHA: f64 = 0.05;

/// Returns the page of a comparison.
pub fn page(found: &SideBySide) -> String {
    let mut page = head(found);
    page += &verdict(found);
    page += "\n\n";
    page += &places(found);
    page
}

/// Returns what was compared, with scores and costs.
fn head(found: &SideBySide) -> String {
    let primary = &found.primary;
    let groups = found.groups.map_or(String::new(), |groups| format!(" in {groups} groups"));
    let parts = if found.parts > 1 { format!(", {} test parts", found.parts) } else { String::new() };
    let [a, b] = &found.names;
    let row = |name: &str, at: usize| {
        let SideCosts { parameters, bytes, macs, ms } = found.costs[at];
        vec![
            name.to_string(),
            primary.show_longer()(found.scores[at]),
            ms.map_or("–".into(), |ms| format!("{ms:.3}")),
            thousands(parameters),
            macs.map_or("–".into(), thousands),
            thousands(bytes),
        ]
    };
    let score = primary.head();
    let header = ["", score.as_str(), "latency ms", "parameters", "MACs", "bytes of the file"];
    let rows = [row(&format!("A {a}"), 0), row(&format!("B {b}"), 1)];
    format!(
        "{} samples{groups}{parts}\n\n{}\n",
        found.samples,
        tables::table(&header, &rows, &[1, 2, 3, 4, 5])
    )
}

/// Says who is better, by how much, and how sure that is.
fn verdict(found: &SideBySide) -> String {
    let primary = &found.primary;
    let worse = primary.loss(found.difference);
    let (better, size) = if worse > 0.0 { ("B", worse) } else { ("A", -worse) };
    let interval = found.interval.map_or(String::new(), |ends| {
        let [low, high] =
            if better == "B" { primary.losses(ends) } else { primary.losses(ends).map(|end| -end) };
        let show = primary.show();
        format!(" [{}, {}]", show(low.min(high)), show(low.max(high)))
    });
    let p = found.p.map_or(String::new(), |p| {
        let p = if p < 0.001 { "p < 0.001".into() } else { format!("p = {p:.3}") };
        format!(" ({}, {p})", test(found.test))
    });
    if found.difference == 0.0 {
        return format!("Both score alike{p}.");
    }
    let size = format!("{}{interval}", primary.difference(size));
    if found.p.is_some_and(|p| p < ALPHA) {
        return format!("{better} is better by {size}{p}.");
    }
    let unit = if found.deciding_groups { "groups" } else { "samples" };
    let open = found.deciding.map_or(String::new(), |count| {
        format!(" A difference of this size would show with about {} {unit}.", thousands(rounded(count)))
    });
    format!("Open: {better} seems better by {size}{p}.{open}")
}

/// Returns a test in words.
fn test(test: Test) -> &'static str {
    match test {
        Test::NadeauBengio => "corrected resampled t-test",
        Test::FreshWorlds => "t-test over worlds",
        Test::McNemar => "McNemar's exact test",
        Test::GroupedPairs => "t-test over groups",
        Test::Wilcoxon => "Wilcoxon's signed-rank test",
    }
}

/// Returns who is right where.
fn places(found: &SideBySide) -> String {
    let of_labels = found.right.is_some();
    let several = found.places.iter().any(|place| !place.of.is_empty());
    let mut header = vec![];
    if several {
        header.push(if of_labels { "attribute" } else { "quantity" });
    }
    header.push(if of_labels { "class" } else { "true value" });
    header.extend(["samples", if of_labels { "A right %" } else { "A off by" }]);
    header.extend([if of_labels { "B right %" } else { "B off by" }]);
    header.extend(if of_labels { ["only A right", "only B right"] } else { ["A closer", "B closer"] });
    let show = found.primary.show_longer();
    let row = |place: &Place| {
        let mut row = if several { vec![place.of.clone()] } else { vec![] };
        row.extend([place.name.clone(), place.samples.to_string()]);
        row.extend(place.scores.map(show));
        row.extend(place.only.map(|count| count.to_string()));
        row
    };
    let mut rows: Vec<Vec<String>> = found.places.iter().map(row).collect();
    if let Some(right) = found.right {
        let mut all = if several { vec![String::new()] } else { vec![] };
        all.extend(["all".into(), found.samples.to_string()]);
        let share = |only: usize| 100.0 * (right.both + only) as f64 / found.samples.max(1) as f64;
        all.extend(right.only.map(|only| show(share(only))));
        all.extend(right.only.map(|count| count.to_string()));
        rows.push(all);
    }
    let first = usize::from(several) + 1;
    tables::table(&header, &rows, &(first..header.len()).collect::<Vec<_>>())
}
