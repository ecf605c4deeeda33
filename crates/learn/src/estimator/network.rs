//! Networks as estimators.

use std::sync::Arc;

use serde_json::{Value, json};
use taxel_data::{Fold, Task};
use taxel_faults::TrainingFaults;
use taxel_graph::{Graph, Loss, Weights};

use crate::encoding::{Encoder, Input};
use crate::error::{Error, Result};
use crate::estimator::estimator::{Estimator, Fitted, Trained, TrainingSet};
use crate::estimator::trainable::Trainable;
use crate::model::{ModelKind, digest};
use crate::problem::{Problem, augment_problem, require};
use crate::run::records::{Change, Costs, FoldRecord};
use crate::training::hooks::Hooks;
use crate::training::network::{TrainedNetwork, Training};
use crate::training::recipe::{ClassWeights, Recipe};

/// Multiply-accumulates that stand for what a small network spends besides them.
const OVERHEAD: u64 = 200_000;

impl Trainable {
    /// Refuses frozen nodes that the network does not have.
    ///
    /// # Errors
    /// The first of them.
    fn check_frozen(&self) -> Result<()> {
        self.graph.covered(&self.recipe.frozen).map(|_| ()).map_err(|error| {
            Problem::new("frozen", format!("{:?}", self.recipe.frozen), error.to_string()).into()
        })
    }

    /// Returns the recipes that may be trained.
    fn recipes(&self) -> impl Iterator<Item = &Recipe> {
        let tried = self.search.iter().flat_map(|search| &search.grid).map(|tried| &tried.recipe);
        tried.chain([&self.recipe])
    }

    /// Refuses inputs that are not what the encoding makes.
    fn check_inputs(&self, name: &str, encoder: &Encoder) -> Result<()> {
        for node in self.graph.inputs() {
            let refuse =
                |reason: String| Error::Input { network: name.into(), input: node.name.clone(), reason };
            let shape =
                encoder.shape(&node.name).ok_or_else(|| refuse("the encoding makes no such input".into()))?;
            // `[n]` and `[1, n]` take the whole sample as one row.
            let row = matches!(*node.shape, [n] | [1, n] if n == shape.iter().product::<usize>());
            if node.shape != shape && !row {
                return Err(refuse(format!("it takes {:?}, the samples are {shape:?}", node.shape)));
            }
        }
        Ok(())
    }

    /// Refuses settings of `recipe` that the task or the encoding do not allow.
    fn check_recipe(&self, recipe: &Recipe, task: &Task, encoder: &Encoder) -> Result<()> {
        check_loss(recipe, task)?;
        let reason = "moves pixels: it needs encoding.image of kind \"raw\" or \"frame\", or encoding.tensor; \
                      readings have \"gain\", \"jitter\", \"time_shift\" and \"time_warp\"";
        if let Some(augment) = &recipe.augment {
            require(!augment.changes_images() || encoder.is_warpable(), "augment", "{ .. }", reason)?;
            augment.check_layout(encoder.dataset().spec.layout).map_err(augment_problem)?;
        }
        if let Some(stopping) = &recipe.early_stopping {
            stopping.by.metric("train.early_stopping.by", task)?;
        }
        Ok(())
    }
}

/// Refuses a loss that cannot learn the task, and settings of labels for values.
fn check_loss(recipe: &Recipe, task: &Task) -> Result<()> {
    let said = serde_json::to_string(&recipe.loss).unwrap_or_default();
    let values = recipe.loss.is_none_or(Loss::learns_values);
    match task {
        Task::Values(_) => {
            let reason =
                "values need \"huber\", \"mean-squared-error\", \"gaussian-likelihood\" or \"quantiles\"";
            require(values, "loss", said, reason)?;
            let reason = "is for classes; leave it out for values";
            require(recipe.label_smoothing == 0.0, "label_smoothing", recipe.label_smoothing, reason)?;
            require(recipe.class_weights == ClassWeights::None, "class_weights", "\"balanced\"", reason)?;
        }
        Task::Levels(_) | Task::Classes(_) => {
            if recipe.loss == Some(Loss::CumulativeLogits) {
                check_order(task)?;
            }
            let of_values = values && !matches!(recipe.loss, None | Some(Loss::MeanSquaredError));
            require(!of_values, "loss", &said, "learns values, and the targets are classes")?;
            let several = task.attributes().len() > 1 && recipe.loss == Some(Loss::SoftmaxCrossEntropy);
            let reason = "several attributes need \"multi-label-soft-margin\", \"cumulative-logits\", \"hinge\" or \
                 \"mean-squared-error\"";
            require(!several, "loss", said, reason)?;
        }
    }
    Ok(())
}

/// Refuses levels that are in no order: their names need rising numbers, or an order that is not the alphabet's, which is then one
/// that was asked for.
fn check_order(task: &Task) -> Result<()> {
    let number = |name: &String| {
        let digits = |c: char| c.is_ascii_digit() || c == '.';
        let text = name.trim_start_matches(|c| !digits(c));
        text.split(|c| !digits(c)).next().and_then(|number| number.parse::<f64>().ok())
    };
    for attribute in task.attributes() {
        let numbers: Option<Vec<f64>> = attribute.classes.iter().map(number).collect();
        let rises = numbers.is_some_and(|numbers| numbers.windows(2).all(|pair| pair[0] < pair[1]));
        let asked = !attribute.classes.is_sorted();
        let reason = format!(
            "needs classes in an order, by rising numbers in their names (level-1, level-2, …) or as data.classes lists \
             them; those of {} are {}",
            attribute.name,
            attribute.classes.join(", ")
        );
        require(rises || asked, "loss", "\"cumulative-logits\"", reason)?;
    }
    Ok(())
}

