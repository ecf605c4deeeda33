#![doc = include_str!("../README.md")]

mod dilated_resnet;

pub use dilated_resnet::DilatedResNetConfig;
