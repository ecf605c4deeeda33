//! Time steps in, decisions out.

use taxel_data::{Padding, SampleSpec, Task};
use taxel_encodings::NumaTac;
use taxel_learn::metrics::Levels;
use taxel_learn::{Card, Predictor, Transform, Workspace};

use crate::contact::Contact;
use crate::error::{Error, Result};
use crate::health::Health;
use crate::options::StreamOptions;
use crate::rest::RestLevel;
use crate::window::Window;

/// A model that predicts on the time steps of one sensor as they come. After the first prediction it allocates nothing.
///
/// One window fills at a time. When it is full it is decided, unless it was before, and the next one begins `hop` time steps
/// after it: the two share the rest. Under a contact judge a window begins with contact, is filled whatever follows, and
/// slides on while contact lasts.
pub struct Decider {
    predictor: Predictor,
    workspace: Workspace,
    window: Window,
    health: Health,
    contact: Option<Contact>,
    /// Of a model whose training had it taken off.
    rest: Option<RestLevel>,
    levels: Levels,
    hop: usize,
    before: usize,
    /// The probability at which a window is decided that is not full.
    early: Option<f32>,
    /// Looks at such a window at each tenth, not at each time step.
    looks_at_tenths: bool,
    /// Time steps before which nothing is decided.
    least: usize,
    padding: Padding,
    sample: Vec<f32>,
    /// Those of the last prediction.
    probabilities: Vec<f32>,
    /// That of the last prediction.
    familiarity: Option<f32>,
    /// The familiarity up to which a window is unknown.
    unknown: f32,
    /// Time steps since the stream, or the recording, began.
    /// Share of windows whose intervals hold the true values.
    share: Option<f64>,
    intervals: Vec<[f32; 2]>,
    readings: u64,
    /// Time steps to be passed over before the next window.
    pass: usize,
    /// Whether the window under way has its decision.
    decided: bool,
    /// Whether contact must begin before a window does.
    waiting: bool,
    contacts: u64,
}

/// A prediction for a window.
pub struct Decision<'a> {
    /// The last time step of the window, from 0.
    pub reading: u64,
    /// Time steps of the window that were there.
    pub known: usize,
    /// Time steps of a full window.
    pub ticks: usize,
    /// Faults of the channels, as of the last time step.
    pub health: &'a Health,
    /// How familiar the window is to the model, 0.01..1; none of a model without a gate.
    pub familiarity: Option<f32>,
    /// Whether it is unlike those that the model has learned from.
    pub is_unknown: bool,
    /// The interval of each value at the share that was asked for; empty of classes, without intervals and of an unknown window.
    pub intervals: &'a [[f32; 2]],
    prediction: std::result::Result<&'a [f32], taxel_learn::Error>,
}

impl Decision<'_> {
    /// Returns the share of the window that was there, above 0 and at most 1.
    pub fn seen(&self) -> f64 {
        self.known as f64 / self.ticks as f64
    }

    /// Returns the probabilities of the classes, or of the levels of the attributes one after the other.
    ///
    /// # Errors
    /// A window that the model's encoding refuses: one in which it finds no contact, for example.
    pub fn probabilities(&self) -> std::result::Result<&[f32], &taxel_learn::Error> {
        self.prediction.as_ref().map(|prediction| *prediction)
    }

    /// Checks whether the window was not full.
    pub fn is_early(&self) -> bool {
        self.known < self.ticks
    }
}

impl Decider {
    /// Makes a decider of a model.
    ///
    /// # Errors
    /// Options out of their range or without a meaning for the model; samples that the model refuses.
    pub fn new(predictor: Predictor, options: &StreamOptions) -> Result<Self> {
        let card = predictor.card();
        let spec = &card.spec;
        let window = Window::new(spec);
        let ticks = window.ticks();
        let full_scale = options.full_scale.or(spec.full_scale);
        let judge = card.inputs.iter().find_map(|input| numatac(&input.transform));
        let before =
            options.before.unwrap_or_else(|| judge.map_or(0, |judge| ticks.saturating_sub(judge.window) / 2));
        check(options, spec, before, ticks, matches!(card.task, Task::Values(_)))?;
        let early = early_from(options, card)?;
        let contact = options.contact.then(|| Contact::new(spec, judge, full_scale));
        Ok(Decider {
            workspace: predictor.workspace()?,
            health: Health::new(spec, full_scale),
            waiting: contact.is_some(),
            rest: RestLevel::new(spec, options.tare),
            contact,
            probabilities: vec![0.0; card.task.outputs()],
            share: options.interval,
            intervals: Vec::with_capacity(card.task.quantities().len()),
            familiarity: None,
            unknown: options.unknown,
            levels: card.levels(),
            hop: options.hop.unwrap_or((ticks / 4).max(1)),
            before,
            early,
            looks_at_tenths: card.certainty.as_ref().is_some_and(|certainty| !certainty.tenths.is_empty()),
            least: options.least.unwrap_or(ticks.div_ceil(10)),
            padding: options.padding.unwrap_or(spec.padding()),
            sample: vec![0.0; ticks * window.each()],
            readings: 0,
            pass: 0,
            decided: false,
            contacts: 0,
            window,
            predictor,
        })
    }

