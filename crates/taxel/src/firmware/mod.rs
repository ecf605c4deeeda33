//! A model as C for microcontrollers.

use std::path::Path;

use ndarray::{ArrayD, IxDyn};
use taxel_baselines::{Fitted, LinearFeatures, LinearModel};
use taxel_data::{SampleSpec, Task};
use taxel_firmware::{
    Answers, Attribute, Expected, Features, Gate, Library, Linear, Method, Quantity, ReadingsGate, Samples,
    Shares, Size, Spread, write_folder,
};
use taxel_graph::{Graph, Loss};
use taxel_judge::{Need, Room};
use taxel_learn::certainty::{Axes, FALSE_ALARMS, Place, Readings, Seen};
use taxel_learn::{Card, Model, ModelKind, Precision};
use taxel_runtime::Blueprint;

use crate::error::{Error, Result};
use crate::remarks::tare_remark;
use crate::saved_baseline::fitted;

mod samples;

use samples::{Encoded, encoded, walked};

/// Samples of the test that goes with the C.
const SAMPLES: usize = 200;
/// The share of true values that intervals of the C hold.
const SHARE: f64 = 0.9;

/// A folder of C that was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExportedC {
    /// Name of the library: functions begin with `taxel_<name>_`.
    pub name: String,
    /// Memory and products of one prediction.
    pub size: Size,
    /// Abilities of the model that the C lacks.
    pub remarks: Vec<String>,
}

/// The computation of a model, read for C.
enum Read {
    Network(Box<Blueprint>),
    Linear(Box<Fitted>),
}

/// Writes a network in eight bits or in floats, MiniRocket or ridge as a folder of C99 for microcontrollers, whose predictions have the bits
/// of [`Model::predict`]; without a `name` the library has the model's.
///
/// ```no_run
/// let model = taxel::Model::open("small.safetensors".as_ref())?;
/// let exported = taxel::export_c(&model, "firmware".as_ref(), Some("squeeze"))?;
/// println!("{} bytes of RAM", exported.size.ram);
/// # Ok::<(), taxel::Error>(())
/// ```
///
/// # Errors
/// A model that has no C of the same bits, with the reason, and a folder that cannot be written.
pub fn export_c(model: &Model, folder: &Path, name: Option<&str>) -> Result<ExportedC> {
    export_c_within(model, folder, name, Room::default())
}

/// Writes the folder of [`export_c`] if the model fits the room, as code for a Cortex-M4 with the time steps of `push`.
///
/// # Errors
/// As [`export_c`], and a model that needs more than there is, with the numbers; then nothing is written.
pub fn export_c_within(
    model: &Model,
    folder: &Path,
    name: Option<&str>,
    mut room: Room,
) -> Result<ExportedC> {
    room.check()?;
    with_library(model, name, SAMPLES, |library| {
        let size = library.size()?;
        let need = Need::Bytes { flash: size.flash as u64, ram: (size.ram + size.ring) as u64 };
        room.needs.insert(library.model.clone(), need);
        if let Some(over) = room.refusal(&library.model) {
            let fix = "`taxel choose RUN` with the same limits names the smallest that suffices";
            return Err(refusal(model.card(), format!("{over}; nothing was written: {fix}")));
        }
        write_folder(folder, &library.files()?)?;
        Ok(ExportedC { name: library.identifier(), size, remarks: library.remarks.clone() })
    })
}

/// Calls `then` with the library of a model, whose test has so many samples.
pub(crate) fn with_library<T>(
    model: &Model,
    name: Option<&str>,
    tested: usize,
    then: impl FnOnce(&Library) -> Result<T>,
) -> Result<T> {
    let card = model.card();
    let read = read(model)?;
    let method = match &read {
        Read::Network(blueprint) => Method::Network(blueprint),
        Read::Linear(fitted) => linear(card, fitted)?,
    };
    let answers = answers(card)?;
    let Encoded { encoding, sample, image } = encoded(card)?;
    let samples = Samples::new(tested, &walked(card, &encoding, sample), sample[1]);
    let expected = if tested == 0 { Expected::default() } else { expected(model, &samples, &answers)? };
    let SampleSpec { unit, rate, .. } = &card.spec;
    let name = name.unwrap_or(&card.name);
    then(&Library {
        model: card.name.clone(),
        about: card.to_string(),
        remarks: remarks(card, &answers),
        readings: readings(card),
        unit: unit.clone(),
        rate: *rate,
        image,
        ..Library::new(name, method, (encoding, sample), answers, samples, expected)
    })
}

fn refusal(card: &Card, reason: String) -> Error {
    Error::Export { model: card.name.clone(), reason }
}

