//! The folder of C: its files, and how much memory the code needs.

use std::fmt::Write;

use taxel_base::exponential::{EXP, LEAST, LN, LN_2};
use taxel_encodings::Scaling;

use crate::arena::Arena;
use crate::check::{Check, taken};
use crate::error::{Error, Result};
use crate::fuse::fuse;
use crate::layer::{Stage, Work};
use crate::layouts::layouts;
use crate::library::{CFile, Library};
use crate::literals::{float, text};
use crate::lower::{Network, lower};
use crate::size::Size;
use crate::source::{Source, element, margins, offset};

/// A network that has been planned.
struct Planned {
    network: Network,
    arena: Arena,
    source: Source,
    stage: Stage,
    size: Size,
}

impl Library<'_> {
    /// Returns how much memory the code needs.
    ///
    /// # Errors
    /// [`Error::Refused`] for a network that has no C of the same bits.
    pub fn size(&self) -> Result<Size> {
        Ok(self.plan()?.size)
    }

    /// Returns all files; equal libraries give equal files.
    ///
    /// # Errors
    /// As [`Library::size`].
    pub fn files(&self) -> Result<Vec<CFile>> {
        let planned = self.plan()?;
        let name = self.identifier();
        let check = Check::new(self, &planned.network);
        let guard = "/* What `taxel predict` computes: written by taxel, read by check.c. */\n";
        let test = self.filled(
            include_str!("c/check.c"),
            &planned.size,
            &[
                ("@checks@", check.checks.replace("@NAME@", &name.to_uppercase())),
                ("@check_calls@", check.calls),
            ],
        );
        let mut files = vec![
            CFile { path: format!("src/taxel_{name}.h"), text: self.header(&planned.size) },
            CFile { path: format!("src/taxel_{name}.c"), text: self.source(&planned) },
            CFile { path: "test/check.c".into(), text: test },
            CFile { path: "test/vectors.h".into(), text: format!("{guard}{}", check.vectors) },
        ];
        files.extend(layouts(self, &planned.size));
        files.sort_by(|a, b| a.path.cmp(&b.path));
        Ok(files)
    }

    fn plan(&self) -> Result<Planned> {
        let refuse = |reason| Error::Refused { model: self.model.clone(), reason };
        let network = fuse(lower(self.blueprint, self.sample).map_err(refuse)?);
        if network.logits.channels != self.classes.len() {
            let (logits, classes) = (network.logits.channels, self.classes.len());
            return Err(refuse(format!("it has {logits} logits for {classes} classes")));
        }
        let mut stages = network.layers.iter().filter_map(|layer| match &layer.work {
            Work::Stage(stage) => Some(stage.clone()),
            _ => None,
        });
        let Some(stage) = stages.next_back() else { return Err(refuse("it reads no sample".into())) };
        let arena = Arena::new(&network.layers, &network.memories, &network.logits);
        let source = Source::new(&network, &arena);
        let size = self.measured(&network, &arena, &source, &stage);
        Ok(Planned { network, arena, source, stage, size })
    }

    fn measured(&self, network: &Network, arena: &Arena, source: &Source, stage: &Stage) -> Size {
        let values = self.sample[0] * self.sample[1];
        let names: usize = self.classes.iter().map(|name| name.len() + 1 + 4).sum();
        let scaling = if let Scaling::ZScore { mean, .. } = self.scaling { 8 * mean.len() } else { 0 };
        let tables = source.table_bytes
            + names
            + scaling
            + size_of_val(&EXP)
            + self.temperature.map_or(0, |_| size_of_val(&LN));
        Size {
            tables,
            flash: tables + Size::code(&source.kernels, self.temperature.is_some()),
            ram: arena.len,
            ring: values * if stage.scales.is_some() { 1 } else { size_of::<f32>() },
            macs: network.layers.iter().map(|layer| layer.work.macs()).sum(),
        }
    }

    fn header(&self, size: &Size) -> String {
        self.filled(include_str!("c/library.h"), size, &[])
    }

    fn source(&self, planned: &Planned) -> String {
        let Planned { network, arena, source, stage, size } = planned;
        let full = if has_full_bytes(network) { "#define FULL_BYTES 1\n\n" } else { "" };
        let mut kernels = format!("{full}{}\n{}", include_str!("c/floats.c"), exponential(self.temperature));
        for kernel in &source.kernels {
            kernels += &format!("\n{}", kernel.text(network));
        }
        let classes = self.classes.iter().fold(String::new(), |mut all, name| {
            let _ = writeln!(all, "    {},", text(name));
            all
        });
        let staged = network.layers.iter().find(|layer| matches!(layer.work, Work::Stage(_)));
        let (to, stage_margins) = staged.map_or((0, String::new()), |layer| {
            let element = element(&layer.to);
            (offset(&layer.to, arena) / element, margins(network, arena, layer.to.memory))
        });
        let reading = if stage.scales.is_some() { "int8_t" } else { "float" };
        self.filled(
            include_str!("c/library.c"),
            size,
            &[
                ("@kernels@", kernels),
                ("@tables@", source.tables.clone()),
                ("@calls@", source.calls.clone()),
                ("@classes@", classes),
                ("@taken@", taken(stage, self.scaling)),
                ("@reading@", reading.into()),
                ("@stage_to@", to.to_string()),
                ("@stage_margins@", stage_margins),
                ("@by_channel@", stage.by_channel.to_string()),
                ("@by_step@", stage.by_step.to_string()),
                ("@logits@", offset(&network.logits, arena).to_string()),
                ("@arena@", arena.len.to_string()),
                (
                    "@temper@",
                    self.temperature.map_or("", |_| "    temper(row, TAXEL_@NAME@_CLASSES);\n").into(),
                ),
            ],
        )
    }
}

/// Checks whether all bytes may be 0 to 255: nothing is cut off before.
fn has_full_bytes(network: &Network) -> bool {
    network.layers.iter().filter(|layer| layer.to.scale.is_some()).all(|layer| match &layer.work {
        Work::Stage(Stage { ending, .. })
        | Work::Map { ending, .. }
        | Work::Add { ending, .. }
        | Work::Mean { ending, .. } => (ending.low, ending.high) == (0.0, 255.0),
        Work::Conv(conv) => {
            let ending = conv.then.map_or(conv.ending, |then| then.ending);
            (ending.low, ending.high) == (0.0, 255.0)
        }
        Work::Depthwise(conv) => (conv.ending.low, conv.ending.high) == (0.0, 255.0),
        _ => true,
    })
}

/// Writes softmax and temperature with their constants.
fn exponential(temperature: Option<f64>) -> String {
    let list = |values: &[f32]| values.iter().map(|value| float(*value)).collect::<Vec<_>>().join(", ");
    let mut text = include_str!("c/softmax.c").replace("EXP_COEFFICIENTS", &list(&EXP));
    if let Some(temperature) = temperature {
        let inverse = float((1.0 / temperature) as f32);
        text += &include_str!("c/temper.c")
            .replace("LN_COEFFICIENTS", &list(&LN))
            .replace("INVERSE_TEMPERATURE", &inverse);
    }
    text.replace("LN_2_HIGH", &float(LN_2[0]))
        .replace("LN_2_LOW", &float(LN_2[1]))
        .replace("LOG2_E", &float(std::f32::consts::LOG2_E))
        .replace("EXP_LEAST", &float(LEAST))
}
