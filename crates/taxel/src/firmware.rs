//! A model as C for microcontrollers.

use std::path::Path;

use ndarray::{ArrayD, IxDyn};
use taxel_data::{SampleSpec, Task};
use taxel_encodings::Scaling;
use taxel_firmware::{Expected, Library, Samples, Size, write_folder};
use taxel_graph::{Graph, Loss};
use taxel_learn::{Card, Model, ModelKind, Transform};
use taxel_runtime::Blueprint;

use crate::error::{Error, Result};

/// Samples of the test that goes with the C.
const SAMPLES: usize = 200;

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

/// The parts of a card that become C.
struct Exportable<'a> {
    graph: &'a Graph,
    ranges: &'a taxel_runtime::Ranges,
    scaling: &'a Scaling,
    sample: [usize; 2],
    classes: &'a [String],
}

/// Writes a model in eight bits as a folder of C99 for microcontrollers, whose predictions have the bits of
/// [`Model::predict`]; without a `name` the library has the model's.
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
    let card = model.card();
    let Exportable { graph, ranges, scaling, sample, classes } = exportable(card)?;
    let blueprint = Blueprint::new(graph, model.weights(), ranges).map_err(taxel_learn::Error::from)?;
    let samples = Samples::new(SAMPLES, &walked(card, scaling, sample), sample[1]);
    let expected = expected(model, &samples)?;
    let SampleSpec { unit, rate, .. } = &card.spec;
    let library = Library {
        model: card.name.clone(),
        classes: classes.to_vec(),
        temperature: card.certainty.as_ref().map(|certainty| certainty.temperature),
        about: card.to_string(),
        remarks: remarks(card),
        unit: unit.clone(),
        rate: *rate,
        ..Library::new(name.unwrap_or(&card.name), &blueprint, scaling, sample, samples, expected)
    };
    write_folder(folder, &library.files()?)?;
    Ok(ExportedC { name: library.identifier(), size: library.size()?, remarks: library.remarks })
}

fn exportable(card: &Card) -> Result<Exportable<'_>> {
    let refuse = |reason: String| Err(Error::Export { model: card.name.clone(), reason });
    let ModelKind::Network { graph, loss, .. } = &card.kind else {
        return refuse(
            "is a baseline; only networks become C: `taxel choose` names the smallest that suffices".into(),
        );
    };
    let Some(quantized) = &card.quantized else {
        let bytes = size_of::<f32>() * graph.parameter_count();
        return refuse(format!(
            "is in 32-bit floats ({bytes} bytes of weights), and C is printed of eight bits ({} bytes): write that model \
             first with `taxel quantize MODEL --calibrate RECORDINGS --output SMALL`",
            bytes / size_of::<f32>()
        ));
    };
    let (Task::Classes(classes), Loss::SoftmaxCrossEntropy) = (&card.task, loss) else {
        return refuse(
            "predicts something other than one class by a softmax, which C does not have yet".into(),
        );
    };
    let [input] = &card.inputs[..] else {
        return refuse(format!("has {} inputs; C reads one", card.inputs.len()));
    };
    let (Transform::Signal(scaling), [_] | [_, _]) = (&input.transform, &card.spec.shape[..]) else {
        let words = crate::export::words(&input.transform);
        return refuse(format!(
            "reads {words}; C scales series (raw, full-scale or z-score) and has no other encoding yet"
        ));
    };
    let sample = match card.spec.shape[..] {
        [channels, steps] => [channels, steps],
        _ => [1, card.spec.shape.iter().product()],
    };
    Ok(Exportable { graph, ranges: &quantized.ranges, scaling, sample, classes })
}

/// Returns the range of each channel that samples of the test stay in: that of the training.
fn walked(card: &Card, scaling: &Scaling, [channels, _]: [usize; 2]) -> Vec<[f32; 2]> {
    let seen = card.trained_on.ranges.channels();
    let finite = seen.iter().flatten().all(|value| value.is_finite());
    if finite && seen.len() == channels {
        return seen.to_vec();
    }
    match scaling {
        Scaling::Raw => vec![[-1.0, 1.0]; channels],
        Scaling::FullScale { full_scale } => vec![[0.0, *full_scale]; channels],
        Scaling::ZScore { mean, sd } => {
            mean.iter().zip(sd).map(|(mean, sd)| [mean - 3.0 * sd, mean + 3.0 * sd]).collect()
        }
    }
}

/// Predicts the samples of the test, without the guard.
fn expected(model: &Model, samples: &Samples) -> Result<Expected> {
    let card = model.card();
    let shape = [&[samples.count], &card.spec.shape[..]].concat();
    let refuse = |reason: String| Error::Export { model: card.name.clone(), reason };
    let x =
        ArrayD::from_shape_vec(IxDyn(&shape), samples.values()).map_err(|error| refuse(error.to_string()))?;
    let predictor = model.predictor(1, 1)?.guarded(None)?;
    let logits = predictor.logits(&x)?;
    let probabilities = predictor.finished(logits.clone());
    Ok(Expected { logits, probabilities })
}

fn remarks(card: &Card) -> Vec<String> {
    let mut remarks = vec![];
    if card.guard.is_some() {
        remarks
            .push("The model's guard is not in the C: broken channels reach the network as they are.".into());
    }
    if card.certainty.as_ref().is_some_and(|certainty| certainty.seen.is_some()) {
        remarks.push("The model's gate is not in the C: it does not say whether a sample is like those of the training.".into());
    }
    if card.spec.length.is_some() || card.spec.tare.is_some() {
        remarks.push(
            "A sample has to be cut to its length, and resting values taken off, before it is predicted."
                .into(),
        );
    }
    remarks
}