fn read(model: &Model) -> Result<Read> {
    let card = model.card();
    match &card.kind {
        ModelKind::Network { graph, .. } => network(model, graph).map(|read| Read::Network(Box::new(read))),
        ModelKind::Average { .. } => {
            let reason = "is an average, and C is printed of one network: print the rows that it averages, and take the mean of their \
                          answers";
            Err(refusal(card, reason.into()))
        }
        ModelKind::Baseline { method, series } => {
            fitted(model, method, *series).map(|fitted| Read::Linear(Box::new(fitted)))
        }
    }
}

fn network(model: &Model, graph: &Graph) -> Result<Blueprint> {
    let card = model.card();
    if card.precision != Precision::F32 {
        let reason = "is in bf16, and C would predict in floats: export the model that it was made of";
        return Err(refusal(card, reason.into()));
    }
    let blueprint = match &card.quantized {
        Some(quantized) => Blueprint::new(graph, model.weights(), &quantized.ranges),
        None if !taxel_runtime::has_fused_products() => {
            return Err(refusal(
                card,
                "is in 32-bit floats, and this processor fuses no products, so that its predictions differ from those of C in the \
                 last bits: export on a PC with AVX2 or on 64-bit Arm, or quantize it with `taxel quantize`"
                    .into(),
            ));
        }
        None => Blueprint::floats(graph, model.weights()),
    };
    Ok(blueprint.map_err(taxel_learn::Error::from)?)
}

/// Returns the linear model of a baseline.
fn linear<'f>(card: &Card, fitted: &'f Fitted) -> Result<Method<'f>> {
    let Some(LinearModel { features, weights, bias }) = fitted.linear() else {
        let reason = "is a baseline without C; networks, MiniRocket and ridge have one: fit one of these from the run (taxel fit RUN \
                      --network mini-rocket), or ask `taxel choose RUN --max-flash 256k` for the smallest that suffices";
        return Err(refusal(card, reason.into()));
    };
    let features = match features {
        LinearFeatures::Readings => Features::Readings,
        LinearFeatures::Rocket { convolutions, levels } => Features::Rocket { convolutions, levels },
    };
    Ok(Method::Linear(Linear { features, weights, bias }))
}

/// Returns what the C answers.
fn answers(card: &Card) -> Result<Answers> {
    let loss = match &card.kind {
        ModelKind::Network { loss, .. } => Some(*loss),
        ModelKind::Baseline { .. } | ModelKind::Average { .. } => None,
    };
    let temperature = card.certainty.as_ref().map(|certainty| certainty.temperature);
    match (&card.task, loss) {
        (Task::Classes(classes), None | Some(Loss::SoftmaxCrossEntropy)) => {
            Ok(Answers::Classes { names: classes.clone(), temperature, gate: gate(card) })
        }
        (Task::Values(quantities), loss) => {
            let named = |quantity: &taxel_data::Quantity| Quantity {
                name: quantity.name.clone(),
                unit: quantity.unit.clone(),
            };
            let spread = match loss {
                Some(Loss::GaussianLikelihood) => Spread::LogVariance,
                Some(Loss::Quantiles) => Spread::Quantiles,
                _ => Spread::Alike,
            };
            let at = card.intervals.as_ref().and_then(|intervals| intervals.at(SHARE));
            let half = at.map(|at| at.half.clone());
            Ok(Answers::Values { quantities: quantities.iter().map(named).collect(), spread, half })
        }
        (Task::Classes(_) | Task::Levels(_), loss) => {
            let Some(shares) = loss.and_then(shares) else {
                let count = card.task.attributes().len();
                let reason = format!("predicts {count} attributes, and C has no probabilities of its loss");
                return Err(refusal(card, reason));
            };
            let named = |one: &taxel_data::Attribute| Attribute {
                name: one.name.clone(),
                classes: one.classes.clone(),
            };
            let attributes = card.task.attributes().iter().map(named).collect();
            Ok(Answers::Attributes { attributes, shares, temperature })
        }
    }
}

/// Returns how outputs that a loss has made become probabilities, each or attribute by attribute.
fn shares(loss: Loss) -> Option<Shares> {
    match loss {
        Loss::MultiLabelSoftMargin | Loss::Hinge => Some(Shares::Sigmoid),
        Loss::CumulativeLogits => Some(Shares::Ordered),
        Loss::MeanSquaredError => Some(Shares::Cut),
        Loss::SoftmaxCrossEntropy | Loss::Huber | Loss::GaussianLikelihood | Loss::Quantiles => None,
    }
}

