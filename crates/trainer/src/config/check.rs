//! The ranges of an experiment's values, each written as "not inside" so that NaN fails too.

use std::collections::HashSet;
use std::fmt::Display;

use crate::config::{
    Config, Data, Encoding, Image, ImageKind, Network, OptimizerOverride, Protocol, Published, Range,
    Schedule, ScheduleKind, Train,
};

/// A value outside its range.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// Dotted path of the key, `networks.0.train.epochs`.
    pub key: String,
    /// The value given.
    pub value: String,
    /// The values that work.
    pub reason: String,
}

type Check = Result<(), Problem>;

fn refuse(key: impl Into<String>, value: impl Display, reason: impl Into<String>) -> Check {
    Err(Problem { key: key.into(), value: value.to_string(), reason: reason.into() })
}

fn within(key: String, value: usize, least: usize, most: usize) -> Check {
    match (least..=most).contains(&value) {
        true => Ok(()),
        false => refuse(key, value, format!("must be in {least}..={most}")),
    }
}

/// Letters, digits, `.`, `_`, `-`, not starting with a dot: safe as part of a file name.
fn file_name(key: &str, name: &str) -> Check {
    let plain = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
    match !name.is_empty() && name.len() <= 100 && !name.starts_with('.') && name.chars().all(plain) {
        true => Ok(()),
        false => refuse(
            key,
            format!("{name:?}"),
            "must be 1 to 100 letters, digits, `.`, `_` or `-`, not starting with `.`: it names files",
        ),
    }
}

impl Config {
    /// The first value outside its range, if any.
    ///
    /// # Errors
    /// Key, value and allowed values.
    pub fn check(&self) -> Check {
        file_name("name", &self.name)?;
        if self.seed > i64::MAX as u64 {
            return refuse("seed", self.seed, format!("must be in 0..={}", i64::MAX));
        }
        self.data.check()?;
        self.encoding.check()?;
        self.protocol.check()?;
        self.train.check("train")?;
        if self.networks.is_empty() {
            return refuse("networks", "[]", "name at least one network");
        }
        let mut labels = HashSet::new();
        for (i, network) in self.networks.iter().enumerate() {
            let at = format!("networks.{i}");
            network.check(&at, &self.train)?;
            if !labels.insert(network.label()) {
                let reason = "two networks go by this name; give one of them a label of its own";
                return refuse(format!("{at}.label"), format!("{:?}", network.label()), reason);
            }
        }
        Ok(())
    }

    /// Fills in what depends on other values, so that the written config says everything.
    pub(crate) fn fill_defaults(&mut self) {
        if let Some(image) = &mut self.encoding.image {
            image.fill_defaults();
        }
        if self.data.scene.is_some() {
            self.data.samples.get_or_insert(1500);
        }
    }
}

impl Data {
    fn check(&self) -> Check {
        match (&self.scene, &self.path) {
            (Some(_), None) | (None, Some(_)) => {}
            (Some(_), Some(path)) => {
                return refuse("data.path", format!("{path:?}"), "give either scene or path, not both");
            }
            (None, None) => {
                return refuse("data", "{}", "needs scene = \"..\" or path = \"..\"");
            }
        }
        if let Some(scene) = &self.scene {
            let known = taxel_scenes::names();
            if !known.contains(&scene.as_str()) {
                let reason = format!("no scene has this name; known: {}", known.join(", "));
                return refuse("data.scene", format!("{scene:?}"), reason);
            }
        }
        within("data.samples".into(), self.samples.unwrap_or(1500), 1, 10_000_000)?;
        let set = |present: bool, name: &'static str| present.then_some(name);
        let foreign = match self.scene {
            Some(_) => set(self.x.is_some(), "x")
                .or(set(self.y.is_some(), "y"))
                .or(set(self.group.is_some(), "group"))
                .or(set(self.group_block.is_some(), "group_block"))
                .or(set(self.channels.is_some(), "channels"))
                .or(set(!self.drop.is_empty(), "drop"))
                .or(set(self.deny_contradictory.is_some(), "deny_contradictory"))
                .or(set(self.attribute.is_some(), "attribute"))
                .or(set(self.resize.is_some(), "resize"))
                .or(set(self.limits.is_some(), "limits")),
            None => set(self.samples.is_some(), "samples").or(set(!self.without.is_empty(), "without")),
        };
        if let Some(name) = foreign {
            let other = if self.scene.is_some() { "data.path" } else { "data.scene" };
            return refuse(format!("data.{name}"), "..", format!("works with {other} only; leave it out"));
        }
        match self.full_scale {
            Some(value) if !(value > 0.0 && value <= f64::from(f32::MAX)) => refuse(
                "data.full_scale",
                value,
                "must be positive and finite, such as 1023 for 10-bit counts",
            ),
            _ => Ok(()),
        }
    }
}

impl Encoding {
    fn check(&self) -> Check {
        self.image.as_ref().map_or(Ok(()), Image::check)
    }
}

impl Image {
    fn check(&self) -> Check {
        let set = |present: bool, name: &'static str| present.then_some(name);
        let (foreign, reason) = match self.kind {
            ImageKind::Raw => (
                set(self.size.is_some(), "size")
                    .or(set(self.range.is_some(), "range"))
                    .or(set(self.colormap.is_some(), "colormap"))
                    .or(set(self.constant.is_some(), "constant")),
                "belongs to kind = \"gadf\" or \"gasf\"; leave it out",
            ),
            ImageKind::Gadf | ImageKind::Gasf => (
                set(self.scale.is_some(), "scale"),
                "belongs to kind = \"raw\"; a field is made from raw readings and has a range",
            ),
        };
        if let Some(name) = foreign {
            return refuse(format!("encoding.image.{name}"), "..", reason);
        }
        let least = if self.range.unwrap_or_default() == Range::PerSample { 2 } else { 1 };
        within("encoding.image.size".into(), self.size.unwrap_or(50), least, 4096)?;
        match self.range {
            Some(Range::Fixed { low, high })
                if !(low.is_finite() && high.is_finite() && (low as f32) < (high as f32)) =>
            {
                let value = format!("{{ low = {low}, high = {high} }}");
                refuse("encoding.image.range", value, "low must be below high, both finite")
            }
            _ => Ok(()),
        }
    }

