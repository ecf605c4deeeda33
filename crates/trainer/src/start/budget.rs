//! How long a first experiment takes here, and what of it fits a budget.

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use taxel_data::Dataset;
use taxel_learn::{Recipe, augmented, clean};
use taxel_zoo::Registry;

use crate::error::Result;
use crate::experiment::{Experiment, Overrides};
use crate::measured::{Estimate, measured};
use crate::start::families::{AVERAGE, ROCKET, copies};
use crate::start::start::Start;

/// Fewest epochs of a recipe that is shortened.
const LEAST_EPOCHS: usize = 20;
/// Seconds of MiniRocket's ridge times the cube of its samples, or of its features where these are fewer; a core of 2023.
const RIDGE: f64 = 2e-10;
const ROCKET_FEATURES: f64 = 1e4;
/// How much faster so many threads are than one: threads to this power. Two are 1.6 times as fast, as on one core of two threads.
const SPEED_OF_THREADS: f64 = 0.7;
/// Share of the budget that the estimate may take: what it leaves out are tests, tables and files.
const SHARE: f64 = 0.8;

impl Start {
    /// Measures a few epochs of each network, clean and under faults, where samples are encoded anew in every epoch, and each baseline, on
    /// up to 256 samples.
    ///
    /// # Errors
    /// Samples that the experiment cannot learn from.
    pub fn measured(
        &self,
        dataset: &Dataset,
        registry: &Registry,
        cancel: &AtomicBool,
    ) -> Result<Vec<Estimate>> {
        let experiment = Experiment::parse(&self.to_toml(), &self.file(), &Overrides::default(), registry)?;
        let config = experiment.config();
        let networks = config.networks.iter().map(|network| network.label.clone());
        let baselines = config.methods().into_iter().map(|method| method.name().to_string());
        let averages = config.averages.iter().map(|average| average.label.clone());
        let twins = config.networks.iter().map(|network| augmented(&network.label));
        let names: Vec<String> = networks.chain(baselines).chain(averages).chain(twins).collect();
        measured(&experiment, (registry, dataset), &names, cancel)
    }

    /// Leaves out what does not fit `budget` on `threads` threads: baselines that take more than half of it by themselves, epochs down to
    /// half, then the last networks, and of one network epochs down to 20, then training under faults.
    pub fn within(mut self, budget: Duration, estimates: &[Estimate], threads: usize) -> Self {
        let most = SHARE * budget.as_secs_f64();
        let takes_most =
            |estimate: &&Estimate| !estimate.is_network && self.takes(estimate) / speed(threads) > most / 2.0;
        let slow: Vec<&Estimate> = estimates.iter().filter(takes_most).collect();
        let is_slow = |name: &str| slow.iter().any(|estimate| name == estimate.name);
        self.family.baselines.retain(|name| !is_slow(name));
        if self.family.averaged.iter().any(|name| is_slow(name)) {
            self.family.averaged.clear();
        }
        let mut smallest = self.clone();
        for candidate in self.smaller() {
            let seconds = candidate.seconds(estimates, threads);
            smallest = Start { minutes: Some(seconds / 60.0), ..candidate };
            if seconds <= most {
                break;
            }
        }
        smallest
    }

    /// Lists this experiment and ever smaller ones.
    fn smaller(&self) -> Vec<Start> {
        let whole = self.family.epochs;
        let mut all = vec![];
        for is_hardened in [self.is_hardened, false] {
            for networks in (1..=self.family.networks.len()).rev() {
                let least = if networks == 1 { LEAST_EPOCHS.min(whole) } else { whole / 2 };
                let mut epochs = whole;
                loop {
                    let mut one = Start { is_hardened, ..self.clone() };
                    one.family.networks.truncate(networks);
                    one.family.epochs = epochs;
                    all.push(one);
                    if epochs <= least {
                        break;
                    }
                    epochs = (epochs * 4 / 5).max(least);
                }
            }
        }
        all
    }

    /// Estimates the seconds of the whole experiment.
    fn seconds(&self, estimates: &[Estimate], threads: usize) -> f64 {
        estimates.iter().map(|estimate| self.takes(estimate)).sum::<f64>() / speed(threads)
    }

