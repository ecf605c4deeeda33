//! `taxel encode`: one encoding over a batch.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use ndarray::{Array4, ArrayD, Axis};
use serde::Deserialize;
use serde_json::Value;
use taxel_encodings::{Colormap, Constant, Gaf, HardnessImage, Method, Range};

use crate::Outcome;
use crate::arrays::write_npy;

/// Encodes recordings [N, time] or [N, channels, time] as images.
///
/// gadf and gasf flatten each recording row by row, average it to `size` pieces, rescale it to -1..1 and
/// write the Gramian angular field [N, size, size], values -1..1. With a colormap, and for hardness-image
/// always (jet), the result is [N, colours, size, size], values 0..1.
///
/// Settings: size=50; range=per-sample or range={"fixed":{"low":0,"high":1023}};
/// colormap=none|grey|jet|viridis; constant=error|zero (what a constant recording becomes).
#[derive(Args)]
#[command(after_help = "Example:  taxel encode gadf --input grasps.npy --output images.npy --set size=50")]
pub struct Encode {
    /// Which encoding.
    #[arg(value_enum)]
    encoding: Encoding,
    /// `.npy`, batch first.
    #[arg(long)]
    input: PathBuf,
    /// Where the images go, `.npy` in 32-bit floats.
    #[arg(long)]
    output: PathBuf,
    /// A setting: key=value.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Encoding {
    /// Gramian angular difference field.
    Gadf,
    /// Gramian angular summation field.
    Gasf,
    /// The whole pipeline of paper 000: difference field and colours.
    HardnessImage,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Settings {
    size: usize,
    range: Range,
    constant: Constant,
    colormap: Option<Value>,
}

impl Default for Settings {
    fn default() -> Self {
        let gaf = Gaf::default();
        Settings { size: gaf.size, range: gaf.range, constant: gaf.constant, colormap: None }
    }
}

impl Encode {
    pub fn run(self) -> Outcome {
        let settings: Settings = serde_json::from_value(Value::Object(super::settings(&self.set)?))
            .map_err(|e| format!("--set: {e}"))?;
        let method = if self.encoding == Encoding::Gasf { Method::Summation } else { Method::Difference };
        let Settings { size, range, constant, colormap } = settings;
        let gaf = Gaf { size, method, range, constant };
        let colormap: Option<Colormap> = match colormap {
            Some(Value::String(name)) if name == "none" => None,
            Some(name) => Some(serde_json::from_value(name).map_err(|e| format!("--set colormap: {e}"))?),
            None if self.encoding == Encoding::HardnessImage => Some(Colormap::default()),
            None => None,
        };
        let file = self.input.display();
        let array = taxel_data::read_npy(&self.input)?;
        let array = match array.ndim() {
            2 => array.insert_axis(Axis(1)),
            3 => array,
            _ => {
                let shape = array.shape();
                return Err(
                    format!("{file}: shape {shape:?}; expected [N, time] or [N, channels, time]").into()
                );
            }
        };
        let recordings = array.into_dimensionality::<ndarray::Ix3>()?;
        let image = HardnessImage { gaf, colormap: colormap.unwrap_or(Colormap::Grey) };
        let images: ArrayD<f32> = if colormap.is_some() {
            let images: Array4<f32> =
                image.encode_batch(recordings.view()).map_err(|e| format!("{file}: {e}"))?;
            images.into_dyn()
        } else {
            let mut fields = ArrayD::zeros(vec![recordings.len_of(Axis(0)), size, size]);
            for (i, recording) in recordings.outer_iter().enumerate() {
                let series: ndarray::Array1<f32> = recording.iter().copied().collect();
                let field =
                    image.gaf.encode(series.view()).map_err(|e| format!("{file}: sample {i}: {e}"))?;
                fields.index_axis_mut(Axis(0), i).assign(&field);
            }
            fields
        };
        write_npy(&self.output, &images)?;
        Ok(ExitCode::SUCCESS)
    }
}
