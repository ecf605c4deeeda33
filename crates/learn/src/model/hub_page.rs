//! The page of a model on the Hugging Face Hub: `README.md`, whose head in YAML the Hub reads.

use std::fmt::Write as _;

use taxel_base::Layout;
use taxel_data::Task;

use crate::metrics::metrics;
use crate::model::card::{Card, Score};

/// The line by which a page of a model of taxel is known.
pub const HUB_LIBRARY: &str = "library_name: taxel";

impl Card {
    /// Writes the model card of the Hugging Face Hub for the model in the file `file`: the head with task, tags and scores,
    /// then what it reads and predicts, how it is used and what was measured. It names no licence, which is the user's to say.
    pub fn hub_page(&self, file: &str) -> String {
        let mut page = self.head();
        let name = taxel_base::markdown_text(&self.name);
        let predicts = match &self.task {
            Task::Classes(_) | Task::Levels(_) => "It tells classes of touch.",
            Task::Values(_) => "It measures values of touch.",
        };
        let _ = write!(
            page,
            "# {name}\n\nA model for a tactile sensor, trained by [taxel](https://crates.io/crates/taxel). {predicts}\n\n\
             ## Use\n\n```sh\ncargo install taxel\ntaxel predict {file} recording.csv\ntaxel stream {file} --serial \
             /dev/ttyUSB0\n```\n\n```python\nimport taxel\n\nmodel = taxel.load(\"{file}\")\nmodel.predict(x)   # {} raw \
             readings, each [{}]\n```\n\n",
            self.spec.layout.axes(),
            self.spec.shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", "),
        );
        if let Some(score) = &self.score {
            page.push_str(&self.scores(score));
        }
        let _ = write!(page, "## Card\n\n```text\n{self}```\n");
        if self.trained_on.source.is_simulated() {
            page.push_str("\nIt has learned from simulated recordings only. What it does on a real sensor is not measured.\n");
        }
        page
    }

    /// Writes the head that the Hub reads.
    fn head(&self) -> String {
        let quoted = |text: &str| serde_json::Value::from(text).to_string();
        let kind = self.hub_task();
        let (layout, name) = (self.spec.layout.name(), quoted(&self.name));
        let mut head = format!(
            "---\n{HUB_LIBRARY}\npipeline_tag: {kind}\ntags:\n- tactile\n- haptics\n- robotics\n- {layout}\n- {name}\n"
        );
        if let Some(score) = &self.score {
            let source = quoted(&self.trained_on.source.to_string());
            let digest = quoted(&self.trained_on.digest);
            let protocol = quoted(&score.protocol.words(&self.task));
            let _ = write!(
                head,
                "model-index:\n- name: {name}\n  results:\n  - task:\n      type: {kind}\n    dataset:\n      name: {source}\n      \
                 type: {digest}\n      split: {protocol}\n    metrics:\n"
            );
            for (metric, value) in score.mean.iter() {
                let _ = write!(head, "    - type: {metric}\n      value: {value}\n");
            }
        }
        head + "---\n\n"
    }

    /// Returns the task in the Hub's words, which have none for series.
    fn hub_task(&self) -> &'static str {
        let is_of_values = matches!(self.task, Task::Values(_));
        match (self.spec.layout, is_of_values) {
            (Layout::Features, false) => "tabular-classification",
            (Layout::Features, true) => "tabular-regression",
            (Layout::Image | Layout::Colour, false) => "image-classification",
            _ => "robotics",
        }
    }

    /// Writes the scores that stand in the table of a run.
    fn scores(&self, score: &Score) -> String {
        let protocol = score.protocol.words(&self.task);
        let mut page = format!(
            "## Scores\n\nOf {} models with the same recipe, each on samples that it was not trained on ({protocol}).\n\n| metric | \
             mean | SD over folds |\n|---|---:|---:|\n",
            score.folds
        );
        for metric in metrics(&self.task).iter().filter(|metric| metric.is_shown) {
            let Some(mean) = score.mean.get(metric.name) else { continue };
            let sd = score.sd.as_ref().and_then(|sd| sd.get(metric.name));
            let sd = sd.map_or("–".into(), |sd| format!("{sd:.2}"));
            let unit = metric.unit_of(&self.task).map_or(String::new(), |unit| format!(" {unit}"));
            let _ = writeln!(page, "| {}{unit} | {mean:.2} | {sd} |", metric.in_words());
        }
        page + "\n"
    }
}
