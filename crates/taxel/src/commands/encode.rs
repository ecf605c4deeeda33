//! `taxel encode`: one encoding over a batch.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum, ValueHint};
use ndarray::{Array1, Array3, Array4, ArrayD, Axis, Dimension};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use taxel_encodings::{
    Colormap, Constant, ElectrodeImage, Gaf, HardnessImage, Method, NumaTac, OneFrame, Range, Resize,
    TactileTensor, all_frames, red_channel,
};
use taxel_zoo::Settings;

use crate::CommandResult;
use crate::arrays::write_npy;
use crate::commands::arguments::settings::settings;

/// Encodes a batch of recordings, as a network reads them.
///
/// Arrays have the batch axis N first.
///
/// gadf and gasf take [N, time] or [N, channels, time], flatten each recording row by row, average it to
/// `size` pieces, rescale it to -1..1 and write the Gramian angular field [N, size, size], values -1..1.
/// With a colormap, and for hardness-image always (jet), the result is [N, colours, size, size], values 0..1.
/// Settings: size=50; range=per-sample or range={"fixed":{"low":0,"high":1023}};
/// colormap=none|grey|jet|viridis; constant=error|zero (what a constant recording becomes).
///
/// tactile-tensor: [N, frames, rows, columns] to [N, 1, rows, columns, frames]; frames=51 resamples.
///
/// frame: [N, frames, rows, columns] to one frame each, [N, 1, rows, columns]; frame=peak or frame=3.
///
/// all-frames: the same to [N * frames, 1, rows, columns], sample after sample.
///
/// numatac: raw bits [N, fingers, 1 DC + 22 AC, ticks] to Pa from contact on, [N, fingers, 23, window];
/// window=300; above=1.1; below=0.9; offset=before-contact or offset={"fixed":{"dc":238,"ac":2048}}.
///
/// red-channel: grey [N, rows, columns] to [N, 3, rows, columns].
///
/// electrode-image: [N, 7, 3, 700 or more] to [N, 3, 70, 70]; order=columns (MATLAB) or rows.
///
/// resize: [N, channels, rows, columns] or [N, rows, columns]; height=224 width=224 filter=bilinear|area.
#[derive(Args)]
#[command(after_help = "Examples:  taxel encode gadf --input grasps.npy --output images.npy --set size=50
           taxel encode tactile-tensor --input squeezes.npy --output tensors.npy --set frames=21")]
pub struct Encode {
    /// The encoding.
    #[arg(value_enum)]
    encoding: Encoding,
    /// The recordings, `.npy`.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    input: PathBuf,
    /// The array to write, `.npy` in 32-bit floats.
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
    /// A setting of the encoding in place of its default: key=value; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Encoding {
    /// Gramian angular difference field.
    Gadf,
    /// Gramian angular summation field.
    Gasf,
    /// The whole pipeline of Kaewrakmuk and Srinonchat 2026: difference field and colours.
    HardnessImage,
    /// Frames of a squeeze as one 3D tensor (Gandarias et al. 2019b, Pastor et al. 2019).
    TactileTensor,
    /// One frame of a squeeze, for 2D methods.
    Frame,
    /// Every frame of a squeeze as an image of its own.
    AllFrames,
    /// Dual-channel series from contact on, in Pa (Zhang et al. 2022, equations 1 and 2).
    Numatac,
    /// Grey in the red of three colours (Rouhafzay et al. 2021).
    RedChannel,
    /// 7 x 3 electrodes over 700 times as a colour image (Rouhafzay et al. 2021).
    ElectrodeImage,
    /// Images at another size.
    Resize,
}

/// Settings of a Gramian angular field.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
struct FieldSettings {
    size: usize,
    range: Range,
    constant: Constant,
    colormap: Option<Value>,
}

