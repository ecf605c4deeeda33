//! A network's model in bf16, made from one in floats.

use taxel_engine::Precision;

use super::card::Card;
use super::file::Model;
use super::multiplied::multiplied;
use crate::error::{Error, Result};

impl Model {
    /// Returns the same network with the weights of its convolutions and linear layers in bf16, which predicts with products
    /// of bf16 and sums in floats: half the file, and faster where the processor has AVX512-BF16. It can be made everywhere.
    ///
    /// Its certainty and its intervals stay those that were measured in floats. It has no score.
    ///
    /// # Errors
    /// A baseline, an average, or a model in eight bits or in bf16.
    pub fn halved(&self) -> Result<Model> {
        let card = self.card();
        let refuse = |reason: &str| Err(Error::Half { model: card.name.clone(), reason: reason.into() });
        let Some(graph) = card.graph() else {
            return refuse("is no network: only networks have weights in bf16");
        };
        if card.quantized.is_some() {
            return refuse("is in eight bits; take the model in floats that it was made of");
        }
        if card.precision == Precision::Bf16 {
            return refuse("is in bf16 already");
        }
        let mut weights = self.weights().clone();
        for name in multiplied(graph) {
            if let Some(rounded) = weights.get(name).map(taxel_checkpoint::halved) {
                weights.insert(name, rounded);
            }
        }
        Ok(Model::new(Card { precision: Precision::Bf16, score: None, ..card.clone() }, weights))
    }
}