    /// Returns the card of the model.
    pub fn card(&self) -> &Card {
        self.predictor.card()
    }

    /// Counts the values of one time step.
    pub fn each(&self) -> usize {
        self.window.each()
    }

    /// Counts the time steps of a full window.
    pub fn ticks(&self) -> usize {
        self.window.ticks()
    }

    /// Returns the time steps from one window to the next.
    pub fn hop(&self) -> usize {
        self.hop
    }

    /// Counts how often contact began.
    pub fn contacts(&self) -> u64 {
        self.contacts
    }

    /// Checks whether windows wait for a contact that no value can show: all lie at 0 when they rest, and no full scale is known.
    pub fn waits_in_vain(&self) -> bool {
        self.contact.as_ref().is_some_and(|contact| !contact.can_judge())
    }

    /// Begins another recording: nothing of the last one counts.
    pub fn begin(&mut self) {
        self.health.begin();
        self.contact.iter_mut().for_each(Contact::begin);
        self.rest.iter_mut().for_each(RestLevel::begin);
        self.readings = 0;
        self.anew();
    }

    /// Takes the level at rest anew, from the next readings; until then nothing is decided. False for a model that reads what the
    /// sensor gives.
    pub fn tare(&mut self) -> bool {
        self.rest.iter_mut().for_each(RestLevel::begin);
        self.rest.is_some()
    }

    /// Returns a time step as the training had it: less the level at rest, written into `room`. None while that is not known.
    pub fn tared<'r>(&self, reading: &'r [f32], room: &'r mut Vec<f32>) -> Option<&'r [f32]> {
        let Some(rest) = &self.rest else { return Some(reading) };
        room.clear();
        room.extend_from_slice(reading);
        let (before, _, after) = self.card().spec.around_time();
        rest.take_off(room, (before, 1, after));
        rest.is_known().then_some(room.as_slice())
    }

    /// Gives up the window under way and begins another one: time steps are missing.
    pub fn anew(&mut self) {
        self.contact.iter_mut().for_each(Contact::let_go);
        self.window.keep(0);
        (self.pass, self.decided, self.waiting) = (0, false, self.contact.is_some());
    }

    /// Takes a time step of [`Decider::each`] finite values; returns the decision that it leads to. A time step of another length
    /// is ignored.
    pub fn push(&mut self, reading: &[f32]) -> Option<Decision<'_>> {
        if reading.len() != self.window.each() {
            return None;
        }
        self.readings += 1;
        self.health.push(reading);
        let begins = self.contact.as_mut().is_some_and(|contact| contact.push(reading));
        self.contacts += u64::from(begins);
        let is_touching = self.contact.as_ref().map(Contact::is_touching);
        self.rest.iter_mut().for_each(|rest| rest.push(reading, is_touching));
        if self.waiting {
            self.window.push(reading);
            if !begins {
                return None;
            }
            self.window.keep(self.before + 1);
            self.waiting = false;
        } else if self.pass > 0 {
            self.pass -= 1;
            return None;
        } else {
            self.window.push(reading);
        }
        let (known, ticks) = (self.window.known(), self.window.ticks());
        let full = known == ticks;
        let is_tared = self.rest.as_ref().is_none_or(RestLevel::is_known);
        let predicted =
            (is_tared && !self.decided && (full || self.looks_early(known))).then(|| self.predict_window());
        let decides = predicted.as_ref().is_some_and(|sure| full || matches!(sure, Ok(true)));
        self.decided |= decides;
        if full {
            self.next();
        }
        let predicted = predicted.filter(|_| decides)?;
        let is_unknown = predicted.is_ok() && self.is_unknown();
        let Decider { health, readings, probabilities, familiarity, intervals, .. } = self;
        let familiarity = familiarity.filter(|_| predicted.is_ok());
        let prediction = predicted.map(|_| &**probabilities);
        let reading = *readings - 1;
        Some(Decision { reading, known, ticks, health, familiarity, is_unknown, intervals, prediction })
    }

    /// Checks whether a window that is not full is predicted. What is known of a calibrated model is known of whole tenths: more
    /// looks would be more chances to be sure and wrong.
    fn looks_early(&self, known: usize) -> bool {
        let tenths = |known: usize| 10 * known / self.window.ticks();
        let is_tenth = known > 0 && tenths(known) > tenths(known - 1);
        self.early.is_some() && known >= self.least && (is_tenth || !self.looks_at_tenths)
    }

    fn is_unknown(&self) -> bool {
        self.familiarity.is_some_and(|familiarity| familiarity <= self.unknown)
    }

    /// Predicts the window as it is; returns whether the model is confident enough to decide early.
    fn predict_window(&mut self) -> std::result::Result<bool, taxel_learn::Error> {
        self.window.sample(self.padding, &mut self.sample);
        if let Some(rest) = &self.rest {
            let around = self.predictor.card().spec.around_time();
            rest.take_off(&mut self.sample, around);
            // Padding is at rest, or the last time step: the level is not taken off twice.
            self.padding.fill(&mut self.sample, (around.0, around.2), self.window.known());
        }
        let seen = self.window.known() as f64 / self.window.ticks() as f64;
        let predicted = self.predictor.predict_start(&mut self.workspace, &self.sample, seen)?;
        self.probabilities.copy_from_slice(predicted);
        self.familiarity = self.predictor.familiarity(&mut self.workspace, seen);
        self.intervals.clear();
        // No share of intervals holds for a window that is unlike those that they were fitted to.
        if let Some(share) = self.share.filter(|_| !self.is_unknown()) {
            let of_quantity = |at| self.predictor.interval(&self.workspace, at, share);
            self.intervals.extend((0..self.probabilities.len()).filter_map(of_quantity));
        }
        let early = self.early.filter(|_| !self.is_unknown());
        Ok(early.is_some_and(|least| self.levels.confidence(&self.probabilities) >= least))
    }

    /// Begins the next window: this one is full.
    fn next(&mut self) {
        self.decided = false;
        if self.contact.as_ref().is_some_and(|contact| !contact.is_touching()) {
            self.waiting = true;
            return;
        }
        let ticks = self.window.ticks();
        self.window.keep(ticks.saturating_sub(self.hop));
        self.pass = self.hop.saturating_sub(ticks);
    }
}

