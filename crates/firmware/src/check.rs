//! The test that goes with the C: what each sample and each ending has to give.

use std::fmt::Write;

use taxel_kernels::frozen::bytes::Ending;

use crate::encoding::{Encoding, different_rows};
use crate::layer::{Layer, Stage, Then, Windows, Work};
use crate::library::Library;
use crate::literals::{floats, table};
use crate::numbers::{Digest, LARGEST, add_thresholds, byte, ended, ordered, steps};
use crate::row_text::Lines;
use crate::rows;
use crate::samples::SEED;

/// The texts of the test.
pub(crate) struct Check {
    /// Numbers that have to come out.
    pub vectors: String,
    /// Functions that compute them, and their calls.
    pub checks: String,
    pub calls: String,
    lines: Lines,
}

impl Check {
    pub fn new(library: &Library, all: &[Layer]) -> Self {
        let lines = Lines::of(all);
        let mut check =
            Check { vectors: samples(library), checks: String::new(), calls: String::new(), lines };
        let mut layers = 0;
        for (number, layer) in all.iter().enumerate() {
            layers += usize::from(check.layer(number, layer, &library.encoding));
        }
        let _ = writeln!(check.vectors, "#define LAYERS {layers}u");
        check
    }

    /// Adds what a layer's ending has to give; false for a layer without one.
    fn layer(&mut self, number: usize, layer: &Layer, encoding: &Encoding) -> bool {
        let (found, kind, arguments) = match &layer.work {
            Work::Stage(stage) => {
                let Some(found) = staged(stage, encoding) else { return false };
                let _ = writeln!(self.vectors, "#define STAGE_ROWS {}u", found.len());
                (found, "stage", None)
            }
            Work::Conv(conv) => {
                let addend = conv.addend.map(|addend| (f32::from(addend.zero), addend.factor));
                let found = sums(layer, &conv.factor, conv.reach, addend, &conv.ending, conv.then);
                (
                    found,
                    "conv",
                    Some(format!(
                        "{}u, {}, {}u, ",
                        conv.factor.len(),
                        conv.reach,
                        u8::from(addend.is_some())
                    )),
                )
            }
            Work::Depthwise(conv) => {
                let found = sums(layer, &conv.factor, conv.reach, None, &conv.ending, None);
                (found, "depthwise", Some(format!("{}u, {}, 0u, ", conv.factor.len(), conv.reach)))
            }
            Work::Map { factors, shifts, ending } => {
                (maps(layer, factors, shifts, ending), "map", Some(String::new()))
            }
            Work::Mean { windows, scales, ending } => {
                (all_means(layer, windows, scales, ending), "mean", Some(String::new()))
            }
            Work::Add { factors, shift, ending } => {
                (vec![pairs(layer, *factors, *shift, ending)], "add", Some(String::new()))
            }
            _ => return false,
        };
        self.function(kind);
        let wanted: Vec<String> = found.iter().map(|digest| format!("0x{digest:08x}u")).collect();
        self.vectors += &table("uint32_t", &format!("wanted_{number}"), &wanted);
        let name = crate::literals::text(&layer.name);
        let _ = match arguments {
            None => writeln!(self.calls, "    check_{kind}(wanted_{number});"),
            Some(more) => {
                writeln!(self.calls, "    check_{kind}({name}, &layer_{number}, {more}wanted_{number});")
            }
        };
        true
    }

    /// Adds the function that checks layers of a kind, once.
    fn function(&mut self, kind: &str) {
        if self.checks.contains(&format!("check_{kind}(")) {
            return;
        }
        if matches!(kind, "stage" | "map") && !self.checks.contains("float ordered(") {
            self.checks += include_str!("c/check/ordered.c");
        }
        let sums = include_str!("c/check/conv.c");
        let text = match kind {
            "stage" => include_str!("c/check/stage.c").to_string(),
            "map" => include_str!("c/check/map.c").to_string(),
            "mean" if self.lines.pool => include_str!("c/check/mean_rows.c").to_string(),
            "mean" => include_str!("c/check/mean.c").to_string(),
            "add" => include_str!("c/check/add.c").to_string(),
            "conv" => {
                let one = |what: &str| format!("conv_{what}(conv_now, conv_filter, sum, conv_addend)");
                let all = "check_all_sums(layer, conv_filter, reach, has_addend);";
                let sums = format!("{}{}", include_str!("c/check/whole.c"), sums.replace("@all@", all));
                sums.replace("@byte@", &one("byte")).replace("@float@", &one("float"))
            }
            _ => {
                let one = |what: &str| format!("depthwise_{what}(depthwise_now, depthwise_filter, sum)");
                let sums = sums.replace("        @all@\n", "");
                sums.replace("@byte@", &one("byte")).replace("@float@", &one("float"))
            }
        };
        self.checks += &text.replace("@kind@", kind);
    }
}

