//! The mean of several networks and baselines as one estimator.

use std::sync::Arc;

use serde_json::{Value, json};
use taxel_data::{Fold, Task};
use taxel_faults::TrainingFaults;
use taxel_graph::Weights;

use crate::encoding::{Encoder, Input};
use crate::error::Result;
use crate::estimator::estimator::{Estimator, Fitted, Trained, TrainingSet};
use crate::metrics::Outcome;
use crate::model::members::tensor_name;
use crate::model::{AverageMember, ModelKind};
use crate::problem::require;
use crate::run::records::{Costs, FoldRecord};
use crate::training::hooks::Hooks;
use crate::training::session::Saver;

/// A network or baseline of an average.
#[derive(Debug, Clone)]
pub(crate) struct Member {
    /// Name of its own row.
    pub name: String,
    pub estimator: Arc<dyn Estimator>,
}

/// The mean of what several networks and baselines predict, each counting alike. Each is trained as its own row is.
#[derive(Debug, Clone)]
pub(crate) struct Average {
    pub members: Vec<Member>,
}

impl Average {
    fn each(&self) -> impl Iterator<Item = &dyn Estimator> {
        self.members.iter().map(|member| member.estimator.as_ref())
    }
}

impl Estimator for Average {
    fn inputs(&self) -> Vec<&str> {
        let mut names = vec![];
        for name in self.each().flat_map(|member| member.inputs()) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    fn check(&self) -> Result<()> {
        require(self.members.len() > 1, "of", self.members.len(), "an average needs two members or more")?;
        self.each().try_for_each(|member| member.check())
    }

    fn check_samples(&self, _name: &str, samples: usize, encoder: &Encoder) -> Result<()> {
        self.members
            .iter()
            .try_for_each(|member| member.estimator.check_samples(&member.name, samples, encoder))
    }

    fn unfit(&self, samples: usize, encoder: &Encoder) -> Option<String> {
        self.members.iter().find_map(|member| {
            let reason = member.estimator.unfit(samples, encoder)?;
            Some(format!("averages {}, which {reason}", member.name))
        })
    }

    fn faults(&self) -> Option<&TrainingFaults> {
        self.each().find_map(|member| member.faults())
    }

    fn under(&self, faults: &TrainingFaults) -> Arc<dyn Estimator> {
        let under = |member: &Member| Member { estimator: member.estimator.under(faults), ..member.clone() };
        Arc::new(Average { members: self.members.iter().map(under).collect() })
    }

    /// Says no: what its members gain, their own rows show.
    fn gains_by_faults(&self) -> bool {
        false
    }

    fn has_logits(&self) -> bool {
        false
    }

    fn costs(&self) -> Costs {
        self.each().map(|member| member.costs()).fold(Costs::default(), |sum, own| Costs {
            parameters: sum.parameters + own.parameters,
            bytes: sum.bytes + own.bytes,
            macs: sum.macs + own.macs,
            flops: sum.flops + own.flops,
        })
    }

    fn samples(&self, fold: &Fold) -> usize {
        self.each().map(|member| member.samples(fold)).sum()
    }

    fn work_per_sample(&self) -> u64 {
        self.each().map(|member| member.work_per_sample()).max().unwrap_or(0)
    }

    fn drawn(&self) -> Result<Vec<String>> {
        let drawn: Vec<Vec<String>> = self.each().map(|member| member.drawn()).collect::<Result<_>>()?;
        Ok(drawn.concat())
    }

    fn identify(&self, identity: &mut Value) {
        let of = |member: &Member| {
            let mut own = json!({ "name": member.name });
            member.estimator.identify(&mut own);
            own
        };
        identity["average"] = json!(self.members.iter().map(of).collect::<Vec<_>>());
    }

    fn fit(&self, set: &TrainingSet, hooks: &mut Hooks) -> Result<Option<Trained>> {
        let mut members = vec![];
        for member in &self.members {
            let read = member.estimator.inputs();
            let own = read.iter().filter_map(|name| set.inputs.iter().find(|input| input.name == *name));
            let inputs: Vec<Input> = own.cloned().collect();
            let set = TrainingSet { name: &member.name, inputs: &inputs, ..*set };
            // One file of a training that goes on cannot hold several.
            let mut saver = Saver::none();
            let mut hooks = Hooks { tick: &mut *hooks.tick, cancel: hooks.cancel, saver: &mut saver };
            let Some(trained) = member.estimator.fit(&set, &mut hooks)? else { return Ok(None) };
            members.push((member.name.clone(), trained));
        }
        averaged(set, members).map(Some)
    }
}

/// Averages what members predict for the test part.
fn averaged(set: &TrainingSet, members: Vec<(String, Trained)>) -> Result<Trained> {
    let sum = |value: fn(&Trained) -> f64| members.iter().map(|(_, trained)| value(trained)).sum::<f64>();
    let (train_seconds, test_seconds) = (sum(|own| own.train_seconds), sum(|own| own.test_seconds));
    let samples = members.iter().map(|(_, trained)| trained.samples).sum();
    let mut outputs: Vec<f32> = vec![];
    for (_, trained) in &members {
        outputs.resize(trained.outputs.len(), 0.0);
        outputs.iter_mut().zip(&trained.outputs).for_each(|(sum, output)| *sum += output);
    }
    outputs.iter_mut().for_each(|sum| *sum /= members.len() as f32);
    let mut test_loss = 0.0;
    if !set.fold.test.is_empty() {
        let outcome = Outcome::new(&set.dataset.targets, &set.fold.test, outputs.clone());
        test_loss = outcome.loss(&set.dataset.task())?;
    }
    let members = members.into_iter().map(|(name, trained)| (name, trained.fitted)).collect();
    let fitted = Box::new(FittedAverage { members });
    Ok(Trained { fitted, outputs, spread: vec![], test_loss, train_seconds, test_seconds, samples })
}

/// An average whose members have learned.
struct FittedAverage {
    members: Vec<(String, Box<dyn Fitted>)>,
}

impl FittedAverage {
    /// Returns the inputs of one member: of what it is given a baseline takes all, so it gets its own alone.
    fn inputs_of<'i>(member: &dyn Fitted, inputs: &'i [Input]) -> Vec<&'i Input> {
        match member.kind() {
            ModelKind::Baseline { .. } => {
                inputs.iter().filter(|input| input.name == crate::encoding::SERIES).collect()
            }
            ModelKind::Network { .. } | ModelKind::Average { .. } => member.inputs(inputs),
        }
    }
}

