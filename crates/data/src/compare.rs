//! Compares what recordings say of themselves with what a model was trained on.

use crate::dataset::sample_spec::SampleSpec;
use crate::formats::clock::RATE_TOLERANCE;
use crate::recordings::RecordingFacts;
use crate::unit::UnitFactor;
use ndarray::ArrayD;
use std::fmt::{self, Display};

/// Largest relative difference of two full scales, by rounding.
const SCALE_TOLERANCE: f64 = 1e-3;

/// A fact in which recordings differ from those of the training.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FactDifference {
    /// `unit`, `rate`, `full scale`, `layout` or `bit depth`.
    pub fact: &'static str,
    /// Value in training.
    pub trained: String,
    /// Value of these recordings.
    pub here: String,
}

impl Display for FactDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let FactDifference { fact, trained, here } = self;
        write!(f, "{fact} {here}, but the model was trained on {trained}")
    }
}

/// The result of comparing recordings with those of a training. Facts that one of them does not know are not compared.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FactComparison {
    /// Brings the values to the unit of the training, where the two differ by a power of ten alone.
    pub unit: Option<UnitFactor>,
    /// All that cannot be brought to what the model reads.
    pub differences: Vec<FactDifference>,
}

impl FactComparison {
    /// Lists all differences for a message; none where there are none.
    pub fn refusal(&self) -> Option<String> {
        let differences: Vec<String> = self.differences.iter().map(ToString::to_string).collect();
        (!differences.is_empty()).then(|| differences.join("; "))
    }

    /// Brings values to the unit of the training.
    pub fn convert(&self, x: &mut ArrayD<f32>) {
        if let Some(unit) = &self.unit {
            x.mapv_inplace(|value| unit.convert(value));
        }
    }
}

impl SampleSpec {
    /// Compares what recordings say of themselves with what a model was trained on. Units of one quantity that differ by a
    /// power of ten can be converted; every other difference asks another sensor, or another amplifier, for an answer.
    pub fn compare(&self, here: &RecordingFacts) -> FactComparison {
        let mut comparison = FactComparison::default();
        let mut differs = |fact, trained: String, here: String| {
            comparison.differences.push(FactDifference { fact, trained, here });
        };
        let mut unit = None;
        if let (Some(trained), Some(here)) = (&self.unit, &here.unit)
            && trained.trim() != here.trim()
        {
            unit = UnitFactor::between(here, trained);
            if unit.is_none() {
                differs("unit", trained.clone(), here.clone());
            }
        }
        let is_resampled = self.recorded_rate().is_none();
        if let (Some(trained), Some(here)) = (self.rate, here.rate)
            && !is_resampled
            && !self.is_overruled("rate")
            && self.layout.time_axis().is_some()
            && (trained - here).abs() > RATE_TOLERANCE * trained
        {
            differs("rate", format!("{trained} Hz"), format!("{here} Hz"));
        }
        if let (Some(trained), Some(here)) = (self.full_scale, here.full_scale) {
            let converted = unit.as_ref().map_or(here, |unit| unit.convert(here));
            if f64::from((trained - converted).abs()) > SCALE_TOLERANCE * f64::from(trained) {
                differs("full scale", trained.to_string(), converted.to_string());
            }
        }
        if let Some(here) = here.layout.filter(|here| *here != self.layout && !self.is_overruled("layout")) {
            differs("layout", self.layout.to_string(), here.to_string());
        }
        if let (Some(trained), Some(here)) = (self.depth, here.depth)
            && trained != here
        {
            differs("bit depth", format!("{trained} bits"), format!("{here} bits"));
        }
        comparison.unit = unit;
        comparison
    }

    /// Checks whether the options of the training said a fact against the files.
    fn is_overruled(&self, fact: &str) -> bool {
        self.overruled.iter().any(|name| name == fact)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use taxel_base::Layout;

    fn trained() -> SampleSpec {
        SampleSpec {
            unit: Some("mV".into()),
            rate: Some(100.0),
            full_scale: Some(1000.0),
            depth: Some(8),
            ..SampleSpec::new(Layout::Series, &[5, 50])
        }
    }

    fn here() -> RecordingFacts {
        RecordingFacts {
            unit: Some("mV".into()),
            rate: Some(100.4),
            full_scale: Some(1000.0),
            layout: Some(Layout::Series),
            depth: Some(8),
            ..RecordingFacts::default()
        }
    }

    #[test]
    fn what_is_equal_or_unknown_passes() {
        assert_eq!(trained().compare(&here()), FactComparison::default());
        assert_eq!(trained().compare(&RecordingFacts::default()), FactComparison::default());
        assert_eq!(SampleSpec::new(Layout::Series, &[5, 50]).compare(&here()), FactComparison::default());
    }

    #[test]
    fn a_unit_with_another_prefix_is_converted_with_its_full_scale() {
        let volts = RecordingFacts { unit: Some("V".into()), full_scale: Some(1.0), ..here() };
        let comparison = trained().compare(&volts);
        assert!(comparison.differences.is_empty(), "{comparison:?}");
        let mut x = ndarray::arr1(&[0.1_f32, 0.7]).into_dyn();
        comparison.convert(&mut x);
        assert_eq!(x, ndarray::arr1(&[100.0_f32, 700.0]).into_dyn());
    }

    #[test]
    fn every_other_difference_is_named() {
        for (fact, other) in [
            ("unit", RecordingFacts { unit: Some("N".into()), ..here() }),
            ("rate", RecordingFacts { rate: Some(1000.0), ..here() }),
            ("full scale", RecordingFacts { full_scale: Some(1.0), ..here() }),
            ("layout", RecordingFacts { layout: Some(Layout::Image), ..here() }),
            ("bit depth", RecordingFacts { depth: Some(16), ..here() }),
        ] {
            let differences = trained().compare(&other).differences;
            assert_eq!(differences.iter().map(|one| one.fact).collect::<Vec<_>>(), [fact]);
        }
        let text =
            trained().compare(&RecordingFacts { rate: Some(1000.0), ..here() }).differences[0].to_string();
        assert_eq!(text, "rate 1000 Hz, but the model was trained on 100 Hz");
        let overruled = SampleSpec { overruled: vec!["rate".into()], ..trained() };
        assert!(overruled.compare(&RecordingFacts { rate: Some(1000.0), ..here() }).differences.is_empty());
    }
}
