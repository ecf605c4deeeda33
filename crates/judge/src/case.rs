//! A run folder opened: its data, its folds and its models.

use std::path::Path;

use taxel_scenes::faults::{Layout, Sensor};
use taxel_trainer::config::ImageKind;
use taxel_trainer::metrics::Levels;
use taxel_trainer::{Experiment, FoldKey, FoldRecord, Predictor, Results, RunFolder, Samples};

use crate::error::{Error, Result};
use crate::stress::Range;

/// A run folder with the samples that it was run on.
pub struct Case {
    /// The folder.
    pub folder: RunFolder,
    /// What was run.
    pub experiment: Experiment,
    /// Its scores.
    pub results: Results,
    /// The samples, read or simulated again; equal to those of the run.
    pub samples: Samples,
}

impl Case {
    /// Opens a run folder and loads its data.
    ///
    /// # Errors
    /// A folder without finished folds, or data that are not those of the run any more.
    pub fn open(path: &Path) -> Result<Self> {
        let folder = RunFolder::open(path)?;
        let (experiment, results) = (folder.experiment()?, folder.results()?);
        let refuse = |reason: String| Error::Run { folder: path.display().to_string(), reason };
        if results.networks.iter().all(|n| n.folds.is_empty()) {
            return Err(refuse("has no finished fold; go on with taxel run --resume".into()));
        }
        let samples = Samples::load(&experiment)?;
        if samples.digest != results.data_digest {
            return Err(refuse(format!(
                "was run on other data than {} holds now ({} then, {} now); run the experiment again",
                samples.source, results.data_digest, samples.digest
            )));
        }
        Ok(Case { folder, experiment, results, samples })
    }

    /// Sizes of the attributes.
    pub fn levels(&self) -> Levels {
        self.samples.labels.levels()
    }

    /// The saved model of a fold, answering at most `batch` samples at a time on `threads` threads.
    ///
    /// # Errors
    /// A model that is missing or damaged.
    pub fn predictor(&self, key: &FoldKey, batch: usize, threads: usize) -> Result<Predictor> {
        let attributes = self.samples.labels.attributes();
        Ok(Predictor::open(&self.folder, &self.experiment, attributes, key, (batch, threads))?)
    }

    /// Finished folds of the first repetition of `network`.
    ///
    /// # Errors
    /// A damaged record.
    pub fn first_repetition(&self, network: &str) -> Result<Vec<FoldRecord>> {
        self.records(network).map(|all| all.into_iter().filter(|r| r.key.repetition == 0).collect())
    }

    /// Finished folds of `network`.
    ///
    /// # Errors
    /// A damaged record.
    pub fn records(&self, network: &str) -> Result<Vec<FoldRecord>> {
        let mut records = vec![];
        for key in self.folder.keys()?.iter().filter(|key| key.network == network) {
            records.extend(self.folder.record(key)?);
        }
        Ok(records)
    }

    /// Names of the networks and baselines whose models are tested further: of a learning curve's rows the
    /// one with the most training samples.
    pub fn contestants(&self) -> Vec<&str> {
        let most = self.results.networks.iter().filter_map(|n| n.per_class).max();
        let rows = self.results.networks.iter().filter(|n| n.per_class == most && !n.folds.is_empty());
        rows.map(|n| n.network.as_str()).collect()
    }

    /// Training batch of a network, and of baselines that of the experiment.
    pub fn batch(&self, network: &str) -> usize {
        let config = self.experiment.config();
        let own = config.network(network);
        own.map_or(config.train.batch_size, |n| n.train(&config.train).batch_size)
    }

    /// Axes, range and rest values of the raw readings.
    pub fn sensor(&self) -> (Sensor, Range) {
        let x = &self.samples.x;
        let (least, most) =
            x.iter().fold((0.0f32, f32::NEG_INFINITY), |(low, high), &v| (low.min(v), high.max(v)));
        let high = self.samples.full_scale.map_or(most, |full| full.max(most));
        // A range of nothing but zeros has no width; any will do.
        let high = if high > least { high } else { least + 1.0 };
        let range = Range { low: least, high, from_samples: self.samples.full_scale.is_none() };
        let layout = self.layout();
        let rest = match &self.samples.rest {
            Some(rest) => rest.clone(),
            None => resting(&self.samples, layout),
        };
        (Sensor { layout, low: least, high, rest }, range)
    }

    /// What the axes of a sample are: what the encodings of the experiment take them for.
    fn layout(&self) -> Layout {
        let image = self.experiment.config().encoding.image.as_ref().map(|image| image.kind);
        match (self.samples.shape(), image) {
            (_, Some(ImageKind::Numatac)) => Layout::Fingers,
            ([3, _, _], Some(ImageKind::Raw)) => Layout::Colour,
            ([_, _, _], _) => Layout::Sequence,
            ([_, _], Some(ImageKind::Raw)) => Layout::Image,
            _ => Layout::Series,
        }
    }

    /// Whether a sample `[F]` stands for one channel `[1, F]`.
    pub fn is_flat(&self) -> bool {
        self.samples.shape().len() == 1
    }
}

/// Readings without contact where nobody says what they are: of series the median of each channel's first
/// reading, since recordings begin before contact; 0 elsewhere.
fn resting(samples: &Samples, layout: Layout) -> Vec<f32> {
    let shape = samples.shape();
    let (channels, ticks) = match (layout, shape) {
        (Layout::Series, [ticks]) => (1, *ticks),
        (Layout::Series, [channels, ticks]) => (*channels, *ticks),
        (Layout::Fingers, [fingers, channels, ticks]) => (fingers * channels, *ticks),
        _ => return vec![0.0],
    };
    let values = samples.x.as_standard_layout();
    let all = values.as_slice().unwrap_or_default();
    let each = channels * ticks;
    (0..channels)
        .map(|channel| {
            let mut first: Vec<f32> = all.chunks_exact(each.max(1)).map(|s| s[channel * ticks]).collect();
            first.sort_by(f32::total_cmp);
            first.get(first.len() / 2).copied().unwrap_or(0.0)
        })
        .collect()
}
