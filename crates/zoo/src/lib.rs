//! The registry: every network by name, with its configuration, inputs and paper.
//!
//! ```
//! let entry = taxel_zoo::find("hybrid-resvgg")?;
//! let graph = entry.graph(&taxel_zoo::Settings::new())?;
//! assert_eq!(graph.parameter_count(), 116_547);
//!
//! let mut settings = taxel_zoo::Settings::new();
//! settings.insert("clases".into(), 28.into());
//! let error = entry.graph(&settings).unwrap_err();
//! assert!(error.to_string().starts_with("hybrid-resvgg: unknown field `clases`"));
//! # Ok::<(), taxel_zoo::Error>(())
//! ```

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use taxel_comparators::{LstmConfig, MlpConfig, TactNet, TactNetConfig, TactNetDepth, TactResNetConfig};
use taxel_graph::{Architecture, Graph};
use taxel_hybrid_cnn::{Body, Fusion, Hybrid, HybridConfig, Light, Light1dConfig, Light2dConfig};
use taxel_multiscale_cnn::MultiscaleConfig;
use taxel_tactnet3d::TactNet3d;
use taxel_visuotactile::{
    AlexNet, DenseNet201, GoogLeNetConfig, HiddenConfig, ImageConfig, MnasNetConfig, MobileNetV2Config,
    MobileNetV2SplitConfig, ResNet, ResNetDepth, ShuffleNetV2, Vgg16,
};

/// Configuration values by key; what is left out keeps the paper's value.
pub type Settings = serde_json::Map<String, Value>;

/// A network that is not there or cannot be built.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// No network of that name.
    #[error("no network is called `{name}`; known: {known}")]
    Unknown {
        /// Name asked for.
        name: String,
        /// All names, comma-separated.
        known: String,
    },
    /// A setting has an unknown key or a value of the wrong type.
    #[error("{model}: {source}")]
    Settings {
        /// Network name.
        model: String,
        /// What serde says.
        source: serde_json::Error,
    },
    /// The network refuses its configuration.
    #[error("{model}: {source}")]
    Graph {
        /// Network name.
        model: String,
        /// What the graph says.
        source: taxel_graph::Error,
    },
    /// The data do not have what the network reads.
    #[error("{model} reads `{input}` with {axes} axes; {reason}")]
    Input {
        /// Network name.
        model: String,
        /// Input name.
        input: String,
        /// Axes the network expects, batch left out.
        axes: usize,
        /// What is there instead.
        reason: String,
    },
}

/// Result with this crate's [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// One input of a network and the configuration keys that hold its axis sizes.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Input {
    /// `signal` (channels × time), `image` (channels × rows × columns) or `tensor` (channels × rows ×
    /// columns × frames).
    pub name: &'static str,
    /// Keys of the axes in order; a single key means that the whole sample is flattened into it.
    pub keys: &'static [&'static str],
}

/// A registered network.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    /// Name in configs, on the command line and in run folders.
    pub name: &'static str,
    /// Family crate.
    pub family: &'static str,
    /// Where it is published.
    pub paper: &'static str,
    /// What it reads.
    pub inputs: &'static [Input],
    build: Build,
}

enum BuildError {
    Settings(serde_json::Error),
    Graph(taxel_graph::Error),
}

const SIGNAL: Input = Input { name: "signal", keys: &["in_channels", "length"] };
const IMAGE: Input = Input { name: "image", keys: &["in_channels", "height", "width"] };
const HYBRID: &[Input] = &[SIGNAL, Input { name: "image", keys: &["image_channels", "height", "width"] }];
const FLAT: Input = Input { name: "signal", keys: &["in_features"] };
const TENSOR: Input = Input { name: "tensor", keys: &["in_channels", "height", "width", "frames"] };

