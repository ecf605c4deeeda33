//! Every network that taxel knows.

use std::sync::OnceLock;

use serde::Serialize;
use serde::de::DeserializeOwned;
use taxel_comparators::{LstmConfig, MlpConfig, TactNetConfig, TactResNetConfig};
use taxel_dilated_resnet::{DilatedResNetConfig, DilatedResNetRocketConfig};
use taxel_graph::Architecture;
use taxel_hybrid_cnn::{Body, HybridConfig, Light1dConfig, Light2dConfig};
use taxel_multiscale_cnn::MultiscaleConfig;
use taxel_tactnet3d::TactNet3dConfig;
use taxel_visuotactile::{
    AlexNetConfig, DenseNet201Config, GoogLeNetConfig, MnasNetConfig, MobileNetV2Config,
    MobileNetV2SplitConfig, ResNetConfig, ShuffleNetV2Config, Vgg16Config,
};

use crate::entry::{Entry, Input};
use crate::error::Result;
use crate::registry::Registry;

/// The registry of all of them.
pub fn built_in() -> &'static Registry {
    static BUILT_IN: OnceLock<Registry> = OnceLock::new();
    BUILT_IN.get_or_init(|| {
        let mut registry = Registry::empty();
        for entry in comparators().into_iter().chain(light()).chain(others()).chain(images()) {
            #[expect(clippy::expect_used, reason = "a test builds this registry")]
            registry.add(entry).expect("the names below differ");
        }
        registry
    })
}

impl Registry {
    /// The networks of the papers and those they compare with.
    pub fn built_in() -> Self {
        built_in().clone()
    }
}

/// The network called `name` among them.
///
/// # Errors
/// As [`Registry::find`].
pub fn find(name: &str) -> Result<&'static Entry> {
    built_in().find(name)
}

fn comparators() -> Vec<Entry> {
    let gandarias = "Gandarias et al. 2019; 000, Table 5";
    let family = "comparators";
    vec![
        Entry::of(MlpConfig::default(), "mlp", family, "000, Table 5", [Input::flat()]),
        Entry::of(LstmConfig::default(), "lstm", family, "000, Table 5", [Input::signal()]),
        Entry::of(TactNetConfig::FOUR, "tactnet4", family, gandarias, [Input::image()]),
        Entry::of(TactNetConfig::SIX, "tactnet6", family, gandarias, [Input::image()]),
        Entry::of(TactResNetConfig::default(), "tactresnet", family, gandarias, [Input::image()]),
    ]
}

fn light() -> Vec<Entry> {
    let one =
        |body, name, paper| Entry::of(Light1dConfig::of(body), name, "hybrid-cnn", paper, [Input::signal()]);
    let two =
        |body, name, paper| Entry::of(Light2dConfig::of(body), name, "hybrid-cnn", paper, [Input::image()]);
    let both = |network: HybridConfig, paper| {
        let image = Input::new("image", &["image_channels", "height", "width"]);
        Entry::of(network.clone(), network.branches.name, "hybrid-cnn", paper, [Input::signal(), image])
    };
    vec![
        one(Body::Vgg6, "vgg6-lite-1d", "000, section 3.1.1"),
        one(Body::ResNet8, "resnet8-lite-1d", "000, section 3.1.2"),
        one(Body::DenseNet6, "densenet6-lite-1d", "000, section 3.1.3"),
        two(Body::Vgg6, "vgg6-lite-2d", "000, section 3.1.1"),
        two(Body::ResNet8, "resnet8-lite-2d", "000, section 3.1.2"),
        two(Body::DenseNet6, "densenet6-lite-2d", "000, section 3.1.3"),
        both(HybridConfig::VGG, "000, section 3.2"),
        both(HybridConfig::RESNET, "000, section 3.2"),
        both(HybridConfig::DENSENET, "000, section 3.2"),
        both(HybridConfig::RESVGG, "000, section 3.2"),
        both(HybridConfig::RESVGG_NOFC, "000, Table 4"),
    ]
}

fn others() -> Vec<Entry> {
    let squeeze = |network: TactNet3dConfig, paper| {
        Entry::of(network.clone(), network.layers.name, "tactnet3d", paper, [Input::tensor()])
    };
    let (multiscale, name) = (MultiscaleConfig::default(), "multiscale-cnn");
    vec![
        squeeze(TactNet3dConfig::ACTIVE, "002, Table I"),
        squeeze(TactNet3dConfig::ACTIVE_4_8, "002, Table I"),
        squeeze(TactNet3dConfig::ACTIVE_FC32, "002, Table I"),
        squeeze(TactNet3dConfig::ACTIVE_8_16_32, "002, Table I"),
        squeeze(TactNet3dConfig::PALPATION, "003, Fig. 4"),
        Entry::of(multiscale, name, name, "004, Table 1", [Input::image()]),
        Entry::of(
            DilatedResNetConfig::default(),
            "dilated-resnet-1d",
            "dilated-resnet",
            "taxel's own",
            [Input::signal()],
        ),
        Entry::of(
            DilatedResNetRocketConfig::default(),
            "dilated-resnet-rocket-1d",
            "dilated-resnet",
            "taxel's own",
            [Input::signal(), Input::rocket()],
        ),
    ]
}

fn images() -> Vec<Entry> {
    vec![
        image(MobileNetV2Config::default(), "mobilenet-v2", "Sandler et al. 2018; 001, Tables 1-6"),
        image(MobileNetV2SplitConfig::default(), "mobilenet-v2-split", "001, section 7"),
        image(AlexNetConfig::default(), "alexnet", "Krizhevsky 2014; 001, Tables 1-5"),
        image(Vgg16Config::default(), "vgg16", "Simonyan and Zisserman 2015; 000, Table 5"),
        image(ResNetConfig::EIGHTEEN, "resnet18", "He et al. 2016; 000, Table 5"),
        image(ResNetConfig::FIFTY, "resnet50", "He et al. 2016; 001, Tables 1-5"),
        image(DenseNet201Config::default(), "densenet201", "Huang et al. 2017; 000, Table 5"),
        image(GoogLeNetConfig::default(), "googlenet", "Szegedy et al. 2015; 001, Tables 1-5"),
        image(ShuffleNetV2Config::default(), "shufflenet-v2", "Ma et al. 2018; 004, Table 2"),
        image(MnasNetConfig::default(), "mnasnet1-0", "Tan et al. 2019; 004, Table 2"),
    ]
}

fn image<C>(own: C, name: &str, paper: &str) -> Entry
where
    C: Architecture + Serialize + DeserializeOwned + Send + Sync + 'static,
{
    Entry::of(own, name, "visuotactile", paper, [Input::image()])
}
