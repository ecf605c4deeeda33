//! Which values become bytes: those that convolutions and linear layers read, and what goes the same way.

use taxel_kernels::Rectifier;
use taxel_kernels::frozen::Pooling;
use taxel_kernels::frozen::bytes::{ByteScale, EXACT};

use crate::ranges::Ranges;
use crate::step::{Algorithm, Conv, FrozenStep, StepId, StepOp};

/// Products in a sum up to which 32 bits hold it, with a bias.
const DEPTH: usize = 30_000;

/// Returns the steps with scales, and with steps between floats and bytes where both are needed; and those of the
/// outputs.
pub(crate) fn quantize(
    steps: Vec<FrozenStep>,
    outputs: &[StepId],
    ranges: &Ranges,
) -> (Vec<FrozenStep>, Vec<StepId>) {
    let scales = scales(&steps, ranges);
    let len = steps.len();
    let seen = steps.iter().map(|step| ranges.get(&step.name).map(|&[low, high]| ByteScale::over(low, high)));
    let seen: Vec<Option<ByteScale>> = seen.collect();
    let mut plan =
        QuantizedSteps { steps: vec![], now: vec![], floats: vec![None; len], bytes: vec![None; len] };
    for (id, step) in steps.into_iter().enumerate() {
        plan.push(step, scales[id], &seen);
    }
    let outputs = outputs.iter().map(|&output| plan.as_floats(output)).collect();
    (plan.steps, outputs)
}

/// Returns the scale of every value that becomes bytes.
fn scales(steps: &[FrozenStep], ranges: &Ranges) -> Vec<Option<ByteScale>> {
    let classes = classes(steps);
    let mut seen: Vec<Option<[f32; 2]>> = vec![None; steps.len()];
    for (step, &class) in steps.iter().zip(&classes) {
        if let Some(&[low, high]) = ranges.get(&step.name) {
            let [least, most] = seen[class].unwrap_or([low, high]);
            seen[class] = Some([least.min(low), most.max(high)]);
        }
    }
    let mut read = vec![false; steps.len()];
    for step in steps {
        let by_bytes = match &step.work {
            // An addend goes into the sum as bytes, too.
            StepOp::Conv(conv) => {
                let addend =
                    step.inputs.get(1).is_none_or(|addend| ranges.contains_key(&steps[*addend].name));
                fits(conv) && addend
            }
            StepOp::Linear { bias, weight, .. } => weight.len() / bias.len().max(1) <= DEPTH,
            _ => false,
        };
        if by_bytes {
            read[classes[step.inputs[0]]] = true;
        }
    }
    // What goes into a sum of bytes is bytes, too.
    for (id, step) in steps.iter().enumerate().rev() {
        if matches!(step.work, StepOp::Add { .. }) && read[classes[id]] {
            step.inputs.iter().for_each(|&input| read[classes[input]] = true);
        }
    }
    let scale = |class: &StepId| {
        let [low, high] = seen[*class].filter(|_| read[*class])?;
        Some(ByteScale::over(low, high))
    };
    classes.iter().map(scale).collect()
}

/// Checks whether no sum can overflow.
fn fits(conv: &Conv) -> bool {
    let depth = conv.weight.len() / conv.bias.len().max(1);
    match conv.algorithm {
        // A quarter is left for the bias.
        Algorithm::Depthwise => depth * 255 * 127 * 2 < EXACT as usize / 2,
        _ => depth <= DEPTH,
    }
}

/// Returns for every value the first one that it shares its scale with: values that are parts of each other or only
/// moved.
fn classes(steps: &[FrozenStep]) -> Vec<StepId> {
    let mut class: Vec<StepId> = (0..steps.len()).collect();
    for (id, step) in steps.iter().enumerate() {
        let moved = match step.work {
            StepOp::Concat => step.inputs.len(),
            StepOp::Slice(_)
            | StepOp::Shuffle(_)
            | StepOp::Flatten
            | StepOp::Pool { pooling: Pooling::Max, .. } => 1,
            _ => 0,
        };
        for &input in &step.inputs[..moved] {
            let (a, b) = (class[id].min(class[input]), class[id].max(class[input]));
            class.iter_mut().filter(|other| **other == b).for_each(|other| *other = a);
        }
    }
    class
}

