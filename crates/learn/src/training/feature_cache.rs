//! The feature cache: a frozen part that gives the same features in every pass runs once for every sample, by the
//! engine for what is learned from and by the runtime for what is tested.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use taxel_engine::{EngineOptions, Evaluator, Workspace};
use taxel_graph::{Graph, Halves, Node, Op, Weights};

use crate::encoding::Encoded;
use crate::error::Result;
use crate::model::digest;
use crate::model::ready::Ready;
use crate::model::responder::Responder;
use crate::training::recipe::{FrozenStatistics, Recipe};

/// Bytes of the features of all samples, above which every pass makes them anew.
const MOST_BYTES: usize = 2 << 30;

/// Cuts the network behind what `recipe` leaves as it is for every sample. `None` where a sample differs from pass to
/// pass, or where the features of `samples` samples would be too many.
pub(crate) fn halves(graph: &Graph, recipe: &Recipe, samples: usize) -> Option<Halves> {
    if recipe.frozen.is_empty() || recipe.augment.is_some() || recipe.faults.is_some() {
        return None;
    }
    let unchanged = unchanged_nodes(graph, recipe).ok()?;
    let halves = graph.halves(&unchanged)?;
    let features: usize = halves.head.inputs().map(|node| node.shape.iter().product::<usize>()).sum();
    (samples.saturating_mul(features * size_of::<f32>()) <= MOST_BYTES).then_some(halves)
}

/// Marks the nodes that keep all their tensors: frozen ones, but not batch norms whose statistics `recipe` renews.
///
/// # Errors
/// A frozen node that the network does not have.
pub(crate) fn unchanged_nodes(graph: &Graph, recipe: &Recipe) -> taxel_graph::Result<Vec<bool>> {
    let mut unchanged = graph.covered(&recipe.frozen)?;
    if recipe.frozen_statistics == FrozenStatistics::Renewed {
        unchanged.iter_mut().zip(graph.nodes()).for_each(|(stays, node)| *stays &= !is_norm(node));
    }
    Ok(unchanged)
}

/// Checks whether the runtime predicts with the halves, one after the other, to the last digit as with the whole: the
/// head folds nothing into the body, and reads features in the order in which it has them alone.
pub(crate) fn predict_alike(halves: &Halves) -> bool {
    let folds_nothing = |node: &Node| {
        matches!(node.op, Op::Input | Op::Linear { .. } | Op::Relu | Op::Activation(_) | Op::Dropout { .. })
    };
    let nodes = halves.body.nodes();
    let mut end = &nodes[halves.body.outputs()[0].1];
    while let Op::Dropout { .. } = end.op {
        end = &nodes[end.inputs[0]];
    }
    end.shape.len() == 1 && end.op != Op::Flatten && halves.head.nodes().iter().all(folds_nothing)
}

/// Checks whether a node has running statistics.
pub(crate) fn is_norm(node: &Node) -> bool {
    matches!(node.op, Op::BatchNorm { .. })
}

/// Features by sample.
type FeaturesBySample = HashMap<usize, Vec<f32>>;

/// The features that were made last, for trainings that begin with the same body and the same inputs.
#[derive(Debug, Default)]
pub struct FeatureCache {
    learned: Last,
    tested: Last,
}

/// The features that were made last in one way.
#[derive(Debug, Default)]
struct Last(Mutex<Option<Made>>);

/// Features, and all that they depend on.
#[derive(Debug)]
struct Made {
    body: Graph,
    weights: String,
    inputs: Vec<Arc<Encoded>>,
    features: Arc<Mutex<FeaturesBySample>>,
}

impl Last {
    fn features(
        &self,
        body: &Graph,
        weights: &Weights,
        inputs: &[Arc<Encoded>],
    ) -> Arc<Mutex<FeaturesBySample>> {
        let mut last = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let weights = digest(weights);
        let same = |made: &&Made| {
            let shared = made.inputs.iter().zip(inputs).all(|(known, other)| Arc::ptr_eq(known, other));
            shared && made.inputs.len() == inputs.len() && made.weights == weights && made.body == *body
        };
        if let Some(made) = last.as_ref().filter(same) {
            return Arc::clone(&made.features);
        }
        let features = Arc::default();
        let (body, inputs) = (body.clone(), inputs.to_vec());
        *last = Some(Made { body, weights, inputs, features: Arc::clone(&features) });
        features
    }
}

