//! Makes a data set of arrays in memory.

use crate::check::duplicates;
use crate::dataset::dataset::{Dataset, refuse_layout};
use crate::dataset::digest::hash_rows;
use crate::dataset::full_scale::refuse_far_below;
use crate::dataset::labels::{by_name, group_numbers, refuse_unclear};
use crate::dataset::sample_spec::SampleSpec;
use crate::dataset::source::Source;
use crate::dataset::targets::{Quantity, Targets, Values};
use crate::error::plural;
use crate::{Error, Result};
use ndarray::{ArrayD, Dimension};
use taxel_base::Layout;

impl Dataset {
    /// Takes samples `x` `[N, ..]`, whose further axes are those of `layout`, and one class name per sample.
    /// Names that are numbers are sorted by value, words by the alphabet: their positions are the labels.
    ///
    /// The same samples and labels in a `.npz` have the same digest.
    ///
    /// # Errors
    ///
    /// No samples, an empty axis, a shape that does not fit the layout, another number of labels than
    /// samples, a value that is not finite, names of classes that look alike.
    pub fn new(name: &str, layout: Layout, x: ArrayD<f32>, labels: &[impl ToString]) -> Result<Self> {
        let at = || format!("{name}: x");
        let long = |shape: &[usize]| shape.iter().map(|axis| *axis as u64).collect();
        let Some((&samples, shape)) = x.shape().split_first() else {
            return Err(Error::Layout { at: at(), layout, shape: vec![] });
        };
        refuse_layout(&at(), layout, shape)?;
        match x.shape().iter().position(|axis| *axis == 0) {
            Some(0) => return Err(Error::NoSamples { at: at() }),
            Some(axis) => return Err(Error::EmptyAxis { at: at(), shape: long(x.shape()), axis }),
            None => {}
        }
        refuse_length(name, "labels", labels.len(), samples)?;
        if let Some((index, value)) = x.indexed_iter().find(|(_, value)| !value.is_finite()) {
            let (sample, index) = (format!("{name}: x[{}]", index[0]), index.slice()[1..].to_vec());
            return Err(Error::NotFinite { sample, index, value: *value });
        }
        let spec = SampleSpec::new(layout, shape);
        let x = if x.is_standard_layout() { x } else { x.as_standard_layout().into_owned() };
        let (classes, y) = by_name(labels.iter().map(ToString::to_string).collect());
        refuse_unclear("class", &classes).map_err(|why| Error::file(name, why))?;
        let row_hash = hash_rows(&x);
        let mut dataset = Self {
            name: name.into(),
            source: Source::real(name),
            spec,
            targets: Targets::classes(&classes, &y),
            official: None,
            groups: None,
            group_name: None,
            weights: None,
            units: Some(duplicates::units(&row_hash)),
            origins: (0..samples).map(|i| format!("x[{i}]")).collect(),
            dropped: vec![],
            warnings: vec![],
            row_hash,
            dtype: "<f4".into(),
            digest: String::new(),
            x,
        };
        dataset.update_digest();
        Ok(dataset)
    }

