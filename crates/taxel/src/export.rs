//! A model as ONNX, with what ONNX can say of its encoding.

use std::path::Path;

use serde_json::json;
use taxel_baselines::{Dilated, Fitted, LinearFeatures, LinearModel};
use taxel_data::{Layout, SampleSpec};
use taxel_encodings::{CodeView, QuantileCode, Scaling, TactileTensor};
use taxel_graph::{Graph, Loss, Network, Tensor, Weights};
use taxel_learn::certainty::{Axes, FALSE_ALARMS, Place, Seen};
use taxel_learn::{Card, Model, ModelKind, Precision, Transform};
use taxel_onnx::{
    Code, CodeRow, DISTANCE, DISTANCES, Export, Front, FrontStep, GatePlace, PROBABILITIES, QUANTITIES,
    READINGS_DISTANCE, ReadingsPlace, RocketConv, RocketFeatures, TEMPERATURE, UNKNOWN_BEYOND, VALUES,
};

use crate::error::{Error, Result};
use crate::remarks::{sensor_facts, tare_remark};
use crate::saved_baseline::fitted;

/// Names of the input, the layer and the output of a linear baseline.
const INPUT: &str = "series";
const RIDGE: &str = "ridge";
const LOGITS: &str = "logits";

/// An exported file.
#[derive(Debug, Clone, PartialEq)]
pub struct Exported {
    /// Inputs in their order.
    pub inputs: Vec<ExportedInput>,
    /// Names of the outputs in their order: logits and, where they follow, `probabilities`, or `values`; of a model with a gate `distance`.
    pub outputs: Vec<String>,
    /// Work of a program before it calls the model, beside the encoding of inputs.
    pub remarks: Vec<String>,
}

/// An input of an exported model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExportedInput {
    /// Its name.
    pub name: String,
    /// Shape of one sample, batch axis left out.
    pub shape: Vec<usize>,
    /// The encoding that has to be done before, in words; none where it takes raw readings.
    pub encoded: Option<&'static str>,
}

/// Writes a model as ONNX (opset 17): z-scores, full scale, the order of axes, quantile codes, histories and MiniRocket's
/// features are part of it, so that it takes raw readings; other encodings are not, and [`ExportedInput::encoded`] names them.
///
/// ```no_run
/// let model = taxel::Model::open("model.safetensors".as_ref())?;
/// let exported = taxel::export(&model, "model.onnx".as_ref())?;
/// assert_eq!(exported.outputs, ["logits", "probabilities"]);
/// # Ok::<(), taxel::Error>(())
/// ```
///
/// # Errors
/// A baseline other than MiniRocket and ridge, an average, a model in eight bits or in bf16, and a file that cannot be written.
pub fn export(model: &Model, path: &Path) -> Result<Exported> {
    let card = model.card();
    match &card.kind {
        ModelKind::Network { graph, loss, .. } => {
            if card.quantized.is_some() {
                let reason = "is in eight bits, which the file would not be: export the model that it was made of, and let the \
                              other tool put that in eight bits";
                return Err(Error::Export { model: card.name.clone(), reason: reason.into() });
            }
            if card.precision != Precision::F32 {
                let reason = "is in bf16, and a file of ONNX would predict in floats: export the model that it was made of";
                return Err(Error::Export { model: card.name.clone(), reason: reason.into() });
            }
            let read = |node: &taxel_graph::Node| read(card, node);
            written(card, (graph, model.weights()), Some(*loss), &read, path)
        }
        ModelKind::Average { .. } => {
            let reason = "is an average, and a file of ONNX holds one network: export the rows that it averages, and take the mean of \
                          their outputs";
            Err(Error::Export { model: card.name.clone(), reason: reason.into() })
        }
        ModelKind::Baseline { method, series } => {
            let fitted = fitted(model, method, *series)?;
            let Linear { graph, weights, front } = linear(card, &fitted, *series)?;
            let read = |_: &taxel_graph::Node| (front.clone(), None);
            written(card, (&graph, &weights), None, &read, path)
        }
    }
}