/// Writes how samples are made and what they have to give.
fn samples(library: &Library) -> String {
    let walks = &library.samples.walks;
    let mut text = format!("#define SAMPLES {}u\n#define SAMPLE_SEED 0x{SEED:08x}u\n", library.samples.count);
    text += &table("int32_t", "walk_low", &walks.iter().map(|walk| walk.low).collect::<Vec<_>>());
    text += &table("int32_t", "walk_high", &walks.iter().map(|walk| walk.high).collect::<Vec<_>>());
    let units: Vec<f32> = walks.iter().map(|walk| f64::from(walk.power).exp2() as f32).collect();
    text += &floats("walk_unit", &units);
    let bits = |values: &[f32]| values.iter().map(|v| format!("0x{:08x}u", v.to_bits())).collect::<Vec<_>>();
    text += &table("uint32_t", "expected_outputs", &bits(&library.expected.outputs));
    text += &table("uint32_t", "expected_answers", &bits(&library.expected.answers));
    if !library.expected.gate.is_empty() {
        let (distances, unknown): (Vec<f32>, Vec<bool>) = library.expected.gate.iter().copied().unzip();
        text += &table("uint32_t", "expected_distance", &bits(&distances));
        text +=
            &table("uint32_t", "expected_unknown", &unknown.into_iter().map(u32::from).collect::<Vec<_>>());
    }
    if !library.expected.readings.is_empty() {
        let (distances, unknown): (Vec<f32>, Vec<bool>) = library.expected.readings.iter().copied().unzip();
        let unknown: Vec<u32> = unknown.into_iter().map(u32::from).collect();
        text += &table("uint32_t", "expected_far", &bits(&distances));
        text += &table("uint32_t", "expected_strange", &unknown);
    }
    if library.answers.has_intervals() {
        let [low, high] = &library.expected.ends;
        text += &table("uint32_t", "expected_low", &bits(low));
        text += &table("uint32_t", "expected_high", &bits(high));
    }
    text
}

/// Returns a digest of every filter: of all thresholds of its bytes, or of floats for sums all over the range.
fn sums(
    layer: &Layer,
    factors: &[f32],
    reach: i32,
    addend: Option<(f32, f32)>,
    ending: &Ending,
    then: Option<Then>,
) -> Vec<u32> {
    let one = |factor: &f32| {
        let mut digest = Digest::new();
        let value = |sum, byte| steps(sum, *factor, addend.map(|(zero, factor)| (byte, zero, factor)));
        if layer.to.scale.is_some() {
            let last = if addend.is_some() { 255 } else { 0 };
            for added in 0..=last {
                add_thresholds(&mut digest, reach, |sum| match then {
                    None => byte(value(sum, added), ending),
                    Some(then) => {
                        byte(ended(value(sum, added), ending) * then.factor + then.shift, &then.ending)
                    }
                });
            }
        } else {
            for i in -512..=512i32 {
                let added = (i & 127) as u8 + 128;
                digest.word(ended(value(reach / 512 * i, added), ending).to_bits());
            }
        }
        digest.0
    };
    factors.iter().map(one).collect()
}

/// Returns a digest of all thresholds of each row of the input that has numbers of its own; none where it is taken as floats.
fn staged(stage: &Stage, encoding: &Encoding) -> Option<Vec<u32>> {
    let (factors, shifts) = stage.scales.as_ref()?;
    let one = |row: usize| {
        let mut digest = Digest::new();
        add_thresholds(&mut digest, LARGEST, |place| {
            let x = encoding.scaled(row, ordered(place));
            byte(x * factors[row] + shifts[row], &stage.ending)
        });
        digest.0
    };
    Some((0..different_rows(stage, encoding)).map(one).collect())
}

fn maps(layer: &Layer, factors: &[f32], shifts: &[f32], ending: &Ending) -> Vec<u32> {
    let one = |(factor, shift): (&f32, &f32)| {
        let mut digest = Digest::new();
        let value = |x: f32| x * factor + shift;
        if layer.from[0].scale.is_none() && layer.to.scale.is_some() && *factor > 0.0 {
            add_thresholds(&mut digest, LARGEST, |place| byte(value(ordered(place)), ending));
        } else {
            (0..=255u8).for_each(|x| digest.word(stored(layer, value(f32::from(x)), ending)));
        }
        digest.0
    };
    factors.iter().zip(shifts).map(one).collect()
}

/// Returns a digest of each mean that has numbers of its own: of one row of outputs where all rows have the same.
fn all_means(layer: &Layer, windows: &Windows, scales: &[(f32, f32)], ending: &Ending) -> Vec<u32> {
    let stored = rows::tables(scales, &layer.to);
    let one = |(at, scale): (usize, &(f32, f32))| {
        let (row, column) = (at / layer.to.positions, at % layer.to.positions);
        let [lines, columns] = [windows.rows[row], windows.columns[column]].map(|[from, to]| to - from);
        means(layer, lines * columns, *scale, ending)
    };
    stored.iter().enumerate().map(one).collect()
}

fn means(layer: &Layer, inside: usize, (factor, shift): (f32, f32), ending: &Ending) -> u32 {
    let mut digest = Digest::new();
    (0..=255 * inside).for_each(|sum| digest.word(stored(layer, sum as f32 * factor + shift, ending)));
    digest.0
}

fn pairs(layer: &Layer, [of_a, of_b]: [f32; 2], shift: f32, ending: &Ending) -> u32 {
    let mut digest = Digest::new();
    for a in 0..=255u8 {
        for b in 0..=255u8 {
            let value = f32::from(a) * of_a + f32::from(b) * of_b + shift;
            digest.word(stored(layer, value, ending));
        }
    }
    digest.0
}

/// Returns the byte or the bits of the float that a layer stores.
fn stored(layer: &Layer, value: f32, ending: &Ending) -> u32 {
    match layer.to.scale {
        Some(_) => u32::from(byte(value, ending)),
        None => ended(value, ending).to_bits(),
    }
}
