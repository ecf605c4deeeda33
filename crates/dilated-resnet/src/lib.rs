#![doc = include_str!("../README.md")]

mod dilated_resnet;
mod dilated_resnet_rocket;

pub use dilated_resnet::DilatedResNetConfig;
pub use dilated_resnet_rocket::DilatedResNetRocketConfig;
