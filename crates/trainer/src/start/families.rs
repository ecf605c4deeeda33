//! Which networks, baselines, encoding and recipe suit samples of a layout.
//!
//! # Reference
//!
//! The recipes of `configs/real/*-hardened.toml` and of the configs of values, chosen there on inner folds.

use taxel_baselines::Method;
use taxel_data::{Layout, Task};
use taxel_faults::TrainingFaults;
use taxel_learn::Candidate;

/// Encoding, networks, baselines and recipe that are tried on samples of one layout.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Family {
    /// Lines of `[encoding]`.
    pub encoding: Vec<String>,
    /// Networks, the most promising first.
    pub networks: Vec<&'static str>,
    /// Baselines by name.
    pub baselines: Vec<&'static str>,
    /// Rows whose predictions are averaged too; none of classes.
    pub averaged: Vec<&'static str>,
    /// Epochs of the recipe.
    pub epochs: usize,
    /// Further lines of `[train]`.
    settings: Vec<&'static str>,
}

/// The recipe of taxel's own networks, of which few samples get more steps.
const ADAMW: [&str; 6] = [
    "batch_size = 64",
    r#"optimizer = { name = "adamw", lr = 3e-3, weight_decay = 0.02, decay = "matrices" }"#,
    "warm_up = 0.1",
    r#"schedule = { kind = "cosine" }"#,
    "least_steps = 800                      # few samples get more epochs",
    "least_batches = 4",
];

/// The recipe of image networks: steps down steady the last epochs.
const SGDM: [&str; 4] = [
    "batch_size = 32",
    r#"optimizer = { name = "sgdm", lr = 0.01, momentum = 0.9 }"#,
    r#"schedule = { kind = "steps", at = [0.6, 0.85], factor = 0.1 }"#,
    POPULATION,
];
/// Statistics of the whole training part.
const POPULATION: &str = r#"batch_norm = "population""#;

/// The largest side of an image that is kept.
const LARGEST_SIDE: usize = 64;
/// Least time steps from which MiniRocket makes features.
const ROCKET_STEPS: usize = 9;
/// Most samples for the ridge of MiniRocket, copies under faults among them: it takes gigabytes beyond.
const ROCKET_SAMPLES: usize = 8000;
pub(super) const ROCKET: &str = "mini-rocket";
const TREES: &str = "extra-trees";
/// Most readings of all samples together for trees on images, which take minutes beyond.
const TREE_READINGS: usize = 8_000_000;
/// Networks of values: the best of the committed pages, then a wider one.
const OF_VALUES: [&str; 2] = ["layer-norm-mlp", "deep-mlp"];
/// The row of their mean with trees.
pub(super) const AVERAGE: &str = "mlp-and-trees";
/// Time steps of the two fingers of Zhang et al. 2022, one pressure and 22 vibrations each.
const NUMATAC_STEPS: usize = 300;
/// Steps back whose differences a history holds.
const LAGS: [usize; 6] = [1, 2, 4, 8, 16, 32];

/// Returns how many copies of the training part a baseline sees under faults, with the clean one.
pub(super) fn copies() -> usize {
    TrainingFaults::default().copies + 1
}

/// Checks whether a baseline of that name has a row under faults too.
fn gains_by_faults(name: &str) -> bool {
    let method = Method::all().into_iter().chain(Method::of_values()).find(|method| method.name() == name);
    method.is_some_and(|method| Candidate::baseline(method).estimator.gains_by_faults())
}

