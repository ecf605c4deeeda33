//! The files around the C: what Arduino, PlatformIO, Zephyr and CMake expect, and the README.

use crate::library::{CFile, Library};
use crate::size::Size;

/// Returns the files around the C.
pub(crate) fn layouts(library: &Library, size: &Size) -> Vec<CFile> {
    let model = one_line(&library.model);
    let period = library.rate.map_or(10_000, |rate| (1e6 / rate).round().clamp(1.0, 4e9) as u64);
    let rate = if library.rate.is_some() { "" } else { "; the model does not say it" };
    let unit = library.unit.as_ref().map_or(String::new(), |unit| format!(", in {}", one_line(unit)));
    let remarks = library.remarks.iter().map(|remark| format!("\n{remark}\n")).collect::<String>();
    let readings = library.readings.as_ref().map_or("", |_| include_str!("folder/use_readings.md"));
    let printed = library.answers.example();
    let printed = match library.image {
        Some(_) => printed.replace("predict_latest(", "predict(sample, "),
        None => printed.into(),
    };
    let more = [
        ("@model@", model.clone()),
        ("@period@", period.to_string()),
        ("@rate@", rate.into()),
        ("@unit@", unit),
        ("@answer_row@", library.answers.row()),
        ("@use@", library.answers.use_of() + readings),
        ("@print@", printed),
        ("@period_ms@", period.div_ceil(1000).to_string()),
        ("@samples@", library.samples.count.to_string()),
        ("@about@", library.about.trim_end().replace("```", "'''")),
        ("@remarks@", remarks),
    ];
    let example = match library.image {
        Some(_) => include_str!("folder/SensorImage.ino"),
        None => include_str!("folder/SensorLoop.ino"),
    };
    let file = |path: &str, template: &str| {
        let text = library.filled(template, size, &more);
        CFile { path: path.into(), text }
    };
    vec![
        file("CMakeLists.txt", include_str!("folder/CMakeLists.txt")),
        file("README.md", include_str!("folder/README.md")),
        file("library.json", include_str!("folder/library.json")),
        file("library.properties", include_str!("folder/library.properties")),
        file("zephyr/module.yml", include_str!("folder/module.yml")),
        file("zephyr/Kconfig", include_str!("folder/Kconfig")),
        file("zephyr/CMakeLists.txt", include_str!("folder/zephyr.txt")),
        file("examples/SensorLoop/SensorLoop.ino", example),
    ]
}

fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
