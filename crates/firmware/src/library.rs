//! A network in eight bits with all that its C needs.

use taxel_encodings::Scaling;
use taxel_runtime::Blueprint;

use crate::literals::{comment, identifier};
use crate::samples::Samples;
use crate::size::Size;

/// A network in eight bits with all that its C needs.
#[derive(Debug, Clone)]
pub struct Library<'a> {
    /// Name of the library: files and functions begin with `taxel_<name>`.
    pub name: String,
    /// Name of the model.
    pub model: String,
    /// Version of taxel.
    pub version: String,
    /// The network.
    pub blueprint: &'a Blueprint,
    /// How values of a sample are scaled.
    pub scaling: &'a Scaling,
    /// Channels and time steps of a sample.
    pub sample: [usize; 2],
    /// Names of the classes.
    pub classes: Vec<String>,
    /// The temperature that divides the logits, of a calibrated model.
    pub temperature: Option<f64>,
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

/// Predictions that the C has to repeat, sample after sample.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Expected {
    /// Logits.
    pub logits: Vec<f32>,
    /// Probabilities.
    pub probabilities: Vec<f32>,
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
    /// Makes a library without classes, of which nothing more is known.
    pub fn new(
        name: &str,
        blueprint: &'a Blueprint,
        scaling: &'a Scaling,
        sample: [usize; 2],
        samples: Samples,
        expected: Expected,
    ) -> Self {
        Library {
            name: name.into(),
            model: name.into(),
            version: env!("CARGO_PKG_VERSION").into(),
            blueprint,
            scaling,
            sample,
            classes: vec![],
            temperature: None,
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
                    "{}: {} classes of samples of {channels} channels x {steps} time steps",
                    self.model,
                    self.classes.len()
                )),
            ),
            ("@version@", comment(&self.version)),
            ("@class_count@", self.classes.len().to_string()),
            ("@channels@", channels.to_string()),
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
        text
    }
}