/// Returns the gate of a model of one attribute, if it has one.
fn gate(card: &Card) -> Option<Gate> {
    let seen = card.certainty.as_ref()?.seen.as_ref()?;
    let [Place { center, within, around, means }] = &seen.places[..] else { return None };
    let limit = card.unknown_beyond(FALSE_ALARMS)[0]?;
    let [center, within, around, means] = [center, within, around, means].map(Vec::clone);
    Some(Gate { center, within, around, means, limit })
}

/// Returns the gate of the readings of a model, if it has one.
fn readings(card: &Card) -> Option<ReadingsGate> {
    let gate = card.readings_gate()?;
    let Axes { channels, steps, by_step, has_time } = Axes::new(card.spec.layout, &card.spec.shape);
    let (center, around) = (gate.center.clone(), gate.around.clone());
    let [_, limit] = card.unknown_beyond(FALSE_ALARMS);
    Some(ReadingsGate {
        channels,
        steps,
        by_step,
        has_time,
        floor: gate.floor(),
        center,
        around,
        limit: limit?,
    })
}

/// Predicts the samples of the test, without the guard.
fn expected(model: &Model, samples: &Samples, answers: &Answers) -> Result<Expected> {
    let card = model.card();
    let shape = [&[samples.count], &card.spec.shape[..]].concat();
    let refuse = |reason: String| Error::Export { model: card.name.clone(), reason };
    let x =
        ArrayD::from_shape_vec(IxDyn(&shape), samples.values()).map_err(|error| refuse(error.to_string()))?;
    let predictor = model.predictor(1, 1)?.guarded(None)?;
    let seen = card.certainty.as_ref().and_then(|certainty| certainty.seen.as_ref());
    let (outputs, predictions) = (predictor.logits(&x)?, predictor.predict(&x)?);
    let mut ends = [vec![], vec![]];
    for [low, high] in (0..samples.count).filter_map(|i| predictions.intervals(i, SHARE)).flatten() {
        ends[0].push(low);
        ends[1].push(high);
    }
    let (mut scratch, limits) = (vec![], card.unknown_beyond(FALSE_ALARMS));
    let is_beyond =
        |distance: f64, limit: Option<f32>| limit.is_some_and(|limit| distance > f64::from(limit));
    let mut measured = |seen: &Seen| -> Vec<(f32, bool)> {
        let rows = outputs.chunks_exact(card.task.outputs());
        let mut of_row = |row: &[f32]| {
            let distance = seen.distance(row, &mut scratch);
            (distance as f32, is_beyond(distance, limits[0]))
        };
        rows.map(&mut of_row).collect()
    };
    let mut gate = seen.map_or(vec![], &mut measured);
    let of_readings = |gate: &Readings| -> Vec<(f32, bool)> {
        let values = samples.values();
        let each = (values.len() / samples.count.max(1)).max(1);
        let of_sample = |sample: &[f32]| {
            let distance = gate.distance_of(sample, card.spec.layout, &card.spec.shape);
            (distance, is_beyond(f64::from(distance), limits[1]))
        };
        values.chunks_exact(each).map(of_sample).collect()
    };
    let readings = card.readings_gate().filter(|_| limits[1].is_some()).map_or(vec![], of_readings);
    // Both gates together refuse what `predict` calls unknown.
    if let Some(familiarity) = &predictions.familiarity {
        let is_unknown =
            |i: usize| [&gate, &readings].iter().any(|gate| gate.get(i).is_some_and(|(_, far)| *far));
        debug_assert!((0..samples.count).all(|i| is_unknown(i) == (familiarity[i] <= FALSE_ALARMS)));
    }
    if !matches!(answers, Answers::Classes { gate: Some(_), .. }) {
        gate.clear();
    }
    Ok(Expected { outputs, answers: predictions.outputs, ends, gate, readings })
}

fn remarks(card: &Card, answers: &Answers) -> Vec<String> {
    let mut remarks = vec![];
    if matches!(card.kind, ModelKind::Network { .. }) && card.quantized.is_none() {
        remarks.push(
            "The network is in 32-bit floats: it needs a processor with FPU, such as a Cortex-M4F. `taxel quantize` makes one in \
             eight bits, which needs none."
                .into(),
        );
    }
    if card.guard.is_some() {
        remarks
            .push("The model's guard is not in the C: broken channels reach the network as they are.".into());
    }
    let has_gate = card.certainty.as_ref().is_some_and(|certainty| certainty.seen.is_some());
    if has_gate && !matches!(answers, Answers::Classes { gate: Some(_), .. }) {
        remarks.push("The model's gate is not in the C: it does not say whether a sample is like those of the training.".into());
    }
    if let Some(rule) = &card.spec.length {
        remarks
            .push(format!("A sample has to be cut to its length ({}) before it is predicted.", rule.key()));
    }
    remarks.extend(tare_remark(card));
    remarks
}
