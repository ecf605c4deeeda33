//! The numbers of messages by their names: the fields or keys that lead to them.

use std::collections::HashMap;

/// The numbers of one message, and their names where these are wanted.
#[derive(Debug, Default)]
pub(crate) struct Numbers {
    pub values: Vec<f64>,
    /// The path to each: `wrench.force.x`, `data[3]`; empty where names are not wanted.
    pub names: Vec<String>,
    pub has_names: bool,
    /// The texts of a list called `name` at the top: those of the joints of `sensor_msgs/JointState`.
    pub labels: Vec<String>,
    path: String,
}

impl Numbers {
    /// Begins another message.
    pub fn begin(&mut self, has_names: bool) {
        self.values.clear();
        self.names.clear();
        self.labels.clear();
        self.path.clear();
        self.has_names = has_names;
    }

    /// Goes into a field. Returns where to [`leave`](Self::leave) it.
    pub fn enter(&mut self, field: &str) -> usize {
        let before = self.path.len();
        if self.has_names {
            self.path.extend((before > 0).then_some('.'));
            self.path.push_str(field);
        }
        before
    }

    /// Goes into a place of a list.
    pub fn enter_place(&mut self, place: usize) -> usize {
        let before = self.path.len();
        if self.has_names {
            self.path.push_str(&format!("[{place}]"));
        }
        before
    }

    /// Returns where to leave what is not entered: a single value is at the path of its field.
    pub fn here(&self) -> usize {
        self.path.len()
    }

    /// Checks whether nothing was entered.
    pub fn is_at_top(&self) -> bool {
        self.path.is_empty()
    }

    /// Takes a text, which may be the name of a joint.
    pub fn push_text(&mut self, text: &str) {
        let place = self.path.strip_prefix("name[").and_then(|rest| rest.strip_suffix(']'));
        if place.is_some_and(|place| place.parse::<usize>().is_ok()) {
            self.labels.push(text.into());
        }
    }

    /// Gives names to the numbers of each list at the top that has as many as there are joints by these: `position[1]` becomes
    /// `position.elbow`.
    pub fn name_joints(&mut self) {
        let labels = &self.labels;
        if labels.is_empty() || labels.iter().enumerate().any(|(at, label)| labels[..at].contains(label)) {
            return;
        }
        fn in_list(name: &str) -> Option<(&str, usize)> {
            let (list, place) = name.strip_suffix(']')?.split_once('[')?;
            Some((list, place.parse().ok().filter(|_| !list.is_empty() && !list.contains('.'))?))
        }
        let mut counts: HashMap<String, usize> = HashMap::new();
        for (list, _) in self.names.iter().filter_map(|name| in_list(name)) {
            *counts.entry(list.into()).or_default() += 1;
        }
        for name in &mut self.names {
            let joint = in_list(name).filter(|(list, _)| counts.get(*list) == Some(&labels.len()));
            if let Some((list, label)) = joint.and_then(|(list, place)| Some((list, labels.get(place)?))) {
                *name = format!("{list}.{label}");
            }
        }
    }

    /// Goes back to where the path was before.
    pub fn leave(&mut self, before: usize) {
        self.path.truncate(before);
    }

    /// Adds a number at the path.
    pub fn push(&mut self, value: f64) {
        self.values.push(value);
        if self.has_names {
            self.names.push(self.path.clone());
        }
    }
}

/// The names of the numbers of a first message, to which those of all others are matched.
#[derive(Debug, Default)]
pub(crate) struct Template {
    pub names: Vec<String>,
    places: HashMap<String, usize>,
}

impl Template {
    /// Takes the names of the first message; refuses two of one name.
    pub fn of(names: &[String]) -> Result<Self, String> {
        let mut places = HashMap::with_capacity(names.len());
        for (at, name) in names.iter().enumerate() {
            if places.insert(name.clone(), at).is_some() {
                return Err(twice(name));
            }
        }
        Ok(Self { names: names.to_vec(), places })
    }