impl Default for FieldSettings {
    fn default() -> Self {
        let gaf = Gaf::default();
        FieldSettings { size: gaf.size, range: gaf.range, constant: gaf.constant, colormap: None }
    }
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct FrameSettings {
    frame: Option<Value>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NoSettings {}

type Encoded = Result<ArrayD<f32>, String>;

impl Encode {
    pub fn run(self) -> CommandResult {
        let array = taxel_data::read_npy(&self.input)?;
        let encoded = self.encode(array, settings(&self.set)?)?;
        write_npy(&self.output, &encoded)?;
        Ok(ExitCode::SUCCESS)
    }

    fn encode(&self, array: ArrayD<f32>, settings: Settings) -> Encoded {
        let sequence = "[N, frames, rows, columns]";
        match self.encoding {
            Encoding::Gadf | Encoding::Gasf | Encoding::HardnessImage => self.field(array, read(settings)?),
            Encoding::TactileTensor => {
                let tensor: TactileTensor = read(settings)?;
                let x: Array4<f32> = self.axes(array, sequence)?;
                let encode = |(i, x)| {
                    tensor.encode(x).map(ndarray::ArrayBase::into_dyn).map_err(|e| self.sample(i, e))
                };
                let tensors: Vec<ArrayD<f32>> =
                    x.outer_iter().enumerate().map(encode).collect::<Result<_, _>>()?;
                let views: Vec<_> = tensors.iter().map(|x| x.view()).collect();
                ndarray::stack(Axis(0), &views).map_err(|_| self.says("has no samples"))
            }
            Encoding::Frame => {
                let frame = match read::<FrameSettings>(settings)?.frame {
                    None => OneFrame::Peak,
                    Some(Value::Number(index)) => read_value(serde_json::json!({ "at": index }), "frame")?,
                    Some(other) => read_value(other, "frame")?,
                };
                let x = self.axes(array, sequence)?;
                self.done(frame.encode_batch(x.view()))
            }
            Encoding::AllFrames => {
                read::<NoSettings>(settings)?;
                let x = self.axes(array, sequence)?;
                self.done(Ok(all_frames(x.view())))
            }
            Encoding::Numatac => {
                let numatac: NumaTac = read(settings)?;
                let x = self.axes(array, "[N, fingers, 1 DC + AC, ticks]")?;
                self.done(numatac.encode_batch(x.view()))
            }
            Encoding::RedChannel => {
                read::<NoSettings>(settings)?;
                let x: Array3<f32> = self.axes(array, "[N, rows, columns]")?;
                self.done(Ok(red_channel(x.view())))
            }
            Encoding::ElectrodeImage => {
                let image: ElectrodeImage = read(settings)?;
                let x = self.axes(array, "[N, 7, 3, times]")?;
                self.done(image.encode_batch(x.view()))
            }
            Encoding::Resize => {
                let resize: Resize = read(settings)?;
                let grey = array.ndim() == 3;
                let array = if grey { array.insert_axis(Axis(1)) } else { array };
                let x = self.axes(array, "[N, rows, columns] or [N, channels, rows, columns]")?;
                let resized = self.done(resize.encode_batch(x.view()))?;
                Ok(if grey { resized.remove_axis(Axis(1)) } else { resized })
            }
        }
    }

    fn field(&self, array: ArrayD<f32>, settings: FieldSettings) -> Encoded {
        let method = if self.encoding == Encoding::Gasf { Method::Summation } else { Method::Difference };
        let FieldSettings { size, range, constant, colormap } = settings;
        let gaf = Gaf { size, method, range, constant };
        let colormap: Option<Colormap> = match colormap {
            Some(Value::String(name)) if name == "none" => None,
            Some(name) => Some(read_value(name, "colormap")?),
            None if self.encoding == Encoding::HardnessImage => Some(Colormap::default()),
            None => None,
        };
        let array = if array.ndim() == 2 { array.insert_axis(Axis(1)) } else { array };
        let recordings: Array3<f32> = self.axes(array, "[N, time] or [N, channels, time]")?;
        let image = HardnessImage { gaf, colormap: colormap.unwrap_or(Colormap::Grey) };
        if colormap.is_some() {
            return self.done(image.encode_batch(recordings.view()));
        }
        let mut fields = ArrayD::zeros(vec![recordings.len_of(Axis(0)), size, size]);
        for (i, recording) in recordings.outer_iter().enumerate() {
            let series: Array1<f32> = recording.iter().copied().collect();
            let field = image.gaf.encode(series.view()).map_err(|e| self.sample(i, e))?;
            fields.index_axis_mut(Axis(0), i).assign(&field);
        }
        Ok(fields)
    }

    /// Returns the batch with the axes that the encoding takes.
    fn axes<D: Dimension>(
        &self,
        array: ArrayD<f32>,
        expected: &str,
    ) -> Result<ndarray::Array<f32, D>, String> {
        let shape = array.shape().to_vec();
        array.into_dimensionality().map_err(|_| self.says(&format!("shape {shape:?}; expected {expected}")))
    }

    fn done(&self, encoded: taxel_encodings::Result<Array4<f32>>) -> Encoded {
        encoded.map(Array4::into_dyn).map_err(|e| self.says(&e.to_string()))
    }

    fn sample(&self, i: usize, error: taxel_encodings::Error) -> String {
        self.says(&format!("sample {i}: {error}"))
    }

    fn says(&self, what: &str) -> String {
        format!("{}: {what}", self.input.display())
    }
}

fn read<T: DeserializeOwned>(settings: Settings) -> Result<T, String> {
    serde_json::from_value(Value::Object(settings)).map_err(|e| format!("--set: {e}"))
}

fn read_value<T: DeserializeOwned>(value: Value, key: &str) -> Result<T, String> {
    serde_json::from_value(value).map_err(|e| format!("--set {key}: {e}"))
}
