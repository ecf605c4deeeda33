//! `taxel simulate`: a data set from a simulated world.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use taxel_data::{Npz, Quantity};
use taxel_faults::Fault;
use taxel_scenes::Scene;
use taxel_trainer::quantity;

use crate::CommandResult;
use crate::arrays::write;
use crate::commands::arguments::output_format::OutputFormat;
use crate::commands::arguments::settings::settings;
use crate::outln;
use crate::terminal::tables;

/// Simulates recordings of a sensor, with labels, groups and true physical values.
///
/// The .npz holds x, y, group and one array per true value; NAME.classes.json beside it has the names of the classes and the
/// units of the values. `taxel data check` and `taxel run --data` read both, and learn a value where it is named: `--y shore`.
/// The settings of the scenes:
///
/// fingertip: shore=[0,10,20]; between=[0,30] (any hardness in the range); unseen=0.3 (of the last samples only); sessions=10.
/// palpation: paper=002|003; subset=all|rigid|deformable|in-bag; frames=51; sessions=5.
/// gripper: objects=["tennis","mask"] (default all 30); sessions=5. y is [N, 2]: elasticity, hardness.
/// imprint: elements=128; view=0 (pixels of pictures that go with it); meshes=FOLDER.
/// gel: touches=cloths|objects; pixels=64; meshes=FOLDER.
/// hand: sessions=10; frames=700 (the last ones; 1 is a single time step).
/// vision: pixels=64; classes=object|family; meshes=FOLDER.
/// Every scene: factors={placement=0.5} keeps half of an effect, 0 leaves it out, 1 is all of it.
#[derive(Args)]
#[command(after_help = "Examples:  taxel simulate fingertip --samples 1500 --seed 0 --output grasps.npz
           taxel simulate palpation --set paper=002 --samples 540 --output squeezes.npz
           taxel simulate fingertip --explain
           taxel simulate fingertip --samples 300 --without placement --output easy.npz
           taxel simulate imprint --samples 1500 --set elements=16 --set meshes=my-meshes --output touch.npz
           taxel simulate fingertip --samples 300 --fault dead --severity 4 --output broken.npz")]
pub struct Simulate {
    /// The scene: fingertip, palpation, gripper, imprint, gel, hand or vision.
    scene: String,
    /// Recordings to simulate.
    #[arg(long, value_name = "N", default_value_t = taxel::experiment::SAMPLES)]
    samples: usize,
    /// Seed of every random choice.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// The data set to write, `.npz`.
    #[arg(long, short, value_name = "FILE", required_unless_present = "explain")]
    output: Option<PathBuf>,
    /// A setting of the scene in place of its default: key=value; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Leaves an effect out; may be given several times.
    #[arg(long, value_name = "EFFECT")]
    without: Vec<String>,
    /// Corrupts every recording by this fault, as `taxel stress` does.
    #[arg(long, value_name = "FAULT", requires = "severity")]
    fault: Option<Fault>,
    /// Severity of the fault, 1 to 5.
    #[arg(long, value_name = "N", requires = "fault")]
    severity: Option<u8>,
    /// Prints every effect of the scene with value, unit and source, and simulates nothing.
    #[arg(long)]
    explain: bool,
    #[command(flatten)]
    format: OutputFormat,
}

impl Simulate {
    pub fn run(self) -> CommandResult {
        if self.explain {
            return self.explain();
        }
        let Some(output) = self.output else {
            return Err("--output is missing; name the .npz to write".into());
        };
        let settings = serde_json::Value::Object(settings(&self.set)?);
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
        write(&output, arrays(&scene, self.samples))?;
        let classes_of = match &scene.attributes {
            Some(attributes) => serde_json::json!(attributes.class_names),
            None => serde_json::json!(scene.class_names),
        };
        let names = serde_json::json!({
            "classes": classes_of, "channels": scene.channel_names, "unit": scene.unit,
            "full_scale": scene.full_scale, "layout": scene.layout, "source": source, "values": values(&scene),
            "test_array": scene.test.is_some().then_some("test"),
        });
        let labels = output.with_extension("classes.json");
        write(&labels, Ok((serde_json::to_string_pretty(&names)? + "\n").into_bytes()))?;
        outln!("{}: {} of {classes} classes, {}", output.display(), tables::shape(&shape), scene.unit);
        Ok(ExitCode::SUCCESS)
    }

    /// Prints every effect of the scene.
    fn explain(&self) -> CommandResult {
        let effects = taxel_scenes::explain(&self.scene)?;
        if self.format.is_json() {
            outln!("{}", serde_json::to_string_pretty(&effects)?);
            return Ok(ExitCode::SUCCESS);
        }
        for effect in effects {
            let removable = if effect.removable { "" } else { "  (always there)" };
            outln!("{} · {} = {} {}{removable}", effect.name, effect.parameter, effect.value, effect.unit);
            outln!("    {}\n    source: {}", effect.why, effect.source);
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Returns the bytes of the .npz with the arrays of `scene`, which has `n` samples.
fn arrays(scene: &Scene, n: usize) -> std::io::Result<Vec<u8>> {
    let mut npz = Npz::default();
    let x = scene.x.as_standard_layout();
    add_readings(&mut npz, scene.x.shape(), x.as_slice().unwrap_or_default(), scene.full_scale)?;
    match &scene.attributes {
        Some(attributes) => {
            let y = attributes.y.as_standard_layout();
            npz.add("y", attributes.y.shape(), y.as_slice().unwrap_or_default())?;
        }
        None => npz.add("y", &[n], &scene.y)?,
    }
    npz.add("group", &[n], &scene.group)?;
    for (name, values) in &scene.streams {
        npz.add(name, values.shape(), values.as_standard_layout().as_slice().unwrap_or_default())?;
    }
    for (name, values) in &scene.truth {
        npz.add(name, &[n], values)?;
    }
    if let Some(test) = &scene.test {
        npz.add("test", &[n], &test.iter().copied().map(i64::from).collect::<Vec<_>>())?;
    }
    npz.finish()
}

/// Returns the quantities of the true values, by array.
fn values(scene: &Scene) -> BTreeMap<&str, Quantity> {
    scene.truth.iter().map(|(name, _)| (name.as_str(), quantity(name))).collect()
}

/// Adds the readings. Whole numbers of image sequences go as integers: a quarter or half the size of 32-bit floats.
fn add_readings(npz: &mut Npz, shape: &[usize], x: &[f32], full_scale: f32) -> std::io::Result<()> {
    let whole = shape.len() == 4 && x.iter().all(|v| v.fract() == 0.0 && *v >= 0.0 && *v <= full_scale);
    if whole && full_scale <= f32::from(u8::MAX) {
        npz.add("x", shape, &x.iter().map(|&v| v as u8).collect::<Vec<_>>())
    } else if whole && full_scale <= f32::from(u16::MAX) {
        npz.add("x", shape, &x.iter().map(|&v| v as u16).collect::<Vec<_>>())
    } else {
        npz.add("x", shape, x)
    }
}
