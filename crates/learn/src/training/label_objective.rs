//! The objective of a training on classes or levels.

use taxel_base::exponential;
use taxel_data::Labels;
use taxel_graph::{Loss, Targets};

use crate::metrics::{Levels, softmax};
use crate::training::recipe::{ClassWeights, Recipe};
use crate::training::teacher::Teacher;

/// A loss with labels as its targets, and how outputs are read.
pub(crate) struct LabelObjective {
    loss: Loss,
    levels: Levels,
    smoothing: f64,
    /// Per class, their mean over the training samples is 1.
    weights: Option<Vec<f64>>,
}

impl LabelObjective {
    /// Makes the objective of `recipe` on the training samples `rows`.
    pub fn new(recipe: &Recipe, labels: &Labels, rows: &[usize]) -> Self {
        Self::of(recipe, Levels::new(&labels.sizes()), &labels.of(rows))
    }

    /// Makes the same objective of the labels `seen` themselves.
    fn of(recipe: &Recipe, levels: Levels, seen: &[u32]) -> Self {
        let outputs = levels.outputs();
        let balanced = || {
            let mut counts = vec![0.0f64; outputs];
            seen.iter().for_each(|&label| counts[label as usize] += 1.0);
            let present = counts.iter().filter(|n| **n > 0.0).count() as f64;
            let weight = |n: &f64| if *n > 0.0 { seen.len() as f64 / (present * n) } else { 0.0 };
            counts.iter().map(weight).collect()
        };
        LabelObjective {
            loss: recipe.loss.unwrap_or_default(),
            smoothing: recipe.label_smoothing,
            weights: (recipe.class_weights == ClassWeights::Balanced).then(balanced),
            levels,
        }
    }

    /// Loss of a batch's labels, and the gradients, by `backward`. Of a batch that is `taught` the predictions of the
    /// teacher to its rows are part of the targets.
    pub fn backward<T>(
        &self,
        labels: &[u32],
        taught: Option<(&Teacher, &[usize])>,
        backward: impl FnOnce(Loss, Targets) -> T,
    ) -> T {
        let soft = self.smoothing > 0.0 || self.weights.is_some();
        if self.loss == Loss::SoftmaxCrossEntropy && !soft && taught.is_none() {
            return backward(self.loss, Targets::Labels(labels));
        }
        let mut targets = self.levels.targets(labels);
        if soft {
            self.soften(labels, &mut targets);
        }
        if let Some((teacher, rows)) = taught {
            teacher.teach(rows, &mut targets);
        }
        if self.loss == Loss::CumulativeLogits {
            self.levels.accumulate(&mut targets);
        }
        backward(self.loss, Targets::Values(&targets))
    }

    /// Changes targets into those of `torch.nn.CrossEntropyLoss(weight=.., label_smoothing=..)`: PyTorch divides by
    /// the weights of the batch's labels, the engine by the number of samples.
    fn soften(&self, labels: &[u32], targets: &mut [f32]) {
        let classes = self.levels.outputs();
        let weight = |class: usize| self.weights.as_ref().map_or(1.0, |weights| weights[class]);
        let whole: f64 = labels.iter().map(|&label| weight(label as usize)).sum();
        let share = labels.len() as f64 / whole.max(f64::MIN_POSITIVE);
        for row in targets.chunks_exact_mut(classes) {
            for (class, target) in row.iter_mut().enumerate() {
                let smooth = (1.0 - self.smoothing) * f64::from(*target) + self.smoothing / classes as f64;
                *target = (smooth * weight(class) * share) as f32;
            }
        }
    }

    /// Computes the mean loss of logits `[n, outputs]` in evaluation: without smoothing and weights, so that
    /// different trainings compare.
    pub fn value(&self, logits: &[f32], labels: &[u32]) -> f64 {
        let outputs = self.levels.outputs();
        let mut targets = self.levels.targets(labels);
        if self.loss == Loss::CumulativeLogits {
            self.levels.accumulate(&mut targets);
        }
        let softplus = |v: f64| v.max(0.0) + (-v.abs()).exp().ln_1p();
        let term = |(row, targets): (&[f32], &[f32])| -> f64 {
            let pairs = || row.iter().zip(targets).map(|(x, t)| (f64::from(*x), f64::from(*t)));
            match self.loss {
                Loss::SoftmaxCrossEntropy => {
                    let most = pairs().map(|(x, _)| x).fold(f64::NEG_INFINITY, f64::max);
                    let sum: f64 = pairs().map(|(x, _)| (x - most).exp()).sum();
                    pairs().map(|(x, t)| t * (sum.ln() + most - x)).sum()
                }
                Loss::MultiLabelSoftMargin | Loss::CumulativeLogits => {
                    pairs().map(|(x, t)| softplus(x) - x * t).sum::<f64>() / outputs as f64
                }
                Loss::Hinge => {
                    let missing = pairs().map(|(x, t)| 1.0 - (2.0 * t - 1.0) * x);
                    // Not `max`, which would hide NaN.
                    missing.map(|v| if v <= 0.0 { 0.0 } else { v }).sum::<f64>() / outputs as f64
                }
                // The others learn values, and are refused for labels.
                _ => pairs().map(|(x, t)| (x - t).powi(2)).sum::<f64>() / outputs as f64,
            }
        };
        let rows = logits.chunks_exact(outputs).zip(targets.chunks_exact(outputs));
        rows.map(term).sum::<f64>() / (logits.len() / outputs).max(1) as f64
    }

