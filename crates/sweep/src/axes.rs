//! The points of a study, one after the other: no list of them is ever in memory.

use rand::RngExt;
use toml::Value;

use crate::error::{Error, Result};
use crate::study::{Draw, Random, Study, values};

/// Values by dotted key.
pub(crate) type Point = Vec<(String, Value)>;

/// Everything that is varied besides the configs.
pub(crate) struct Axes {
    grid: Vec<(String, Vec<Value>)>,
    list: Vec<Point>,
    random: Option<(Random, Vec<(String, Draw)>)>,
}

impl Axes {
    /// Returns the axes of a study.
    ///
    /// # Errors
    /// An axis without values, a key that two axes vary, or more points than can be counted.
    pub fn new(study: &Study) -> Result<Self> {
        let refuse = |reason: String| Error::file(&study.file, reason);
        let array = |(key, value): (String, Value)| match value {
            Value::Array(values) if !values.is_empty() => Ok((key, values)),
            other => Err(refuse(format!("grid.{key} = {other}: must be a list of values to try"))),
        };
        let grid = values(&study.grid).into_iter().map(array).collect::<Result<Vec<_>>>()?;
        let list: Vec<Point> = study.list.iter().map(values).collect();
        let random = match &study.random {
            Some(random) => Some((random.clone(), random.over().map_err(refuse)?)),
            None => None,
        };
        let axes = Axes { grid, list, random };
        let mut known = std::collections::BTreeSet::new();
        for key in axes.keys() {
            if !known.insert(key.clone()) {
                return Err(refuse(format!(
                    "{key}: two of [grid], [[list]] and [random] vary it; leave one"
                )));
            }
        }
        let product = axes.counts().iter().try_fold(1usize, |all, count| all.checked_mul(*count));
        product.map(|_| axes).ok_or_else(|| refuse("the axes have more points than can be counted".into()))
    }

    /// Returns the keys that are varied, each once per axis.
    fn keys(&self) -> Vec<&String> {
        let mut list: Vec<&String> = self.list.iter().flatten().map(|(key, _)| key).collect();
        list.sort();
        list.dedup();
        let grid = self.grid.iter().map(|(key, _)| key);
        let random = self.random.iter().flat_map(|(_, over)| over).map(|(key, _)| key);
        grid.chain(list).chain(random).collect()
    }

    /// Returns the number of values of each axis, the slowest first: keys of the grid, the list, the draws.
    fn counts(&self) -> Vec<usize> {
        let mut counts: Vec<usize> = self.grid.iter().map(|(_, values)| values.len()).collect();
        counts.push(self.list.len().max(1));
        counts.push(self.random.as_ref().map_or(1, |(random, _)| random.draws));
        counts
    }

    /// Returns the number of points; 1 where nothing is varied.
    pub fn len(&self) -> usize {
        self.counts().iter().product()
    }

    /// Returns the point of number `at`.
    pub fn point(&self, at: usize) -> Point {
        let mut rest = at;
        let mut places = vec![];
        for count in self.counts().into_iter().rev() {
            places.push(rest % count);
            rest /= count;
        }
        places.reverse();
        let mut point: Point = self
            .grid
            .iter()
            .zip(&places)
            .map(|((key, values), &place)| (key.clone(), values[place].clone()))
            .collect();
        let (list, draw) = (places[self.grid.len()], places[self.grid.len() + 1]);
        point.extend(self.list.get(list).into_iter().flatten().cloned());
        if let Some((random, over)) = &self.random {
            point.extend(over.iter().map(|(key, how)| (key.clone(), drawn(how, random.seed, draw, key))));
        }
        point
    }
}

