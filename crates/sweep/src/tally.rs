//! Scores counted up while results go by: what each setting and each key does, in memory that grows with the number
//! of settings alone.

use std::collections::HashMap;

use taxel_judge::{Contest, MAJORITY, Primary};

use crate::collected::{KeyEffect, ScoreSpread, Setting};
use crate::data_sets::DataSets;
use crate::record::{NetworkScore, TrialResult};
use crate::trial::{Trial, shown};

/// Ranks are for networks that a reader can tell apart.
const RANKED: usize = 30;

/// Mean and spread of numbers that go by (Welford).
#[derive(Debug, Clone, Copy)]
struct RunningSpread {
    count: usize,
    mean: f64,
    squares: f64,
    least: f64,
    most: f64,
}

impl RunningSpread {
    const NONE: RunningSpread =
        RunningSpread { count: 0, mean: 0.0, squares: 0.0, least: f64::INFINITY, most: f64::NEG_INFINITY };

    fn add(&mut self, value: f64) {
        self.count += 1;
        let before = value - self.mean;
        self.mean += before / self.count as f64;
        self.squares += before * (value - self.mean);
        self.least = self.least.min(value);
        self.most = self.most.max(value);
    }

    fn spread(&self) -> ScoreSpread {
        let sd = (self.count > 1).then(|| (self.squares / (self.count - 1) as f64).sqrt());
        ScoreSpread { count: self.count, mean: self.mean, sd, least: self.least, most: self.most }
    }
}

/// Counts by key, in the order in which keys came first.
struct KeyedCounts<K> {
    places: HashMap<K, usize>,
    rows: Vec<(K, RunningSpread)>,
}

impl<K: Clone + Eq + std::hash::Hash> KeyedCounts<K> {
    fn new() -> Self {
        KeyedCounts { places: HashMap::new(), rows: vec![] }
    }

    fn add(&mut self, key: K, value: f64) {
        let place = *self.places.entry(key.clone()).or_insert_with(|| {
            self.rows.push((key, RunningSpread::NONE));
            self.rows.len() - 1
        });
        self.rows[place].1.add(value);
    }
}

/// A network with its settings on the samples of one `[data]` table.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct SettingKey {
    /// Place of the table.
    place: usize,
    source: String,
    /// Varied keys that say which samples a trial has.
    of_data: Keys,
    network: String,
    zoo: String,
    primary: Primary,
    /// Varied keys besides, the seed left out.
    set: Keys,
}

/// Keys and their values.
type Keys = Vec<(String, String)>;

/// All that is counted.
pub(crate) struct Tally {
    settings: KeyedCounts<SettingKey>,
    /// Key, metric, network, value.
    axes: KeyedCounts<(String, Primary, String, String)>,
    data_sets: DataSets,
}

/// A network with its settings on one data set.
struct SettingRow<'a> {
    /// Data sets stand in the order in which they came first.
    data_set: usize,
    /// The data set in words.
    name: String,
    set: String,
    setting: &'a SettingKey,
    count: &'a RunningSpread,
}

impl Tally {
    pub fn new() -> Self {
        Tally { settings: KeyedCounts::new(), axes: KeyedCounts::new(), data_sets: DataSets::default() }
    }

    /// Counts a finished run; `trial` says what the axes say of it.
    pub fn add(&mut self, trial: &Trial, result: &TrialResult) {
        let place = self.data_sets.place(&result.data);
        let keys = trial.set.iter().filter(|(key, _)| *key != "seed");
        let keys: Keys = keys.map(|(key, value)| (key.clone(), shown(value))).collect();
        let (of_data, set): (Keys, Keys) = keys.iter().cloned().partition(|(key, _)| is_data(key));
        for NetworkScore { network, zoo, scores, .. } in &result.networks {
            let Some(score) = scores.primary() else { continue };
            let primary = &result.primary;
            let setting = SettingKey {
                place,
                source: result.data.source.clone(),
                of_data: of_data.clone(),
                network: network.clone(),
                zoo: zoo.clone(),
                primary: primary.clone(),
                set: set.clone(),
            };
            self.settings.add(setting, score);
            for (key, value) in &keys {
                self.axes.add((key.clone(), primary.clone(), network.clone(), value.clone()), score);
            }
        }
    }