/// Every network that taxel knows.
pub const NETWORKS: &[Entry] = &[
    comparator("mlp", "000, Table 5", &[FLAT], |s| build(parse::<MlpConfig>(s)?)),
    comparator("lstm", "000, Table 5", &[SIGNAL], |s| build(parse::<LstmConfig>(s)?)),
    comparator("tactnet4", "Gandarias et al. 2019; 000, Table 5", &[IMAGE], |s| {
        tactnet(TactNetDepth::Four, s)
    }),
    comparator("tactnet6", "Gandarias et al. 2019; 000, Table 5", &[IMAGE], |s| {
        tactnet(TactNetDepth::Six, s)
    }),
    comparator("tactresnet", "Gandarias et al. 2019; 000, Table 5", &[IMAGE], |s| {
        build(parse::<TactResNetConfig>(s)?)
    }),
    light("vgg6-lite-1d", "000, section 3.1.1", &[SIGNAL], |s| light_1d(Body::Vgg6, s)),
    light("resnet8-lite-1d", "000, section 3.1.2", &[SIGNAL], |s| light_1d(Body::ResNet8, s)),
    light("densenet6-lite-1d", "000, section 3.1.3", &[SIGNAL], |s| light_1d(Body::DenseNet6, s)),
    light("vgg6-lite-2d", "000, section 3.1.1", &[IMAGE], |s| light_2d(Body::Vgg6, s)),
    light("resnet8-lite-2d", "000, section 3.1.2", &[IMAGE], |s| light_2d(Body::ResNet8, s)),
    light("densenet6-lite-2d", "000, section 3.1.3", &[IMAGE], |s| light_2d(Body::DenseNet6, s)),
    light("hybrid-vgg", "000, section 3.2", HYBRID, |s| {
        hybrid("hybrid-vgg", Body::Vgg6, Body::Vgg6, Fusion::FullyConnected, s)
    }),
    light("hybrid-resnet", "000, section 3.2", HYBRID, |s| {
        hybrid("hybrid-resnet", Body::ResNet8, Body::ResNet8, Fusion::FullyConnected, s)
    }),
    light("hybrid-densenet", "000, section 3.2", HYBRID, |s| {
        hybrid("hybrid-densenet", Body::DenseNet6, Body::DenseNet6, Fusion::FullyConnected, s)
    }),
    light("hybrid-resvgg", "000, section 3.2", HYBRID, |s| {
        hybrid("hybrid-resvgg", Body::ResNet8, Body::Vgg6, Fusion::FullyConnected, s)
    }),
    light("hybrid-resvgg-nofc", "000, Table 4", HYBRID, |s| {
        hybrid("hybrid-resvgg-nofc", Body::ResNet8, Body::Vgg6, Fusion::None, s)
    }),
    palpation("tactnet3d", "002, Table I", |s| tactnet3d(TactNet3d::ACTIVE, s)),
    palpation("tactnet3d-4-8", "002, Table I", |s| tactnet3d(TactNet3d::ACTIVE_4_8, s)),
    palpation("tactnet3d-fc32", "002, Table I", |s| tactnet3d(TactNet3d::ACTIVE_FC32, s)),
    palpation("tactnet3d-8-16-32", "002, Table I", |s| tactnet3d(TactNet3d::ACTIVE_8_16_32, s)),
    palpation("tactnet3d-51", "003, Fig. 4", |s| tactnet3d(TactNet3d::PALPATION, s)),
    Entry {
        name: "multiscale-cnn",
        family: "multiscale-cnn",
        paper: "004, Table 1",
        inputs: &[IMAGE],
        build: |s| build(parse::<MultiscaleConfig>(s)?),
    },
    image("mobilenet-v2", "Sandler et al. 2018; 001, Tables 1-6", |s| build(parse::<MobileNetV2Config>(s)?)),
    image("mobilenet-v2-split", "001, section 7", |s| build(parse::<MobileNetV2SplitConfig>(s)?)),
    image("alexnet", "Krizhevsky 2014; 001, Tables 1-5", |s| {
        build(AlexNet(over(HiddenConfig::colour(6), s)?))
    }),
    image("vgg16", "Simonyan and Zisserman 2015; 000, Table 5", |s| {
        build(Vgg16(over(HiddenConfig::colour(3), s)?))
    }),
    image("resnet18", "He et al. 2016; 000, Table 5", |s| {
        build(ResNet { depth: ResNetDepth::Eighteen, config: over(ImageConfig::colour(3), s)? })
    }),
    image("resnet50", "He et al. 2016; 001, Tables 1-5", |s| {
        build(ResNet { depth: ResNetDepth::Fifty, config: over(ImageConfig::colour(6), s)? })
    }),
    image("densenet201", "Huang et al. 2017; 000, Table 5", |s| {
        build(DenseNet201(over(ImageConfig::colour(3), s)?))
    }),
    image("googlenet", "Szegedy et al. 2015; 001, Tables 1-5", |s| build(parse::<GoogLeNetConfig>(s)?)),
    image("shufflenet-v2", "Ma et al. 2018; 004, Table 2", |s| {
        build(ShuffleNetV2(over(ImageConfig::fingers(), s)?))
    }),
    image("mnasnet1-0", "Tan et al. 2019; 004, Table 2", |s| build(parse::<MnasNetConfig>(s)?)),
];