/// A frozen body whose features are made once for every sample.
pub(crate) struct CachedFeatures {
    source: FeatureSource,
    batch: usize,
    inputs: Vec<Arc<Encoded>>,
    features: Arc<Mutex<FeaturesBySample>>,
    /// Features of the rows that were gathered last, one after the other.
    gathered: Vec<f32>,
}

/// Who makes the features.
enum FeatureSource {
    Engine(Box<Evaluator>, Workspace),
    Runtime(Box<Responder>),
}

impl CachedFeatures {
    /// Features that training learns from: `body` with its `weights`, for the `inputs` of all samples in its order.
    ///
    /// # Errors
    /// Weights that do not fit, or threads that cannot be started.
    pub fn learned(
        body: &Graph,
        weights: &Weights,
        inputs: Vec<Arc<Encoded>>,
        options: EngineOptions,
        cache: &FeatureCache,
    ) -> Result<CachedFeatures> {
        let features = cache.learned.features(body, weights, &inputs);
        let batch = options.batch;
        let evaluator = Evaluator::new(body, weights, options)?;
        let workspace = evaluator.workspace();
        let source = FeatureSource::Engine(Box::new(evaluator), workspace);
        Ok(CachedFeatures { source, batch, inputs, features, gathered: vec![] })
    }

    /// Features that tests read: of the frozen body, as a model file predicts.
    ///
    /// # Errors
    /// As [`CachedFeatures::learned`].
    pub fn tested(
        body: &Graph,
        weights: &Weights,
        inputs: Vec<Arc<Encoded>>,
        (batch, threads): (usize, usize),
        cache: &FeatureCache,
    ) -> Result<CachedFeatures> {
        let features = cache.tested.features(body, weights, &inputs);
        let source = FeatureSource::Runtime(Box::new(Responder::floats(body, weights, batch, threads)?));
        Ok(CachedFeatures { source, batch, inputs, features, gathered: vec![] })
    }

    /// Features of `rows`, one after the other.
    ///
    /// # Errors
    /// An error of the engine.
    pub fn rows(&mut self, rows: &[usize]) -> Result<&[f32]> {
        let features = Arc::clone(&self.features);
        let mut features = features.lock().unwrap_or_else(PoisonError::into_inner);
        self.make(rows, &mut features)?;
        self.gathered.clear();
        rows.iter().for_each(|row| self.gathered.extend_from_slice(&features[row]));
        Ok(&self.gathered)
    }

