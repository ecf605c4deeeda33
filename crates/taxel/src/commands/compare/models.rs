//! Two models on the same labelled recordings.

use std::error::Error;
use std::path::Path;

use taxel::data::{Targets, Task};
use taxel::judge::{Side, SideBySide, SideCosts, side_by_side, speed};
use taxel::learn::metrics::Outcome;
use taxel::{Dataset, Model, Predictions, Protocol, ReadOptions};

use crate::commands::arguments::model_recordings::ModelRecordings;
use crate::commands::predict::true_values::TrueValues;
use crate::terminal::messages::note;

/// Seconds that each model is timed at most.
const SECONDS: f64 = 1.0;

/// Compares the models of two files.
pub fn compared(
    paths: [&Path; 2],
    data: &Path,
    read_options: &ReadOptions,
) -> Result<SideBySide, Box<dyn Error>> {
    let models = [Model::open(paths[0])?, Model::open(paths[1])?];
    let [first, second] = models.each_ref().map(|model| model.card());
    let order = orders(&first.task, &second.task).ok_or_else(|| {
        format!(
            "{}: predicts other things than {}; compare models of one task",
            paths[1].display(),
            paths[0].display()
        )
    })?;
    let mut sides = vec![];
    let mut shared: Option<Dataset> = None;
    for (at, (model, path)) in models.iter().zip(paths).enumerate() {
        let recordings = ModelRecordings { data, read_options, as_is: None };
        let (read, dataset) = recordings.labelled(model.card())?;
        if dataset.digest == model.card().trained_on.digest {
            note(format!("{}: was trained on these recordings, so its score flatters", path.display()));
        }
        let outcome = {
            let predictions = model.predict(&read.x)?;
            outcome(model, (&first.task, &order[at]), &dataset, &predictions)
                .map_err(|reason| format!("{}: {reason}", path.display()))?
        };
        let ms = speed(model, &read.x, SECONDS)?.whole.p50_ms;
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let trained = model.card().trained_on.samples;
        sides.push(Side::of_model(&name, &dataset, outcome, trained, costs(model, path, ms)));
        shared.get_or_insert(dataset);
    }
    let (Some(dataset), Ok([a, b])) = (shared, <[Side; 2]>::try_from(sides)) else {
        return Err(format!("{}: holds no samples", data.display()).into());
    };
    let protocol = Protocol::k_fold(2);
    let found = side_by_side(&dataset, &first.task, (&protocol, 0), [a, b])?;
    found.ok_or_else(|| format!("{}: holds no sample that both predict", data.display()).into())
}

/// Returns where each output of a task stands in the first one's order; none where they predict other things.
fn orders(first: &Task, second: &Task) -> Option<[Vec<usize>; 2]> {
    let same = (0..first.outputs()).collect();
    if first.quantities() != second.quantities() {
        return None;
    }
    if !first.quantities().is_empty() {
        return Some([same, (0..second.outputs()).collect()]);
    }
    let (known, given) = (first.attributes(), second.attributes());
    let names = |all: &[taxel::Attribute]| all.iter().map(|one| one.name.clone()).collect::<Vec<_>>();
    if names(&known) != names(&given) {
        return None;
    }
    let (mut order, mut begin) = (vec![], 0);
    for (known, given) in known.iter().zip(&given) {
        if known.classes.len() != given.classes.len() {
            return None;
        }
        for class in &known.classes {
            order.push(begin + given.classes.iter().position(|other| other == class)?);
        }
        begin += given.classes.len();
    }
    Some([same, order])
}

/// Returns the predictions beside the true targets, both as the first model numbers its classes.
fn outcome(
    model: &Model,
    (task, order): (&Task, &[usize]),
    dataset: &Dataset,
    predictions: &Predictions,
) -> Result<Outcome, String> {
    let rows: Vec<usize> = (0..dataset.len()).collect();
    let card = model.card();
    if let Targets::Values(values) = &dataset.targets {
        let values = TrueValues::new(&card.task, values)?.into_values();
        return Ok(Outcome::new(&Targets::Values(values), &rows, predictions.outputs.clone()));
    }
    if !card.task.quantities().is_empty() {
        return Err("predicts values, and the recordings have classes".into());
    }
    let outputs: Vec<f32> =
        rows.iter().flat_map(|row| order.iter().map(|at| predictions.row(*row)[*at])).collect();
    let labels = card.labels_of(dataset)?;
    // The place of each class of this model in the first one's order, attribute by attribute.
    let (mut begin, mut places) = (0, vec![]);
    for attribute in task.attributes() {
        let count = attribute.classes.len();
        let place = |class: usize| order[begin..begin + count].iter().position(|at| *at == begin + class);
        places.push((0..count).map(|class| place(class).unwrap_or(class) as u32).collect::<Vec<u32>>());
        begin += count;
    }
    let truth =
        labels.iter().zip(places.iter().cycle()).map(|(label, places)| places[*label as usize]).collect();
    let predicted = taxel::learn::metrics::Levels::of_task(task).predicted(&outputs);
    Ok(Outcome::Labels { truth, predicted, probabilities: outputs, untrained: vec![], steps: None })
}

fn costs(model: &Model, path: &Path, ms: f64) -> SideCosts {
    let cost = model.card().graph().map(taxel::Graph::cost);
    let values = || model.weights().iter().map(|(_, tensor)| tensor.data.len() as u64).sum();
    SideCosts {
        parameters: cost.as_ref().map_or_else(values, |cost| cost.parameters),
        bytes: std::fs::metadata(path).map_or(0, |file| file.len()),
        macs: cost.map(|cost| cost.macs),
        ms: Some(ms),
    }
}