    fn fill_defaults(&mut self) {
        match self.kind {
            ImageKind::Raw => {
                self.scale.get_or_insert(crate::config::Scale::FullScale);
            }
            ImageKind::Gadf | ImageKind::Gasf => {
                self.size.get_or_insert(50);
                self.range.get_or_insert_default();
                self.colormap.get_or_insert_default();
                self.constant.get_or_insert_default();
            }
        }
    }
}

impl Protocol {
    fn check(&self) -> Check {
        within("protocol.folds".into(), self.folds, 2, 1000)?;
        within("protocol.repetitions".into(), self.repetitions, 1, 1000)
    }
}

impl Train {
    fn check(&self, at: &str) -> Check {
        within(format!("{at}.epochs"), self.epochs, 1, 100_000)?;
        within(format!("{at}.batch_size"), self.batch_size, 1, 65_536)?;
        let optimizer = &self.optimizer;
        OptimizerOverride {
            name: None,
            lr: Some(optimizer.lr),
            momentum: Some(optimizer.momentum),
            weight_decay: Some(optimizer.weight_decay),
        }
        .check(&format!("{at}.optimizer"))?;
        self.schedule.check(&format!("{at}.schedule"))
    }
}

impl OptimizerOverride {
    fn check(&self, at: &str) -> Check {
        match self.lr {
            // Rates are applied in f32: one that rounds to 0 would never learn.
            Some(lr) if !((lr as f32) > 0.0 && (lr as f32).is_finite()) => {
                return refuse(format!("{at}.lr"), lr, "must be positive and finite, usually 1e-4 to 0.1");
            }
            _ => {}
        }
        match self.momentum {
            Some(momentum) if !((0.0..1.0).contains(&momentum)) => {
                return refuse(format!("{at}.momentum"), momentum, "must be in [0, 1)");
            }
            _ => {}
        }
        match self.weight_decay {
            Some(decay) if !((0.0..=1.0).contains(&decay)) => {
                refuse(format!("{at}.weight_decay"), decay, "must be in [0, 1]")
            }
            _ => Ok(()),
        }
    }
}

impl Schedule {
    fn check(&self, at: &str) -> Check {
        if self.kind == ScheduleKind::Constant && (self.at.is_some() || self.factor.is_some()) {
            return refuse(at, "{ kind = \"constant\", .. }", "at and factor belong to kind = \"steps\"");
        }
        if self.kind == ScheduleKind::Steps {
            let steps = self.at.as_deref().unwrap_or_default();
            let inside = |share: &f64| *share > 0.0 && *share < 1.0;
            let ascending = steps.windows(2).all(|pair| pair[0] < pair[1]);
            if steps.is_empty() || !(steps.iter().all(inside) && ascending) {
                let reason = "must be shares of the epochs, ascending in (0, 1), such as [0.6, 0.85]";
                return refuse(format!("{at}.at"), format!("{steps:?}"), reason);
            }
        }
        match self.factor {
            Some(factor) if !(factor > 0.0 && factor <= 1.0) => {
                refuse(format!("{at}.factor"), factor, "must be in (0, 1]")
            }
            _ => Ok(()),
        }
    }
}

impl Network {
    fn check(&self, at: &str, train: &Train) -> Check {
        let entry = match taxel_zoo::find(&self.name) {
            Ok(entry) => entry,
            Err(e) => return refuse(format!("{at}.name"), format!("{:?}", self.name), e.to_string()),
        };
        if let Some(label) = &self.label {
            file_name(&format!("{at}.label"), label)?;
        }
        let sizes = entry.inputs.iter().flat_map(|input| input.keys).chain(&["classes"]);
        if let Some(key) = sizes.into_iter().find(|key| self.set.contains_key(**key)) {
            let reason = "comes from the data and its encoding; leave it out";
            return refuse(format!("{at}.set.{key}"), &self.set[*key], reason);
        }
        let settings = crate::experiment::settings(&self.set);
        if let Err(error @ taxel_zoo::Error::Settings { .. }) = entry.graph(&settings) {
            return refuse(format!("{at}.set"), format!("{:?}", self.set), error.to_string());
        }
        if let Some(optimizer) = &self.train.optimizer {
            optimizer.check(&format!("{at}.train.optimizer"))?;
        }
        self.train(train).check(&format!("{at}.train"))?;
        self.published.as_ref().map_or(Ok(()), |p| p.check(&format!("{at}.published")))
    }
}

impl Published {
    fn check(&self, at: &str) -> Check {
        let scores = [
            ("accuracy", Some(self.accuracy)),
            ("precision", self.precision),
            ("recall", self.recall),
            ("f1", self.f1),
        ];
        for (name, score) in scores {
            if let Some(pair) = score
                && !pair.iter().all(|v| (0.0..=100.0).contains(v))
            {
                let reason = "must be [mean, SD] in %, both in [0, 100]";
                return refuse(format!("{at}.{name}"), format!("{pair:?}"), reason);
            }
        }
        Ok(())
    }
}