/// Returns the value of a key in draw number `draw`: keys that are added do not change the others.
fn drawn(how: &Draw, seed: u64, draw: usize, key: &str) -> Value {
    let mut rng = taxel_base::seed::rng(seed, &format!("sweep/{draw}/{key}"));
    match how {
        Draw::Uniform([low, high]) => Value::Float(low + (high - low) * rng.random::<f64>()),
        Draw::LogUniform([low, high]) => {
            Value::Float((low.ln() + (high.ln() - low.ln()) * rng.random::<f64>()).exp().clamp(*low, *high))
        }
        Draw::Integer([low, high]) => Value::Integer(rng.random_range(*low..=*high)),
        Draw::Choice(values) => values[rng.random_range(0..values.len())].clone(),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn study(text: &str) -> Study {
        toml::from_str(text).unwrap()
    }

    fn shown(point: &Point) -> String {
        point.iter().map(|(key, value)| format!("{key}={value}")).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn a_grid_a_list_and_draws_are_multiplied() {
        let axes = Axes::new(&study(
            r#"
            config = "a.toml"
            [grid]
            seed = [1, 2]
            train.epochs = [3, 4, 5]
            [[list]]
            "train.batch_size" = 8
            train.optimizer = { name = "adam", lr = 0.1 }
            [[list]]
            [random]
            draws = 2
            over = { "train.clip" = { choice = [1.0] } }
            "#,
        ))
        .unwrap();
        assert_eq!(axes.len(), 2 * 3 * 2 * 2);
        let all: Vec<String> = (0..axes.len()).map(|at| shown(&axes.point(at))).collect();
        let optimizer = "train.optimizer={ lr = 0.1, name = \"adam\" } train.batch_size=8";
        assert_eq!(all[0], format!("seed=1 train.epochs=3 {optimizer} train.clip=1.0"));
        assert_eq!(all[2], "seed=1 train.epochs=3 train.clip=1.0");
        assert_eq!(all[4], format!("seed=1 train.epochs=4 {optimizer} train.clip=1.0"));
        assert_eq!(all[12], format!("seed=2 train.epochs=3 {optimizer} train.clip=1.0"));
    }

    #[test]
    fn names_are_varied_below_their_table() {
        let text = r#"
            config = "a.toml"
            [grid]
            networks.0.name = ["mlp", "lstm"]
            train.optimizer.name = ["adam"]
            [random]
            draws = 1
            over.networks.1.name = { choice = ["k"] }
        "#;
        let axes = Axes::new(&study(text)).unwrap();
        let second = "networks.0.name=\"lstm\" train.optimizer.name=\"adam\" networks.1.name=\"k\"";
        assert_eq!((axes.len(), shown(&axes.point(1)).as_str()), (2, second));
    }

    #[test]
    fn draws_stay_in_their_range_and_are_the_same_again() {
        let text = r#"
            config = "a.toml"
            [random]
            draws = 200
            seed = 4
            [random.over]
            a = { uniform = [-1.0, 2.0] }
            b = { log_uniform = [1e-4, 1e-1] }
            c = { integer = [2, 4] }
            d = { choice = ["x", "y"] }
        "#;
        let axes = Axes::new(&study(text)).unwrap();
        let mut below = 0;
        let mut seen = std::collections::BTreeSet::new();
        for at in 0..200 {
            let point = axes.point(at);
            assert_eq!(point, Axes::new(&study(text)).unwrap().point(at));
            assert!((-1.0..=2.0).contains(&point[0].1.as_float().unwrap()));
            let rate = point[1].1.as_float().unwrap();
            assert!((1e-4..=1e-1).contains(&rate));
            // Half of the draws lie below the middle of the logarithms, nearly none of them evenly.
            below += usize::from(rate < 10f64.powf(-2.5));
            seen.insert(format!("{}{}", point[2].1, point[3].1));
        }
        assert!((70..130).contains(&below), "{below}");
        assert_eq!(seen.len(), 6, "{seen:?}");
    }

    #[test]
    fn an_old_spelling_draws_the_same() {
        let over = |draw: &str| {
            let text =
                format!("config = \"a.toml\"\n[random]\ndraws = 3\nover.rate = {{ {draw} = [1e-4, 1e-1] }}");
            let axes = Axes::new(&study(&text))?;
            Ok::<_, Error>((0..3).map(|at| shown(&axes.point(at))).collect::<Vec<_>>())
        };
        assert_eq!(over("log_uniform").unwrap(), over("log-uniform").unwrap());
        let error = over("loguniform").unwrap_err().to_string();
        assert!(error.contains("random.over.rate") && error.contains("{ log_uniform = "), "{error}");
    }

    #[test]
    fn a_key_stands_on_one_axis() {
        let text = "config = \"a\"\n[grid]\nseed = [1]\n[[list]]\nseed = 2\n";
        let error = Axes::new(&study(text)).err().unwrap().to_string();
        assert!(error.contains("seed: two of [grid], [[list]] and [random] vary it"), "{error}");
    }
}