struct QuantizedSteps {
    steps: Vec<FrozenStep>,
    /// The value of every old step as it is stored.
    now: Vec<StepId>,
    /// The same as floats, and as bytes of its own range, where a reader needs it.
    floats: Vec<Option<StepId>>,
    bytes: Vec<Option<StepId>>,
}

impl QuantizedSteps {
    fn push(&mut self, step: FrozenStep, scale: Option<ByteScale>, seen: &[Option<ByteScale>]) {
        let is_bytes = |plan: &QuantizedSteps, which: usize| {
            step.inputs.get(which).is_some_and(|&input| plan.steps[plan.now[input]].scale.is_some())
        };
        let all = step.inputs.iter().all(|&input| self.steps[self.now[input]].scale.is_some());
        let in_bytes = match &step.work {
            StepOp::Conv(conv) => is_bytes(self, 0) && fits(conv),
            StepOp::Linear { weight, bias, .. } => {
                is_bytes(self, 0) && weight.len() / bias.len().max(1) <= DEPTH
            }
            StepOp::Affine { .. } => true,
            StepOp::Add { .. } => all,
            StepOp::Pool { pooling: Pooling::Max, .. }
            | StepOp::Concat
            | StepOp::Slice(_)
            | StepOp::Shuffle(_) => scale.is_some(),
            StepOp::Pool { pooling: Pooling::Mean, .. } => {
                all && self.steps[self.now[step.inputs[0]]].shape.size.iter().product::<usize>() * 255
                    < EXACT as usize
            }
            _ => false,
        };
        let inputs: Vec<StepId> = match (in_bytes, &step.work) {
            (true, StepOp::Conv(_)) => {
                let mut inputs = vec![self.now[step.inputs[0]]];
                inputs.extend(step.inputs[1..].iter().map(|&addend| self.as_bytes(addend, seen[addend])));
                inputs
            }
            (true, _) => step.inputs.iter().map(|&input| self.now[input]).collect(),
            (false, _) => step.inputs.iter().map(|&input| self.as_floats(input)).collect(),
        };
        let shape = step.shape;
        let own_scale = scale.filter(|_| in_bytes);
        self.steps.push(FrozenStep { inputs, scale: own_scale, ..step });
        let mut id = self.steps.len() - 1;
        if scale.is_some() && !in_bytes {
            id = self.convert(id, scale);
        }
        debug_assert_eq!(self.steps[id].shape, shape);
        self.now.push(id);
    }

    /// Adds a step that stores the same value, written otherwise.
    fn convert(&mut self, id: StepId, scale: Option<ByteScale>) -> StepId {
        let work = StepOp::Affine { scale: None, rectifier: Rectifier::None };
        let step = FrozenStep::new(work, vec![id], self.steps[id].shape);
        self.steps.push(FrozenStep { scale, ..step });
        self.steps.len() - 1
    }

    fn as_floats(&mut self, old: StepId) -> StepId {
        let id = self.now[old];
        if self.steps[id].scale.is_none() {
            return id;
        }
        if let Some(known) = self.floats[old] {
            return known;
        }
        let floats = self.convert(id, None);
        self.floats[old] = Some(floats);
        floats
    }

    fn as_bytes(&mut self, old: StepId, scale: Option<ByteScale>) -> StepId {
        let id = self.now[old];
        if self.steps[id].scale.is_some() {
            return id;
        }
        if let Some(known) = self.bytes[old] {
            return known;
        }
        let bytes = self.convert(id, scale);
        self.bytes[old] = Some(bytes);
        bytes
    }
}