    /// Estimates the seconds that one method takes on one thread, 0 if it is left out.
    fn takes(&self, estimate: &Estimate) -> f64 {
        let (name, family) = (clean(&estimate.name), &self.family);
        let is_tried = family.networks.iter().chain(&family.baselines).any(|tried| *tried == name)
            || name == AVERAGE && !family.averaged.is_empty();
        let is_augmented = name != estimate.name;
        if !is_tried || is_augmented && !self.is_hardened {
            return 0.0;
        }
        let has_twin = self.is_hardened && family.augmented(self.trained).contains(&name);
        let seen_again = if has_twin && !estimate.is_network { copies() as f64 } else { 0.0 };
        let trained = self.trained as f64;
        let ridge = |samples: f64| {
            if name == ROCKET { RIDGE * samples.min(ROCKET_FEATURES).powi(3) } else { 0.0 }
        };
        let each = estimate.begin * (1.0 + seen_again) + estimate.epoch * self.epochs() as f64;
        (each * trained + ridge(trained) + ridge(seen_again * trained)) * self.folds as f64
    }

    /// Returns the epochs of a fold, of which few samples get more.
    fn epochs(&self) -> usize {
        let recipe = toml::from_str::<Recipe>(&self.family.recipe());
        recipe.map_or(self.family.epochs, |recipe| recipe.for_samples(self.trained).epochs)
    }

    /// Returns the name of its config in messages.
    pub fn file(&self) -> String {
        format!("{}.toml", self.name())
    }
}

fn speed(threads: usize) -> f64 {
    (threads.max(1) as f64).powf(SPEED_OF_THREADS)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use ndarray::Array3;
    use taxel_data::{Layout, ReadOptions};

    use super::*;

    fn start() -> Start {
        let x = Array3::from_shape_fn((6000, 2, 24), |(i, channel, t)| (i * channel + t) as f32);
        let labels: Vec<usize> = (0..6000).map(|i| i % 3).collect();
        let dataset = Dataset::new("skin", Layout::Series, x.into_dyn(), &labels).unwrap();
        Start::new(&dataset, "skin.npz".as_ref(), &ReadOptions::default())
    }

    #[test]
    fn few_samples_get_more_epochs() {
        let few = Start { trained: 240, ..start() };
        // 800 steps of four batches.
        assert_eq!((few.epochs(), start().epochs()), (200, 80));
    }

    #[test]
    fn a_ridge_of_too_many_copies_is_left_out() {
        let only = "only = [\"dilated-resnet-rocket-1d\", \"resnet8-lite-1d\", \"dilated-resnet-1d\"]";
        let few = Start { trained: 1600, ..start() };
        assert!(start().to_toml().contains(only) && !few.to_toml().contains("only"), "{}", start().to_toml());
    }

    #[test]
    fn what_does_not_fit_is_left_out_in_order() {
        let networks = ["dilated-resnet-rocket-1d", "resnet8-lite-1d", "dilated-resnet-1d"];
        let of = |name: &str, epoch| Estimate { name: name.into(), is_network: true, begin: 0.0, epoch };
        let twins = networks.map(augmented);
        let twins = twins.iter().map(|name| of(name, 1.3e-4));
        let estimates: Vec<Estimate> = networks.map(|name| of(name, 1e-4)).into_iter().chain(twins).collect();
        // 4800 samples, 5 folds and 80 epochs: 442 s for each network and its twin.
        let fitted = |seconds: u64| {
            let start = start().within(Duration::from_secs(seconds), &estimates, 1);
            (start.family.networks.len(), start.family.epochs, start.is_hardened)
        };
        assert_eq!(fitted(2000), (3, 80, true));
        assert_eq!(fitted(1000), (3, 40, true));
        assert_eq!(fitted(700), (2, 40, true));
        assert_eq!(fitted(300), (1, 40, true));
        assert_eq!(fitted(150), (1, 20, true));
        assert_eq!(fitted(61), (1, 20, false));
        let slow = Estimate { name: "k-nn".into(), is_network: false, begin: 3e-2, epoch: 0.0 };
        // 4800 samples and 5 folds: 720 s.
        let with_slow = [&estimates[..], &[slow]].concat();
        let baselines =
            |seconds: u64| start().within(Duration::from_secs(seconds), &with_slow, 1).family.baselines.len();
        assert_eq!((baselines(1900), baselines(1700)), (3, 2), "a baseline that takes more than half");
        let faster = start().within(Duration::from_secs(1100), &estimates, 2);
        assert_eq!((faster.family.networks.len(), faster.family.epochs), (3, 80), "two threads");
        assert!(faster.minutes.unwrap() <= 0.8 * 1100.0 / 60.0);
    }
}