impl Estimator for Trainable {
    fn inputs(&self) -> Vec<&str> {
        self.graph.inputs().map(|node| node.name.as_str()).collect()
    }

    fn check(&self) -> Result<()> {
        self.recipe.check()?;
        if let Some(search) = &self.search {
            search.check().map_err(|problem| problem.below("search"))?;
        }
        self.check_frozen()
    }

    fn check_samples(&self, name: &str, _samples: usize, encoder: &Encoder) -> Result<()> {
        let task = encoder.dataset().task();
        self.check_inputs(name, encoder)?;
        self.recipes().try_for_each(|recipe| self.check_recipe(recipe, &task, encoder))?;
        if matches!(task, Task::Values(_)) {
            self.graph.check_rescalable().map_err(taxel_engine::Error::from)?;
        }
        let wanted = |recipe: &Recipe| task.outputs() * recipe.outputs_per_target(&task);
        let shape = self.graph.outputs().first().map_or(&[][..], |(_, id)| &self.graph.nodes()[*id].shape);
        let outputs = shape.iter().product::<usize>();
        if let Some(classes) = self.recipes().map(wanted).find(|wanted| *wanted != outputs) {
            return Err(Error::Outputs { network: name.into(), outputs, classes });
        }
        if let Some(search) = &self.search {
            search.by.metric("choose.by", &task)?;
        }
        Ok(())
    }

    fn faults(&self) -> Option<&TrainingFaults> {
        self.recipe.faults.as_ref()
    }

    fn under(&self, faults: &TrainingFaults) -> Arc<dyn Estimator> {
        let mut network = self.clone();
        for tried in network.search.iter_mut().flat_map(|search| &mut search.grid) {
            tried.recipe.faults = Some(faults.clone());
        }
        network.recipe.faults = Some(faults.clone());
        Arc::new(network)
    }

    fn costs(&self) -> Costs {
        self.graph.cost().into()
    }

    fn samples(&self, fold: &Fold) -> usize {
        Training::samples(self, fold)
    }

    fn work_per_sample(&self) -> u64 {
        self.graph.cost().macs + OVERHEAD
    }

    /// Returns the names of the tensors that [`Trainable::start`] does not give: a head for other classes.
    ///
    /// # Errors
    /// Any other tensor that is missing, extra or misshaped, by name.
    fn drawn(&self) -> Result<Vec<String>> {
        let Some(start) = self.start.as_deref() else { return Ok(vec![]) };
        let mut fresh = Weights::init(&self.graph, self.recipe.init, 0, "checkpoint");
        fresh.start_from(&self.graph, start, false).map_err(Error::from)
    }

    fn identify(&self, identity: &mut Value) {
        identity["graph"] = json!(self.graph);
        identity["recipe"] = json!(self.recipe);
        identity["search"] = json!(self.search);
        identity["start"] = json!(self.start.as_deref().map(digest));
    }

    fn as_network(&self) -> Option<&Trainable> {
        Some(self)
    }

    fn fit(&self, set: &TrainingSet, hooks: &mut Hooks) -> Result<Option<Trained>> {
        let training = Training { network: self, set };
        let Some(mut trained) = training.run(hooks)? else { return Ok(None) };
        Ok(Some(Trained {
            outputs: std::mem::take(&mut trained.outputs),
            spread: std::mem::take(&mut trained.spread),
            test_loss: trained.test_loss,
            train_seconds: trained.train_seconds,
            test_seconds: trained.test_seconds,
            samples: (trained.epochs.len() * set.fold.train.len()) as u64,
            fitted: Box::new(FittedNetwork { graph: self.graph.clone(), start: self.start.clone(), trained }),
        }))
    }
}

/// A trained network.
struct FittedNetwork {
    graph: Graph,
    start: Option<Arc<Weights>>,
    trained: TrainedNetwork,
}

impl Fitted for FittedNetwork {
    fn kind(&self) -> ModelKind {
        ModelKind::Network {
            graph: Box::new(self.graph.clone()),
            loss: self.trained.recipe.loss.unwrap_or_default(),
            batch: self.trained.batch,
            recipe: Box::new(self.trained.recipe.clone()),
        }
    }

    fn tensors(&self, _task: &Task) -> Weights {
        self.trained.weights.clone()
    }

    fn inputs<'i>(&self, inputs: &'i [Input]) -> Vec<&'i Input> {
        let names = self.graph.inputs().map(|node| &node.name);
        names.filter_map(|name| inputs.iter().find(|input| input.name == name)).collect()
    }

    fn complete(&self, record: FoldRecord) -> Result<FoldRecord> {
        let TrainedNetwork { epochs, chosen, best_epoch, diverged, other_statistics, .. } = &self.trained;
        let changes = match self.start.as_deref() {
            Some(start) => Change::all(&self.graph, start, &self.trained.weights)?,
            None => vec![],
        };
        Ok(FoldRecord {
            chosen: chosen.clone(),
            best_epoch: *best_epoch,
            diverged: *diverged,
            epochs: epochs.clone(),
            other_statistics: *other_statistics,
            changes,
            ..record
        })
    }
}
