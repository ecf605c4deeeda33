//! The C of a network: tables, kernels that it needs, and one call per layer.

use std::collections::BTreeSet;
use std::fmt::Write;

use taxel_kernels::frozen::bytes::Ending;

use crate::arena::{Arena, element, offset};
use crate::floats::source::FloatSource;
use crate::kernel::Kernel;
use crate::layer::{Conv, Depthwise, Gaps, Layer, Memory, RowNumber, Span, Statistic, Then, Windows, Work};
use crate::literals::{float, floats, numbers, table};
use crate::lower::Network;
use crate::row_text::Lines;
use crate::rows;
use crate::whole::Whole;

/// The layers of a network as C.
#[derive(Debug, Default)]
pub(crate) struct Source {
    /// Kernels that are called.
    pub kernels: BTreeSet<Kernel>,
    /// Constant tables and descriptions of layers.
    pub tables: String,
    /// Statements that run the network behind its input.
    pub calls: String,
    /// Bytes of the tables, and of those that only processors without floats in hardware need.
    pub table_bytes: usize,
    pub whole_bytes: usize,
    lines: Lines,
}

impl Source {
    /// Writes all layers but the input.
    pub fn new(network: &Network, arena: &Arena) -> Self {
        let mut source = Source { lines: Lines::of(&network.layers), ..Source::default() };
        if network.layers.iter().flat_map(Layer::rows).any(|row| network.memories[row.memory].gaps.count > 0)
        {
            source.kernels.insert(Kernel::Fill);
        }
        let mut begun = BTreeSet::new();
        for (number, layer) in network.layers.iter().enumerate() {
            if begun.insert(layer.to.memory) && !matches!(layer.work, Work::Stage(_)) {
                source.calls += &margins(network, arena, layer.to.memory);
            }
            source.layer(number, layer, arena);
        }
        source
    }

    fn layer(&mut self, number: usize, layer: &Layer, arena: &Arena) {
        match &layer.work {
            Work::Stage(_) => {}
            Work::Conv(conv) => self.conv(number, layer, conv, arena),
            Work::Depthwise(conv) => self.depthwise(number, layer, conv, arena),
            Work::Map { factors, shifts, ending } => {
                self.map(number, layer, [factors, shifts], ending, arena)
            }
            Work::Copy => {
                let sizes = [layer.to.channels * element(&layer.to), layer.to.positions];
                self.moved(Kernel::Copy, "copy", layer, arena, &sizes);
            }
            Work::Add { factors, shift, ending } => {
                let numbers = [factors[0], factors[1], *shift].map(float).join(", ");
                let (before, makes) =
                    (format!("{numbers}, {}", end(ending)), u8::from(layer.to.scale.is_some()));
                let fields = format!("{before}, {}, {makes}", pair(layer, arena));
                self.described(number, layer, Kernel::Add, "add", &fields, 48);
            }
            Work::AddFloats(ending) => {
                let bounds = [ending.low, ending.high].map(float).join(", ");
                let fields = format!("{bounds}, {}", pair(layer, arena));
                self.described(number, layer, Kernel::AddFloats, "add_floats", &fields, 32);
            }
            Work::Most(_) | Work::Mean { .. } | Work::MeanFloats { .. } => self.pool(number, layer, arena),
            Work::Deviation { share, eps } => {
                let (from, to) = (&layer.from[0], &layer.to);
                let places =
                    [offset(from, arena), offset(to, arena), to.channels, from.positions, from.pitch];
                let fields = format!("{}, {}, {}", float(*share), float(*eps), numbers(&places));
                self.kernels.insert(Kernel::Root);
                self.described(number, layer, Kernel::Deviation, "deviation", &fields, 24);
            }
            Work::Shuffle(groups) => {
                let sizes = [layer.to.channels, *groups, layer.to.positions];
                self.moved(Kernel::Shuffle, "shuffle", layer, arena, &sizes);
            }
            Work::Flatten => {
                let (from, to) = (&layer.from[0], &layer.to);
                let places =
                    [offset(from, arena), from.pitch, offset(to, arena), from.channels, from.positions];
                self.kernels.insert(Kernel::Flatten);
                let places: Vec<String> = places.iter().map(|place| format!("{place}u")).collect();
                let _ = writeln!(self.calls, "    flatten(arena, {});", places.join(", "));
            }
            Work::Floats(work) => {
                let FloatSource { kernels, function, tables, table_bytes, fields } =
                    FloatSource::new(number, layer, work, arena);
                self.tables += &tables;
                self.kernels.extend(&kernels);
                if work.is_fused() {
                    self.kernels.insert(Kernel::Fused);
                }
                if let Some(&kernel) = kernels.last() {
                    self.described(number, layer, kernel, function, &fields, table_bytes);
                }
            }
        }
    }

