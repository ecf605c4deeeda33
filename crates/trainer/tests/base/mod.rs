//! A small config, and how it is read with changes.

#![allow(dead_code)]

use taxel_trainer::{Error, Experiment, Overrides};
use taxel_zoo::Registry;

pub const BASE: &str = r#"name = "tiny"

[data]
scene = "fingertip"
samples = 60

[encoding]
image = { kind = "gadf" }

[train]
epochs = 7

[[networks]]
name = "mlp"
set = { hidden = 16 }

[[networks]]
name = "vgg6-lite-2d"
train = { batch_size = 8, optimizer = { lr = 1e-4 } }

[quick]
data.samples = 12
train.epochs = 2
train.schedule = { kind = "steps", at = [0.5] }
"#;

pub fn parse_with(text: &str, overrides: &Overrides) -> Result<Experiment, Error> {
    Experiment::parse(text, "tiny.toml", overrides, &Registry::built_in())
}

pub fn parse(text: &str) -> Result<Experiment, Error> {
    parse_with(text, &Overrides::default())
}

pub fn set(sets: &[&str]) -> Result<Experiment, Error> {
    let set = sets.iter().map(ToString::to_string).collect();
    parse_with(BASE, &Overrides { set, ..Overrides::default() })
}

pub fn quick() -> Overrides {
    Overrides { quick: true, ..Overrides::default() }
}
