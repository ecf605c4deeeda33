//! Every operation of a graph as ONNX nodes.

use taxel_graph::{Activation, Node, Op, Tensor, Weights, Window};

use super::sink::{Sink, float, int, ints, sizes};
use crate::error::Cause;
use crate::proto::Attribute;

/// One node of the graph with what its ONNX nodes need.
pub struct Emit<'a> {
    pub sink: &'a mut Sink,
    pub node: &'a Node,
    /// Name of its first input's value.
    pub x: &'a str,
    /// Names of all its inputs' values, and their shapes, batch axis left out.
    pub inputs: Vec<(&'a str, &'a [usize])>,
    /// Name of the value that comes out.
    pub output: &'a str,
    pub weights: &'a Weights,
}

impl Emit<'_> {
    /// Writes the nodes.
    ///
    /// # Errors
    /// A tensor that is missing.
    pub fn emit(mut self) -> Result<(), Cause> {
        match &self.node.op {
            // Its value is the model's input.
            Op::Input => {}
            Op::Conv { window, dilation, groups, bias, .. } => self.conv(window, dilation, *groups, *bias)?,
            Op::BatchNorm { eps, momentum } => self.batch_norm(*eps, *momentum)?,
            Op::LayerNorm { eps } => {
                let tensors = self.stored(2)?;
                let tensors: Vec<&str> = tensors.iter().map(String::as_str).collect();
                self.last("LayerNormalization", &tensors, vec![int("axis", 1), float("epsilon", *eps)]);
            }
            Op::Relu => self.last("Relu", &[], vec![]),
            Op::Activation(activation) => self.activation(*activation),
            Op::Dropout { probability } => {
                let ratio = self.sink.floats(&self.base("ratio"), &[], &[*probability]);
                self.last("Dropout", &[&ratio], vec![]);
            }
            Op::MaxPool(window) => self.last("MaxPool", &[], windowed(window)),
            Op::AveragePool { window, counted } => self.average_pool(window, counted),
            Op::GlobalAveragePool => {
                let mean = self.step("GlobalAveragePool", &[self.x], "mean", vec![]);
                self.end("Flatten", &[&mean], vec![int("axis", 1)]);
            }
            Op::GlobalStandardDeviation { eps } => self.deviation(*eps),
            Op::AdaptiveAveragePool { output } => self.adaptive_average_pool(output),
            Op::Flatten => self.last("Flatten", &[], vec![int("axis", 1)]),
            Op::Linear { bias, .. } => {
                let tensors = self.stored(if *bias { 2 } else { 1 })?;
                let tensors: Vec<&str> = tensors.iter().map(String::as_str).collect();
                self.last("Gemm", &tensors, vec![int("transB", 1)]);
            }
            Op::Lstm { hidden, .. } => self.lstm(*hidden)?,
            Op::Gru { hidden, .. } => self.gru(*hidden)?,
            Op::Scale => {
                let tensors = self.stored(1)?;
                self.last("Mul", &[&tensors[0]], vec![]);
            }
            Op::ChannelShuffle { groups } => self.channel_shuffle(*groups),
            Op::Slice { start, len } => {
                let [start, end, axis] = [*start, start + len, 1]
                    .map(|number| self.sink.ints(&self.base("bounds"), &[number as i64]));
                self.last("Slice", &[&start, &end, &axis], vec![]);
            }
            Op::Standardize { mean, std } => self.standardize(mean, std)?,
            Op::SwitchScale => self.switch_scale(),
            Op::Add => self.joined("Add", vec![]),
            Op::Concat => self.joined("Concat", vec![int("axis", 1)]),
        }
        Ok(())
    }

    pub(super) fn base(&self, part: &str) -> String {
        format!("{}/{part}", self.output)
    }

    /// Adds a node on the way to the output.
    pub(super) fn step(
        &mut self,
        op: &str,
        inputs: &[&str],
        part: &str,
        attributes: Vec<Attribute>,
    ) -> String {
        let base = self.base(part);
        self.sink.step(op, inputs, &base, attributes)
    }

    /// Adds the node that gives the output.
    pub(super) fn end(&mut self, op: &str, inputs: &[&str], attributes: Vec<Attribute>) {
        self.sink.put(op, inputs, self.output, attributes);
    }

    /// Adds the only node, on the first input and `more`.
    fn last(&mut self, op: &str, more: &[&str], attributes: Vec<Attribute>) {
        self.end(op, &[&[self.x], more].concat(), attributes);
    }

    /// Adds the only node, on all inputs.
    fn joined(&mut self, op: &str, attributes: Vec<Attribute>) {
        let inputs: Vec<&str> = self.inputs.iter().map(|(name, _)| *name).collect();
        self.sink.put(op, &inputs, self.output, attributes);
    }

    /// Returns the tensor of parameter `at`.
    pub(super) fn tensor(&self, at: usize) -> Result<&Tensor, Cause> {
        let found = self.node.params.get(at).and_then(|param| self.weights.get(&param.name));
        found.ok_or_else(|| {
            let name = self.node.params.get(at).map_or_else(String::new, |param| param.name.clone());
            Cause::Tensor { name, reason: "is not among the weights".into() }
        })
    }

    /// Stores the first `count` tensors as they are, under their names.
    fn stored(&mut self, count: usize) -> Result<Vec<String>, Cause> {
        let mut names = vec![];
        for at in 0..count {
            let tensor = self.tensor(at)?.clone();
            let name = self.node.params[at].name.clone();
            self.sink.store(&name, &tensor.shape, &tensor.data);
            names.push(name);
        }
        Ok(names)
    }

    fn conv(&mut self, window: &Window, dilation: &[usize], groups: usize, bias: bool) -> Result<(), Cause> {
        let tensors = self.stored(if bias { 2 } else { 1 })?;
        let tensors: Vec<&str> = tensors.iter().map(String::as_str).collect();
        let mut attributes = windowed(window);
        if !dilation.is_empty() {
            attributes.push(ints("dilations", sizes(dilation)));
        }
        attributes.push(int("group", groups as i64));
        self.last("Conv", &tensors, attributes);
        Ok(())
    }

    fn batch_norm(&mut self, eps: f32, momentum: f32) -> Result<(), Cause> {
        let tensors = self.stored(4)?;
        let tensors: Vec<&str> = tensors.iter().map(String::as_str).collect();
        // ONNX weighs what was, PyTorch what is new.
        let attributes = vec![float("epsilon", eps), float("momentum", 1.0 - momentum)];
        self.last("BatchNormalization", &tensors, attributes);
        Ok(())
    }

    fn activation(&mut self, activation: Activation) {
        match activation {
            Activation::Relu6 => {
                let [low, high] = [0.0, 6.0].map(|end| self.sink.floats(&self.base("end"), &[], &[end]));
                self.last("Clip", &[&low, &high], vec![]);
            }
            Activation::LeakyRelu { slope } => self.last("LeakyRelu", &[], vec![float("alpha", slope)]),
            Activation::Sigmoid => self.last("Sigmoid", &[], vec![]),
            Activation::Tanh => self.last("Tanh", &[], vec![]),
            Activation::HardSwish => self.last("HardSwish", &[], vec![]),
        }
    }

    /// Writes an average pool. ONNX counts all padding or none: where a part is counted, that part becomes zeros first.
    fn average_pool(&mut self, window: &Window, counted: &[(usize, usize)]) {
        let mut window = window.clone();
        let all = window.padding == *counted;
        let mut x = self.x.to_string();
        if !all && counted.iter().any(|pad| *pad != (0, 0)) {
            let pads = [&[(0, 0); 2], counted].concat();
            let pads = self.sink.ints(&self.base("pads"), &ends(&pads));
            x = self.step("Pad", &[self.x, &pads], "padded", vec![]);
            for (padding, counted) in window.padding.iter_mut().zip(counted) {
                *padding = (padding.0 - counted.0, padding.1 - counted.1);
            }
        }
        let mut attributes = windowed(&window);
        attributes.push(int("count_include_pad", i64::from(all)));
        self.end("AveragePool", &[&x], attributes);
    }

    fn deviation(&mut self, eps: f32) {
        let axes: Vec<i64> = (2..=self.inputs[0].1.len() as i64).collect();
        let over = |keep: i64| vec![ints("axes", axes.clone()), int("keepdims", keep)];
        let mean = self.step("ReduceMean", &[self.x], "mean", over(1));
        let centred = self.step("Sub", &[self.x, &mean], "centred", vec![]);
        let squared = self.step("Mul", &[&centred, &centred], "squared", vec![]);
        let variance = self.step("ReduceMean", &[&squared], "variance", over(0));
        let eps = self.sink.floats(&self.base("eps"), &[], &[eps]);
        let shifted = self.step("Add", &[&variance, &eps], "shifted", vec![]);
        self.end("Sqrt", &[&shifted], vec![]);
    }

    /// Writes a mean over parts. Parts of one size are a pool; others, along one axis after the other, a product with a
    /// matrix of shares.
    fn adaptive_average_pool(&mut self, output: &[usize]) {
        let size = self.inputs[0].1[1..].to_vec();
        if size == output {
            return self.last("Identity", &[], vec![]);
        }
        if size.iter().zip(output).all(|(size, parts)| size % parts == 0) {
            let kernel: Vec<usize> = size.iter().zip(output).map(|(size, parts)| size / parts).collect();
            let padding = vec![(0, 0); kernel.len()];
            let window = Window { stride: kernel.clone(), kernel, padding };
            return self.last("AveragePool", &[], windowed(&window));
        }
        let (mut x, axes) = (self.x.to_string(), size.len() + 2);
        for (at, (&size, &parts)) in size.iter().zip(output).enumerate() {
            if size == parts {
                continue;
            }
            // The axis in question goes last and back.
            let mut perm: Vec<i64> = (0..axes as i64).collect();
            perm.swap(at + 2, axes - 1);
            let turn = |emitter: &mut Self, x: &str, part| {
                if at + 3 == axes {
                    return x.to_string();
                }
                emitter.step("Transpose", &[x], part, vec![ints("perm", perm.clone())])
            };
            let turned = turn(self, &x, "turned");
            let shares = self.sink.floats(&self.base("shares"), &[size, parts], &shares(size, parts));
            let product = self.step("MatMul", &[&turned, &shares], "parts", vec![]);
            x = turn(self, &product, "back");
        }
        self.end("Identity", &[&x], vec![]);
    }

    fn channel_shuffle(&mut self, groups: usize) {
        let shape = self.inputs[0].1;
        let space = sizes(&shape[1..]);
        let split = [&[0, groups as i64, (shape[0] / groups) as i64], &space[..]].concat();
        let whole = [&[0, shape[0] as i64], &space[..]].concat();
        let perm = [&[0, 2, 1], &(3..split.len() as i64).collect::<Vec<_>>()[..]].concat();
        let (split, whole) =
            (self.sink.ints(&self.base("split"), &split), self.sink.ints(&self.base("whole"), &whole));
        let grouped = self.step("Reshape", &[self.x, &split], "grouped", vec![]);
        let dealt = self.step("Transpose", &[&grouped], "dealt", vec![ints("perm", perm)]);
        self.end("Reshape", &[&dealt, &whole], vec![]);
    }

    /// Writes a standardisation. One value per channel meets all positions: ONNX aligns axes at their ends.
    fn standardize(&mut self, mean: &str, std: &str) -> Result<(), Cause> {
        let channels = self.inputs[0].1[0];
        let shape = [&[channels], &vec![1; self.inputs[0].1.len() - 1][..]].concat();
        for (at, name) in [mean, std].into_iter().enumerate() {
            let data = self.tensor(at)?.data.clone();
            self.sink.store(name, &shape, &data);
        }
        let centred = self.step("Sub", &[self.x, mean], "centred", vec![]);
        self.end("Div", &[&centred, std], vec![]);
        Ok(())
    }

    fn switch_scale(&mut self) {
        let ((_, shape), (stream, streamed)) = (self.inputs[0], self.inputs[1]);
        let axes: Vec<i64> = (2..=streamed.len() as i64).collect();
        let over = || vec![ints("axes", axes.clone()), int("keepdims", 0)];
        let high = self.step("ReduceMax", &[stream], "high", over());
        let low = self.step("ReduceMin", &[stream], "low", over());
        let constant = self.step("Equal", &[&high, &low], "still", vec![]);
        let moves = self.step("Not", &[&constant], "moves", vec![]);
        let moves = self.step("Cast", &[&moves], "switches", vec![int("to", 1)]);
        let any = vec![ints("axes", vec![1]), int("keepdims", 1)];
        let mut switch = self.step("ReduceMax", &[&moves], "switch", any);
        if shape.len() > 1 {
            let axes = self.sink.ints(&self.base("axes"), &(2..=shape.len() as i64).collect::<Vec<_>>());
            switch = self.step("Unsqueeze", &[&switch, &axes], "spread", vec![]);
        }
        self.last("Mul", &[&switch], vec![]);
    }
}

/// Returns kernel, stride and padding as attributes.
fn windowed(window: &Window) -> Vec<Attribute> {
    vec![
        ints("kernel_shape", sizes(&window.kernel)),
        ints("strides", sizes(&window.stride)),
        ints("pads", ends(&window.padding)),
    ]
}

/// Lists all paddings before, then all after.
fn ends(padding: &[(usize, usize)]) -> Vec<i64> {
    let before = padding.iter().map(|pad| pad.0 as i64);
    before.chain(padding.iter().map(|pad| pad.1 as i64)).collect()
}

/// Computes `[size, parts]`: what each value counts in the mean of each part.
fn shares(size: usize, parts: usize) -> Vec<f32> {
    let mut shares = vec![0.0; size * parts];
    for part in 0..parts {
        let (from, to) = (part * size / parts, ((part + 1) * size).div_ceil(parts));
        (from..to).for_each(|at| shares[at * parts + part] = 1.0 / (to - from) as f32);
    }
    shares
}