    /// Adds the call of a kernel that moves rows and has no description; of each row of an image.
    fn moved(&mut self, kernel: Kernel, name: &str, layer: &Layer, arena: &Arena, sizes: &[usize]) {
        self.kernels.insert(kernel);
        let (from, to) = (&layer.from[0], &layer.to);
        for row in 0..to.rows {
            let each = element(to);
            let [x, y] = [from, to].map(|one| offset(one, arena) + row * one.row_pitch * each);
            let places = [&[x, from.pitch * each, y, to.pitch * each][..], sizes].concat();
            let places: Vec<String> = places.iter().map(|place| format!("{place}u")).collect();
            let _ = writeln!(self.calls, "    {name}(arena, {});", places.join(", "));
        }
    }

    fn map(
        &mut self,
        number: usize,
        layer: &Layer,
        [factors, shifts]: [&[f32]; 2],
        ending: &Ending,
        arena: &Arena,
    ) {
        let tables =
            [self.floats(number, "factor", factors), self.floats(number, "shift", shifts)].join(", ");
        let (from, to) = (&layer.from[0], &layer.to);
        let places =
            [offset(from, arena), offset(to, arena), to.channels, to.positions, from.pitch, to.pitch];
        let kinds = [from, to].map(|row| usize::from(row.scale.is_some()));
        let fields = format!("{tables}, {}, {}, {}", end(ending), numbers(&places), numbers(&kinds));
        self.described(number, layer, Kernel::Map, "map", &fields, 40);
    }

    /// Adds the description of a layer, of about so many bytes, and its call.
    fn described(
        &mut self,
        number: usize,
        layer: &Layer,
        kernel: Kernel,
        name: &str,
        fields: &str,
        bytes: usize,
    ) {
        self.kernels.insert(kernel);
        let kind = if matches!(kernel, Kernel::Most | Kernel::MostFloats | Kernel::Mean | Kernel::MeanFloats)
        {
            self.kernels.insert(Kernel::Pool);
            "pool"
        } else {
            name
        };
        let title = crate::literals::comment(&layer.name);
        let _ = writeln!(
            self.tables,
            "/* {title} */\nstatic const {kind}_layer layer_{number} = {{\n    {fields}\n}};\n"
        );
        let (call, by_rows) = rows::call(name, layer, kernel, &format!("&layer_{number}"));
        self.kernels.extend(by_rows);
        let _ = writeln!(self.calls, "    {call}; /* {title} */");
        self.table_bytes += bytes;
    }

    /// Adds a table of floats; the name of it comes back.
    fn floats(&mut self, number: usize, what: &str, values: &[f32]) -> String {
        let name = format!("{what}_{number}");
        self.tables += &floats(&name, values);
        self.table_bytes += size_of_val(values);
        name
    }

    fn sums(&mut self, number: usize, weight: &[i8], start: &[i32], factor: &[f32]) {
        self.tables += &table("int8_t", &format!("weight_{number}"), weight);
        self.tables += &table("int32_t", &format!("start_{number}"), start);
        self.table_bytes += weight.len().next_multiple_of(4) + size_of_val(start);
        self.floats(number, "factor", factor);
    }