    /// Makes those that are missing.
    fn make(&mut self, rows: &[usize], features: &mut FeaturesBySample) -> Result<()> {
        let missing: Vec<usize> = rows.iter().copied().filter(|row| !features.contains_key(row)).collect();
        let mut values = vec![vec![]; self.inputs.len()];
        for rows in missing.chunks(self.batch) {
            self.inputs.iter().zip(&mut values).for_each(|(input, values)| input.gather(rows, values));
            let slices: Vec<&[f32]> = values.iter().map(Vec::as_slice).collect();
            let predicted;
            let made = match &mut self.source {
                FeatureSource::Engine(evaluator, workspace) => {
                    evaluator.predict(workspace, &slices, rows.len())?
                }
                FeatureSource::Runtime(responder) => {
                    predicted = responder.decide(&slices, rows.len())?;
                    &predicted
                }
            };
            let each = made.chunks_exact(made.len() / rows.len());
            features.extend(rows.iter().copied().zip(each.map(<[f32]>::to_vec)));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use ndarray::Array;
    use taxel_graph::{Conv, Network, Scheme};

    use super::*;

    fn network() -> Graph {
        let net = Network::new("net");
        let x =
            net.input("image", &[1, 4, 4]).conv("stem.conv", Conv::new(3, 3)).batch_norm("stem.bn").relu();
        let x = x.global_average_pool().linear("fc", 2);
        net.finish(&[("logits", x)]).unwrap()
    }

    #[test]
    fn features_are_made_where_every_pass_would_make_the_same() {
        let recipe = |text: &str| -> Recipe { serde_json::from_str(text).unwrap() };
        let ends = |text: &str| {
            halves(&network(), &recipe(text), 10).map(|halves| halves.body.outputs()[0].0.clone())
        };
        let stem = r#""frozen": ["stem"]"#;
        assert_eq!(ends(&format!("{{ {stem} }}")).unwrap(), "stem.bn/relu/global_average_pool");
        let renewed = format!(r#"{{ {stem}, "frozen_statistics": "renewed" }}"#);
        assert_eq!(ends(&renewed).unwrap(), "stem.conv");
        for other in [
            "{}".to_string(),
            r#"{ "frozen": ["fc"] }"#.into(),
            format!(r#"{{ {stem}, "augment": {{ "shift": 1.0 }} }}"#),
            format!(r#"{{ {stem}, "faults": {{ "kinds": ["dead"] }} }}"#),
        ] {
            assert_eq!(ends(&other), None, "{other}");
        }
        let most = MOST_BYTES / (3 * size_of::<f32>());
        let stem = recipe(&format!("{{ {stem} }}"));
        assert!(halves(&network(), &stem, most).is_some() && halves(&network(), &stem, most + 1).is_none());
    }

    #[test]
    fn every_sample_is_asked_once_by_all_that_share_body_and_inputs() {
        let graph = network().cut("stem").unwrap();
        let weights = |seed| Weights::init(&graph, Scheme::Pytorch, seed, "test");
        let encoded = || {
            let x = Array::from_shape_fn((6, 1, 4, 4), |(n, _, i, j)| (n * 16 + i * 4 + j) as f32).into_dyn();
            Arc::new(Encoded::new(x))
        };
        let (cache, x) = (FeatureCache::default(), encoded());
        let cached = |weights: &Weights, x: &Arc<Encoded>| {
            let options = EngineOptions { batch: 2, ..EngineOptions::default() };
            CachedFeatures::learned(&graph, weights, vec![Arc::clone(x)], options, &cache).unwrap()
        };
        let known = |cached: &CachedFeatures| cached.features.lock().unwrap().len();
        let mut one = cached(&weights(1), &x);
        let first = one.rows(&[4, 0, 4, 1, 2]).unwrap().to_vec();
        assert_eq!(known(&one), 4);
        let len = first.len() / 5;
        assert_eq!(first[..len], first[2 * len..3 * len]);
        assert_eq!(one.rows(&[1]).unwrap(), &first[3 * len..4 * len]);
        let mut again = cached(&weights(1), &x);
        assert_eq!(known(&again), 4);
        again.rows(&[5]).unwrap();
        assert_eq!(known(&one), 5);
        let mut other = cached(&weights(2), &x);
        assert_eq!(known(&other), 0, "other weights");
        other.rows(&[3]).unwrap();
        assert_eq!(known(&cached(&weights(2), &encoded())), 0, "other inputs");
        // What is tested is made by another program, and kept beside what is learned from.
        let tested =
            || CachedFeatures::tested(&graph, &weights(2), vec![Arc::clone(&x)], (2, 1), &cache).unwrap();
        let (mut one, mut learned) = (tested(), cached(&weights(2), &x));
        assert_eq!(known(&one), 0);
        let frozen = one.rows(&[1, 5]).unwrap().to_vec();
        assert_eq!((known(&one), known(&tested())), (2, 2));
        for (frozen, learned) in frozen.iter().zip(learned.rows(&[1, 5]).unwrap()) {
            assert!((frozen - learned).abs() < 1e-5, "{frozen} {learned}");
        }
    }

    #[test]
    fn halves_that_answer_to_the_last_digit() {
        let at = |names: &[&str], graph: &Graph| {
            let names: Vec<String> = names.iter().map(ToString::to_string).collect();
            predict_alike(&graph.halves(&graph.covered(&names).unwrap()).unwrap())
        };
        let net = |end: &str| {
            let net = Network::new("net");
            let x = net.input("image", &[1, 4, 4]).conv("stem", Conv::new(3, 3)).relu();
            let x = match end {
                "mean" => x.global_average_pool(),
                "flatten" => x.flatten(),
                "flatten, nothing dropped" => x.flatten().dropout(0.0),
                _ => x.flatten().linear("hidden", 4).batch_norm("bn"),
            };
            net.finish(&[("logits", x.dropout(0.5).linear("fc", 2))]).unwrap()
        };
        assert!(at(&["stem"], &net("mean")));
        // A linear layer reads an image in the order of the runtime; a norm becomes part of the layer before it.
        assert!(!at(&["stem"], &net("flatten")) && !at(&["stem"], &net("flatten, nothing dropped")));
        assert!(!at(&["stem", "hidden"], &net("norm")));
        assert!(at(&["stem", "hidden", "bn"], &net("norm")));
    }
}
