//! From a sample to what the network reads, as C.

use std::fmt::Write;

use taxel_encodings::{History, QuantileCode, Scaling};
use taxel_kernels::frozen::bytes::Ending;

use crate::layer::Stage;
use crate::literals::{float, floats, table};

/// Views of a channel in a quantile code.
const VIEWS: usize = 4;

/// How a sample of channels × time steps becomes what the network reads.
#[derive(Debug, Clone, Copy)]
pub enum Encoding<'a> {
    /// Values as they are, or scaled per channel.
    Scaled(&'a Scaling),
    /// The quantile code: each channel as ramps between the quantiles of its values. It goes to bytes row by row.
    Code(&'a QuantileCode),
    /// The last reading of each channel and its differences to earlier ones, then scaled row by row.
    History {
        /// Which earlier ones.
        history: &'a History,
        /// How the rows are scaled.
        scaling: &'a Scaling,
    },
}

impl Encoding<'_> {
    /// Returns channels and time steps of what comes out of a sample.
    pub(crate) fn shape(&self, [channels, steps]: [usize; 2]) -> [usize; 2] {
        match self {
            Encoding::Scaled(_) => [channels, steps],
            Encoding::Code(code) => code.shape(channels, steps),
            Encoding::History { history, .. } => history.shape(channels),
        }
    }

    /// Says why samples of this shape cannot be encoded.
    pub(crate) fn check(&self, [channels, steps]: [usize; 2]) -> Result<(), String> {
        match self {
            Encoding::Scaled(_) => Ok(()),
            Encoding::Code(code) => code.plan(channels, steps).map(drop).map_err(|error| error.to_string()),
            Encoding::History { history, .. } => history.check(steps).map_err(|error| error.to_string()),
        }
    }

    /// Returns the time steps that a ring has to hold.
    pub(crate) fn ring_steps(&self, steps: usize) -> usize {
        match self {
            Encoding::History { history, .. } => 1 + history.lags.iter().copied().max().unwrap_or(0),
            Encoding::Scaled(_) | Encoding::Code(_) => steps,
        }
    }

    /// Returns the bytes of one value in the ring.
    pub(crate) fn kept_bytes(&self, stage: &Stage) -> usize {
        let is_byte = matches!(self, Encoding::Scaled(_)) && stage.scales.is_some();
        if is_byte { 1 } else { size_of::<f32>() }
    }

    /// Returns how rows are scaled once they are there.
    fn scaling(&self) -> &Scaling {
        match self {
            Encoding::Scaled(scaling) | Encoding::History { scaling, .. } => scaling,
            Encoding::Code(_) => &Scaling::Raw,
        }
    }

    /// Scales one value of a row as C does.
    pub(crate) fn scaled(&self, row: usize, x: f32) -> f32 {
        match self.scaling() {
            Scaling::Raw => x,
            Scaling::FullScale { full_scale } => x / full_scale,
            Scaling::ZScore { mean, sd } => (x - mean[row]) / sd[row],
        }
    }

    /// Returns the operations of floats that one sample takes, about: for estimates.
    pub(crate) fn operations(&self, [channels, steps]: [usize; 2]) -> usize {
        match self {
            Encoding::Scaled(_) => channels * steps,
            Encoding::Code(code) => {
                let ramps: usize = code.views().iter().map(|view| view.edges.len().max(1)).sum();
                3 * steps * ramps
            }
            Encoding::History { history, .. } => channels * (1 + history.lags.len()),
        }
    }

    /// Returns the bytes of the tables.
    pub(crate) fn table_bytes(&self) -> usize {
        let scaling = if let Scaling::ZScore { mean, .. } = self.scaling() { 8 * mean.len() } else { 0 };
        scaling
            + match self {
                Encoding::Scaled(_) => 0,
                Encoding::Code(code) => {
                    let ramps = |edges: &Vec<f32>| 8 * edges.len().saturating_sub(1);
                    code.views().iter().map(|view| 12 + ramps(&view.edges)).sum()
                }
                Encoding::History { history, .. } => 4 * history.lags.len(),
            }
    }

    /// Returns about the bytes of the code, besides those of scaled values.
    pub(crate) fn code_bytes(&self) -> usize {
        match self {
            Encoding::Scaled(_) => 0,
            Encoding::Code(_) => 700,
            Encoding::History { .. } => 150,
        }
    }

    /// Writes the functions that bring a sample, and a ring of time steps, into the arena.
    pub(crate) fn text(&self, stage: &Stage, sample: [usize; 2]) -> String {
        let taken = taken(stage, self.scaling());
        let put = match stage.by_row {
            None => include_str!("c/encoding/put.c").to_string(),
            Some([columns, by_row]) => include_str!("c/image/put.c")
                .replace("@columns@", &columns.to_string())
                .replace("@by_row@", &by_row.to_string()),
        };
        let rest = match self {
            Encoding::Scaled(_) => include_str!("c/encoding/scaled.c").to_string(),
            Encoding::Code(code) => series(&self.code(code, sample), include_str!("c/encoding/code.c")),
            Encoding::History { history, .. } => {
                let tables = table("uint32_t", "lags", &history.lags);
                let count = format!("static const uint32_t lag_count = {}u;\n", history.lags.len());
                series(&format!("{count}{tables}\n"), include_str!("c/encoding/history.c"))
            }
        };
        format!("{taken}\n{put}\n{rest}")
    }

    /// Writes the tables of a quantile code.
    fn code(&self, code: &QuantileCode, [channels, length]: [usize; 2]) -> String {
        let [rows, steps] = code.shape(channels, length);
        let stride = length.div_ceil(steps);
        let rows_of_view = rows / (VIEWS * channels) - 1;
        let (mut ramps, mut views) = (vec![], vec![]);
        for view in code.views() {
            let (first, factor) = (ramps.len(), 1.0 / view.sd);
            ramps.extend(
                view.edges
                    .windows(2)
                    .map(|pair| format!("{{{}, {}}}", float(pair[0]), float(1.0 / (pair[1] - pair[0])))),
            );
            let count = ramps.len() - first;
            views.push(format!("{{{{{}, {}}}, {first}, {count}}}", float(view.mean), float(factor)));
        }
        if ramps.is_empty() {
            ramps.push("{0.0f, 0.0f}".into());
        }
        let mut text = format!(
            "#define CODE_STEPS {steps}u\n#define CODE_STRIDE {stride}u\n#define CODE_ROWS {rows_of_view}u\n\n"
        );
        text += include_str!("c/encoding/code_types.c");
        text += &table("line", "ramps", &ramps);
        text += &table("code_view", "code_views", &views);
        text.push('\n');
        text
    }
}

