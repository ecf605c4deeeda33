//! The folder of C: its files, and how much memory the code needs.

use crate::answers::{Answers, ReadingsGate};
use crate::body::Body;
use crate::check::Check;
use crate::cores::Core;
use crate::error::{Error, Result};
use crate::layouts::layouts;
use crate::library::{CFile, Library, Method};
use crate::size::Size;
use crate::source::address;

impl Library<'_> {
    /// Returns how much memory the code needs.
    ///
    /// # Errors
    /// [`Error::Refused`] for a network that has no C of the same bits.
    pub fn size(&self) -> Result<Size> {
        Ok(self.measured(&self.plan()?))
    }

    /// Returns about how many instructions one prediction takes on a core, from raw values to answers; none of MiniRocket and
    /// ridge, which were not counted. Instructions are not cycles.
    ///
    /// # Errors
    /// As [`Library::size`].
    pub fn instructions(&self, core: Core) -> Result<Option<usize>> {
        Ok(self.plan()?.counts.map(|counts| core.instructions(&counts)))
    }

    /// Refuses cores that the C does not compile for: networks in 32-bit floats need an FPU.
    ///
    /// # Errors
    /// [`Error::Refused`] with the number of instructions, and as [`Library::size`].
    pub fn check_core(&self, core: Core) -> Result<()> {
        let body = self.plan()?;
        if !body.needs_fpu || core.has_floats() {
            return Ok(());
        }
        let reason = format!(
            "is in 32-bit floats, and {core} has no FPU: about {:.0} instructions a product would be needed, {} for one prediction; \
             `taxel quantize` makes a network in eight bits of it",
            core.float_product(),
            body.counts.map_or(0, |counts| core.instructions(&counts))
        );
        Err(Error::Refused { model: self.model.clone(), reason })
    }

    /// Returns about how many bytes of flash it takes on a core; on one without floats in hardware the compiler's float
    /// routines come on top.
    ///
    /// # Errors
    /// As [`Library::size`].
    pub fn flash(&self, core: Core) -> Result<usize> {
        let body = self.plan()?;
        let Size { tables, flash, .. } = self.measured(&body);
        Ok(core.flash(tables, flash - tables, body.whole_bytes))
    }

    /// Returns all files; equal libraries give equal files.
    ///
    /// # Errors
    /// As [`Library::size`].
    pub fn files(&self) -> Result<Vec<CFile>> {
        let body = self.plan()?;
        let (name, size) = (self.identifier(), self.measured(&body));
        let check = Check::new(self, &body.layers);
        let guard = "/* What `taxel predict` computes: written by taxel, read by check.c. */\n";
        let test = self.filled(
            include_str!("c/check/main.c"),
            &size,
            &[
                (
                    "@digest@",
                    if check.calls.is_empty() { "" } else { include_str!("c/check/digest.c") }.into(),
                ),
                ("@check_samples@", self.answers.check(!self.expected.readings.is_empty())),
                ("@checks@", check.checks.replace("@NAME@", &name.to_uppercase())),
                ("@check_calls@", check.calls),
            ],
        );
        let mut files = vec![
            CFile { path: format!("src/taxel_{name}.h"), text: self.header(&size, body.needs_fpu) },
            CFile { path: format!("src/taxel_{name}.c"), text: self.source(&body, &size) },
            CFile { path: "test/check.c".into(), text: test },
            CFile { path: "test/vectors.h".into(), text: format!("{guard}{}", check.vectors) },
        ];
        files.extend(layouts(self, &size));
        files.sort_by(|a, b| a.path.cmp(&b.path));
        Ok(files)
    }

    fn plan(&self) -> Result<Body> {
        let refuse = |reason| Error::Refused { model: self.model.clone(), reason };
        self.encoding.check(self.sample).map_err(refuse)?;
        let body = match &self.method {
            Method::Network(blueprint) => Body::network(blueprint, &self.encoding, self.sample),
            Method::Linear(linear) => linear.body(self.encoding.shape(self.sample)),
        };
        let body = body.map_err(refuse)?;
        let (words, wanted) = (self.answers.words(), self.answers.outputs());
        if body.outputs != wanted {
            return Err(refuse(format!("it has {} outputs, and {words} need {wanted}", body.outputs)));
        }
        Ok(body)
    }

    fn measured(&self, body: &Body) -> Size {
        let Library { encoding, answers, sample, readings, .. } = self;
        let of_readings = readings.as_ref().map_or([0; 2], |gate| [gate.table_bytes(), gate.code_bytes()]);
        let tables = body.table_bytes + answers.table_bytes() + encoding.table_bytes() + of_readings[0];
        let code = body.code_bytes + answers.code_bytes() + encoding.code_bytes() + of_readings[1];
        Size {
            tables,
            flash: tables + code,
            ram: body.arena,
            ring: if self.image.is_some() {
                0
            } else {
                encoding.ring_steps(sample[1]) * sample[0] * encoding.kept_bytes(&body.stage)
            },
            macs: body.macs,
        }
    }

    fn header(&self, size: &Size, needs_fpu: bool) -> String {
        let fpu = if needs_fpu { include_str!("c/float32/library.h") } else { "" };
        let readings = self.readings.as_ref().map_or("", |_| include_str!("c/answers/readings.h"));
        let more = [("@api@", self.answers.header() + readings), ("@fpu@", fpu.into())];
        self.filled(include_str!("c/library.h"), size, &more)
    }

    fn source(&self, body: &Body, size: &Size) -> String {
        let stage = &body.stage;
        let mut helpers = self.answers.helpers();
        if self.readings.is_some() {
            // What the gate of readings computes with, unless it stands there already.
            for (function, text) in
                [("float logarithm(", Answers::logarithm()), ("float root(", include_str!("c/root.c").into())]
            {
                if !helpers.contains(function) && !body.kernels.contains(function) {
                    helpers += &text;
                }
            }
        }
        let of_readings = self.readings.as_ref().map_or(String::new(), ReadingsGate::text);
        let reading = if stage.scales.is_some() { "int8_t" } else { "float" };
        self.filled(
            include_str!("c/library.c"),
            size,
            &[
                ("@kernels@", format!("{}\n{helpers}", body.kernels)),
                ("@tables@", body.tables.clone()),
                ("@calls@", body.calls.clone()),
                ("@answers@", self.answers.source() + &of_readings),
                ("@encoding@", self.encoding.text(stage, self.sample)),
                ("@reading@", reading.into()),
                ("@stage_to@", body.stage_at.to_string()),
                ("@stage_margins@", body.stage_margins.clone()),
                ("@by_channel@", stage.by_channel.to_string()),
                ("@by_step@", stage.by_step.to_string()),
                ("@logits@", address("const int8_t", body.outputs_at)),
                ("@arena@", body.arena.to_string()),
            ],
        )
    }
}
