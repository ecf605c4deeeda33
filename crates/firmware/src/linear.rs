//! Linear models on features of a series, as C: MiniRocket with ridge, and ridge.

use taxel_kernels::Rectifier;
use taxel_kernels::frozen::bytes::{ByteOutput, Ending};
use taxel_kernels::rocket::Dilated;

use crate::body::Body;
use crate::layer::Stage;
use crate::literals::{floats, table};

/// Sums that the terms of a scalar product are dealt to.
const LANES: usize = 16;
/// Bytes of code, about, with the routines of doubles in software.
const CODE: usize = 3600;
/// The largest number that a table of 16 bits holds.
const COUNT: usize = u16::MAX as usize;

/// A linear model on features: sums of products in double precision, rounded once.
#[derive(Debug, Clone, Copy)]
pub struct Linear<'a> {
    /// The features that the weights meet.
    pub features: Features<'a>,
    /// Weights `[outputs, features]`.
    pub weights: &'a [f32],
    /// A number that is added to each output.
    pub bias: &'a [f32],
}

/// The features of a linear model.
#[derive(Debug, Clone, Copy)]
pub enum Features<'a> {
    /// The values of the series, channel after channel.
    Readings,
    /// MiniRocket's shares of time above a threshold.
    Rocket {
        /// Convolutions with their thresholds.
        convolutions: &'a [Dilated],
        /// Whether the last step of each channel and the mean of each follow.
        levels: bool,
    },
}

impl Linear<'_> {
    /// Plans the model for series of channels × steps.
    pub(crate) fn body(&self, [channels, steps]: [usize; 2]) -> Result<Body, String> {
        let width = self.features.width([channels, steps]);
        let outputs = self.bias.len();
        if self.weights.len() != width * outputs {
            return Err(format!("it has {} weights for {width} features", self.weights.len()));
        }
        if steps > COUNT || channels > COUNT {
            return Err(format!("it reads {channels}×{steps} values; {COUNT} per axis are the most"));
        }
        // Series, the output of a convolution, sums in doubles, outputs.
        let series = channels * steps;
        let row = if matches!(self.features, Features::Readings) { 0 } else { steps };
        let sums = series + row;
        let outputs_at = sums + 2 * LANES * outputs;
        let (tables, table_bytes) = self.tables(width);
        let features = self.features.text();
        let places = [("@row@", series), ("@sums@", sums), ("@row_outputs@", outputs_at)];
        let mut kernels = format!(
            "{}\n{tables}\n{}\n{features}",
            include_str!("c/floats.c"),
            include_str!("c/linear/ridge.c")
        );
        for (key, value) in places {
            kernels = kernels.replace(key, &format!("{value}u"));
        }
        Ok(Body {
            kernels,
            tables: String::new(),
            calls: "    linear(arena);\n".into(),
            table_bytes,
            code_bytes: CODE,
            counts: None,
            whole_bytes: 0,
            macs: self.features.macs([channels, steps]) + self.weights.len(),
            arena: size_of::<f32>() * (outputs_at + outputs),
            stage: Stage { by_channel: steps, by_step: 1, by_row: None, scales: None, ending: plain() },
            needs_fpu: false,
            stage_at: 0,
            stage_margins: String::new(),
            outputs_at: size_of::<f32>() * outputs_at,
            outputs,
            layers: vec![],
        })
    }

    /// Writes the tables; their bytes come back.
    fn tables(&self, width: usize) -> (String, usize) {
        let outputs = self.bias.len();
        // Feature after feature, as they are computed.
        let turned: Vec<f32> =
            (0..width).flat_map(|at| (0..outputs).map(move |k| self.weights[k * width + at])).collect();
        let mut text = floats("ridge_weight", &turned) + &floats("ridge_bias", self.bias);
        let mut bytes = 4 * (turned.len() + outputs);
        if let Features::Rocket { convolutions, .. } = self.features {
            let (mut rows, mut read, mut biases) = (vec![], Vec::<usize>::new(), vec![]);
            for Dilated { dilation, twos, channels, biases: own, counted } in convolutions {
                let [a, b, c] = twos;
                rows.push(format!(
                    "{{{}, {}, {}, {}, {dilation}, {}, {}, {{{a}, {b}, {c}}}}}",
                    read.len(),
                    channels.len(),
                    biases.len(),
                    own.len(),
                    counted.start,
                    counted.end
                ));
                read.extend(channels);
                biases.extend(own);
            }
            bytes += 24 * rows.len() + 2 * read.len() + 4 * biases.len();
            text = format!(
                "{}{}{}{}{text}",
                include_str!("c/linear/types.c"),
                table("uint16_t", "rocket_channels", &read),
                floats("rocket_biases", &biases),
                table("dilated", "convolutions", &rows)
            );
            text += &format!("#define CONVOLUTIONS {}u\n", rows.len());
        }
        (text, bytes)
    }
}

impl Features<'_> {
    fn width(&self, [channels, steps]: [usize; 2]) -> usize {
        match self {
            Features::Readings => channels * steps,
            Features::Rocket { convolutions, levels } => {
                let shares: usize = convolutions.iter().map(|one| one.biases.len()).sum();
                shares + if *levels { 2 * channels } else { 0 }
            }
        }
    }

    /// Counts the additions of the convolutions.
    fn macs(&self, [_, steps]: [usize; 2]) -> usize {
        match self {
            Features::Readings => 0,
            Features::Rocket { convolutions, .. } => {
                9 * steps * convolutions.iter().map(|one| one.channels.len()).sum::<usize>()
            }
        }
    }

    fn text(&self) -> String {
        match self {
            Features::Readings => include_str!("c/linear/readings.c").into(),
            Features::Rocket { levels, .. } => {
                let (functions, call) = if *levels {
                    (include_str!("c/linear/levels.c"), "    levels(arena, number);\n")
                } else {
                    ("", "")
                };
                include_str!("c/linear/rocket.c")
                    .replace("@levels@\n", functions)
                    .replace("    @call_levels@\n", call)
            }
        }
    }
}

/// Returns the ending that changes nothing.
fn plain() -> Ending {
    ByteOutput::Floats.ending(Rectifier::None)
}
