//! The random numbers of every scene: the seed, and the effects that are left out.
//!
//! # Reference
//!
//! None.

use crate::{Error, Result};
use ndarray::{Array, ArrayViewMut, Axis, RemoveAxis};
use rand::RngExt;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use taxel_base::seed::{Rng, rng};

/// One request to simulate, checked.
pub(crate) struct World<'a> {
    scene: &'static str,
    seed: u64,
    without: &'a [String],
}

impl<'a> World<'a> {
    /// Refuses zero samples and names in `without` that are no removable effect of the scene.
    pub(crate) fn new(
        scene: &'static str,
        samples: usize,
        seed: u64,
        without: &'a [String],
        removable: &[&str],
    ) -> Result<Self> {
        if samples == 0 {
            let expected = "must be at least 1";
            return Err(Error::Parameter { name: "samples", value: "0".into(), expected });
        }
        if let Some(name) = without.iter().find(|name| !removable.contains(&name.as_str())) {
            let hint = taxel_base::names::hint(name, removable.iter().copied());
            return Err(Error::UnknownEffect { scene, name: name.clone(), hint });
        }
        Ok(World { scene, seed, without })
    }

    /// Returns the generator of one purpose, such as `17/noise`.
    pub(crate) fn rng(&self, purpose: &str) -> Rng {
        rng(self.seed, &format!("{}/{purpose}", self.scene))
    }

    /// Checks whether the effect is part of the world.
    pub(crate) fn has(&self, effect: &str) -> bool {
        self.without.iter().all(|name| name != effect)
    }

    /// Returns `with`, or `otherwise` if the effect has been removed.
    pub(crate) fn unless(&self, effect: &str, with: f64, otherwise: f64) -> f64 {
        if self.has(effect) { with } else { otherwise }
    }
}

/// Makes the samples of `x` [N, ..] side by side; what `make` says of each, in their order.
pub(crate) fn each_sample<D, T, F>(x: &mut Array<f32, D>, make: F) -> Vec<T>
where
    D: RemoveAxis,
    T: Send,
    F: Fn(usize, ArrayViewMut<f32, D::Smaller>) -> T + Sync,
{
    let mut each: Vec<_> = x.axis_iter_mut(Axis(0)).collect();
    each.par_iter_mut().enumerate().map(|(i, sample)| make(i, sample.view_mut())).collect()
}

/// Draws from the normal distribution, mean 0, SD 1.
pub(crate) fn normal(rng: &mut Rng) -> f64 {
    rng.sample(StandardNormal)
}

/// Gathers true values by name, sample by sample.
pub(crate) fn columns(names: &[&str], rows: &[Vec<f64>]) -> Vec<(String, Vec<f32>)> {
    let column = |at: usize| rows.iter().map(|row| row[at] as f32).collect();
    names.iter().enumerate().map(|(at, name)| ((*name).into(), column(at))).collect()
}
