//! A network with all that its training needs besides samples.

use std::sync::Arc;

use taxel_graph::{Graph, Weights};

use crate::estimator::search::Search;
use crate::training::recipe::Recipe;

/// A network with all that its training needs besides samples.
#[derive(Debug, Clone)]
pub struct Trainable {
    /// The network; its inputs have the shapes that the encoding makes.
    pub graph: Graph,
    /// How it is trained.
    pub recipe: Recipe,
    /// Recipes among which each fold chooses; then `recipe` is not trained.
    pub search: Option<Search>,
    /// Tensors that it starts from; a head for another number of classes is drawn. Default fresh weights.
    pub start: Option<Arc<Weights>>,
}
