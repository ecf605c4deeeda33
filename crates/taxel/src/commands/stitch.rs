//! `taxel stitch`: two trained networks become the two streams of one.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueHint};
use taxel::base::thousands;
use taxel_checkpoint as checkpoint;
use taxel_graph::{Tensor, Weights};

use crate::CommandResult;
use crate::commands::arguments::network::weights_of;
use crate::commands::arguments::settings::settings;
use crate::outln;

/// Stitches two trained MobileNetV2, one of vision and one of touch, into one two-stream network.
///
/// The result is a mobilenet-v2-split (Rouhafzay et al. 2021, section 7). The layers 18 to 139 of both must be equal: train them from
/// the same start with `18:139` frozen. Where the channels of one stream are zero, the result predicts as the network of
/// the other stream.
#[derive(Args)]
#[command(
    after_help = "Example:  taxel stitch --visual photographs.safetensors --tactile imprints.safetensors \\
              --output both.safetensors --set classes=6"
)]
pub struct Stitch {
    /// Weights of the mobilenet-v2 of vision.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    visual: PathBuf,
    /// Weights of the mobilenet-v2 of touch.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    tactile: PathBuf,
    /// The weights of mobilenet-v2-split to write, `.safetensors`.
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
    /// Mean that is subtracted from each input channel, those of vision first [default: 0].
    #[arg(long, value_name = "M,M,...", value_delimiter = ',', allow_negative_numbers = true)]
    mean: Vec<f32>,
    /// Standard deviation that each input channel is then divided by [default: 1].
    #[arg(long, value_name = "S,S,...", value_delimiter = ',')]
    std: Vec<f32>,
    /// A setting of the network in place of its default: key=value; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

impl Stitch {
    pub fn run(self) -> CommandResult {
        let mut settings = settings(&self.set)?;
        let split = taxel_zoo::find("mobilenet-v2-split")?.graph(&settings)?;
        let channels = split.inputs().map(|node| node.shape[0]).sum::<usize>();
        settings.insert("in_channels".into(), (channels / 2).into());
        let single = taxel_zoo::find("mobilenet-v2")?.graph(&settings)?;
        let (visual, tactile) = (weights_of(&single, &self.visual)?, weights_of(&single, &self.tactile)?);
        let mut norms = Weights::new();
        for (name, given, default) in [("mean", self.mean, 0.0), ("std", self.std, 1.0)] {
            let data = if given.is_empty() { vec![default; channels] } else { given };
            let usable = |v: &f32| v.is_finite() && (name == "mean" || *v > 0.0);
            if data.len() != channels || !data.iter().all(usable) {
                let range = if name == "mean" { "finite" } else { "above 0" };
                return Err(format!("--{name}: expected {channels} {range} numbers, got {data:?}").into());
            }
            norms.insert(name, Tensor { shape: vec![channels], data });
        }
        let weights =
            Weights::stitched(&split, &[("visual", &visual), ("tactile", &tactile)], "shared", &norms)?;
        checkpoint::write(&self.output, &weights, "")?;
        let (two, one) = (2 * single.cost().parameters, split.cost().parameters);
        outln!(
            "{}: {} parameters in place of {}, {:.2} times fewer",
            self.output.display(),
            thousands(one),
            thousands(two),
            two as f64 / one as f64
        );
        Ok(ExitCode::SUCCESS)
    }
}
