//! The members of an average as models of their own.

use std::ops::Range;

use taxel_graph::Weights;

use super::card::Card;
use super::kind::{AverageMember, ModelKind};

/// A member of an average, by itself.
pub(super) struct Member {
    /// Its card: that of the average with its own kind, name and inputs.
    pub card: Card,
    /// Its tensors, under their own names.
    pub weights: Weights,
    /// Which inputs of the average are its own.
    pub inputs: Range<usize>,
}

/// Returns the name that a tensor of member `at` has in the file of an average.
pub(crate) fn tensor_name(at: usize, name: &str) -> String {
    format!("{at}.{name}")
}

/// Takes an average apart; nothing of any other model.
///
/// # Errors
/// A card whose members do not hold together, in words.
pub(super) fn members(card: &Card, weights: &Weights) -> Result<Vec<Member>, String> {
    let ModelKind::Average { members } = &card.kind else { return Ok(vec![]) };
    let mut first = 0usize;
    let mut found = vec![];
    for (at, AverageMember { name, kind, inputs }) in members.iter().enumerate() {
        if matches!(kind, ModelKind::Average { .. }) {
            return Err(format!("its card says that {name}, which it averages, is an average itself"));
        }
        let end = first.saturating_add(*inputs);
        let own = card.inputs.get(first..end);
        let own = own.ok_or_else(|| format!("its card makes fewer inputs than {name} reads"))?;
        let prefix = tensor_name(at, "");
        let mut tensors = Weights::new();
        for (name, tensor) in weights.iter() {
            if let Some(name) = name.strip_prefix(&prefix) {
                tensors.insert(name, tensor.clone());
            }
        }
        let card = Card { name: name.clone(), kind: kind.clone(), inputs: own.to_vec(), ..card.clone() };
        found.push(Member { card, weights: tensors, inputs: first..end });
        first = end;
    }
    if found.len() < 2 || first != card.inputs.len() {
        return Err(format!(
            "its card says an average of {} members with {first} inputs, and makes {}",
            found.len(),
            card.inputs.len()
        ));
    }
    Ok(found)
}
