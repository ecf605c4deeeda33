//! Model files of run folders: the one that its fold wrote, or none.

use std::path::Path;

use taxel_graph::Weights;

use crate::error::{Error, Result};
use crate::json_file::read_json;
use crate::model::{Card, Model, TrainedOn, TrainingPart};
use crate::run::folder::RunFolder;
use crate::run::records::{FoldKey, FoldRecord};

impl Model {
    /// Reads a model file; nothing else needs to be there. One in the `models/` of a run folder must be the one
    /// that its fold wrote.
    ///
    /// # Errors
    /// A file that cannot be read or is no model of taxel, was written in another format, whose tensors are not
    /// those that its card describes, or that was put in the place of a fold's own: by file and name.
    pub fn open(path: &Path) -> Result<Self> {
        let (model, digest) = Model::read(path)?;
        match fold_of(path)? {
            Some(fold) => checked(path, model, &digest, &fold),
            None => Ok(model),
        }
    }
}

/// Refuses a model whose `digest` is not the one in the record of its fold; a record without a digest takes any.
fn checked(path: &Path, model: Model, digest: &str, fold: &(RunFolder, FoldRecord)) -> Result<Model> {
    let (folder, record) = fold;
    match &record.model {
        Some(wanted) if wanted != digest => {
            Err(foreign(path, &folder.record_path(&record.key), model.card(), (digest, wanted)))
        }
        _ => Ok(model),
    }
}

/// Reads weights as [`taxel_checkpoint::read`] does; those of a run folder must be the ones that the fold wrote.
///
/// # Errors
/// As [`taxel_checkpoint::read`] and, of a file in the `models/` of a run folder, [`Model::open`].
pub fn read_weights(path: &Path) -> Result<Weights> {
    match fold_of(path)? {
        Some(fold) => {
            let (model, digest) = Model::read(path)?;
            Ok(checked(path, model, &digest, &fold)?.weights().clone())
        }
        None => Ok(taxel_checkpoint::read(path)?.0),
    }
}

impl RunFolder {
    /// Reads the model that a finished fold wrote.
    ///
    /// # Errors
    /// A file that is missing or damaged, or is not the one whose digest the record holds.
    pub fn model(&self, record: &FoldRecord) -> Result<Model> {
        let (path, record_path) = (self.model_path(&record.key), self.record_path(&record.key));
        let (model, digest) = Model::read(&path)?;
        match &record.model {
            Some(wanted) if *wanted == digest => Ok(model),
            Some(wanted) => Err(foreign(&path, &record_path, model.card(), (&digest, wanted))),
            None => Err(older(&record_path)),
        }
    }

    /// Returns the digest of the model that a fold of an older version wrote, if the card says that it is of this
    /// fold, `network` and training.
    pub(crate) fn older_model(&self, key: &FoldKey, network: &str, data: &str, seed: u64) -> Result<String> {
        let (path, record_path) = (self.model_path(key), self.record_path(key));
        let (model, digest) = Model::read(&path)?;
        let TrainedOn { digest: trained_on, part, seed: drawn, .. } = &model.card().trained_on;
        let fold = TrainingPart::Fold { repetition: key.repetition, fold: key.fold };
        if (model.card().name.as_str(), part, trained_on.as_str(), *drawn) == (network, &fold, data, seed) {
            return Ok(digest);
        }
        let reason = format!(
            "{}, data {trained_on}, seed {drawn}, and not the model of fold {key}; {}",
            who(model.card()),
            how_to_fix(&record_path)
        );
        Err(Error::damaged(&path, reason))
    }
}

/// Refuses the record of a fold that was written before there were digests.
pub(crate) fn older(record: &Path) -> Error {
    let reason = "was written by an older version and holds no digests of data and model; resume the run, which \
                  adds them";
    Error::damaged(record, reason)
}

/// Returns the fold whose model stands at `path`; none outside of run folders.
fn fold_of(path: &Path) -> Result<Option<(RunFolder, FoldRecord)>> {
    let full = std::fs::canonicalize(path).unwrap_or_else(|_| path.into());
    let run = full.parent().filter(|folder| folder.ends_with("models")).and_then(Path::parent);
    let Some((run, name)) = run.zip(full.file_stem()) else { return Ok(None) };
    let Ok(folder) = RunFolder::open(run) else { return Ok(None) };
    let record = read_json(&run.join("folds").join(name).with_added_extension("json"))?;
    Ok(record.map(|record| (folder, record)))
}

/// Says what a model was trained on: `is mlp of repetition 0, fold 1`.
fn who(card: &Card) -> String {
    let name = &card.name;
    match card.trained_on.part {
        TrainingPart::Fold { repetition, fold } => {
            format!("is {name} of repetition {repetition}, fold {fold}")
        }
        TrainingPart::Everything => format!("is {name} trained on everything"),
    }
}

fn how_to_fix(record: &Path) -> String {
    let record = record.display();
    format!("copy the right file back, or delete {record} and resume the run: that fold is trained again")
}

fn foreign(path: &Path, record: &Path, card: &Card, (here, wanted): (&str, &str)) -> Error {
    let reason = format!(
        "{}, and not the model that its fold wrote (digest {here}, the fold's is {wanted}); {}",
        who(card),
        how_to_fix(record)
    );
    Error::damaged(path, reason)
}
