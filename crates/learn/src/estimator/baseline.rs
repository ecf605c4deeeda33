//! Baselines on labelled series: fitted, asked, saved.

use taxel_baselines::{Fitted, Method, Saved, Series, Workspace};
use taxel_data::{Attribute, Dataset};
use taxel_faults::TrainingFaults;
use taxel_graph::{Tensor, Weights};

use crate::encoding::{Encoded, Input};
use crate::error::{Error, Result};
use crate::run::records::Costs;
use crate::training::breaker::Breaker;
use crate::training::part::Part;

/// A baseline that has seen its training part: one fitted method per attribute.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FittedBaseline {
    pub method: Method,
    /// Channels and length of a recording.
    pub shape: [usize; 2],
    own: Vec<Fitted>,
    /// Classes of each attribute.
    sizes: Vec<usize>,
}

/// What a baseline learns from.
pub(crate) struct Lesson<'a> {
    pub dataset: &'a Dataset,
    /// The samples as baselines read them.
    pub series: &'a Input,
    /// The training part.
    pub rows: &'a [usize],
    /// Faults of the copies that it learns from too.
    pub faults: Option<&'a TrainingFaults>,
    /// It keys what is drawn at random.
    pub part: Part,
}

impl Lesson<'_> {
    /// The recordings, clean ones first and then every faulty copy, and as many labels.
    fn samples(&self) -> Result<(Vec<f32>, Vec<u32>)> {
        let Lesson { dataset, series, rows, faults, part } = *self;
        let (mut values, mut truth) = (vec![], dataset.labels.of(rows));
        series.encoded.gather(rows, &mut values);
        let Some(faults) = faults else { return Ok((values, truth)) };
        let Some(mut breaker) = Breaker::new(faults, dataset, rows, &[series], part)? else {
            return Ok((values, truth));
        };
        let (clean, own) = (values.clone(), truth.clone());
        for copy in 0..faults.copies {
            let mut broken = [clean.clone()];
            breaker.fill(rows, &format!("copy{copy}"), &mut broken)?;
            values.extend_from_slice(&broken[0]);
            truth.extend_from_slice(&own);
        }
        Ok((values, truth))
    }
}

impl FittedBaseline {
    /// Learns its lesson.
    ///
    /// # Errors
    /// What the method refuses.
    pub fn fit(method: Method, lesson: &Lesson) -> Result<Self> {
        let refuse = |source| Error::Baseline { baseline: method.name().into(), source };
        let shape = shape_of(&lesson.series.encoded)?;
        let (values, truth) = lesson.samples()?;
        let train = Series::new(&values, shape[0], shape[1]).map_err(refuse)?;
        let sizes = lesson.dataset.labels.sizes();
        let Part { seed, repetition, fold } = lesson.part;
        let mut own = vec![];
        for (i, &size) in sizes.iter().enumerate() {
            let y: Vec<u32> = truth.iter().skip(i).step_by(sizes.len()).copied().collect();
            let purpose = format!("r{repetition}/f{fold}/{i}");
            own.push(method.fit(&train, &y, size, seed, &purpose).map_err(refuse)?);
        }
        Ok(FittedBaseline { method, shape, own, sizes })
    }

    /// Scores `[n, outputs]` of recordings `[n, channels, length]`, row-major.
    ///
    /// # Errors
    /// Recordings of another shape, or that are not finite.
    pub fn scores(&self, values: &[f32]) -> Result<Vec<f32>> {
        let refuse = |source| Error::Baseline { baseline: self.method.name().into(), source };
        let x = Series::new(values, self.shape[0], self.shape[1]).map_err(refuse)?;
        let each: Vec<Vec<f32>> =
            self.own.iter().map(|own| own.scores(&x).map_err(refuse)).collect::<Result<_>>()?;
        let mut rows = vec![];
        for sample in 0..x.len() {
            for (scores, &size) in each.iter().zip(&self.sizes) {
                rows.extend_from_slice(&scores[sample * size..(sample + 1) * size]);
            }
        }
        Ok(rows)
    }

    /// Scores of one recording.
    pub fn outputs(&self) -> usize {
        self.sizes.iter().sum()
    }

    /// Memory for [`FittedBaseline::answer`], one of each attribute.
    pub fn workspaces(&self) -> Vec<Workspace> {
        self.own.iter().map(Fitted::workspace).collect()
    }

    /// [`FittedBaseline::scores`] of one recording; nothing is allocated after the first.
    ///
    /// # Errors
    /// A recording of another shape or that is not finite, workspaces of another baseline.
    pub fn answer(
        &self,
        recording: &[f32],
        workspaces: &mut [Workspace],
        mut scores: &mut [f32],
    ) -> Result<()> {
        for ((own, workspace), &size) in self.own.iter().zip(workspaces).zip(&self.sizes) {
            let (to, rest) = scores.split_at_mut(size);
            scores = rest;
            own.answer(recording, workspace, to)
                .map_err(|source| Error::Baseline { baseline: self.method.name().into(), source })?;
        }
        Ok(())
    }

    /// Everything that was fitted; of several attributes under the attribute's name.
    pub fn tensors(&self, attributes: &[Attribute]) -> Weights {
        let mut weights = Weights::new();
        for (own, attribute) in self.own.iter().zip(attributes) {
            for (name, shape, data) in own.tensors() {
                weights.insert(&format!("{}{name}", prefix(attributes, attribute)), Tensor { shape, data });
            }
        }
        weights
    }

    /// What [`FittedBaseline::tensors`] gave.
    ///
    /// # Errors
    /// A tensor that is missing or does not fit, by name.
    pub fn read(
        method: Method,
        shape: [usize; 2],
        attributes: &[Attribute],
        weights: &Weights,
    ) -> taxel_baselines::Result<Self> {
        let mut own = vec![];
        for attribute in attributes {
            let prefix = prefix(attributes, attribute);
            let mut saved = Saved::default();
            for (name, tensor) in weights.iter() {
                if let Some(name) = name.strip_prefix(&prefix) {
                    saved.insert(name, &tensor.data);
                }
            }
            own.push(Fitted::read(&method, shape, attribute.classes.len(), &saved)?);
        }
        let sizes = attributes.iter().map(|attribute| attribute.classes.len()).collect();
        Ok(FittedBaseline { method, shape, own, sizes })
    }

    /// What one answer costs.
    pub fn costs(&self) -> Costs {
        let sum = |cost: fn(&Fitted) -> u64| self.own.iter().map(cost).sum::<u64>();
        let (parameters, macs) = (sum(Fitted::parameters), sum(Fitted::macs));
        Costs { parameters, bytes: 4 * parameters, macs, flops: 2 * macs }
    }
}

/// Channels and length of encoded series.
pub(crate) fn shape_of(series: &Encoded) -> Result<[usize; 2]> {
    match *series.shape() {
        [channels, length] => Ok([channels, length]),
        ref shape => Err(Error::Axes {
            source_label: "readings".into(),
            input: crate::encoding::SERIES,
            shape: shape.to_vec(),
            reason: "baselines read channels × time",
        }),
    }
}

/// Tensors of one attribute go by their own names, those of several by the attribute's before it.
fn prefix(attributes: &[Attribute], attribute: &Attribute) -> String {
    if attributes.len() > 1 { format!("{}.", attribute.name) } else { String::new() }
}
