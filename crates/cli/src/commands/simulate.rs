//! `taxel simulate`: a data set from a simulated world.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use taxel_data::Npz;
use taxel_scenes::faults::Fault;

use crate::Outcome;
use crate::arrays::write;
use crate::text;

/// Simulates recordings with labels, groups and true physical values.
///
/// Writes x, y, group and one array per true value to the .npz, and the class names to
/// NAME.classes.json beside it: `taxel data check` and `taxel run --data` read both.
#[derive(Args)]
#[command(after_help = "Examples:  taxel simulate fingertip --samples 1500 --seed 0 --output grasps.npz
           taxel simulate fingertip --explain
           taxel simulate fingertip --samples 300 --without placement --output easy.npz
           taxel simulate imprint --samples 1500 --set elements=16 --set meshes=my-meshes --output touch.npz
           taxel simulate fingertip --samples 300 --fault dead --severity 4 --output broken.npz")]
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
    /// A setting of the scene in place of its default: key=value; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Leaves an effect out; may be repeated.
    #[arg(long, value_name = "EFFECT")]
    without: Vec<String>,
    /// Breaks every recording by this fault, as `taxel stress` does.
    #[arg(long, value_name = "FAULT", requires = "severity")]
    fault: Option<Fault>,
    /// How badly, 1 to 5.
    #[arg(long, requires = "fault")]
    severity: Option<u8>,
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
        let settings = serde_json::Value::Object(super::settings(&self.set)?);
        let settings = taxel_scenes::Settings::read(&self.scene, settings)?;
        let mut scene = settings.simulate(self.samples, self.seed, &self.without)?;
        let mut source = format!("simulated: {}", self.scene);
        if !self.set.is_empty() {
            source += &format!(" ({})", self.set.join(", "));
        }
        if !self.without.is_empty() {
            source += &format!(" without {}", self.without.join(", "));
        }
        if let (Some(fault), Some(severity)) = (self.fault, self.severity) {
            scene.corrupt(fault, severity, self.seed)?;
            source += &format!(" with {fault}, {} {}", fault.level(severity)?, fault.unit());
        }
        let (shape, classes) = (scene.x.shape().to_vec(), scene.class_names.len());
        let n = self.samples;
        let fill = || -> std::io::Result<Vec<u8>> {
            let mut npz = Npz::default();
            npz.add("x", &shape, scene.x.as_standard_layout().as_slice().unwrap_or_default())?;
            npz.add("y", &[n], &scene.y)?;
            npz.add("group", &[n], &scene.group)?;
            for (name, values) in &scene.streams {
                npz.add(name, values.shape(), values.as_standard_layout().as_slice().unwrap_or_default())?;
            }
            for (name, values) in &scene.truth {
                npz.add(name, &[n], values)?;
            }
            npz.finish()
        };
        write(&output, fill())?;
        let names = serde_json::json!({
            "classes": scene.class_names, "channels": scene.channel_names, "unit": scene.unit,
            "full_scale": scene.full_scale, "source": source,
        });
        let labels = output.with_extension("classes.json");
        write(&labels, Ok((serde_json::to_string_pretty(&names)? + "\n").into_bytes()))?;
        println!("{}: {} of {classes} classes, {}", output.display(), text::shape(&shape), scene.unit);
        Ok(ExitCode::SUCCESS)
    }
}