type Build = fn(&Settings) -> std::result::Result<Graph, BuildError>;

const fn comparator(
    name: &'static str,
    paper: &'static str,
    inputs: &'static [Input],
    build: Build,
) -> Entry {
    Entry { name, family: "comparators", paper, inputs, build }
}

const fn light(name: &'static str, paper: &'static str, inputs: &'static [Input], build: Build) -> Entry {
    Entry { name, family: "hybrid-cnn", paper, inputs, build }
}

const fn palpation(name: &'static str, paper: &'static str, build: Build) -> Entry {
    Entry { name, family: "tactnet3d", paper, inputs: &[TENSOR], build }
}

const fn image(name: &'static str, paper: &'static str, build: Build) -> Entry {
    Entry { name, family: "visuotactile", paper, inputs: &[IMAGE], build }
}

/// The network called `name`.
pub fn find(name: &str) -> Result<&'static Entry> {
    NETWORKS.iter().find(|entry| entry.name == name).ok_or_else(|| Error::Unknown {
        name: name.into(),
        known: NETWORKS.iter().map(|e| e.name).collect::<Vec<_>>().join(", "),
    })
}

impl Entry {
    /// The network with `settings` in place of the paper's values.
    pub fn graph(&self, settings: &Settings) -> Result<Graph> {
        let model = self.name.to_string();
        (self.build)(settings).map_err(|error| match error {
            BuildError::Settings(source) => Error::Settings { model, source },
            BuildError::Graph(source) => Error::Graph { model, source },
        })
    }

    /// Settings that fit the network to samples: `shape_of` tells the shape of an input by name.
    ///
    /// # Errors
    /// An input that the data do not have, or with another number of axes.
    pub fn fit(&self, classes: usize, shape_of: impl Fn(&str) -> Option<Vec<usize>>) -> Result<Settings> {
        let mut settings = Settings::new();
        settings.insert("classes".into(), classes.into());
        for input in self.inputs {
            let refuse = |reason: String| Error::Input {
                model: self.name.into(),
                input: input.name.into(),
                axes: input.keys.len(),
                reason,
            };
            let shape = shape_of(input.name)
                .ok_or_else(|| refuse(format!("the experiment encodes no `{}`", input.name)))?;
            if input.keys.len() == 1 {
                settings.insert(input.keys[0].into(), shape.iter().product::<usize>().into());
            } else if input.keys.len() == shape.len() {
                for (key, size) in input.keys.iter().zip(&shape) {
                    settings.insert((*key).into(), (*size).into());
                }
            } else {
                return Err(refuse(format!("the samples are {shape:?}")));
            }
        }
        Ok(settings)
    }
}

fn parse<C: DeserializeOwned>(settings: &Settings) -> std::result::Result<C, BuildError> {
    serde_json::from_value(Value::Object(settings.clone())).map_err(BuildError::Settings)
}

/// `settings` over a network's own values, where networks of one family differ in them.
fn over<C: Serialize + DeserializeOwned>(own: C, settings: &Settings) -> std::result::Result<C, BuildError> {
    let own = serde_json::to_value(own).map_err(BuildError::Settings)?;
    let mut merged = own.as_object().cloned().unwrap_or_default();
    merged.extend(settings.clone());
    parse(&merged)
}

fn build(network: impl Architecture) -> std::result::Result<Graph, BuildError> {
    network.graph().map_err(BuildError::Graph)
}

fn tactnet(depth: TactNetDepth, settings: &Settings) -> std::result::Result<Graph, BuildError> {
    build(TactNet { depth, config: parse::<TactNetConfig>(settings)? })
}

fn tactnet3d(mut network: TactNet3d, settings: &Settings) -> std::result::Result<Graph, BuildError> {
    network.config = over(network.config, settings)?;
    build(network)
}

fn light_1d(body: Body, settings: &Settings) -> std::result::Result<Graph, BuildError> {
    build(Light { body, config: parse::<Light1dConfig>(settings)? })
}

fn light_2d(body: Body, settings: &Settings) -> std::result::Result<Graph, BuildError> {
    build(Light { body, config: parse::<Light2dConfig>(settings)? })
}

fn hybrid(
    name: &'static str,
    temporal: Body,
    spatial: Body,
    fusion: Fusion,
    settings: &Settings,
) -> std::result::Result<Graph, BuildError> {
    build(Hybrid { name, temporal, spatial, fusion, config: parse::<HybridConfig>(settings)? })
}