    /// Brings the numbers of a message into the order of the first, or says what it lacks or has more.
    pub fn arrange(&self, numbers: &mut Numbers) -> Result<(), String> {
        if numbers.names == self.names {
            return Ok(());
        }
        let mut values: Vec<Option<f64>> = vec![None; self.names.len()];
        let mut more = None;
        for (name, value) in numbers.names.iter().zip(&numbers.values) {
            match self.places.get(name).map(|at| &mut values[*at]) {
                None => more = more.or(Some(name)),
                Some(Some(_)) => return Err(twice(name)),
                Some(empty) => *empty = Some(*value),
            }
        }
        let how = "write the same in every message, or choose fields that are always there with topics";
        if let Some(at) = values.iter().position(Option::is_none) {
            return Err(format!("has no number {:?}, which message 0 has; {how}", self.names[at]));
        }
        if let Some(name) = more {
            return Err(format!("has {name:?}, which message 0 has not; {how}"));
        }
        numbers.values = values.into_iter().flatten().collect();
        Ok(())
    }
}

fn twice(name: &str) -> String {
    format!("has {name:?} twice; give each number a name of its own")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(all: &[(&str, f64)]) -> Numbers {
        let mut numbers = Numbers::default();
        numbers.begin(true);
        for (name, value) in all {
            let before = numbers.enter(name);
            numbers.push(*value);
            numbers.leave(before);
        }
        numbers
    }

    #[test]
    fn numbers_are_matched_by_name() {
        let first = numbers(&[("a", 1.0), ("b", 2.0)]);
        let template = Template::of(&first.names).unwrap();
        let arranged = |all: &[(&str, f64)]| {
            let mut numbers = numbers(all);
            template.arrange(&mut numbers).map(|()| numbers.values)
        };
        assert_eq!(arranged(&[("a", 3.0), ("b", 4.0)]).unwrap(), [3.0, 4.0]);
        assert_eq!(arranged(&[("b", 4.0), ("a", 3.0)]).unwrap(), [3.0, 4.0]);
        for (odd, why) in [
            (&[("a", 1.0)][..], "has no number \"b\""),
            (&[("a", 1.0), ("b", 1.0), ("c", 1.0)], "has \"c\", which"),
            (&[("b", 1.0), ("b", 1.0), ("a", 1.0)], "has \"b\" twice"),
        ] {
            assert!(arranged(odd).unwrap_err().starts_with(why), "{odd:?}");
        }
        assert!(Template::of(&["a".into(), "a".into()]).is_err());
    }

    #[test]
    fn joints_name_the_lists_that_are_as_long() {
        let names = ["position[0]", "position[1]", "effort[0]", "a.b[0]", "a.b[1]", "x"];
        let named = |labels: &[&str]| {
            let mut numbers = numbers(&names.map(|name| (name, 0.0)));
            numbers.labels = labels.iter().map(ToString::to_string).collect();
            numbers.name_joints();
            numbers.names.join(" ")
        };
        assert_eq!(named(&["elbow", "wrist"]), "position.elbow position.wrist effort[0] a.b[0] a.b[1] x");
        assert_eq!(named(&["elbow", "elbow"]), names.join(" "));
        assert_eq!(named(&[]), names.join(" "));
    }

    #[test]
    fn paths_are_written_where_they_are_wanted() {
        let mut numbers = Numbers::default();
        for (has_names, want) in [(true, vec!["force.x[2]"]), (false, vec![])] {
            numbers.begin(has_names);
            let outer = numbers.enter("force");
            let inner = numbers.enter("x");
            numbers.enter_place(2);
            numbers.push(1.0);
            numbers.leave(inner);
            numbers.leave(outer);
            assert_eq!(
                (&numbers.names, &numbers.values),
                (&want.iter().map(ToString::to_string).collect(), &vec![1.0])
            );
        }
    }
}