    /// Returns the counted settings by data set. A data key that all trials of a data set share is part of its name. A data
    /// key with several values there leads to the same samples, so it is a setting like others.
    fn rows<'a>(&'a self) -> Vec<SettingRow<'a>> {
        let mut shared: HashMap<usize, Vec<&(String, String)>> = HashMap::new();
        for (setting, _) in &self.settings.rows {
            shared
                .entry(self.data_sets.data_set(setting.place))
                .and_modify(|all| all.retain(|pair| setting.of_data.contains(pair)))
                .or_insert_with(|| setting.of_data.iter().collect());
        }
        let row = |(setting, count): &'a (SettingKey, RunningSpread)| {
            let data_set = self.data_sets.data_set(setting.place);
            let shared = &shared[&data_set];
            let name = format!("{} {}", setting.source, words(shared.iter().copied()));
            let others = setting.of_data.iter().filter(|pair| !shared.contains(pair));
            SettingRow {
                data_set,
                name: name.trim().into(),
                set: words(others.chain(&setting.set)),
                setting,
                count,
            }
        };
        self.settings.rows.iter().map(row).collect()
    }

    /// Returns every network with every setting, data sets in the order of the plan, the best of each first.
    pub fn settings(&self) -> Vec<Setting> {
        let mut rows = self.rows();
        let better_first =
            |a: &SettingRow, b: &SettingRow| a.setting.primary.order(b.count.mean, a.count.mean);
        rows.sort_by(|a, b| a.data_set.cmp(&b.data_set).then(better_first(a, b)));
        let setting = |row: SettingRow| Setting {
            source: row.name,
            network: row.setting.network.clone(),
            set: row.set,
            primary: row.setting.primary.clone(),
            score: row.count.spread(),
        };
        rows.into_iter().map(setting).collect()
    }

    /// Returns the effect of each key, keys in alphabetical order, networks in the order of the plan; keys with more than
    /// `most` rows are left out.
    pub fn axes(&self, most: usize) -> Vec<KeyEffect> {
        let mut axes: Vec<KeyEffect> = vec![];
        for ((key, primary, network, value), count) in &self.axes.rows {
            let is_own = |axis: &KeyEffect| axis.key == *key && axis.primary == *primary;
            let at = axes.iter().position(is_own).unwrap_or_else(|| {
                axes.push(KeyEffect { key: key.clone(), primary: primary.clone(), rows: vec![] });
                axes.len() - 1
            });
            axes[at].rows.push((network.clone(), value.clone(), count.spread()));
        }
        axes.retain(|axis| axis.rows.len() <= most);
        axes.sort_by(|a, b| a.key.cmp(&b.key));
        for axis in &mut axes {
            let mut networks: Vec<String> = vec![];
            axis.rows.iter().for_each(|(network, _, _)| {
                if !networks.contains(network) {
                    networks.push(network.clone());
                }
            });
            axis.rows.sort_by_key(|(network, _, _)| networks.iter().position(|known| known == network));
        }
        axes
    }

    /// Returns the networks with their settings by data set, for ranks; the baseline that reads nothing is left out. None
    /// where there are too many to tell apart.
    pub fn contests(&self) -> Option<Vec<Contest>> {
        let mut contests: Vec<(usize, Contest)> = vec![];
        for row in self.rows().into_iter().filter(|row| row.setting.zoo != MAJORITY) {
            let at =
                contests.iter().position(|(data_set, _)| *data_set == row.data_set).unwrap_or_else(|| {
                    let primary = row.setting.primary.clone();
                    contests.push((row.data_set, Contest { name: row.name, primary, scores: vec![] }));
                    contests.len() - 1
                });
            let name = format!("{} {}", row.setting.network, row.set).trim().to_string();
            let scores = &mut contests[at].1.scores;
            scores.push((name, row.count.mean));
            if scores.len() > RANKED {
                return None;
            }
        }
        Some(contests.into_iter().map(|(_, contest)| contest).collect())
    }
}

/// Returns the keys and values on one line.
fn words<'a>(keys: impl Iterator<Item = &'a (String, String)>) -> String {
    keys.map(|(key, value)| format!("{key}={value}")).collect::<Vec<_>>().join(" ")
}