/// Puts tables, and the functions of an encoding of whole series, between those that read a sample or a ring.
fn series(tables: &str, encode: &str) -> String {
    format!(
        "{}\n{tables}{encode}\n{}",
        include_str!("c/encoding/series.c"),
        include_str!("c/encoding/whole.c")
    )
}

/// Returns how many rows of the input have numbers of their own.
pub(crate) fn different_rows(stage: &Stage, encoding: &Encoding) -> usize {
    let Some((factors, shifts)) = &stage.scales else { return 0 };
    let is_plain = !matches!(encoding.scaling(), Scaling::ZScore { .. });
    let same = |values: &[f32]| values.iter().all(|value| value.to_bits() == values[0].to_bits());
    if is_plain && same(factors) && same(shifts) { 1 } else { factors.len() }
}

/// Writes one value of a row as the first layer reads it: a function of C.
fn taken(stage: &Stage, scaling: &Scaling) -> String {
    let mut tables = String::new();
    let mut body = String::new();
    match scaling {
        Scaling::Raw => {}
        Scaling::FullScale { full_scale } => {
            let _ = writeln!(body, "    x = over(x, {});", float(*full_scale));
        }
        Scaling::ZScore { mean, sd } => {
            tables += &floats("mean_of", mean);
            tables += &floats("deviation_of", sd);
            body += "    x = over(less(x, mean_of[row]), deviation_of[row]);\n";
        }
    }
    if let Some((factors, shifts)) = &stage.scales {
        let mut number = |name: &str, values: &[f32]| {
            if values.iter().all(|value| value.to_bits() == values[0].to_bits()) {
                return float(values[0]);
            }
            tables += &floats(name, values);
            format!("{name}[row]")
        };
        let (factor, shift) = (number("factor_of", factors), number("shift_of", shifts));
        let Ending { zero, low, high } = stage.ending;
        let ending = [zero, low, high].map(float).join(", ");
        let _ = writeln!(body, "    return byte_of(plus(times(x, {factor}), {shift}), {ending});");
    } else {
        body += "    return x;\n";
    }
    let unused = if body.contains("row") { "" } else { "    (void)row;\n" };
    format!("{tables}\nstatic inline reading taken(float x, uint32_t row)\n{{\n{unused}{body}}}\n")
}
