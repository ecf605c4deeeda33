//! Predictions as a table, CSV, JSON and NumPy arrays.

use serde_json::json;
use taxel::Predictions;
use taxel::base::Grid;
use taxel::data::{Npz, Quantity};

use super::samples::SamplePredictions;
use crate::commands::arguments::certainty::UNKNOWN;
use crate::terminal::tables;

impl SamplePredictions<'_> {
    pub fn table(&self) -> String {
        let mut header = vec!["sample".to_string()];
        header.extend(self.starts.map(|_| "start".to_string()));
        for attribute in self.predictions.task.attributes() {
            header.extend([attribute.name, "probability".into()]);
            if self.truth.is_some() {
                header.push("true".into());
            }
        }
        let quantities = self.predictions.task.quantities();
        let interval = self.interval.map(|share| format!("{:.0} % interval", 100.0 * share));
        let truth = self.values.map(|_| "true".to_string());
        let of_quantity = |quantity: &Quantity| {
            [Some(quantity.to_string()), interval.clone(), truth.clone()].into_iter().flatten()
        };
        let values: Vec<String> = quantities.iter().flat_map(of_quantity).collect();
        header.extend(self.familiarity().map(|_| "familiarity".to_string()));
        header.extend(self.sets.map(|sets| format!("{:.0} % set", 100.0 * sets.share)));
        header.extend(values.iter().cloned());
        header.extend(self.replaced.map(|_| "replaced".to_string()));
        let row = |i: usize| {
            let mut cells = vec![self.origins[i].clone()];
            cells.extend(self.starts.map(|starts| starts[i].to_string()));
            for (at, predicted) in self.predictions.predicted(i).into_iter().enumerate() {
                let class = if self.is_unknown(i) {
                    format!("{UNKNOWN} (like {})", predicted.class)
                } else {
                    predicted.class.to_string()
                };
                cells.extend([class, format!("{:.3}", predicted.probability)]);
                cells.extend(self.truth.map(|truth| truth[i].get(at).cloned().unwrap_or_default()));
            }
            cells.extend(self.familiarity().map(|all| format!("{:.2}", all[i])));
            cells.extend(self.sets.map(|sets| self.set_words(sets, i)));
            let ends = self.ends(i).unwrap_or_default();
            for (at, (_, value)) in self.predictions.values(i).into_iter().enumerate() {
                let is_unknown = self.is_unknown(i);
                cells.push(if is_unknown {
                    format!("{UNKNOWN} ({value:.3})")
                } else {
                    format!("{value:.3}")
                });
                let interval = |[low, high]: &[f32; 2]| {
                    // No share of intervals holds for a sample that is unlike those that they were fitted to.
                    if is_unknown { "–".to_string() } else { format!("{low:.3} to {high:.3}") }
                };
                cells.extend(ends.get(at).map(interval));
                cells.extend(self.values.map(|values| values.cell(i, at)));
            }
            cells.extend(self.replaced.map(|replaced| replaced.words(i)));
            cells
        };
        let rows: Vec<Vec<String>> = (0..self.predictions.len()).map(row).collect();
        let header: Vec<&str> = header.iter().map(String::as_str).collect();
        let is_number = |name: &str| {
            ["probability", "start", "familiarity"].contains(&name) || values.iter().any(|v| v == name)
        };
        let right: Vec<usize> = (0..header.len()).filter(|i| is_number(header[*i])).collect();
        tables::table(&header, &rows, &right) + &self.explanation()
    }

    /// Says what each prediction rests on, below the table.
    fn explanation(&self) -> String {
        let Some(explained) = self.explained else { return String::new() };
        let one = |i: usize| format!("\n{}: what changes\n{}", self.origins[i], explained.words(i));
        (0..self.predictions.len()).map(one).collect()
    }

    pub fn csv(&self) -> String {
        let task = &self.predictions.task;
        let attributes = task.attributes().into_iter().map(|attribute| attribute.name);
        let has_labels = task.quantities().is_empty();
        let outputs =
            task.output_names().into_iter().map(|name| if has_labels { format!("p({name})") } else { name });
        let quantities = task.quantities().iter().filter(|_| self.interval.is_some());
        let ends =
            quantities.flat_map(|quantity| ["low", "high"].map(|end| format!("{}_{end}", quantity.name)));
        let outputs = outputs.chain(ends);
        let start = self.starts.map(|_| "start".to_string());
        let likeliest =
            self.predictions.task.attributes().into_iter().filter(|_| self.familiarity().is_some());
        let likeliest = likeliest.map(|attribute| format!("likeliest {}", attribute.name));
        let familiarity = self.familiarity().map(|_| "familiarity".to_string());
        let unknown = self.familiarity().filter(|_| !has_labels).map(|_| UNKNOWN.to_string());
        let familiarity = familiarity.into_iter().chain(unknown);
        let set = self.sets.map(|_| "set".to_string());
        let replaced = self.replaced.map(|_| "replaced".to_string());
        let columns = start.into_iter().chain(attributes).chain(outputs).chain(likeliest);
        let columns = columns.chain(familiarity).chain(set).chain(replaced);
        let mut grid = columns.fold(Grid::new().left("sample"), Grid::left);
        for i in 0..self.predictions.len() {
            let predicted = self.predictions.predicted(i);
            let outputs = self.predictions.row(i);
            let class = |class: &str| if self.is_unknown(i) { UNKNOWN.into() } else { class.to_string() };
            let cells = predicted.iter().map(|one| class(one.class));
            let likeliest = predicted.iter().filter(|_| self.familiarity().is_some());
            let likeliest = likeliest.map(|one| one.class.to_string());
            let familiarity = self.familiarity().map(|all| all[i].to_string());
            let unknown = self.familiarity().filter(|_| !has_labels).map(|_| self.is_unknown(i).to_string());
            let familiarity = familiarity.into_iter().chain(unknown);
            let set = self.sets.map(|sets| self.set_words(sets, i));
            let start = self.starts.map(|starts| starts[i].to_string());
            let sample = [self.origins[i].clone()].into_iter().chain(start);
            let replaced = self.replaced.map(|replaced| replaced.count(i).to_string());
            let ends = self.ends(i).unwrap_or_default().concat();
            let end = |end: &f32| if self.is_unknown(i) { String::new() } else { end.to_string() };
            let outputs = outputs.iter().map(f32::to_string).chain(ends.iter().map(end));
            let cells = sample.chain(cells).chain(outputs).chain(likeliest);
            grid.row(cells.chain(familiarity).chain(set).chain(replaced));
        }
        grid.csv()
    }

    pub fn json(&self) -> serde_json::Result<String> {
        let names = self.predictions.task.output_names();
        let has_labels = self.predictions.task.quantities().is_empty();
        let one = |i: usize| {
            let outputs = self.predictions.row(i).iter().map(|p| json!(p));
            let outputs: serde_json::Map<String, serde_json::Value> =
                names.iter().cloned().zip(outputs).collect();
            let predicted = self.predictions.predicted(i);
            let is_unknown = self.is_unknown(i);
            let named =
                |class: &dyn Fn(&str) -> serde_json::Value| -> serde_json::Map<String, serde_json::Value> {
                    predicted.iter().map(|one| (one.attribute.to_string(), class(one.class))).collect()
                };
            let classes = named(&|class| if is_unknown { json!(UNKNOWN) } else { json!(class) });
            let mut sample = if has_labels {
                json!({
                    "sample": self.origins[i], "predicted": classes, "probabilities": outputs,
                    "true": self.truth.map(|truth| &truth[i]),
                })
            } else {
                json!({ "sample": self.origins[i], "predicted": outputs })
            };
            if let Some(ends) = self.ends(i).filter(|_| !is_unknown) {
                let named = names.iter().cloned().zip(ends.into_iter().map(|ends| json!(ends)));
                sample["interval"] = named.collect::<serde_json::Map<_, _>>().into();
            }
            if let Some(values) = self.values {
                sample["true"] = json!(values.of(i));
            }
            if is_unknown && has_labels {
                sample["likeliest"] = named(&|class| json!(class)).into();
            }
            if let Some(familiarity) = self.familiarity() {
                sample["familiarity"] = json!(as_printed(familiarity[i]));
                if !has_labels {
                    sample[UNKNOWN] = json!(is_unknown);
                }
            }
            if let Some(sets) = self.sets {
                sample["set"] = self.set_names(sets, i).into_iter().collect::<serde_json::Value>();
            }
            if let Some(starts) = self.starts {
                sample["start"] = json!(starts[i]);
            }
            if let Some(replaced) = self.replaced {
                sample["replaced"] = replaced.json(i);
            }
            if let Some(explained) = self.explained {
                sample["rests_on"] = explained.json(i);
            }
            sample
        };
        let all = json!({
            "answers": (0..self.predictions.len()).map(one).collect::<Vec<_>>(),
            "calibrated": self.is_calibrated,
            "interval_share": self.interval,
            "accuracy_percent": self.right().map(|(right, of)| 100.0 * right as f64 / of as f64),
        });
        Ok(serde_json::to_string_pretty(&all)? + "\n")
    }

    pub fn npz(&self) -> std::io::Result<Vec<u8>> {
        let Predictions { task, outputs, labels, .. } = self.predictions;
        let n = self.predictions.len();
        let mut npz = Npz::default();
        let shape = |columns: usize| if columns == 1 { vec![n] } else { vec![n, columns] };
        if task.quantities().is_empty() {
            npz.add("predicted", &shape(labels.len() / n.max(1)), labels)?;
            npz.add("probabilities", &[n, self.predictions.width()], outputs)?;
        } else {
            npz.add("predicted", &shape(self.predictions.width()), outputs)?;
            if let Some(share) = self.interval {
                let of_sample = |i: usize| {
                    let is_unknown = self.is_unknown(i);
                    let ends = self.ends(i).unwrap_or_default().into_iter().flatten();
                    ends.map(move |end| if is_unknown { f32::NAN } else { end })
                };
                let ends: Vec<f32> = (0..n).flat_map(of_sample).collect();
                npz.add("interval", &[n, self.predictions.width(), 2], &ends)?;
                npz.add("interval_share", &[], &[share])?;
            }
        }
        if let Some(familiarity) = self.familiarity() {
            npz.add("familiarity", &[n], familiarity)?;
            let unknown: Vec<bool> = (0..n).map(|i| self.is_unknown(i)).collect();
            npz.add("unknown", &[n], &unknown)?;
        }
        if let Some(sets) = self.sets {
            let held = (0..n).flat_map(|i| self.set_mask(sets, i)).collect::<Vec<bool>>();
            npz.add("set", &[n, self.predictions.width()], &held)?;
            npz.add("set_share", &[], &[sets.share])?;
        }
        if let Some(replaced) = self.replaced {
            let replaced: Vec<i64> = (0..n).map(|i| replaced.count(i) as i64).collect();
            npz.add("replaced", &[n], &replaced)?;
        }
        if let Some(starts) = self.starts {
            let starts: Vec<i64> = starts.iter().map(|start| *start as i64).collect();
            npz.add("start", &[n], &starts)?;
            npz.add("recording", &[n], &self.recordings())?;
        }
        npz.finish()
    }
}

/// Returns the number whose digits a float prints; in double precision it would show others behind them.
fn as_printed(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}