/// Checks whether a key says which samples a trial has.
fn is_data(key: &str) -> bool {
    key == "config" || key.starts_with("data.")
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use taxel_learn::metrics::Scores;

    use super::*;
    use crate::trial::DataOf;

    /// Adds a finished trial with two networks and majority.
    fn add(tally: &mut Tally, set: &str, data: &str, accuracy: [f64; 2]) {
        add_on(tally, set, (data, set), accuracy);
    }

    /// Adds such a trial on samples of a `[data]` table and a digest.
    fn add_on(tally: &mut Tally, set: &str, (data, digest): (&str, &str), accuracy: [f64; 2]) {
        let data = DataOf {
            source: "simulated: s".into(),
            digest: digest.into(),
            set: data.into(),
            facts: String::new(),
            weights: String::new(),
        };
        let trial = Trial {
            identity: set.into(),
            name: "t".into(),
            set: serde_json::from_str(set).unwrap(),
            fold: None,
            data: data.clone(),
            program: String::new(),
            config: String::new(),
        };
        let score = |network: &str, accuracy| NetworkScore {
            network: network.into(),
            zoo: network.into(),
            folds: 1,
            scores: Scores::new([("accuracy", accuracy)]),
        };
        let primary = Primary::default();
        let networks = vec![score("a", accuracy[0]), score("b", accuracy[1]), score(MAJORITY, 1.0)];
        let result = TrialResult { identity: set.into(), name: "t".into(), data, seed: 0, primary, networks };
        tally.add(&trial, &result);
    }

    #[test]
    fn seeds_are_averaged_and_data_sets_kept_apart() {
        let mut tally = Tally::new();
        add(&mut tally, r#"{"seed":0,"lr":0.1,"data.samples":40}"#, "40", [80.0, 60.0]);
        add(&mut tally, r#"{"seed":1,"lr":0.1,"data.samples":40}"#, "40", [90.0, 70.0]);
        add(&mut tally, r#"{"seed":0,"lr":0.2,"data.samples":40}"#, "40", [95.0, 50.0]);
        add(&mut tally, r#"{"seed":0,"lr":0.1,"data.samples":80}"#, "80", [99.0, 98.0]);
        let settings = tally.settings();
        let shown: Vec<String> = settings
            .iter()
            .map(|s| format!("{}|{}|{}|{}", s.source, s.network, s.set, s.score.mean))
            .collect();
        assert_eq!(shown[0], "simulated: s data.samples=40|a|lr=0.2|95");
        assert_eq!(shown[1], "simulated: s data.samples=40|a|lr=0.1|85");
        assert_eq!(shown[6], "simulated: s data.samples=80|a|lr=0.1|99");
        let score = settings[1].score;
        assert_eq!((score.count, score.least, score.most), (2, 80.0, 90.0));
        assert!((score.sd.unwrap() - 50f64.sqrt()).abs() < 1e-12);

        let contests = tally.contests().unwrap();
        assert_eq!(contests.len(), 2);
        assert_eq!(contests[0].scores.len(), 4, "majority is left out: {:?}", contests[0]);
        assert_eq!(contests[0].of("b lr=0.1"), Some(65.0));

        let axes = tally.axes(300);
        let keys: Vec<&str> = axes.iter().map(|axis| axis.key.as_str()).collect();
        assert_eq!(keys, ["data.samples", "lr"], "the seed is no axis");
        let first: Vec<(&str, &str, f64)> =
            axes[1].rows.iter().take(2).map(|(n, v, s)| (n.as_str(), v.as_str(), s.mean)).collect();
        assert_eq!(first, [("a", "0.1", (80.0 + 90.0 + 99.0) / 3.0), ("a", "0.2", 95.0)]);
        assert!(tally.axes(3).is_empty());
    }

    /// Ranks over data sets take them to be independent.
    #[test]
    fn the_same_samples_are_one_data_set_under_whatever_config() {
        let mut tally = Tally::new();
        // One table in three configs, with two seeds; a fourth config writes the same samples otherwise.
        for (config, table) in [("a", "t"), ("b", "t"), ("c", "t"), ("d", "t, by another path")] {
            for seed in ["0", "1"] {
                let set = format!(r#"{{"config":"{config}","seed":{seed}}}"#);
                add_on(&mut tally, &set, (table, seed), [80.0, 60.0]);
            }
        }
        // Another data set has a config of its own: that is its name.
        add_on(&mut tally, r#"{"config":"e","seed":0}"#, ("u", "2"), [70.0, 50.0]);
        let contests = tally.contests().unwrap();
        let names: Vec<&str> = contests.iter().map(|contest| contest.name.as_str()).collect();
        assert_eq!(names, ["simulated: s", "simulated: s config=e"]);
        assert_eq!(contests[0].of("a config=d"), Some(80.0));
        assert_eq!((contests[0].scores.len(), contests[1].scores.len()), (8, 2));
        let settings = tally.settings();
        assert_eq!((settings[0].set.as_str(), settings[0].score.count), ("config=a", 2));
        assert_eq!(settings.last().unwrap().source, "simulated: s config=e");
    }
}
