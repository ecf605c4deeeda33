//! How the samples of a model come into C.

use taxel_data::Layout;
use taxel_encodings::Scaling;
use taxel_firmware::Encoding;
use taxel_learn::{Card, ModelKind, Transform};

use super::refusal;
use crate::error::Result;

/// How samples are read.
pub(super) struct Encoded<'c> {
    pub encoding: Encoding<'c>,
    /// Channels and time steps, or channels and pixels.
    pub sample: [usize; 2],
    /// Rows and columns of an image.
    pub image: Option<[usize; 2]>,
}

/// Returns how samples of a model are read.
pub(super) fn encoded(card: &Card) -> Result<Encoded<'_>> {
    let [input] = &card.inputs[..] else {
        return Err(refusal(card, format!("has {} inputs; C reads one", card.inputs.len())));
    };
    let shape = &card.spec.shape[..];
    if let (Some(scaling), Some((channels, size))) = (pixels(&input.transform), image_of(shape)) {
        let sample = [channels, size[0] * size[1]];
        return Ok(Encoded { encoding: Encoding::Scaled(scaling), sample, image: Some(size) });
    }
    let (Some(encoding), [_] | [_, _]) = (encoding(&input.transform), shape) else {
        let words = crate::export::words(&input.transform);
        let given: usize = shape.iter().product();
        let read = match &card.kind {
            ModelKind::Network { graph, .. } => {
                graph.inputs().map(|node| node.shape.iter().product::<usize>()).sum()
            }
            ModelKind::Baseline { .. } | ModelKind::Average { .. } => given,
        };
        return Err(refusal(
            card,
            format!(
                "reads {words}, {read} values made of the {given} of a sample; C scales series and images (raw, full-scale or z-score), \
                 makes the quantile code or the history of series, and has no other encoding"
            ),
        ));
    };
    let sample = match *shape {
        [channels, steps] => [channels, steps],
        _ => [1, shape.iter().product()],
    };
    Ok(Encoded { encoding, sample, image: None })
}

/// Returns how the pixels of an image are scaled, where nothing else happens to them.
fn pixels(transform: &Transform) -> Option<&Scaling> {
    match transform {
        Transform::Image(scaling) | Transform::Picture { frame: None, red: false, resize: None, scaling } => {
            Some(scaling)
        }
        _ => None,
    }
}

/// Returns channels, and rows and columns, of a sample that is an image.
fn image_of(shape: &[usize]) -> Option<(usize, [usize; 2])> {
    match *shape {
        [rows, columns] => Some((1, [rows, columns])),
        [channels, rows, columns] => Some((channels, [rows, columns])),
        _ => None,
    }
}

/// Returns the encoding as C does it; none where it does not.
fn encoding(transform: &Transform) -> Option<Encoding<'_>> {
    match transform {
        // A network on images may read a series as one of a single channel, whose rows are those of the series.
        Transform::Signal(scaling) | Transform::Rows(scaling) => Some(Encoding::Scaled(scaling)),
        Transform::QuantileCode(code) => Some(Encoding::Code(code)),
        Transform::History { history, then } => match &**then {
            Transform::Signal(scaling) => Some(Encoding::History { history, scaling }),
            _ => None,
        },
        // Nothing moves.
        Transform::Series { layout: Layout::Features | Layout::Series, then } => encoding(then),
        _ => None,
    }
}

/// Returns the range of each channel that samples of the test stay in: that of the training.
pub(super) fn walked(card: &Card, encoding: &Encoding, [channels, _]: [usize; 2]) -> Vec<[f32; 2]> {
    let seen = card.trained_on.ranges.channels();
    let finite = seen.iter().flatten().all(|value| value.is_finite());
    if finite && seen.len() == channels {
        return seen.to_vec();
    }
    match encoding {
        Encoding::Scaled(Scaling::FullScale { full_scale }) => vec![[0.0, *full_scale]; channels],
        Encoding::Scaled(Scaling::ZScore { mean, sd }) => {
            mean.iter().zip(sd).map(|(mean, sd)| [mean - 3.0 * sd, mean + 3.0 * sd]).collect()
        }
        _ => vec![[-1.0, 1.0]; channels],
    }
}