/// Returns the recipe of taxel's own networks with a rule for the statistics of batch norm.
fn adamw(batch_norm: &'static str) -> Vec<&'static str> {
    [&ADAMW[..], &[batch_norm]].concat()
}

impl Family {
    /// Writes the lines of `[train]`.
    pub(super) fn recipe(&self) -> String {
        format!("epochs = {}\n{}\n", self.epochs, self.settings.join("\n"))
    }

    /// Lists the rows that are fault-augmented too, of `trained` samples.
    pub(super) fn augmented(&self, trained: usize) -> Vec<&str> {
        let too_many = copies() * trained > ROCKET_SAMPLES;
        let gain = |name: &&str| gains_by_faults(name) && !(*name == ROCKET && too_many);
        self.networks.iter().copied().chain(self.baselines.iter().copied().filter(gain)).collect()
    }

    /// Returns what is tried on samples of `layout` with axes `shape`.
    pub(super) fn of(layout: Layout, shape: &[usize], task: &Task, samples: usize) -> Self {
        let mut family = match (layout, shape) {
            (Layout::Series, [_, steps]) => Self::series(*steps, task, samples),
            (Layout::Fingers, [2, 23, steps]) if *steps >= NUMATAC_STEPS => Self::numatac(),
            (Layout::Fingers, [_, _, steps]) => Self::series(*steps, task, samples),
            (Layout::Image, [rows, columns]) | (Layout::Colour, [_, rows, columns]) => {
                Self::images([*rows, *columns])
            }
            (Layout::Sequence, _) => Self::sequences(),
            _ => Self::features(task),
        };
        let readings = samples * shape.iter().product::<usize>();
        if matches!(layout, Layout::Image | Layout::Colour) && readings <= TREE_READINGS {
            family.baselines.push(TREES);
        }
        match task {
            Task::Values(_) => {
                family.baselines.retain(|name| !name.contains("majority") && !name.contains("svm"));
                family.baselines.splice(0..0, ["mean", "ridge"]);
                family.settings.push(r#"loss = "huber""#);
            }
            Task::Classes(_) => family.settings.push("label_smoothing = 0.1"),
            Task::Levels(_) => {}
        }
        family
    }

    fn series(steps: usize, task: &Task, samples: usize) -> Self {
        let is_of_values = matches!(task, Task::Values(_));
        let mut baselines = vec!["majority", "k-nn"];
        if steps >= ROCKET_STEPS && !(is_of_values && samples > ROCKET_SAMPLES) {
            baselines.push(ROCKET);
        }
        if is_of_values {
            let lags: Vec<String> = LAGS.iter().filter(|lag| **lag < steps).map(usize::to_string).collect();
            let encoding = if lags.is_empty() {
                vec![]
            } else {
                let about = "# the last reading and its differences to earlier ones";
                vec![format!("signal = {{ kind = \"history\", lags = [{}] }}   {about}", lags.join(", "))]
            };
            baselines.push(TREES);
            return Self { encoding, baselines, ..Self::of_values() };
        }
        if steps < ROCKET_STEPS {
            let networks = vec!["deep-mlp", "mlp"];
            return Self { networks, baselines, ..Self::rows() };
        }
        let encoding = vec![
            "signal = { kind = \"quantile-code\" }   # no reading can be larger than those of training"
                .into(),
            "rocket = { features = 2000 }           # MiniRocket's, for dilated-resnet-rocket-1d".into(),
        ];
        let networks = vec!["dilated-resnet-rocket-1d", "resnet8-lite-1d", "dilated-resnet-1d"];
        Self { encoding, networks, baselines, settings: adamw(r#"batch_norm = "moving""#), ..Self::rows() }
    }

    fn features(task: &Task) -> Self {
        let baselines = vec!["majority", "k-nn", "svm-linear", "svm-rbf", TREES];
        let family = if matches!(task, Task::Values(_)) { Self::of_values() } else { Self::rows() };
        Self { baselines, ..family }
    }

    /// Returns the networks and the recipe of rows of numbers.
    fn rows() -> Self {
        let settings = adamw(POPULATION);
        let (networks, baselines) = (vec!["deep-mlp"], vec![]);
        Self { encoding: vec![], networks, baselines, averaged: vec![], epochs: 80, settings }
    }

    /// Returns the networks and the recipe of values of such rows.
    fn of_values() -> Self {
        let averaged = vec![OF_VALUES[0], TREES];
        Self { networks: OF_VALUES.to_vec(), averaged, epochs: 60, ..Self::rows() }
    }

    fn images([rows, columns]: [usize; 2]) -> Self {
        let most = rows.max(columns);
        let side = |side: usize| (side * LARGEST_SIDE / most).max(1);
        let resize = if most > LARGEST_SIDE {
            format!("resize = [{}, {}], ", side(rows), side(columns))
        } else {
            String::new()
        };
        let encoding = vec![format!("image = {{ kind = \"raw\", {resize}scale = \"z-score\" }}")];
        let networks = vec!["resnet8-lite-2d", "vgg6-lite-2d"];
        let baselines = vec!["majority", "k-nn"];
        Self { encoding, networks, baselines, epochs: 60, settings: SGDM.to_vec(), ..Self::rows() }
    }

    fn sequences() -> Self {
        let encoding = vec![
            r#"tensor = { scale = "z-score" }"#.into(),
            "image = { kind = \"frame\", frame = \"peak\", scale = \"z-score\" }   # the frame of the largest sum"
                .into(),
        ];
        let networks = vec!["resnet8-lite-2d", "tactnet3d-4-8"];
        let baselines = vec!["majority", "k-nn", ROCKET];
        Self { encoding, networks, baselines, epochs: 50, settings: SGDM.to_vec(), ..Self::rows() }
    }

    fn numatac() -> Self {
        let encoding = vec![r#"image = { kind = "numatac" }"#.into()];
        let baselines = vec!["majority", ROCKET];
        let settings = vec![
            "batch_size = 32",
            r#"optimizer = { name = "adam", lr = 1e-3 }"#,
            r#"schedule = { kind = "cosine" }"#,
            r#"batch_norm = "moving""#,
        ];
        Self { encoding, networks: vec!["multiscale-cnn"], baselines, epochs: 60, settings, ..Self::rows() }
    }
}