    /// Computes the mean loss of outputs that are all 0: equal shares for every class.
    pub fn idle(&self) -> f64 {
        let labels = vec![0; self.levels.sizes().len()];
        self.value(&vec![0.0; self.levels.outputs()], &labels)
    }

    /// Counts the labels that logits `[n, outputs]` get right.
    pub fn correct(&self, logits: &[f32], labels: &[u32]) -> usize {
        let mut outputs = std::borrow::Cow::Borrowed(logits);
        if self.loss == Loss::CumulativeLogits {
            self.probabilities(outputs.to_mut());
        }
        self.levels.predicted(&outputs).iter().zip(labels).filter(|(a, b)| a == b).count()
    }

    /// Turns logits into the [`probabilities`] of this loss.
    pub fn probabilities(&self, logits: &mut [f32]) {
        probabilities(self.loss, &self.levels, logits);
    }
}

/// Logits `[n, outputs]` to probabilities, in place: softmax of one class, softmax of sums of ordered levels, a sigmoid per output
/// for several attributes and for the hinge loss, and for the squared error the outputs themselves, cut at 0 and 1.
pub(crate) fn probabilities(loss: Loss, levels: &Levels, logits: &mut [f32]) {
    match loss {
        Loss::SoftmaxCrossEntropy => softmax(logits, levels.outputs()),
        Loss::CumulativeLogits => levels.cumulative_probabilities(logits),
        Loss::MultiLabelSoftMargin | Loss::Hinge => {
            // Not the system's exponential, whose last bit differs between systems.
            logits.iter_mut().for_each(|v| *v = 1.0 / (1.0 + exponential::exp(-*v)));
        }
        // NaN stays NaN. The losses of values are refused for labels.
        _ => logits.iter_mut().for_each(|v| *v = v.clamp(0.0, 1.0)),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use serde_json::Value;
    use taxel_engine::{Engine, EngineOptions, Mode};
    use taxel_graph::{Network, Scheme, Tensor, Weights};

    use super::*;
    use crate::training::schedule::Schedule;

    fn fixture() -> Value {
        serde_json::from_str(include_str!("../../tests/data/objective.json")).unwrap()
    }

    fn singles(value: &Value) -> Vec<f32> {
        value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap() as f32).collect()
    }

    fn numbers(value: &Value) -> Vec<u32> {
        value.as_array().unwrap().iter().map(|v| v.as_u64().unwrap() as u32).collect()
    }

    /// Loss by the engine, and the gradient of the logits summed over the batch: the bias's of a linear
    /// layer that is the identity.
    fn by_engine(objective: &LabelObjective, logits: &[f32], labels: &[u32]) -> (f32, Vec<f32>) {
        let outputs = objective.levels.outputs();
        let net = Network::new("identity");
        let flow = net.input("signal", &[1, outputs]).flatten().linear("fc", outputs);
        let graph = net.finish(&[("logits", flow)]).unwrap();
        let mut weights = Weights::init(&graph, Scheme::Pytorch, 0, "identity");
        let eye = (0..outputs * outputs).map(|i| f32::from(u8::from(i % (outputs + 1) == 0))).collect();
        weights.insert("fc.weight", Tensor { shape: vec![outputs, outputs], data: eye });
        weights.insert("fc.bias", Tensor { shape: vec![outputs], data: vec![0.0; outputs] });
        let n = logits.len() / outputs;
        let options = EngineOptions { batch: n, ..EngineOptions::default() };
        let mut engine = Engine::new(&graph, &weights, options).unwrap();
        engine.forward(&[logits], n, Mode::Train).unwrap();
        let loss =
            objective.backward(labels, None, |loss, targets| engine.backward_with(loss, targets)).unwrap();
        (loss, engine.gradients().get("fc.bias").unwrap().data.clone())
    }

    fn assert_twin(objective: &LabelObjective, case: &Value) {
        let (logits, labels) = (singles(&case["logits"]), numbers(&case["labels"]));
        let (loss, gradient) = by_engine(objective, &logits, &labels);
        let want = case["loss"].as_f64().unwrap();
        assert!((f64::from(loss) - want).abs() <= 1e-6 * want.abs(), "{loss} and {want}");
        let mut sums = vec![0.0; gradient.len()];
        for row in singles(&case["gradient"]).chunks(gradient.len()) {
            sums.iter_mut().zip(row).for_each(|(sum, v)| *sum += v);
        }
        for (got, want) in gradient.iter().zip(&sums) {
            assert!((got - want).abs() <= 2e-6, "{gradient:?} and {sums:?}");
        }
    }

    #[test]
    fn weighted_and_smoothed_losses_agree_with_pytorch() {
        for case in fixture()["entropy"].as_array().unwrap() {
            let classes = case["classes"].as_u64().unwrap() as usize;
            let balanced = case["balanced"] == true;
            let recipe = Recipe {
                label_smoothing: case["smoothing"].as_f64().unwrap(),
                class_weights: if balanced { ClassWeights::Balanced } else { ClassWeights::None },
                ..Recipe::default()
            };
            let objective = LabelObjective::of(&recipe, Levels::new(&[classes]), &numbers(&case["seen"]));
            assert_twin(&objective, case);
            let value = objective.value(&singles(&case["logits"]), &numbers(&case["labels"]));
            assert!((value - case["plain"].as_f64().unwrap()).abs() <= 1e-6, "{value}");
        }
    }

    #[test]
    fn multi_label_loss_agrees_with_pytorch() {
        let case = &fixture()["margin"];
        let recipe = Recipe { loss: Some(Loss::MultiLabelSoftMargin), ..Recipe::default() };
        let sizes: Vec<usize> = numbers(&case["sizes"]).iter().map(|n| *n as usize).collect();
        let objective = LabelObjective::of(&recipe, Levels::new(&sizes), &[]);
        assert_twin(&objective, case);
        let value = objective.value(&singles(&case["logits"]), &numbers(&case["labels"]));
        assert!((value - case["loss"].as_f64().unwrap()).abs() <= 1e-6, "{value}");
    }

    #[test]
    fn cumulative_logits_agree_with_pytorch() {
        let case = &fixture()["cumulative"];
        let recipe = Recipe { loss: Some(Loss::CumulativeLogits), ..Recipe::default() };
        let sizes: Vec<usize> = numbers(&case["sizes"]).iter().map(|n| *n as usize).collect();
        let objective = LabelObjective::of(&recipe, Levels::new(&sizes), &[]);
        assert_twin(&objective, case);
        let (mut logits, labels) = (singles(&case["logits"]), numbers(&case["labels"]));
        let value = objective.value(&logits, &labels);
        assert!((value - case["loss"].as_f64().unwrap()).abs() <= 1e-6, "{value}");
        let right = objective.correct(&logits, &labels);
        objective.probabilities(&mut logits);
        let wanted = singles(&case["probabilities"]);
        assert!(logits.iter().zip(&wanted).all(|(got, want)| (got - want).abs() <= 1e-6), "{logits:?}");
        let said = objective.levels.predicted(&wanted);
        assert_eq!(right, said.iter().zip(&labels).filter(|(a, b)| a == b).count());
        assert!(right > 0 && right < labels.len());
    }

    /// Checks that a teacher of levels tells shares of "at least this level".
    #[test]
    fn a_teacher_of_ordered_levels_tells_shares_of_higher_ones() {
        let recipe = Recipe { loss: Some(Loss::CumulativeLogits), ..Recipe::default() };
        let objective = LabelObjective::of(&recipe, Levels::new(&[3]), &[]);
        let mut teacher = Teacher::new(0.5, 1, 3);
        teacher.tell(&[0], &[0.2, 0.3, 0.5]);
        let targets = objective.backward(&[1], Some((&teacher, &[0])), |_, targets| match targets {
            Targets::Values(values) => values.to_vec(),
            Targets::Labels(_) => vec![],
        });
        let wanted = [1.0, 0.9, 0.25];
        assert!(targets.iter().zip(wanted).all(|(got, want)| (got - want).abs() < 1e-6), "{targets:?}");
    }

    fn hinge() -> (LabelObjective, Value) {
        let case: Value = serde_json::from_str(include_str!("../../tests/data/hinge.json")).unwrap();
        let recipe = Recipe { loss: Some(Loss::Hinge), ..Recipe::default() };
        let classes = case["classes"].as_u64().unwrap() as usize;
        (LabelObjective::of(&recipe, Levels::new(&[classes]), &[]), case)
    }

    #[test]
    fn hinge_loss_agrees_with_scikit_learn_and_its_gradient_with_differences() {
        let (objective, case) = hinge();
        let (scores, labels) = (singles(&case["scores"]), numbers(&case["labels"]));
        let want = case["loss"].as_f64().unwrap();
        let (loss, gradient) = by_engine(&objective, &scores, &labels);
        assert!((f64::from(loss) - want).abs() <= 1e-6, "{loss} and {want}");
        assert!((objective.value(&scores, &labels) - want).abs() <= 1e-6);
        for (class, got) in gradient.iter().enumerate() {
            let moved = |by: f32| {
                let mut moved_scores = scores.clone();
                moved_scores.iter_mut().skip(class).step_by(gradient.len()).for_each(|score| *score += by);
                objective.value(&moved_scores, &labels)
            };
            let want = (moved(1e-4) - moved(-1e-4)) / 2e-4;
            assert!((f64::from(*got) - want).abs() <= 1e-4, "class {class}: {got} and {want}");
        }
    }

    #[test]
    fn a_last_layer_with_hinge_loss_and_a_penalty_becomes_a_linear_support_vector_machine() {
        let (objective, case) = hinge();
        let (x, labels) = (singles(&case["x"]), numbers(&case["labels"]));
        let (n, classes) = (labels.len(), objective.levels.outputs());
        let features = x.len() / n;
        let net = Network::new("machine");
        let flow = net.input("features", &[1, features]).flatten().linear("fc", classes);
        let graph = net.finish(&[("logits", flow)]).unwrap();
        let weights = Weights::init(&graph, Scheme::Pytorch, 0, "machine");
        let mut engine =
            Engine::new(&graph, &weights, EngineOptions { batch: n, ..EngineOptions::default() }).unwrap();
        let weight_decay = case["l2"].as_f64().unwrap() as f32;
        let mut loss = 0.0;
        for step in 0..4000 {
            engine.forward(&[&x], n, Mode::Train).unwrap();
            loss = objective
                .backward(&labels, None, |loss, targets| engine.backward_with(loss, targets))
                .unwrap();
            // 1 over penalty and step, as Pegasos has it.
            let lr = 1.0 / (weight_decay * (200 + step) as f32);
            engine.sgdm(&taxel_engine::Sgdm { lr, momentum: 0.0, weight_decay });
        }
        let trained = engine.weights();
        let all = ["fc.weight", "fc.bias"].map(|name| trained.get(name).unwrap().data.clone()).concat();
        let squares: f64 = all.iter().map(|v| f64::from(*v).powi(2)).sum();
        let (got, least) =
            (f64::from(loss) + f64::from(weight_decay) / 2.0 * squares, case["least"].as_f64().unwrap());
        assert!(got >= least - 1e-6 && got <= least * 1.001, "{got} and {least}");
        let best = [singles(&case["weights"]), singles(&case["biases"])].concat();
        let apart: f32 = all.iter().zip(&best).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(apart <= 0.03, "{all:?} and {best:?}");
    }

    #[test]
    fn a_warm_up_before_the_cosine_agrees_with_pytorch() {
        let optimizer = serde_json::from_str(r#"{ "name": "sgdm", "lr": 0.1 }"#).unwrap();
        let schedule = Schedule::Cosine { floor: 0.0 };
        let recipe = Recipe { epochs: 12, optimizer, schedule, warm_up: 0.25, ..Recipe::default() };
        for (epoch, want) in fixture()["warm_up"].as_array().unwrap().iter().enumerate() {
            let (got, want) = (recipe.rate(epoch), want.as_f64().unwrap());
            assert!((got - want).abs() <= 1e-12, "epoch {epoch}: {got} and {want}");
        }
    }

    #[test]
    fn schedules_agree_with_pytorch() {
        let cosine = Schedule::Cosine { floor: 0.05 };
        let steps = Schedule::Steps { at: vec![0.5, 0.75], factor: 0.3 };
        for (name, schedule) in [("cosine", cosine), ("steps", steps)] {
            for (epoch, want) in fixture()[name].as_array().unwrap().iter().enumerate() {
                let (got, want) = (schedule.rate(0.1, epoch, 12), want.as_f64().unwrap());
                assert!((got - want).abs() <= 1e-12, "{name}, epoch {epoch}: {got} and {want}");
            }
        }
    }
}
