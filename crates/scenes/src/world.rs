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
use std::collections::BTreeMap;
use taxel_base::seed::{Rng, rng};

/// How much of an effect a scene has, by the effect's name: from 0, left out, to 1, as it is.
pub type Factors = BTreeMap<String, f64>;

/// The effects that a scene works without.
pub(crate) struct Removable {
    /// Those that may be there in part.
    pub(crate) graded: &'static [&'static str],
    /// Those that are there or not.
    pub(crate) switched: &'static [&'static str],
}

impl Removable {
    pub(crate) fn has(&self, effect: &str) -> bool {
        self.names().any(|name| name == effect)
    }

    fn names(&self) -> impl Iterator<Item = &'static str> {
        self.graded.iter().chain(self.switched).copied()
    }

    /// Refuses names that are no removable effect of the scene.
    fn check<'n>(&self, scene: &'static str, mut names: impl Iterator<Item = &'n String>) -> Result<()> {
        let Some(name) = names.find(|name| !self.has(name)) else { return Ok(()) };
        Err(Error::UnknownEffect {
            scene,
            name: name.clone(),
            hint: taxel_base::names::hint(name, self.names()),
        })
    }

    /// Refuses factors that an effect cannot have.
    fn check_factors(&self, without: &[String], factors: &Factors) -> Result<()> {
        for (name, &factor) in factors {
            let expected = if !(0.0..=1.0).contains(&factor) {
                "must be from 0, without the effect, to 1, as it is"
            } else if without.contains(name) {
                "names an effect that `without` leaves out; keep one of the two"
            } else if self.switched.contains(&name.as_str()) && factor > 0.0 && factor < 1.0 {
                "must be 0 or 1, since this effect is there or not"
            } else {
                continue;
            };
            return Err(Error::Parameter {
                name: "factors",
                value: format!("{{ {name} = {factor} }}"),
                expected,
            });
        }
        Ok(())
    }
}

/// One request to simulate, checked.
pub(crate) struct World<'a> {
    scene: &'static str,
    seed: u64,
    without: &'a [String],
    factors: &'a Factors,
}

impl<'a> World<'a> {
    /// Refuses zero samples, names in `without` and `factors` that are no removable effect of the scene, and factors that an
    /// effect cannot have.
    pub(crate) fn new(
        scene: &'static str,
        samples: usize,
        seed: u64,
        without: &'a [String],
        factors: &'a Factors,
        removable: &Removable,
    ) -> Result<Self> {
        if samples == 0 {
            let expected = "must be at least 1";
            return Err(Error::Parameter { name: "samples", value: "0".into(), expected });
        }
        removable.check(scene, without.iter().chain(factors.keys()))?;
        removable.check_factors(without, factors)?;
        Ok(World { scene, seed, without, factors })
    }

    /// Returns the generator of one purpose, such as `17/noise`.
    pub(crate) fn rng(&self, purpose: &str) -> Rng {
        rng(self.seed, &format!("{}/{purpose}", self.scene))
    }

    /// Checks whether the effect is part of the world.
    pub(crate) fn has(&self, effect: &str) -> bool {
        self.factor(effect) > 0.0
    }

    /// Returns `with`, or `otherwise` if the effect has been removed; of an effect that is there in part a value between the
    /// two, of positive ones on the scale of their logarithm.
    pub(crate) fn unless(&self, effect: &str, with: f64, otherwise: f64) -> f64 {
        match self.factor(effect) {
            1.0 => with,
            0.0 => otherwise,
            part if with > 0.0 && otherwise > 0.0 => otherwise * (with / otherwise).powf(part),
            part => otherwise + part * (with - otherwise),
        }
    }

    fn factor(&self, effect: &str) -> f64 {
        if self.without.iter().any(|name| name == effect) {
            return 0.0;
        }
        self.factors.get(effect).copied().unwrap_or(1.0)
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