    /// Puts values `[N, quantities]`, row-major, in the place of the classes.
    ///
    /// The same samples and values in a `.npz` have the same digest.
    ///
    /// # Errors
    ///
    /// No quantity, names of quantities that look alike, another number of values than one of each quantity per sample, a
    /// value that is not finite.
    pub fn with_values(mut self, quantities: Vec<Quantity>, values: Vec<f32>) -> Result<Self> {
        let names: Vec<String> = quantities.iter().map(|quantity| quantity.name.clone()).collect();
        refuse_unclear("quantity", &names).map_err(|why| Error::file(&self.name, why))?;
        let width = names.len();
        if width == 0 || !values.len().is_multiple_of(width) {
            let why = format!("{} values are no rows of {width} quantities", values.len());
            return Err(Error::file(&self.name, why));
        }
        refuse_length(&self.name, "values", values.len() / width, self.len())?;
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            let sample = format!("{}: y[{}]", self.name, at / width);
            return Err(Error::NotFinite { sample, index: vec![at % width], value: values[at] });
        }
        self.targets = Targets::Values(Values::new(quantities, values));
        self.update_digest();
        Ok(self)
    }

    /// Says which group (object, session) each sample belongs to. Whole numbers from 0 to 4294967295 stay
    /// as they are; other names are numbered as class names are.
    ///
    /// # Errors
    ///
    /// Another number of groups than samples, names of groups that look alike.
    pub fn with_groups(mut self, groups: &[impl ToString]) -> Result<Self> {
        refuse_length(&self.name, "groups", groups.len(), self.len())?;
        let names: Vec<String> = groups.iter().map(ToString::to_string).collect();
        let numbers: Option<Vec<u32>> = names.iter().map(|name| name.parse().ok()).collect();
        self.groups = Some(match numbers {
            Some(numbers) => numbers,
            None => {
                let numbers = group_numbers(names).map_err(|why| Error::file(&self.name, why))?;
                numbers.into_iter().map(|number| number as u32).collect()
            }
        });
        self.group_name = Some("group".into());
        self.update_digest();
        Ok(self)
    }

    /// Gives names to the channels: the entries of the first axis of a sample, or the values of a time step.
    ///
    /// # Errors
    ///
    /// Another number of names, or one of them twice.
    pub fn with_channel_names(mut self, names: &[impl ToString]) -> Result<Self> {
        let names: Vec<String> = names.iter().map(ToString::to_string).collect();
        let (before, _, after) = self.spec.around_time();
        let first = self.spec.shape.first().copied().filter(|_| self.spec.layout.time_axis() != Some(0));
        let refuse = |value: String, wanted: String| {
            Err(Error::Fact { at: self.name.clone(), key: "channels", value, wanted })
        };
        if let Some((_, name)) = names.iter().enumerate().find(|(at, name)| names[..*at].contains(name)) {
            return refuse(format!("{name:?} twice"), "and a name is of one channel".into());
        }
        if Some(names.len()) != first && names.len() != before * after {
            let channels = plural(first.unwrap_or(before * after), "channel");
            return refuse(plural(names.len(), "name"), format!("and samples have {channels}"));
        }
        self.spec.channel_names = names;
        Ok(self)
    }

    /// Says the unit of the values.
    pub fn with_unit(mut self, unit: &str) -> Self {
        self.spec.unit = Some(unit.into());
        self
    }

    /// Says how many time steps there are per second (Hz).
    ///
    /// # Errors
    ///
    /// A rate that is not above 0 and finite.
    pub fn with_rate(mut self, rate: f64) -> Result<Self> {
        self.refuse_fact("rate", rate)?;
        self.spec.rate = Some(rate);
        Ok(self)
    }

    /// Says the largest possible value.
    ///
    /// # Errors
    ///
    /// A value that is not above 0 and finite, or far below the samples.
    pub fn with_full_scale(mut self, full_scale: f32) -> Result<Self> {
        self.set_full_scale(full_scale)?;
        Ok(self)
    }

    /// Says the largest possible value.
    ///
    /// # Errors
    ///
    /// Those of [`Dataset::with_full_scale`].
    pub fn set_full_scale(&mut self, full_scale: f32) -> Result<()> {
        self.refuse_fact("full_scale", f64::from(full_scale))?;
        refuse_far_below(&self.name, self.x.view(), Some(full_scale))?;
        self.spec.full_scale = Some(full_scale);
        Ok(())
    }

    /// Says the values without contact: one for all, or one per channel.
    pub fn with_rest(mut self, rest: Vec<f32>) -> Self {
        self.spec.rest = Some(rest);
        self
    }

    /// Says how much each sample counts in training: only ratios matter, and one of weight 2 counts as much as two of weight 1.
    /// Samples of weight 0 are left out.
    ///
    /// # Errors
    ///
    /// Another number of weights than samples, one that is negative or not finite, zeros alone.
    pub fn with_weights(mut self, weights: &[f32]) -> Result<Self> {
        refuse_length(&self.name, "weights", weights.len(), self.len())?;
        let refuse = |value: String, wanted: &str| {
            Err(Error::Fact { at: self.name.clone(), key: "weights", value, wanted: wanted.into() })
        };
        if let Some(weight) = weights.iter().find(|weight| !(**weight >= 0.0 && weight.is_finite())) {
            return refuse(weight.to_string(), "which is negative, NaN or infinite");
        }
        let kept: Vec<usize> = (0..weights.len()).filter(|row| weights[*row] > 0.0).collect();
        if kept.is_empty() {
            return refuse("0".into(), "for every sample; give those that count a weight above 0");
        }
        if kept.len() < self.len() {
            self = self.rows(&kept);
        }
        self.weights = Some(kept.into_iter().map(|row| weights[row]).collect());
        self.update_digest();
        Ok(self)
    }

    /// Says which samples the data set's authors test on.
    ///
    /// # Errors
    ///
    /// Another number of marks than samples, or all of them alike.
    pub fn with_official(mut self, test: Vec<bool>) -> Result<Self> {
        refuse_length(&self.name, "official", test.len(), self.len())?;
        if test.iter().all(|mark| *mark == test[0]) {
            return Err(Error::OneSided { file: self.name, array: "official".into() });
        }
        self.official = Some(test);
        Ok(self)
    }

    fn refuse_fact(&self, key: &'static str, value: f64) -> Result<()> {
        if value > 0.0 && value.is_finite() {
            return Ok(());
        }
        let (at, wanted) = (self.name.clone(), "not a number above 0".into());
        Err(Error::Fact { at, key, value: value.to_string(), wanted })
    }
}

fn refuse_length(name: &str, array: &str, len: usize, samples: usize) -> Result<()> {
    if len == samples {
        return Ok(());
    }
    Err(Error::Length { file: name.into(), array: array.into(), len, x: "x".into(), samples })
}
