//! `taxel stitch`: two trained networks become the two streams of one.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use taxel::base::thousands;
use taxel::learn::read_weights;
use taxel_checkpoint as checkpoint;
use taxel_graph::{Graph, Tensor, Weights};

use crate::Outcome;

/// Two MobileNetV2 trained apart, on vision and on touch, become one mobilenet-v2-split (paper 001, section 7).
///
/// Both parents must have the layers 18 to 139 alike: train them from the same start with `18:139` frozen. The
/// result answers for either stream as that parent does, where the other stream's channels are zero.
#[derive(Args)]
#[command(
    after_help = "Example:  taxel stitch --visual photographs.safetensors --tactile imprints.safetensors \\
              --output both.safetensors --set classes=6"
)]
pub struct Stitch {
    /// Weights of the mobilenet-v2 that sees.
    #[arg(long)]
    visual: PathBuf,
    /// Weights of the mobilenet-v2 that feels.
    #[arg(long)]
    tactile: PathBuf,
    /// Where the weights of mobilenet-v2-split go, `.safetensors`.
    #[arg(long)]
    output: PathBuf,
    /// What is taken off each input channel, vision's before touch's [default: 0].
    #[arg(long, value_name = "M,M,...", value_delimiter = ',', allow_negative_numbers = true)]
    mean: Vec<f32>,
    /// What each channel is then divided by [default: 1].
    #[arg(long, value_name = "S,S,...", value_delimiter = ',')]
    std: Vec<f32>,
    /// A configuration value in place of the paper's: key=value.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

impl Stitch {
    pub fn run(self) -> Outcome {
        let mut settings = super::settings(&self.set)?;
        let split = taxel_zoo::find("mobilenet-v2-split")?.graph(&settings)?;
        let channels = split.inputs().map(|node| node.shape[0]).sum::<usize>();
        settings.insert("in_channels".into(), (channels / 2).into());
        let single = taxel_zoo::find("mobilenet-v2")?.graph(&settings)?;
        let (visual, tactile) = (read(&self.visual, &single)?, read(&self.tactile, &single)?);
        let mut own = Weights::new();
        for (name, given, default) in [("mean", self.mean, 0.0), ("std", self.std, 1.0)] {
            let data = if given.is_empty() { vec![default; channels] } else { given };
            let usable = |v: &f32| v.is_finite() && (name == "mean" || *v > 0.0);
            if data.len() != channels || !data.iter().all(usable) {
                let range = if name == "mean" { "finite" } else { "above 0" };
                return Err(format!("--{name}: expected {channels} {range} numbers, got {data:?}").into());
            }
            own.insert(name, Tensor { shape: vec![channels], data });
        }
        let weights =
            Weights::stitched(&split, &[("visual", &visual), ("tactile", &tactile)], "shared", &own)?;
        checkpoint::write(&self.output, &weights, "")?;
        let (two, one) = (2 * single.cost().parameters, split.cost().parameters);
        println!(
            "{}: {} parameters in place of {}, {:.2} times fewer",
            self.output.display(),
            thousands(one),
            thousands(two),
            two as f64 / one as f64
        );
        Ok(ExitCode::SUCCESS)
    }
}

fn read(path: &Path, graph: &Graph) -> Result<Weights, Box<dyn std::error::Error>> {
    let weights = read_weights(path)?;
    weights.check(graph).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(weights)
}
