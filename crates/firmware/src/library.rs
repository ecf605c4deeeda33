//! A model with all that its C needs.

use taxel_runtime::Blueprint;

use crate::answers::{Answers, ReadingsGate};
use crate::encoding::Encoding;
use crate::linear::Linear;
use crate::literals::{comment, identifier};
use crate::samples::Samples;
use crate::size::Size;

/// A model with all that its C needs.
#[derive(Debug, Clone)]
pub struct Library<'a> {
    /// Name of the library: files and functions begin with `taxel_<name>`.
    pub name: String,
    /// Name of the model.
    pub model: String,
    /// Version of taxel.
    pub version: String,
    /// Its computation.
    pub method: Method<'a>,
    /// How a sample becomes what the network reads.
    pub encoding: Encoding<'a>,
    /// Channels and time steps of a sample; of an image channels and pixels.
    pub sample: [usize; 2],
    /// Rows and columns of an image; none of a series. An image is predicted whole: there is no `push`.
    pub image: Option<[usize; 2]>,
    /// Its answers.
    pub answers: Answers,
    /// Whether the readings of a sample are like those of the training; none of a model that does not say it.
    pub readings: Option<ReadingsGate>,
    /// The card of the model, for the README.
    pub about: String,
    /// Remarks for the README: what the model does and the C does not.
    pub remarks: Vec<String>,
    /// Unit of the values, where it is known.
    pub unit: Option<String>,
    /// Time steps per second (Hz), where they are known.
    pub rate: Option<f64>,
    /// Samples of the test.
    pub samples: Samples,
    /// Predictions for them.
    pub expected: Expected,
}

/// The computation of a library.
#[derive(Debug, Clone, Copy)]
pub enum Method<'a> {
    /// A network in eight bits or in floats.
    Network(&'a Blueprint),
    /// A linear model on features: MiniRocket with ridge, or ridge.
    Linear(Linear<'a>),
}

/// Predictions that the C has to repeat, sample after sample.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Expected {
    /// Outputs of the network: logits, or values and what is said of their errors.
    pub outputs: Vec<f32>,
    /// Probabilities, or values.
    pub answers: Vec<f32>,
    /// The lower and the upper ends of the 90 % intervals; empty of a model without them.
    pub ends: [Vec<f32>; 2],
    /// The distance of each sample, and whether it is unknown; empty of a model without a gate.
    pub gate: Vec<(f32, bool)>,
    /// The same of the readings; empty of a model without a gate of readings.
    pub readings: Vec<(f32, bool)>,
}

/// A file of the folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CFile {
    /// Path below the folder, with slashes.
    pub path: String,
    /// Text.
    pub text: String,
}

impl<'a> Library<'a> {
    /// Makes a library of which nothing more is known.
    pub fn new(
        name: &str,
        method: Method<'a>,
        (encoding, sample): (Encoding<'a>, [usize; 2]),
        answers: Answers,
        samples: Samples,
        expected: Expected,
    ) -> Self {
        Library {
            name: name.into(),
            model: name.into(),
            version: env!("CARGO_PKG_VERSION").into(),
            method,
            encoding,
            sample,
            image: None,
            answers,
            readings: None,
            about: String::new(),
            remarks: vec![],
            unit: None,
            rate: None,
            samples,
            expected,
        }
    }

    /// Returns the identifier that files and functions begin with, behind `taxel_`.
    pub fn identifier(&self) -> String {
        identifier(&self.name)
    }

    /// Fills the places of a text that all files share, then `more`.
    pub(crate) fn filled(&self, template: &str, size: &Size, more: &[(&str, String)]) -> String {
        let (name, [channels, steps]) = (self.identifier(), self.sample);
        let [rows, columns] = self.image.unwrap_or([1, steps]);
        let noun = match self.answers {
            Answers::Classes { .. } | Answers::Attributes { .. } => "Classes",
            Answers::Values { .. } => "Quantities",
        };
        let mut text = template.to_string();
        for (key, value) in more {
            text = text.replace(key, value);
        }
        let shared = [
            ("@NAME@", name.to_uppercase()),
            ("@name@", name),
            (
                "@title@",
                comment(&format!(
                    "{}: predicts {} from {}",
                    self.model,
                    self.answers.words(),
                    self.sample_words().replace('×', "x")
                )),
            ),
            ("@version@", comment(&self.version)),
            ("@answer_words@", comment(&self.answers.words()).replace('"', "'")),
            ("@answer_noun@", noun.into()),
            ("@ANSWERS@", noun.to_uppercase()),
            ("@answer_count@", self.answers.count().to_string()),
            ("@outputs@", self.answers.outputs().to_string()),
            ("@ring_steps@", self.encoding.ring_steps(steps).to_string()),
            ("@sample@", self.sample_words()),
            ("@sample_in_ascii@", self.sample_words().replace('×', "x")),
            ("@sample_bytes@", (channels * steps * size_of::<f32>()).to_string()),
            ("@channels@", channels.to_string()),
            ("@rows@", rows.to_string()),
            ("@columns@", columns.to_string()),
            ("@steps@", steps.to_string()),
            ("@values@", (channels * steps).to_string()),
            ("@workspace@", (size.ram / size_of::<f32>()).to_string()),
            ("@ram@", size.ram.to_string()),
            ("@ring@", size.ring.to_string()),
            ("@table@", size.tables.to_string()),
            ("@flash@", size.flash.to_string()),
            ("@macs@", size.macs.to_string()),
        ];
        for (key, value) in shared {
            text = text.replace(key, &value);
        }
        self.of_samples(&text)
    }

    /// Returns the size of a sample in words.
    fn sample_words(&self) -> String {
        let [channels, steps] = self.sample;
        let of = |count: usize| if count == 1 { "channel" } else { "channels" };
        match self.image {
            Some([rows, columns]) => format!("{channels} {} × {rows} rows × {columns} columns", of(channels)),
            None => format!("{channels} channels × {steps} time steps"),
        }
    }

    /// Leaves the lines that are for samples of this kind, series or images, and gives the axes their names.
    fn of_samples(&self, text: &str) -> String {
        let name = self.identifier().to_uppercase();
        let (gone, axes) = match self.image {
            Some(_) => ("live", "channels, rows and columns"),
            None => ("still", "channels and time steps"),
        };
        let mut is_gone = false;
        let mut kept = String::with_capacity(text.len());
        for line in text.split_inclusive('\n') {
            match line.trim() {
                "@live@" | "@still@" => is_gone = line.trim().trim_matches('@') == gone,
                "@end live@" | "@end still@" => is_gone = false,
                _ if is_gone => {}
                _ => kept.push_str(line),
            }
        }
        let kept = kept.replace("@axes@", axes);
        if self.image.is_none() {
            return kept;
        }
        kept.replace(&format!("TAXEL_{name}_STEPS"), &format!("TAXEL_{name}_PIXELS"))
            .replace("each with its time steps", "each row after row")
    }
}