    fn conv(&mut self, number: usize, layer: &Layer, conv: &Conv, arena: &Arena) {
        self.sums(number, &conv.weight, &conv.start, &conv.factor);
        let to = &layer.to;
        let base = offset(&layer.from[0], arena) - layer.from[0].start;
        let (of_zero, factor) =
            conv.addend.map_or((0, 0.0), |addend| (128 - i32::from(addend.zero), addend.factor));
        let added = layer.from.get(1).map_or((0, 0), |row| (offset(row, arena), row.pitch));
        let whole = Whole::new(conv);
        let multipliers = self.multipliers(number, whole.as_ref());
        let then = conv.then.map_or("NULL".into(), |Then { factor, shift, ending }| {
            let Ending { zero, low, high } = ending;
            self.floats(number, "then", &[factor, shift, zero, low, high])
        });
        let statistics = self.statistics(number, conv, arena);
        let fields = format!(
            "weight_{number}, start_{number}, factor_{number}, {multipliers}, {then}, {statistics},\n    \
             {}, {}, {}, {}, {}, {}, {},\n    {}, {}, {}, {}, {}, {}, {}, {}, {}, {}",
            float(factor),
            end(&conv.ending),
            of_zero,
            format_args!(
                "{}, {}",
                whole.as_ref().map_or(0, |whole| whole.addend),
                whole.as_ref().map_or(0, |whole| whole.base)
            ),
            base + conv.first,
            offset(to, arena),
            added.0,
            conv.step,
            conv.segments,
            conv.apart,
            conv.fours,
            conv.groups,
            conv.channels,
            conv.factor.len(),
            to.positions,
            to.pitch,
            format_args!(
                "{}, {}, {}, {}",
                added.1,
                whole.as_ref().map_or(0, |whole| whole.shift),
                u8::from(conv.addend.is_some()),
                u8::from(to.scale.is_some())
            ),
        );
        self.described(number, layer, Kernel::Conv, "conv", &fields, 88);
    }

    /// Adds the multipliers of whole numbers, for processors that use them; their name comes back.
    fn multipliers(&mut self, number: usize, whole: Option<&Whole>) -> String {
        let Some(whole) = whole else { return "NULL".into() };
        let name = format!("multiplier_{number}");
        self.whole_bytes += size_of_val(whole.multipliers.as_slice());
        let values = table("int32_t", &name, &whole.multipliers);
        let _ = write!(self.tables, "#ifdef WHOLE_ENDINGS\n{values}#endif\n");
        format!("OF_WHOLE({name})")
    }

    /// Adds what becomes of each filter's row; its address comes back.
    fn statistics(&mut self, number: usize, conv: &Conv, arena: &Arena) -> String {
        if conv.statistics.is_empty() {
            return "NULL".into();
        }
        let one = |statistic: &Statistic| {
            let (kind, share, eps) = match statistic.number {
                RowNumber::Mean { share } => (0, share, 0.0),
                RowNumber::Most => (1, 0.0, 0.0),
                RowNumber::Deviation { share, eps } => {
                    self.kernels.insert(Kernel::Root);
                    (2, share, eps)
                }
            };
            format!("{{{}, {}, {}, {kind}}}", float(share), float(eps), offset(&statistic.to, arena))
        };
        let rows: Vec<String> = conv.statistics.iter().map(one).collect();
        self.table_bytes += 16 * rows.len() + 8;
        self.tables += &table("statistic", &format!("numbers_{number}"), &rows);
        let list =
            format!("static const statistic_list list_{number} = {{numbers_{number}, {}}};\n", rows.len());
        self.tables += &list;
        format!("&list_{number}")
    }

    fn depthwise(&mut self, number: usize, layer: &Layer, conv: &Depthwise, arena: &Arena) {
        self.sums(number, &conv.weight, &conv.start, &conv.factor);
        let to = &layer.to;
        let fields = format!(
            "weight_{number}, start_{number}, factor_{number}, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}",
            end(&conv.ending),
            offset(&layer.from[0], arena) - layer.from[0].start + conv.first,
            offset(to, arena),
            conv.step,
            conv.taps,
            conv.apart,
            to.channels,
            to.positions,
            to.pitch,
            u8::from(to.scale.is_some())
        );
        let gap = conv.line_apart as i64 - (conv.taps * conv.apart) as i64;
        let lines = if self.lines.depthwise { format!(", {}, {gap}", conv.lines) } else { String::new() };
        self.described(number, layer, Kernel::Depthwise, "depthwise", &(fields + &lines), 48);
    }