/// How raw readings become an input; or, where ONNX cannot say that, the encoding in words.
type Read = (Option<Front>, Option<&'static str>);

/// Writes a network with the facts of a card, whose inputs become what `read` says.
fn written(
    card: &Card,
    (graph, weights): (&Graph, &Weights),
    loss: Option<Loss>,
    read: &dyn Fn(&taxel_graph::Node) -> Read,
    path: &Path,
) -> Result<Exported> {
    let (mut inputs, mut readings) = (vec![], vec![]);
    for node in graph.inputs() {
        let (reading, encoded) = read(node);
        let shape = reading.as_ref().map_or(&node.shape, |reading| &reading.shape).clone();
        inputs.push(ExportedInput { name: node.name.clone(), shape, encoded });
        readings.push(reading);
    }
    let gate = card.certainty.as_ref().and_then(|certainty| certainty.seen.as_ref());
    // Readings are judged where the first input takes them as the sensor gives them.
    let takes_raw =
        readings.first().and_then(Option::as_ref).is_some_and(|front| front.shape == card.spec.shape);
    let readings_gate = readings_place(card).filter(|_| takes_raw);
    let has_readings = readings_gate.is_some();
    let quantities = card.task.quantities();
    let of_classes = loss.unwrap_or(Loss::SoftmaxCrossEntropy);
    let export = Export {
        loss: quantities.is_empty().then_some(of_classes),
        values: (!quantities.is_empty()).then_some(quantities.len()),
        temperature: card.certainty.as_ref().map(|certainty| certainty.temperature),
        sizes: card.levels().sizes().to_vec(),
        gate: gate.map_or(vec![], places),
        readings_gate,
        readings,
        about: card.to_string(),
        facts: facts(card, loss, &inputs, has_readings),
        ..Export::new(graph, weights)
    };
    taxel_onnx::write(path, &export)?;
    let mut outputs: Vec<String> = graph.outputs().iter().map(|(name, _)| name.clone()).collect();
    let answers = if quantities.is_empty() { PROBABILITIES } else { VALUES };
    if !outputs.iter().any(|name| name == answers) {
        outputs.push(answers.into());
    }
    if gate.is_some() && !outputs.iter().any(|name| name == DISTANCE) {
        outputs.push(DISTANCE.into());
    }
    if has_readings && !outputs.iter().any(|name| name == READINGS_DISTANCE) {
        outputs.push(READINGS_DISTANCE.into());
    }
    Ok(Exported { inputs, outputs, remarks: tare_remark(card).into_iter().collect() })
}

/// Returns how an input of a network is read.
fn read(card: &Card, node: &taxel_graph::Node) -> Read {
    let transform = card.inputs.iter().find(|input| input.name == node.name).map(|input| &input.transform);
    let Some(transform) = transform else { return (None, Some("as the network reads it")) };
    match reading(transform, &card.spec.shape, &node.shape) {
        Some(reading) => (Some(reading), None),
        None => (None, Some(words(transform))),
    }
}

/// A linear baseline as a network behind its features.
struct Linear {
    graph: Graph,
    weights: Weights,
    front: Option<Front>,
}

/// Returns MiniRocket with ridge, or ridge, as a linear layer behind the features.
fn linear(card: &Card, fitted: &Fitted, series: [usize; 2]) -> Result<Linear> {
    let refuse = |reason: &str| Error::Export { model: card.name.clone(), reason: reason.into() };
    let Some(LinearModel { features, weights: rows, bias }) = fitted.linear() else {
        return Err(refuse(
            "is a baseline that ONNX cannot say; networks, MiniRocket and ridge can be exported: fit one of these from the run \
             (taxel fit RUN --network mini-rocket), or use this model with `taxel predict`",
        ));
    };
    let width = rows.len() / bias.len().max(1);
    let net = Network::new(&card.name);
    let flow = match features {
        LinearFeatures::Readings => net.input(INPUT, &series).flatten(),
        LinearFeatures::Rocket { .. } => net.input(INPUT, &[width]),
    };
    let graph = net.finish(&[(LOGITS, flow.linear(RIDGE, bias.len()))])?;
    let mut weights = Weights::new();
    let named = |part: &str| format!("{RIDGE}.{part}");
    weights.insert(&named("weight"), Tensor { shape: vec![bias.len(), width], data: rows.to_vec() });
    weights.insert(&named("bias"), Tensor { shape: vec![bias.len()], data: bias.to_vec() });
    let [input] = &card.inputs[..] else { return Err(refuse("has several inputs")) };
    let (mut steps, mut now) = (vec![], card.spec.shape.clone());
    let Some(()) = add(&input.transform, &mut now, &mut steps).filter(|()| now == series) else {
        return Err(refuse(&format!("reads {}, which ONNX cannot say", words(&input.transform))));
    };
    if let LinearFeatures::Rocket { convolutions, levels } = features {
        let one = |conv: &Dilated| RocketConv {
            dilation: conv.dilation,
            twos: conv.twos,
            channels: conv.channels.clone(),
            biases: conv.biases.clone(),
            counted: conv.counted.clone(),
        };
        let convolutions = convolutions.iter().map(one).collect();
        steps.push(FrontStep::Rocket(RocketFeatures { convolutions, levels }));
    }
    Ok(Linear { graph, weights, front: Some(Front { shape: card.spec.shape.clone(), steps }) })
}

/// Returns a gate as ONNX computes it.
fn places(gate: &Seen) -> Vec<GatePlace> {
    let place = |Place { center, within, around, means }: &Place| GatePlace {
        center: center.clone(),
        within: within.clone(),
        around: around.clone(),
        means: means.clone(),
    };
    gate.places.iter().map(place).collect()
}

/// Returns a gate of readings as ONNX computes it.
fn readings_place(card: &Card) -> Option<ReadingsPlace> {
    let gate = card.readings_gate()?;
    let Axes { channels, steps, by_step, has_time } = Axes::new(card.spec.layout, &card.spec.shape);
    let (center, around) = (gate.center.clone(), gate.around.clone());
    let steps_first = by_step > 1;
    Some(ReadingsPlace { channels, steps, steps_first, has_time, floor: gate.floor(), center, around })
}

/// Returns facts for programs that run the file, as `metadata_props`.
fn facts(
    card: &Card,
    loss: Option<Loss>,
    inputs: &[ExportedInput],
    has_readings: bool,
) -> Vec<(String, String)> {
    let SampleSpec { unit, rate, full_scale, .. } = &card.spec;
    let classes = match &card.task.attributes()[..] {
        [] => json!(card.task.quantities()),
        [one] => json!(one.classes),
        several => json!(
            several
                .iter()
                .map(|attribute| (attribute.name.clone(), json!(attribute.classes)))
                .collect::<serde_json::Map<_, _>>()
        ),
    };
    let key = if card.task.quantities().is_empty() { "taxel.classes" } else { QUANTITIES };
    let mut facts = vec![
        ("taxel.version".to_string(), card.taxel.clone()),
        ("taxel.name".into(), card.name.clone()),
        (key.into(), classes.to_string()),
    ];
    facts.extend(loss.map(|loss| ("taxel.loss".into(), json!(loss).as_str().unwrap_or_default().into())));
    for input in inputs {
        let takes = match input.encoded {
            None => "raw readings".to_string(),
            Some(encoding) => format!("encoded: {encoding}"),
        };
        facts.push((format!("taxel.input.{}", input.name), takes));
    }
    let temperature = card.certainty.as_ref().map(|certainty| certainty.temperature.to_string());
    facts.extend(temperature.map(|temperature| (TEMPERATURE.to_string(), temperature)));
    let gate = card.certainty.as_ref().and_then(|certainty| certainty.seen.as_ref());
    facts.extend(gate.map(|gate| (DISTANCES.to_string(), json!(gate.distances).to_string())));
    // Of logits alone where the file does not take raw readings.
    let alone = || [gate.and_then(|gate| gate.limit(FALSE_ALARMS)), None];
    let limits = if has_readings { card.unknown_beyond(FALSE_ALARMS) } else { alone() };
    let limits = [DISTANCE, READINGS_DISTANCE].into_iter().zip(limits);
    let limits: serde_json::Map<_, _> =
        limits.filter_map(|(name, limit)| Some((name.to_string(), json!(limit?)))).collect();
    facts.extend((!limits.is_empty()).then(|| (UNKNOWN_BEYOND.to_string(), json!(limits).to_string())));
    facts.extend(sensor_facts(&card.spec));
    facts.extend(unit.iter().map(|unit| ("taxel.unit".to_string(), unit.clone())));
    facts.extend(rate.iter().map(|rate| ("taxel.rate_hz".to_string(), rate.to_string())));
    facts.extend(full_scale.iter().map(|full| ("taxel.full_scale".to_string(), full.to_string())));
    facts
}

/// Returns the encoding as operations of ONNX before the network; none where ONNX has no such operations.
fn reading(transform: &Transform, shape: &[usize], wanted: &[usize]) -> Option<Front> {
    let (mut steps, mut now) = (vec![], shape.to_vec());
    add(transform, &mut now, &mut steps)?;
    if now != wanted {
        // A flat network reads the same values as features.
        steps.push(FrontStep::Reshape(wanted.to_vec()));
    }
    let fits = now.iter().product::<usize>() == wanted.iter().product::<usize>();
    fits.then(|| Front { shape: shape.to_vec(), steps })
}

/// Adds the steps of a transform of readings of shape `now`, which becomes that of what comes out.
fn add(transform: &Transform, now: &mut Vec<usize>, steps: &mut Vec<FrontStep>) -> Option<()> {
    match transform {
        Transform::Signal(scaling) => {
            channelled(2, now, steps)?;
            scale(scaling, steps);
        }
        Transform::Rows(scaling) => {
            channelled(2, now, steps)?;
            scale(scaling, steps);
            reshape([&[1], &now[..]].concat(), now, steps);
        }
        Transform::Image(scaling) | Transform::Picture { frame: None, red: false, resize: None, scaling } => {
            channelled(3, now, steps)?;
            scale(scaling, steps);
        }
        Transform::Tensor { tensor: TactileTensor { frames }, scaling } => {
            let &[recorded, rows, columns] = &now[..] else { return None };
            if frames.is_some_and(|frames| frames != recorded) {
                return None;
            }
            steps.push(FrontStep::Transpose(vec![1, 2, 0]));
            reshape(vec![1, rows, columns, recorded], now, steps);
            scale(scaling, steps);
        }
        Transform::Series { layout, then } => {
            series(*layout, now, steps)?;
            add(then, now, steps)?;
        }
        Transform::Baseline { readings, then } => {
            (now.len() == 2).then_some(())?;
            steps.push(FrontStep::LessBaseline(*readings));
            add(then, now, steps)?;
        }
        Transform::History { history, then } => {
            channelled(2, now, steps)?;
            let rows = history.shape(now[0]);
            steps.push(FrontStep::History(history.lags.clone()));
            *now = rows.to_vec();
            add(then, now, steps)?;
        }
        Transform::QuantileCode(code) => {
            channelled(2, now, steps)?;
            coded(code, now, steps);
        }
        Transform::Rocket(_)
        | Transform::Field(_)
        | Transform::Picture { .. }
        | Transform::Reduced { .. }
        | Transform::Electrodes { .. }
        | Transform::Numatac { .. } => return None,
    }
    Some(())
}

/// Adds the quantile code of channels × time.
fn coded(code: &QuantileCode, now: &mut Vec<usize>, steps: &mut Vec<FrontStep>) {
    let [rows, coded] = code.shape(now[0], now[1]);
    let row = |view: &CodeView| CodeRow { mean: view.mean, sd: view.sd, edges: view.edges.clone() };
    let ramps = (rows / code.views().len().max(1)).saturating_sub(1);
    let rows_of = code.views().iter().map(row).collect();
    steps.push(FrontStep::Code(Code { rows: rows_of, ramps, steps: coded }));
    *now = vec![rows, coded];
}

fn reshape(to: Vec<usize>, now: &mut Vec<usize>, steps: &mut Vec<FrontStep>) {
    now.clone_from(&to);
    steps.push(FrontStep::Reshape(to));
}

/// Makes values without a channel axis one channel; none where that does not give so many axes.
fn channelled(axes: usize, now: &mut Vec<usize>, steps: &mut Vec<FrontStep>) -> Option<()> {
    if now.len() + 1 == axes {
        reshape([&[1], &now[..]].concat(), now, steps);
    }
    (now.len() == axes).then_some(())
}

/// Makes channels × time of readings of any layout; none where the axes are others.
fn series(layout: Layout, now: &mut Vec<usize>, steps: &mut Vec<FrontStep>) -> Option<()> {
    match (layout, &now[..]) {
        (Layout::Features, &[length]) => reshape(vec![1, length], now, steps),
        (Layout::Series | Layout::Image, &[_, _]) => {}
        (Layout::Colour | Layout::Fingers, &[a, b, length]) => reshape(vec![a * b, length], now, steps),
        (Layout::Sequence, &[frames, rows, columns]) => {
            steps.push(FrontStep::Transpose(vec![1, 2, 0]));
            reshape(vec![rows * columns, frames], now, steps);
        }
        _ => return None,
    }
    Some(())
}

fn scale(scaling: &Scaling, steps: &mut Vec<FrontStep>) {
    let (offset, divisor) = match scaling {
        Scaling::Raw => return,
        Scaling::FullScale { full_scale } => (vec![0.0], vec![*full_scale]),
        Scaling::ZScore { mean, sd } => (mean.clone(), sd.clone()),
    };
    steps.push(FrontStep::Scale { offset, divisor });
}

/// Describes an encoding that ONNX does not do.
pub(crate) fn words(transform: &Transform) -> &'static str {
    match transform {
        Transform::QuantileCode(_) => "the quantile code of the readings (encoding.signal)",
        Transform::History { .. } => {
            "the last reading of each channel and its differences to earlier ones, scaled (encoding.signal)"
        }
        Transform::Rocket(_) => "MiniRocket's features of the readings (encoding.rocket)",
        Transform::Field(_) => "the coloured Gramian angular field of the readings (encoding.image)",
        Transform::Picture { .. } => {
            "a picture, its frame chosen, coloured or resized, then scaled (encoding.image)"
        }
        Transform::Numatac { .. } => "the NumaTac series from contact on, scaled (encoding.image)",
        Transform::Electrodes { .. } => "the electrodes over time as a colour image, scaled (encoding.image)",
        Transform::Tensor { .. } => "frames resampled, then scaled (encoding.tensor)",
        Transform::Baseline { then, .. } | Transform::Series { then, .. } => words(then),
        Transform::Reduced { .. } => "what encoding.reduce leaves of the readings, encoded",
        Transform::Signal(_) | Transform::Image(_) | Transform::Rows(_) => "the readings, scaled",
    }
}
