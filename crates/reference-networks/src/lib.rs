#![doc = include_str!("../README.md")]

mod deep_mlp;
mod dilated_resnet;
mod dilated_resnet_rocket;
mod ds_cnn;
mod fcn;
mod layer_norm_mlp;
mod lstm;
mod mlp;
mod tactnet;
mod tactnet_gru;
mod tactresnet;

pub use deep_mlp::DeepMlpConfig;
pub use dilated_resnet::DilatedResNetConfig;
pub use dilated_resnet_rocket::DilatedResNetRocketConfig;
pub use ds_cnn::DsCnnConfig;
pub use fcn::FcnConfig;
pub use layer_norm_mlp::LayerNormMlpConfig;
pub use lstm::LstmConfig;
pub use mlp::MlpConfig;
pub use tactnet::{TactNetConfig, TactNetDepth};
pub use tactnet_gru::TactNetGruConfig;
pub use tactresnet::TactResNetConfig;

use taxel_graph::Register;

const FAMILY: &str = "reference-networks";

/// Hands every network of this family to the zoo.
pub fn list(zoo: &mut impl Register) {
    zoo.add(mlp::MLP);
    zoo.add(deep_mlp::DEEP_MLP);
    zoo.add(layer_norm_mlp::LAYER_NORM_MLP);
    zoo.add(lstm::LSTM);
    zoo.add(tactnet::TACTNET4);
    zoo.add(tactnet::TACTNET6);
    zoo.add(tactnet_gru::TACTNET6_GRU);
    zoo.add(tactresnet::TACTRESNET);
    zoo.add(fcn::FCN);
    zoo.add(ds_cnn::DS_CNN);
    zoo.add(dilated_resnet::DILATED_RESNET);
    zoo.add(dilated_resnet_rocket::DILATED_RESNET_ROCKET);
}