    fn pool(&mut self, number: usize, layer: &Layer, arena: &Arena) {
        let (from, to) = (&layer.from[0], &layer.to);
        let is_bytes = from.scale.is_some();
        let mut tables = vec!["NULL".to_string(); 2];
        let mut of_row = 0;
        let plain = Ending { zero: 0.0, low: f32::NEG_INFINITY, high: f32::INFINITY };
        let (windows, ending, kernel, name) = match &layer.work {
            Work::Mean { windows, scales, ending } => {
                let scales = rows::tables(scales, to);
                of_row = if scales.len() > to.positions { to.positions } else { 0 };
                let (factors, shifts): (Vec<f32>, Vec<f32>) = scales.iter().copied().unzip();
                tables = vec![self.floats(number, "factor", &factors), self.floats(number, "shift", &shifts)];
                (windows, *ending, Kernel::Mean, "mean")
            }
            Work::MeanFloats { windows, shares } => {
                let shares = rows::tables(shares, to);
                of_row = if shares.len() > to.positions { to.positions } else { 0 };
                tables[0] = self.floats(number, "factor", shares);
                (windows, plain, Kernel::MeanFloats, "mean_floats")
            }
            Work::Most(windows) if is_bytes => (windows, plain, Kernel::Most, "most"),
            Work::Most(windows) => (windows, plain, Kernel::MostFloats, "most_floats"),
            _ => unreachable!("only poolings have windows"),
        };
        self.spans(&format!("spans_{number}"), &windows.columns);
        let (first, more) = self.rows_of_windows(number, layer, windows, of_row);
        let fields = format!(
            "spans_{number}, {}, {}, {}, {}, {}, {}, {}, {}, {}{more}",
            tables.join(", "),
            end(&ending),
            offset(from, arena) + first,
            offset(to, arena),
            to.channels,
            to.positions,
            from.pitch,
            to.pitch,
            u8::from(to.scale.is_some())
        );
        self.described(number, layer, kernel, name, &fields, 44);
    }

    /// Adds a table of windows.
    fn spans(&mut self, name: &str, spans: &[Span]) {
        let pairs: Vec<String> = spans.iter().map(|[from, to]| format!("{{{from}, {to}}}")).collect();
        self.tables += &table("span", name, &pairs);
        self.table_bytes += 4 * spans.len();
    }

    /// Adds the rows of the windows of an image. What comes back: how many bytes the first window begins behind the input, and the
    /// fields of the description. `tables` is the number of factors from one row of outputs to the next.
    fn rows_of_windows(
        &mut self,
        number: usize,
        layer: &Layer,
        windows: &Windows,
        tables: usize,
    ) -> (usize, String) {
        if !self.lines.pool {
            return (0, String::new());
        }
        let (from, to) = (&layer.from[0], &layer.to);
        let of_bytes = [from, to].map(|row| row.row_pitch * element(row));
        let (first, name) = if to.rows > 1 {
            let name = format!("rows_{number}");
            self.spans(&name, &windows.rows);
            (0, name)
        } else {
            (windows.rows[0][0] * of_bytes[0], "NULL".into())
        };
        self.table_bytes += 28;
        let lines = windows.rows[0][1] - windows.rows[0][0];
        let places = numbers(&[to.rows, lines, from.row_pitch, of_bytes[0], of_bytes[1], tables]);
        (first, format!(",\n    {name}, {places}"))
    }
}

/// Writes the places of two addends and of their sum.
fn pair(layer: &Layer, arena: &Arena) -> String {
    let [a, b, to] = [&layer.from[0], &layer.from[1], &layer.to];
    let places = [offset(a, arena), offset(b, arena), offset(to, arena)];
    numbers(&[&places[..], &[to.channels, to.positions, a.pitch, b.pitch, to.pitch]].concat())
}

/// Returns zero and bounds of an ending.
fn end(ending: &Ending) -> String {
    [ending.zero, ending.low, ending.high].map(float).join(", ")
}

/// Writes the address of a byte of the arena.
pub(crate) fn address(kind: &str, at: usize) -> String {
    if at == 0 { "arena".into() } else { format!("({kind} *)arena + {at}") }
}

/// Returns the statements that fill the margins of a memory.
pub(crate) fn margins(network: &Network, arena: &Arena, memory: usize) -> String {
    let Memory { margins, gaps, zero, len } = network.memories[memory];
    let (each, zero) = zero.map_or((size_of::<f32>(), 0), |zero| (1, i32::from(zero) - 128));
    let base = arena.offsets[memory].unwrap_or(0);
    let ends = [base, base + (len - margins[1]) * each];
    let mut calls = String::new();
    for (at, len) in ends.into_iter().zip(margins).filter(|(_, len)| *len > 0) {
        let _ = writeln!(calls, "    (void)memset({}, {zero}, {}u);", address("int8_t", at), len * each);
    }
    let Gaps { len: gap, apart, count } = gaps;
    if count > 0 {
        let first = base + (margins[0] + apart - gap) * each;
        let at = format!("(int8_t *)arena + {first}");
        let _ = writeln!(calls, "    fill({at}, {zero}, {}u, {}u, {count}u);", gap * each, apart * each);
    }
    calls
}
