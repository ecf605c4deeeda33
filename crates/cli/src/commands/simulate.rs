//! `taxel simulate`: a data set from a simulated world.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use ndarray::Array1;

use crate::Outcome;
use crate::arrays::{Column, write_npz};
use crate::text;

/// Simulates recordings with labels, groups and true physical values.
///
/// Writes x, y, group and one array per true value to the .npz, and the class names to
/// NAME.classes.json beside it: `taxel data check` and `taxel run --data` read both.
#[derive(Args)]
#[command(after_help = "Examples:  taxel simulate fingertip --samples 1500 --seed 0 --output grasps.npz
           taxel simulate fingertip --explain
           taxel simulate fingertip --samples 300 --without placement --output easy.npz")]
pub struct Simulate {
    /// Scene name.
    scene: String,
    /// Number of recordings.
    #[arg(long, default_value_t = 1500)]
    samples: usize,
    /// Seed of everything random.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Where the data set goes.
    #[arg(long, required_unless_present = "explain")]
    output: Option<PathBuf>,
    /// Leaves an effect out; may be repeated.
    #[arg(long, value_name = "EFFECT")]
    without: Vec<String>,
    /// Prints every effect with value, unit and source instead.
    #[arg(long)]
    explain: bool,
    /// With --explain: JSON instead of a table.
    #[arg(long)]
    json: bool,
}

impl Simulate {
    pub fn run(self) -> Outcome {
        if self.explain {
            let effects = taxel_scenes::explain(&self.scene)?;
            if self.json {
                println!("{}", serde_json::to_string_pretty(&effects)?);
                return Ok(ExitCode::SUCCESS);
            }
            for effect in effects {
                let removable = if effect.removable { "" } else { "  (always there)" };
                println!(
                    "{} · {} = {} {}{removable}",
                    effect.name, effect.parameter, effect.value, effect.unit
                );
                println!("    {}\n    source: {}", effect.why, effect.source);
            }
            return Ok(ExitCode::SUCCESS);
        }
        let Some(output) = self.output else { return Err("--output is missing".into()) };
        let scene = taxel_scenes::simulate(&self.scene, self.samples, self.seed, &self.without)?;
        let (shape, classes) = (scene.x.shape().to_vec(), scene.class_names.len());
        let mut columns = vec![
            ("x".into(), Column::Floats(scene.x)),
            ("y".into(), Column::Integers(scene.y)),
            ("group".into(), Column::Integers(scene.group)),
        ];
        columns.extend(
            scene
                .truth
                .into_iter()
                .map(|(n, values)| (n, Column::Floats(Array1::from_vec(values).into_dyn()))),
        );
        write_npz(&output, &columns)?;
        let names = serde_json::json!({
            "classes": scene.class_names, "channels": scene.channel_names, "unit": scene.unit,
            "full_scale": scene.full_scale, "source": format!("simulated: {}", self.scene),
        });
        let labels = output.with_extension("classes.json");
        let write = std::fs::write(&labels, serde_json::to_string_pretty(&names)? + "\n");
        write.map_err(|e| format!("{}: cannot be written: {e}", labels.display()))?;
        println!("{}: {} of {classes} classes, {}", output.display(), text::shape(&shape), scene.unit);
        Ok(ExitCode::SUCCESS)
    }
}
