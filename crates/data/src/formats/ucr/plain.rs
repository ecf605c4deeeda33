//! Reads the plain text files of the UCR archive: one case a line, its class first.

use crate::Result;
use crate::formats::ucr::case::{Case, CaseLine, CaseTargets};

/// Hands every case to `take`: one channel, parted by tabs, else by commas, else by blanks.
pub(crate) fn read(text: &str, file: &str, take: &mut dyn FnMut(Case) -> Result<()>) -> Result<CaseTargets> {
    for line in CaseLine::of(text, file) {
        let mut fields: Vec<&str> = match ['\t', ','].into_iter().find(|mark| line.text.contains(*mark)) {
            Some(mark) => line.text.split(mark).map(str::trim).collect(),
            None => line.text.split_whitespace().collect(),
        };
        // Loggers and spreadsheets end lines with a separator.
        if fields.last().is_some_and(|last| last.is_empty()) {
            fields.pop();
        }
        let (class, values) = match fields.split_first() {
            Some((class, values)) if !class.is_empty() && !values.is_empty() => (*class, values),
            _ => return Err(line.no_class()),
        };
        let values = values.iter().enumerate().map(|(column, text)| line.number(text, column + 2));
        let values: Vec<f32> = values.collect::<Result<_>>()?;
        // Classes written as 1.0000000e+00 are the class 1.
        let target = class.parse::<f64>().map_or_else(|_| class.to_string(), |number| number.to_string());
        take(Case { target, channels: vec![values] })?;
    }
    Ok(CaseTargets::Unsaid)
}