/// Returns the contact judge of an encoding that has one.
fn numatac(transform: &Transform) -> Option<NumaTac> {
    match transform {
        Transform::Numatac { numatac, .. } => Some(*numatac),
        Transform::Series { then, .. }
        | Transform::Baseline { then, .. }
        | Transform::History { then, .. }
        | Transform::Reduced { then, .. } => numatac(then),
        _ => None,
    }
}

/// Returns the probability at which early decisions are right as often as is asked, as far as the card says; none where none are
/// asked for.
///
/// # Errors
/// Decisions of held-out samples of the run that were no better than chance, or less often right than is asked.
fn early_from(options: &StreamOptions, card: &Card) -> Result<Option<f32>> {
    let Some(early) = options.early else { return Ok(None) };
    let record = card.certainty.as_ref().and_then(|certainty| certainty.early_at(f64::from(early)));
    let Some(record) = record else { return Ok(Some(early)) };
    if !(record.is_chance() || record.is_unreached()) {
        return Ok(Some(early.max(record.least as f32)));
    }
    let start = if record.is_chance() { "decides by chance" } else { "is not reached" };
    let why = format!(
        "{start}: of {} samples that training had not seen {} were decided early at {}, {:.0} % of them right, and \
         the commonest answer is right in {:.0} %; leave --early out, or try another confidence",
        record.of,
        record.decided,
        record.confidence,
        100.0 * record.right,
        100.0 * record.chance,
    );
    Err(Error::Option { option: "early", value: early.to_string(), why })
}

fn check(
    options: &StreamOptions,
    spec: &SampleSpec,
    before: usize,
    ticks: usize,
    of_values: bool,
) -> Result<()> {
    let refuse = |option, value: String, why: &str| Err(Error::Option { option, value, why: why.into() });
    if let Some(early) = options.early.filter(|_| of_values) {
        let why = "has no meaning here: the model answers values, which have no probability to be sure of";
        return refuse("early", early.to_string(), why);
    }
    if options.hop == Some(0) {
        return refuse("hop", "0".into(), "is the number of readings from one window to the next, from 1");
    }
    if let Some(early) = options.early.filter(|early| !(*early > 0.0 && *early <= 1.0)) {
        return refuse("early", early.to_string(), "is a probability above 0 and at most 1, as 0.9");
    }
    if let Some(full) = options.full_scale.filter(|full| !(*full > 0.0 && full.is_finite())) {
        return refuse("full-scale", full.to_string(), "is the largest possible reading, above 0");
    }
    if spec.layout.time_axis().is_none() && (options.early.is_some() || options.contact) {
        let early = options.early.map_or(String::new(), |early| early.to_string());
        let (option, value) =
            if options.contact { ("contact", "asked for".into()) } else { ("early", early) };
        return refuse(
            option,
            value,
            "has no meaning here: the model reads one reading at a time, not a window of them",
        );
    }
    if !(0.0..1.0).contains(&options.unknown) {
        return refuse("unknown", options.unknown.to_string(), "is a share from 0 and below 1, as 0.05");
    }
    if let Some(steps) = options.tare.filter(|_| spec.tare.is_none()) {
        return refuse(
            "tare",
            steps.to_string(),
            "has no meaning here: the model reads what the sensor gives",
        );
    }
    if before >= ticks {
        let why = format!("leaves nothing of a window of {ticks} readings to contact");
        return refuse("before", before.to_string(), &why);
    }
    Ok(())
}