impl Fitted for FittedAverage {
    fn kind(&self) -> ModelKind {
        let of = |(name, fitted): &(String, Box<dyn Fitted>)| {
            let kind = fitted.kind();
            let inputs = match &kind {
                ModelKind::Network { graph, .. } => graph.inputs().count(),
                ModelKind::Baseline { .. } | ModelKind::Average { .. } => 1,
            };
            AverageMember { name: name.clone(), kind, inputs }
        };
        ModelKind::Average { members: self.members.iter().map(of).collect() }
    }

    fn tensors(&self, task: &Task) -> Weights {
        let mut weights = Weights::new();
        for (at, (_, fitted)) in self.members.iter().enumerate() {
            for (name, tensor) in fitted.tensors(task).iter() {
                weights.insert(&tensor_name(at, name), tensor.clone());
            }
        }
        weights
    }

    fn inputs<'i>(&self, inputs: &'i [Input]) -> Vec<&'i Input> {
        self.members.iter().flat_map(|(_, fitted)| Self::inputs_of(fitted.as_ref(), inputs)).collect()
    }

    fn complete(&self, record: FoldRecord) -> Result<FoldRecord> {
        let mut sum = Costs::default();
        for (_, fitted) in &self.members {
            let costs = match fitted.kind() {
                ModelKind::Network { graph, .. } => Some(Costs::from(graph.cost())),
                _ => fitted.complete(record.clone())?.costs,
            };
            if let Some(own) = costs {
                sum.parameters += own.parameters;
                sum.bytes += own.bytes;
                sum.macs += own.macs;
                sum.flops += own.flops;
            }
        }
        Ok(FoldRecord { costs: Some(sum), ..record })
    }
}
