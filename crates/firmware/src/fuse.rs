//! Convolutions whose floats become one mean, largest value or deviation per filter: only one row of them has to stand in
//! memory at a time.

use crate::layer::{Layer, Memory, Row, RowNumber, Span, Statistic, Work};
use crate::lower::Network;

/// Filters that a convolution computes together.
pub(crate) const TOGETHER: usize = 2;

/// Joins such convolutions with the layers that read them.
pub(crate) fn fuse(mut network: Network) -> Network {
    for at in 0..network.layers.len() {
        let Some(statistics) = network.layers.get(at).and_then(|layer| statistics(&network, layer)) else { continue };
        let to = network.layers[at].to;
        network.layers.retain(|layer| !layer.from.iter().any(|row| row.memory == to.memory));
        network.memories[to.memory] = Memory { len: TOGETHER * to.positions, margins: [0; 2], zero: None };
        network.layers[at].to = Row { start: 0, pitch: 1, ..to };
        if let Work::Conv(conv) = &mut network.layers[at].work {
            conv.statistics = statistics;
        }
    }
    network
}

/// Returns what becomes of a convolution's floats, if that is one number per filter alone.
fn statistics(network: &Network, conv: &Layer) -> Option<Vec<Statistic>> {
    let to = &conv.to;
    let is_alone = to.scale.is_none() && to.positions > 1 && to.pitch == to.channels;
    if !matches!(conv.work, Work::Conv(_)) || !is_alone || network.logits.memory == to.memory {
        return None;
    }
    let others = network.layers.iter().filter(|layer| !std::ptr::eq(*layer, conv));
    let users: Vec<&Layer> = others.filter(|layer| layer.rows().any(|row| row.memory == to.memory)).collect();
    let numbers: Option<Vec<Statistic>> = users.into_iter().map(|layer| statistic(layer, to)).collect();
    numbers.filter(|numbers| !numbers.is_empty())
}

fn statistic(layer: &Layer, row: &Row) -> Option<Statistic> {
    let whole: Span = [0, row.positions];
    let number = match &layer.work {
        Work::MeanFloats { spans, shares } if spans[..] == [whole] => RowNumber::Mean { share: shares[0] },
        Work::Most(spans) if spans[..] == [whole] => RowNumber::Most,
        Work::Deviation { share, eps } => RowNumber::Deviation { share: *share, eps: *eps },
        _ => return None,
    };
    let fits = layer.from[..] == [*row] && layer.to.memory != row.memory;
    fits.then_some(Statistic { number, to: layer.to })
}
