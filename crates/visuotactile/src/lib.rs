#![doc = include_str!("../README.md")]

mod alexnet;
mod densenet;
mod googlenet;
pub mod matlab;
mod mnasnet;
mod mobilenet_v2;
mod mobilenet_v2_split;
mod resnet;
mod shufflenet_v2;
mod vgg;

pub use alexnet::AlexNetConfig;
pub use densenet::DenseNet201Config;
pub use googlenet::GoogLeNetConfig;
pub use mnasnet::MnasNetConfig;
pub use mobilenet_v2::MobileNetV2Config;
pub use mobilenet_v2_split::MobileNetV2SplitConfig;
pub use resnet::{ResNetConfig, ResNetDepth};
pub use shufflenet_v2::ShuffleNetV2Config;
pub use vgg::Vgg16Config;

use taxel_graph::{Flow, Register, Result, at_least};

const FAMILY: &str = "visuotactile";

/// Hands every network of this family to the zoo.
pub fn list(zoo: &mut impl Register) {
    zoo.add(mobilenet_v2::MOBILENET_V2);
    zoo.add(mobilenet_v2_split::MOBILENET_V2_SPLIT);
    zoo.add(alexnet::ALEXNET);
    zoo.add(vgg::VGG16);
    zoo.add(resnet::RESNET18);
    zoo.add(resnet::RESNET50);
    zoo.add(densenet::DENSENET201);
    zoo.add(googlenet::GOOGLENET);
    zoo.add(shufflenet_v2::SHUFFLENET_V2);
    zoo.add(mnasnet::MNASNET);
}

/// Refuses fewer than 2 classes, and images of less than `side` rows or columns: (classes, `[in_channels, height,
/// width]`).
fn check_image(classes: usize, image: [usize; 3], side: usize) -> Result<()> {
    let [in_channels, height, width] = image;
    at_least(&[
        ("classes", classes, 1),
        ("in_channels", in_channels, 1),
        ("height", height, side),
        ("width", width, side),
    ])
}

/// Averages to `size` rows and columns, where it has others.
fn pooled_to(x: &Flow, size: usize) -> Flow {
    if x.shape().get(1..) == Some(&[size, size]) { x.clone() } else { x.adaptive_average_pool(size) }
}
