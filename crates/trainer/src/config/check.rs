//! The ranges of an experiment's values, each written as "not inside" so that NaN fails too.

use std::collections::HashSet;
use std::fmt::Display;

use taxel_graph::Loss;
use toml::{Table, Value};

use crate::config::{
    Baseline, Choose, ClassWeights, Config, Data, EarlyStopping, Encoding, Image, ImageKind, Network,
    OptimizerName, OptimizerOverride, Protocol, ProtocolKind, Published, Range, Scale, Schedule,
    ScheduleKind, Train, TrainOverride,
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
        if let Some(choose) = &self.choose {
            choose.check(&self.train)?;
        }
        if self.networks.is_empty() {
            return refuse("networks", "[]", "name at least one network");
        }
        let mut labels = HashSet::new();
        for (i, network) in self.networks.iter().enumerate() {
            let at = format!("networks.{i}");
            network.check(&at, &self.train)?;
            let train = network.train(&self.train);
            if train.augment.is_some() && !self.encoding.is_warpable() {
                let reason =
                    "moves pixels: it needs encoding.image of kind \"raw\" or \"frame\", or encoding.tensor";
                let key = if network.train.augment.is_some() {
                    format!("{at}.train.augment")
                } else {
                    "train.augment".into()
                };
                return refuse(key, "{ .. }", reason);
            }
            if train.loss == Loss::SoftmaxCrossEntropy && !self.data.attributes.is_empty() {
                let reason = "several attributes (data.attributes) need \"multi-label-soft-margin\" or \
                              \"mean-squared-error\"";
                let key = if network.train.loss.is_some() {
                    format!("{at}.train.loss")
                } else {
                    "train.loss".into()
                };
                return refuse(key, "\"softmax-cross-entropy\"", reason);
            }
            if let Some(choose) = &self.choose {
                for combination in choose.combinations() {
                    train.with(&combination)?.check("choose.grid")?;
                }
            }
            if !labels.insert(network.label()) {
                let reason = "two networks go by this name; give one of them a label of its own";
                return refuse(format!("{at}.label"), format!("{:?}", network.label()), reason);
            }
        }
        for (i, Baseline(method)) in self.baselines.iter().flatten().enumerate() {
            if !labels.insert(method.name()) {
                let reason = "two rows of the table would go by this name; leave one of them out";
                return refuse(format!("baselines.{i}"), format!("{:?}", method.name()), reason);
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
        self.protocol.fill_defaults();
        self.baselines.get_or_insert_with(|| taxel_baselines::Method::all().map(Baseline).to_vec());
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
            if let Err(error) = taxel_scenes::Settings::read(scene, Value::Table(self.set.clone())) {
                return refuse(
                    "data.set",
                    self.set.to_string().trim().replace('\n', ", "),
                    error.to_string(),
                );
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
                .or(set(self.test.is_some(), "test"))
                .or(set(self.test_above.is_some(), "test_above"))
                .or(set(self.resize.is_some(), "resize"))
                .or(set(self.limits.is_some(), "limits")),
            None => set(self.samples.is_some(), "samples")
                .or(set(!self.without.is_empty(), "without"))
                .or(set(!self.set.is_empty(), "set")),
        };
        if let Some(name) = foreign {
            let other = if self.scene.is_some() { "data.path" } else { "data.scene" };
            return refuse(format!("data.{name}"), "..", format!("works with {other} only; leave it out"));
        }
        if self.test.is_none() && self.test_above.is_some() {
            return refuse("data.test_above", "..", "needs the name of an array in data.test");
        }
        if let Some(i) =
            (1..self.attributes.len()).find(|&i| self.attributes[..i].contains(&self.attributes[i]))
        {
            let reason = "is there twice; give every column of labels its own name";
            return refuse(format!("data.attributes.{i}"), format!("{:?}", self.attributes[i]), reason);
        }
        if !self.attributes.is_empty() && self.attribute.is_some() {
            return refuse(
                "data.attribute",
                "..",
                "picks one column, data.attributes takes all; keep one of them",
            );
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
        within("encoding.baseline".into(), self.baseline.unwrap_or(1), 1, 1_000_000)?;
        if let Some(tensor) = self.tensor {
            within("encoding.tensor.frames".into(), tensor.frames.unwrap_or(1), 1, 4096)?;
            no_colours("encoding.tensor.scale", tensor.scale)?;
        }
        no_colours("encoding.signal.scale", Some(self.signal.scale))?;
        self.image.as_ref().map_or(Ok(()), Image::check)
    }
}

/// ImageNet's scale is of three colours.
fn no_colours(key: &str, scale: Option<Scale>) -> Check {
    match scale {
        Some(Scale::Imagenet) => refuse(key, "\"imagenet\"", "belongs to encoding.image of three channels"),
        _ => Ok(()),
    }
}

impl Encoding {
    /// Whether pixels or taxels lie side by side as on the sensor.
    fn is_warpable(&self) -> bool {
        let pixels = |image: &Image| matches!(image.kind, ImageKind::Raw | ImageKind::Frame);
        self.tensor.is_some() || self.image.as_ref().is_some_and(pixels)
    }
}

impl Image {
    fn check(&self) -> Check {
        let set = |present: bool, name: &'static str| present.then_some(name);
        let field = set(self.size.is_some(), "size")
            .or(set(self.range.is_some(), "range"))
            .or(set(self.colormap.is_some(), "colormap"))
            .or(set(self.constant.is_some(), "constant"));
        let picture = set(self.scale.is_some(), "scale")
            .or(set(self.resize.is_some(), "resize"))
            .or(set(self.red.is_some(), "red"));
        let frame = set(self.frame.is_some(), "frame");
        let window = set(self.window.is_some(), "window");
        let (foreign, reason) = match self.kind {
            ImageKind::Raw => (
                field.or(frame).or(window),
                "belongs to another kind of image (fields, frames); leave it out",
            ),
            ImageKind::Frame => (field.or(window), "belongs to kind = \"gadf\" or \"gasf\"; leave it out"),
            ImageKind::Numatac => {
                (field.or(picture).or(frame), "does not apply to kind = \"numatac\"; leave it out")
            }
            ImageKind::Rows => {
                no_colours("encoding.image.scale", self.scale)?;
                let sized = set(self.resize.is_some(), "resize").or(set(self.red.is_some(), "red"));
                (field.or(sized).or(frame).or(window), "does not apply to kind = \"rows\"; leave it out")
            }
            ImageKind::Gadf | ImageKind::Gasf => (
                picture.or(frame).or(window),
                "belongs to kind = \"raw\"; a field is made from raw readings and has a range",
            ),
        };
        if let Some(name) = foreign {
            return refuse(format!("encoding.image.{name}"), "..", reason);
        }
        for side in self.resize.iter().flatten() {
            within("encoding.image.resize".into(), *side, 1, 4096)?;
        }
        within("encoding.image.window".into(), self.window.unwrap_or(300), 1, 1_000_000)?;
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
            ImageKind::Raw | ImageKind::Frame => {
                self.scale.get_or_insert(Scale::FullScale);
            }
            ImageKind::Rows => {
                self.scale.get_or_insert(Scale::ZScore);
            }
            ImageKind::Numatac => {
                self.window.get_or_insert(300);
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

/// A share of the samples.
fn share(key: impl Into<String>, value: f64) -> Check {
    match value > 0.0 && value < 1.0 {
        true => Ok(()),
        false => refuse(key, value, "must be a share of the samples, in (0, 1)"),
    }
}

impl Protocol {
    fn check(&self) -> Check {
        use ProtocolKind::{FewSamples, KFold, LeaveGroupOut, Official, RandomSplits};
        let allowed = |present: bool, name: &str, kinds: &[ProtocolKind], reason: &str| match present
            && !kinds.contains(&self.kind)
        {
            true => refuse(format!("protocol.{name}"), "..", reason),
            false => Ok(()),
        };
        allowed(self.folds.is_some(), "folds", &[KFold], "belongs to kind = \"k-fold\"; leave it out")?;
        let reason = "belongs to kind = \"random-splits\" or \"few-samples\"; leave it out";
        allowed(self.test.is_some(), "test", &[RandomSplits, FewSamples], reason)?;
        let reason = "belongs to kind = \"random-splits\"; leave it out";
        allowed(self.validation.is_some(), "validation", &[RandomSplits], reason)?;
        let reason = "belongs to kind = \"few-samples\"; leave it out";
        allowed(self.per_class.is_some(), "per_class", &[FewSamples], reason)?;
        within("protocol.folds".into(), self.folds.unwrap_or(5), 2, 1000)?;
        within("protocol.repetitions".into(), self.repetitions, 1, 1000)?;
        if self.repetitions > 1 && matches!(self.kind, LeaveGroupOut | Official) {
            let reason = "this kind of protocol has one cut only: repeat it with another --seed";
            return refuse("protocol.repetitions", self.repetitions, reason);
        }
        let (test, validation) = (self.test.unwrap_or(0.2), self.validation.unwrap_or(0.0));
        share("protocol.test", test)?;
        if validation != 0.0 {
            share("protocol.validation", validation)?;
        }
        if test + validation >= 1.0 {
            let reason = "test and validation together leave nothing to train on";
            return refuse("protocol.validation", validation, reason);
        }
        let Some(per_class) = &self.per_class else { return Ok(()) };
        let ascending = per_class.windows(2).all(|pair| pair[0] < pair[1]);
        match per_class.first() {
            Some(1..) if ascending => Ok(()),
            _ => {
                let reason = "must be ascending numbers from 1, such as [1, 2, 5, 10, 20]";
                refuse("protocol.per_class", format!("{per_class:?}"), reason)
            }
        }
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
            betas: optimizer.betas,
            eps: optimizer.eps,
        }
        .check(&format!("{at}.optimizer"))?;
        if optimizer.name == OptimizerName::Sgdm {
            for (name, set) in [("betas", optimizer.betas.is_some()), ("eps", optimizer.eps.is_some())] {
                if set {
                    let reason = "belongs to name = \"adam\" or \"adamw\"; leave it out";
                    return refuse(format!("{at}.optimizer.{name}"), "..", reason);
                }
            }
        }
        self.schedule.check(&format!("{at}.schedule"))?;
        self.objective(at)?;
        if let Some(taxel_data::Error::Augment { key, value, expected }) =
            self.augment.and_then(|augment| augment.check().err())
        {
            return refuse(format!("{at}.augment.{key}"), value, expected);
        }
        match self.clip {
            Some(clip) if !((clip as f32) > 0.0 && clip.is_finite()) => {
                refuse(format!("{at}.clip"), clip, "must be positive and finite, usually 0.1 to 10")
            }
            _ => self.early_stopping.as_ref().map_or(Ok(()), |s| s.check(&format!("{at}.early_stopping"))),
        }
    }

    fn objective(&self, at: &str) -> Check {
        if !(0.0..1.0).contains(&self.label_smoothing) {
            return refuse(format!("{at}.label_smoothing"), self.label_smoothing, "must be in [0, 1)");
        }
        if self.loss == Loss::SoftmaxCrossEntropy {
            return Ok(());
        }
        let reason = "works with loss = \"softmax-cross-entropy\" only; leave it out";
        if self.label_smoothing != 0.0 {
            return refuse(format!("{at}.label_smoothing"), self.label_smoothing, reason);
        }
        match self.class_weights {
            ClassWeights::None => Ok(()),
            ClassWeights::Balanced => refuse(format!("{at}.class_weights"), "\"balanced\"", reason),
        }
    }

    /// The same with other values at dotted keys, as [`Choose::combinations`] lists them.
    ///
    /// # Errors
    /// A key that `[train]` does not have, or a value of the wrong type.
    pub(crate) fn with(&self, combination: &[(String, Value)]) -> Result<Train, Problem> {
        let mut train = self.clone();
        for (key, value) in combination {
            let problem = |reason: String| Problem {
                key: format!("choose.grid.{key}"),
                value: value.to_string(),
                reason: reason.trim().replace('\n', "; "),
            };
            // As one network's own value would be written.
            let mut inner = value.clone();
            for part in key.rsplit('.') {
                inner = Value::Table(Table::from_iter([(part.to_string(), inner)]));
            }
            let own: TrainOverride = inner.try_into().map_err(|e: toml::de::Error| problem(e.to_string()))?;
            train = own.over(&train);
        }
        Ok(train)
    }
}

impl EarlyStopping {
    fn check(&self, at: &str) -> Check {
        within(format!("{at}.patience"), self.patience, 1, 100_000)?;
        share(format!("{at}.validation"), self.validation)
    }
}

impl Choose {
    fn check(&self, train: &Train) -> Check {
        share("choose.validation", self.validation)?;
        if self.grid.is_empty() {
            return refuse(
                "choose.grid",
                "{}",
                "name what is chosen: grid = { \"optimizer.lr\" = [0.01, 0.001] }",
            );
        }
        if let Some((key, _)) = self.grid.iter().find(|(_, values)| values.is_empty()) {
            return refuse(format!("choose.grid.{key}"), "[]", "needs values to choose from");
        }
        let combinations = self.combinations();
        within("choose.grid".into(), combinations.len(), 1, 1000)?;
        combinations.iter().try_for_each(|combination| train.with(combination).map(|_| ()))
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
        match self.betas {
            Some(betas) if !betas.iter().all(|beta| (0.0..1.0).contains(beta)) => {
                return refuse(format!("{at}.betas"), format!("{betas:?}"), "must be two numbers in [0, 1)");
            }
            _ => {}
        }
        match self.eps {
            Some(eps) if !(eps > 0.0 && eps < 1.0) => {
                return refuse(format!("{at}.eps"), eps, "must be in (0, 1), usually 1e-8");
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
        let foreign = match self.kind {
            ScheduleKind::Steps => self.floor.is_some(),
            ScheduleKind::Cosine => self.at.is_some() || self.factor.is_some(),
            ScheduleKind::Constant => self.at.is_some() || self.factor.is_some() || self.floor.is_some(),
        };
        if foreign {
            let reason = "at and factor belong to kind = \"steps\", floor to kind = \"cosine\"";
            return refuse(at, "{ .. }", reason);
        }
        match self.floor {
            Some(floor) if !(0.0..1.0).contains(&floor) => {
                return refuse(format!("{at}.floor"), floor, "must be a share of the first rate, in [0, 1)");
            }
            _ => {}
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
        let sizes = entry.inputs.iter().flat_map(|input| &input.keys).map(String::as_str).chain(["classes"]);
        if let Some(key) = sizes.into_iter().find(|key| self.set.contains_key(*key)) {
            let reason = "comes from the data and its encoding; leave it out";
            return refuse(format!("{at}.set.{key}"), &self.set[key], reason);
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
            ("accuracy", Some(&self.accuracy)),
            ("precision", self.precision.as_ref()),
            ("recall", self.recall.as_ref()),
            ("f1", self.f1.as_ref()),
        ];
        for (name, score) in scores {
            if let Some(pair) = score
                && !((1..=2).contains(&pair.len()) && pair.iter().all(|v| (0.0..=100.0).contains(v)))
            {
                let reason = "must be [mean, SD] or [mean] in %, each in [0, 100]";
                return refuse(format!("{at}.{name}"), format!("{pair:?}"), reason);
            }
        }
        for (name, cost) in [("megabytes", self.megabytes), ("gflops", self.gflops)] {
            if let Some(cost) = cost.filter(|cost| !(cost.is_finite() && *cost > 0.0)) {
                return refuse(format!("{at}.{name}"), cost.to_string(), "must be above 0");
            }
        }
        Ok(())
    }
}
