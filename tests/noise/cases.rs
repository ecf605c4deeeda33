//! The cases of the audit: every form with every layout and protocol that it can have, and every trap.

use std::fmt::{self, Display, Formatter};

use rand::RngExt;
use serde_json::{Value, json};
use taxel::Layout;
use taxel_base::seed;

use super::sets::files::{By, Form, Style};
use super::sets::{CLASSES, Cell, Extra, Set};

/// Samples of a set.
const SAMPLES: usize = 120;
/// Groups of a set.
const GROUPS: usize = 5;

/// A protocol.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Plan {
    KFold,
    ByGroup,
    Random,
    RandomByGroup,
    Few,
    LeaveOut,
    Official,
    InTime,
}

impl Plan {
    const ALL: [Plan; 8] = [
        Plan::KFold,
        Plan::ByGroup,
        Plan::Random,
        Plan::RandomByGroup,
        Plan::Few,
        Plan::LeaveOut,
        Plan::Official,
        Plan::InTime,
    ];

    pub fn json(self) -> Value {
        match self {
            Plan::KFold => json!({"kind": "k-fold", "folds": 4}),
            Plan::ByGroup => json!({"kind": "k-fold", "folds": 4, "split": "group"}),
            Plan::Random => json!({"kind": "random-splits", "test": 0.3, "repetitions": 3}),
            Plan::RandomByGroup => {
                json!({"kind": "random-splits", "test": 0.4, "repetitions": 2, "split": "group"})
            }
            Plan::Few => json!({"kind": "few-samples", "test": 0.4, "per_class": [4, 8]}),
            Plan::LeaveOut => json!({"kind": "leave-group-out"}),
            Plan::Official => json!({"kind": "official"}),
            Plan::InTime => json!({"kind": "chronological", "test": 0.3}),
        }
    }

    pub fn toml(self) -> String {
        let keys = self.json();
        keys.as_object().unwrap().iter().map(|(key, value)| format!("{key} = {value}\n")).collect()
    }

    fn needs_groups(self) -> bool {
        matches!(self, Plan::ByGroup | Plan::RandomByGroup | Plan::LeaveOut)
    }
}

/// An end that a case may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum May {
    Chance,
    /// A kind of leak stands in the results.
    Say(&'static str),
    /// The message holds these words.
    Refuse(&'static str),
    /// A control: the trap must be learned, or it proves nothing where it is not.
    Bite,
}

/// A set of noise with a trap, and how it is run.
pub struct Case {
    /// Empty where nothing is planted.
    pub trap: String,
    pub form: Form,
    pub plan: Plan,
    pub set: Set,
    pub style: Style,
    /// Further lines of `[data]`.
    pub data: String,
    /// Further tables of the config.
    pub more: String,
    /// Samples of which none is like another.
    pub units: usize,
    pub may: Vec<May>,
}

impl Display for Case {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let trap = if self.trap.is_empty() { "-" } else { &self.trap };
        write!(f, "{} | {} | {:?} | {trap}", self.form.name(), self.set.layout.name(), self.plan)
    }
}

impl Case {
    fn new(form: Form, plan: Plan, set: Set) -> Self {
        let (style, units) = (Style::of(form), set.len());
        let (trap, data, more) = (String::new(), String::new(), String::new());
        Self { trap, form, plan, set, style, data, more, units, may: vec![May::Chance] }
    }

    fn trap(self, trap: impl Into<String>, may: &[May]) -> Self {
        Self { trap: trap.into(), may: may.to_vec(), ..self }
    }

    fn data(self, data: &str) -> Self {
        Self { data: data.into(), ..self }
    }

    /// Checks whether all methods are quick enough: features of a kernel are many.
    pub fn is_short(&self) -> bool {
        self.set.layout == Layout::Series
            && (!self.trap.is_empty() || matches!(self.plan, Plan::KFold | Plan::Official))
    }
}

/// Returns the shape of the samples of a layout.
fn shape(layout: Layout) -> Vec<usize> {
    match layout {
        Layout::Features => vec![6],
        Layout::Series => vec![2, 16],
        Layout::Image => vec![4, 5],
        Layout::Colour => vec![3, 4, 4],
        Layout::Sequence => vec![12, 2, 3],
        Layout::Fingers => vec![3, 2, 12],
    }
}

/// Makes samples of whole numbers up to 255, which every format holds, of three classes in a mixed order. Groups and marks
/// hold as many of each class.
fn noise(purpose: &str, layout: Layout, shape: &[usize], samples: usize) -> Set {
    let mut rng = seed::rng(26, purpose);
    let size = shape.iter().product::<usize>();
    let x = (0..samples).map(|_| (0..size).map(|_| f32::from(rng.random::<u8>())).collect()).collect();
    let mut y = vec![];
    while y.len() < samples {
        let first = rng.random_range(0..3);
        let other = 1 + rng.random_range(0..2);
        y.extend([first, (first + other) % 3, (first + 3 - other) % 3]);
    }
    y.truncate(samples);
    Set::new(layout, shape, x, y)
}

/// Returns the noise for a form under a protocol.
fn plain(form: Form, layout: Layout, plan: Plan) -> Set {
    let mut shape = shape(layout);
    if matches!(form, Form::Pair("tsv" | "txt")) {
        shape[0] = 1;
    }
    with_roles(noise(&format!("{form:?} {layout:?} {plan:?}"), layout, &shape, SAMPLES), form, plan)
}

/// Gives a set the groups and marks that its form or protocol needs.
fn with_roles(mut set: Set, form: Form, plan: Plan) -> Set {
    let triples = (0..set.len()).map(|row| row / 3);
    let has_sessions = matches!(form, Form::Files(_, By::Session) | Form::Pictures(By::Session));
    if plan.needs_groups() || has_sessions {
        set.groups = Some(triples.clone().map(|triple| triple % GROUPS).collect());
    }
    let has_parts = matches!(form, Form::Pair(_) | Form::Halves | Form::Files(_, By::Parts));
    if plan == Plan::Official || has_parts {
        set.marks = Some(triples.map(|triple| i64::from(triple % 2 == 1)).collect());
    }
    set
}

/// Lists the layouts that a form holds.
fn layouts(form: Form) -> Vec<Layout> {
    use Layout::{Colour, Features, Fingers, Image, Sequence, Series};
    match form {
        Form::Arrays(_) | Form::Halves => Layout::ALL.to_vec(),
        Form::Files("npy" | "mat" | "h5" | "hdf5", _) => vec![Series, Image, Colour, Sequence, Fingers],
        Form::Files("png" | "jpg" | "jpeg", _) => vec![Image, Colour],
        Form::Files(..) | Form::Pair(_) | Form::LeRobot => vec![Series],
        Form::Pictures(_) => vec![Sequence, Colour],
        Form::Wide(_) => vec![Features, Image, Colour, Sequence, Fingers],
        Form::Long(_) => vec![Series, Sequence],
    }
}

/// Lists the protocols that a form can be run under.
fn plans(form: Form) -> Vec<Plan> {
    let can = |plan: &Plan| match form {
        Form::Arrays(_) | Form::Wide(_) | Form::Long(_) => true,
        // Samples of others are in the order of their names.
        _ if *plan == Plan::InTime => false,
        Form::Halves => true,
        Form::Pair(_) => !plan.needs_groups(),
        Form::LeRobot => !plan.needs_groups() && *plan != Plan::Official,
        Form::Files(_, by) | Form::Pictures(by) => match by {
            By::Table => *plan != Plan::Official,
            By::Session => plan.needs_groups() || *plan == Plan::KFold,
            By::Class | By::Name => !plan.needs_groups() && *plan != Plan::Official,
            By::Parts => false,
        },
    };
    Plan::ALL.into_iter().filter(can).collect()
}

/// Lists the forms that are run with every layout and protocol, and those that are read by the same lines under another
/// ending, which are run once.
fn forms() -> [Vec<Form>; 2] {
    let mut all = vec![Form::Arrays("npz"), Form::Arrays("mat"), Form::Arrays("h5"), Form::Halves];
    for ending in ["csv", "npy", "jsonl", "mat", "h5", "mcap", "png"] {
        all.extend([By::Class, By::Session, By::Table].map(|by| Form::Files(ending, by)));
    }
    all.extend([Form::Files("mcap", By::Name), Form::Pictures(By::Name), Form::Pictures(By::Session)]);
    all.extend(["csv", "parquet"].iter().flat_map(|ending| [Form::Wide(ending), Form::Long(ending)]));
    all.extend(["ts", "tsv", "txt", "arff"].map(Form::Pair));
    all.push(Form::LeRobot);
    let mut once = vec![Form::Arrays("hdf5")];
    once.extend(["ndjson", "hdf5", "jpg", "jpeg"].map(|ending| Form::Files(ending, By::Class)));
    once.extend(["tsv", "pq"].iter().flat_map(|ending| [Form::Wide(ending), Form::Long(ending)]));
    [all, once]
}

/// Lists all cases.
pub fn all() -> Vec<Case> {
    let mut cases = vec![];
    let [whole, once] = forms();
    for form in whole {
        for layout in layouts(form) {
            cases
                .extend(plans(form).into_iter().map(|plan| Case::new(form, plan, plain(form, layout, plan))));
        }
    }
    for form in once {
        let layout = layouts(form)[0];
        cases.push(Case::new(form, Plan::KFold, plain(form, layout, Plan::KFold)));
    }
    columns(&mut cases);
    texts(&mut cases);
    copies(&mut cases);
    windows(&mut cases);
    order(&mut cases);
    splits(&mut cases);
    cases
}

/// A column that goes on through the samples class by class, in their time steps too.
fn running(set: &Set, name: &str, per_step: Option<f64>) -> Extra {
    let steps = set.steps();
    let cell = |rank: usize, step: usize| {
        let count = rank * steps + step;
        per_step.map_or(Cell::Count(count as i64), |length| {
            Cell::Value((count as f64 * length * 1e3).round() / 1e3)
        })
    };
    let of_sample = |rank: usize| (0..steps).map(|step| cell(rank, step)).collect();
    Extra { name: name.into(), cells: set.ranks().into_iter().map(of_sample).collect() }
}

/// Names of columns that are no channels, and the time from step to step in their unit; none of a counter.
const RUNNING: [(&str, Option<f64>); 13] = [
    ("time", Some(0.01)),
    ("timestamp", Some(0.01)),
    ("t_ms", Some(10.0)),
    ("Time [s]", Some(0.01)),
    ("index", None),
    ("nr", None),
    ("row", None),
    ("frame", None),
    ("id", None),
    ("seq", None),
    ("", None),
    ("Unnamed: 0", None),
    ("__index_level_0__", None),
];

/// Plants columns that say when a sample was recorded.
fn columns(cases: &mut Vec<Case>) {
    let forms = [
        Form::Files("csv", By::Class),
        Form::Files("csv", By::Table),
        Form::Files("jsonl", By::Class),
        Form::Files("mcap", By::Class),
        Form::Long("csv"),
        Form::Long("parquet"),
        Form::Wide("csv"),
        Form::Wide("parquet"),
        Form::LeRobot,
    ];
    for form in forms {
        let layout = layouts(form)[0];
        for (name, per_step) in RUNNING {
            let is_parquet = matches!(form, Form::Long("parquet") | Form::Wide("parquet") | Form::LeRobot);
            if is_parquet && (name.is_empty() || name.contains([' ', '['])) {
                continue;
            }
            let name = if form == Form::LeRobot { format!("observation.{name}") } else { name.to_string() };
            let mut set = plain(form, layout, Plan::KFold);
            set.extras.push(running(&set, &name, per_step));
            let may = [May::Chance, May::Refuse("but none that says which recording a row belongs to")];
            cases.push(Case::new(form, Plan::KFold, set).trap(format!("running {name:?}"), &may));
        }
        // Samples in their order, too.
        let mut set = plain(form, layout, Plan::KFold);
        set.extras.push(running(
            &set,
            if form == Form::LeRobot { "observation.index" } else { "index" },
            None,
        ));
        let set = set.select(&set.by_class());
        let may = [May::Chance, May::Say("blocks")];
        cases.push(Case::new(form, Plan::KFold, set).trap("running \"index\" in blocks", &may));
        let mut set = plain(form, layout, Plan::KFold);
        set.extras.push(running(
            &set,
            if form == Form::LeRobot { "observation.thumb" } else { "thumb" },
            Some(0.01),
        ));
        cases.push(
            Case::new(form, Plan::KFold, set)
                .trap("control: running \"thumb\"", &[May::Bite, May::Say("shortcut")]),
        );
    }
    // The columns are numbered as pandas does.
    for form in [Form::Files("csv", By::Class), Form::Wide("csv"), Form::Long("csv")] {
        for extra in [None, Some(""), Some("index")] {
            let mut set = plain(form, layouts(form)[0], Plan::KFold);
            let width = if form == Form::Wide("csv") { set.x[0].len() } else { set.width() };
            set.names = (0..width).map(|at| at.to_string()).collect();
            set.extras.extend(extra.map(|name| running(&set, name, None)));
            let trap =
                format!("header 0,1,2{}", extra.map_or(String::new(), |name| format!(" after {name:?}")));
            cases.push(Case::new(form, Plan::KFold, set).trap(trap, &[May::Chance]));
        }
    }
}

/// Plants numbers that do not read as numbers beside a row number, and texts.
fn texts(cases: &mut Vec<Case>) {
    let forms = [
        Form::Files("csv", By::Class),
        Form::Files("jsonl", By::Class),
        Form::Long("csv"),
        Form::Long("tsv"),
        Form::Wide("csv"),
        Form::Wide("tsv"),
    ];
    for form in forms {
        let with = |name: &str, style: Style, may: &[May], trap: &str| {
            let mut set = plain(form, layouts(form)[0], Plan::KFold);
            for value in set.x.iter_mut().flatten() {
                *value += 0.5;
            }
            set.extras.push(running(&set, name, None));
            Case { style, ..Case::new(form, Plan::KFold, set).trap(format!("{trap} beside {name:?}"), may) }
        };
        let style = Style::of(form);
        for name in ["nr", "thumb"] {
            // The other column is a channel: it alone must not be left.
            let is_thumb = name == "thumb";
            let comma = [May::Refuse("decimal comma"), if is_thumb { May::Bite } else { May::Chance }];
            cases.push(with(name, Style { point: ',', ..style }, &comma, "decimal commas"));
            let unit = [May::Refuse("is a number with more"), May::Refuse("unit")];
            cases.push(with(name, Style { unit: " mV", ..style }, &unit, "cells with units"));
            if !matches!(form, Form::Files("jsonl", _)) {
                cases.push(with(
                    name,
                    Style { point: ',', separator: ';', ..style },
                    &comma,
                    "decimal commas and ;",
                ));
            }
        }
    }
    // Texts that say the class, and another column of labels.
    for form in [
        Form::Files("csv", By::Class),
        Form::Files("jsonl", By::Class),
        Form::Files("mcap", By::Class),
        Form::Long("csv"),
        Form::Wide("csv"),
        Form::Wide("parquet"),
    ] {
        let set = plain(form, layouts(form)[0], Plan::KFold);
        let column = |name: &str, cell: &dyn Fn(usize) -> Cell| Extra {
            name: name.into(),
            cells: (0..set.len()).map(|row| vec![cell(row); set.steps()]).collect(),
        };
        let text = column("material", &|row| Cell::Text(set.class(row).into()));
        let with = |extra: Extra| Set { extras: vec![extra], ..set.clone() };
        cases.push(Case::new(form, Plan::KFold, with(text)).trap("a text says the class", &[May::Chance]));
        if matches!(form, Form::Long(_) | Form::Wide(_)) {
            let number = column("target", &|row| Cell::Count(set.y[row] as i64));
            cases.push(Case::new(form, Plan::KFold, with(number)).trap("a second label", &[May::Chance]));
        }
    }
}

/// Lists each sample and a copy of it, the copies after all samples, and plants roles that tear them apart.
fn twice(set: &Set) -> Set {
    let rows: Vec<usize> = (0..set.len()).chain(0..set.len()).collect();
    set.select(&rows)
}

/// Plants copies.
fn copies(cases: &mut Vec<Case>) {
    let half = SAMPLES / 2;
    // Groups and marks tear them apart; other splits keep them together.
    let may = |plan: Plan| {
        let is_torn = plan.needs_groups() || matches!(plan, Plan::Official | Plan::InTime);
        if is_torn { May::Say("copies") } else { May::Chance }
    };
    let make = |form: Form, layout: Layout, plan: Plan| {
        let mut shape = shape(layout);
        if matches!(form, Form::Pair("tsv" | "txt")) {
            shape[0] = 1;
        }
        let set = twice(&noise(&format!("copies {form:?} {plan:?}"), layout, &shape, half));
        let is_copy = |row: usize| row >= half;
        let mut set = with_roles(set, form, plan);
        let days = |row: usize| row / 3 % 2 + if is_copy(row) { 2 } else { 0 };
        set.groups = set.groups.map(|groups| (0..groups.len()).map(days).collect());
        set.marks = set.marks.map(|marks| (0..marks.len()).map(|row| i64::from(is_copy(row))).collect());
        set
    };
    let forms = [
        Form::Arrays("npz"),
        Form::Arrays("mat"),
        Form::Arrays("h5"),
        Form::Halves,
        Form::Files("csv", By::Session),
        Form::Files("csv", By::Class),
        Form::Files("npy", By::Table),
        Form::Files("jsonl", By::Class),
        Form::Files("mcap", By::Name),
        Form::Files("png", By::Session),
        Form::Wide("csv"),
        Form::Wide("parquet"),
        Form::Long("csv"),
        Form::Long("parquet"),
        Form::Pair("ts"),
        Form::Pair("arff"),
        Form::Pair("tsv"),
        Form::LeRobot,
    ];
    for form in forms {
        for layout in layouts(form) {
            for plan in plans(form) {
                let case = Case { units: half, ..Case::new(form, plan, make(form, layout, plan)) };
                cases.push(case.trap("copies", &[may(plan)]));
            }
        }
    }
    // Copies that differ in what is not read: a channel, or what the encoding leaves out.
    let ways = [
        ("data.channels", "channels = [0, 1]", ""),
        ("encoding.reduce", "", "[encoding]\nreduce = { channels = [0, 1] }"),
    ];
    for (way, data, more) in ways {
        for form in
            [Form::Arrays("npz"), Form::Files("csv", By::Session), Form::Long("csv"), Form::Pair("ts")]
        {
            for plan in plans(form) {
                let set = twice(&noise(&format!("{way} {form:?} {plan:?}"), Layout::Series, &[3, 16], half));
                let mut set = with_roles(set, form, plan);
                let mut rng = seed::rng(26, "unused");
                for sample in &mut set.x {
                    sample[32..].fill_with(|| f32::from(rng.random::<u8>()));
                }
                let roles = make(form, Layout::Series, plan);
                (set.groups, set.marks) = (roles.groups, roles.marks);
                let case = Case { units: half, more: more.into(), ..Case::new(form, plan, set) };
                cases.push(case.data(data).trap(format!("copies under {way}"), &[may(plan)]));
            }
        }
    }
    // The same sample under two labels.
    for (way, shape, data) in [
        ("", vec![2, 16], ""),
        (" under data.channels", vec![3, 16], "channels = [0, 1]"),
        (", dropped", vec![2, 16], "drop = [\"contradictory\"]"),
    ] {
        for form in [Form::Arrays("npz"), Form::Files("csv", By::Class), Form::Long("csv")] {
            let plan = Plan::KFold;
            let one = noise(&format!("contradictory {form:?}"), Layout::Series, &shape, SAMPLES - 30);
            let rows: Vec<usize> = (0..one.len()).chain(0..30).collect();
            let mut set = with_roles(one.select(&rows), form, plan);
            for row in one.len()..set.len() {
                set.y[row] = (set.y[row] + 1) % 3;
                if shape[0] == 3 {
                    set.x[row][32..].fill(row as f32);
                }
            }
            let case = Case { units: one.len(), ..Case::new(form, plan, set) };
            cases.push(case.data(data).trap(format!("contradictory labels{way}"), &[May::Chance]));
        }
    }
}

/// Returns the end of a case in which a recording tells its class: only a cut through recordings is refused.
fn of_recordings(plan: Plan) -> May {
    if plan == Plan::InTime { May::Refuse("end says nothing") } else { May::Chance }
}

/// Plants recordings of which several samples are cut.
fn windows(cases: &mut Vec<Case>) {
    let recordings = 60;
    for form in [
        Form::Arrays("npz"),
        Form::Files("csv", By::Class),
        Form::Files("npy", By::Table),
        Form::Long("csv"),
        Form::Pair("ts"),
    ] {
        for plan in plans(form) {
            let mut set = noise(&format!("windows {form:?} {plan:?}"), Layout::Series, &[2, 32], recordings);
            let mut rng = seed::rng(26, "levels");
            for sample in &mut set.x {
                // A level of its own tells a recording from the others in each of its windows.
                let level = 20.0 * f32::from(rng.random::<u8>());
                sample.iter_mut().for_each(|value| *value += level);
            }
            let case = Case { units: recordings, ..Case::new(form, plan, with_roles(set, form, plan)) };
            let case = case.data("length = { kind = \"window\", to = 16, hop = 8 }");
            cases.push(case.trap("overlapping windows", &[of_recordings(plan)]));
        }
    }
    for form in [
        Form::Arrays("npz"),
        Form::Arrays("h5"),
        Form::Files("npy", By::Class),
        Form::Long("csv"),
        Form::Pictures(By::Name),
    ] {
        for plan in plans(form) {
            let mut set =
                noise(&format!("frames {form:?} {plan:?}"), Layout::Sequence, &[3, 4, 5], recordings);
            for sample in &mut set.x {
                let (first, others) = sample.split_at_mut(20);
                for (at, value) in others.iter_mut().enumerate() {
                    *value = (first[at % 20] + 1.0 + (at / 20) as f32).min(255.0);
                }
            }
            let case = Case { units: recordings, ..Case::new(form, plan, with_roles(set, form, plan)) };
            let case = case.data("each_frame = true");
            cases.push(case.trap("frames of one recording", &[of_recordings(plan)]));
        }
    }
}

/// Plants recordings that were made class by class.
fn order(cases: &mut Vec<Case>) {
    let forms = [
        Form::Arrays("npz"),
        Form::Arrays("mat"),
        Form::Arrays("h5"),
        Form::Files("csv", By::Class),
        Form::Files("csv", By::Table),
        Form::Files("jsonl", By::Session),
        Form::Files("npy", By::Class),
        Form::Files("mcap", By::Name),
        Form::Files("png", By::Class),
        Form::Wide("csv"),
        Form::Wide("parquet"),
        Form::Long("csv"),
        Form::Pair("ts"),
        Form::LeRobot,
    ];
    for form in forms {
        for layout in layouts(form) {
            let plan = if matches!(form, Form::Pair(_)) { Plan::Official } else { Plan::KFold };
            let set = plain(form, layout, plan);
            let blocks = set.select(&set.by_class());
            let may = [May::Chance, May::Say("blocks")];
            cases.push(Case::new(form, plan, blocks.clone()).trap("blocks of one class", &may));

            // The sensor drifts while they are recorded.
            let mut drift = blocks;
            let last = drift.len() as f32;
            for (at, sample) in drift.x.iter_mut().enumerate() {
                sample
                    .iter_mut()
                    .for_each(|value| *value = (*value / 4.0 + 190.0 * at as f32 / last).round());
            }
            let may = [May::Say("blocks"), May::Say("shortcut"), May::Say("beginning")];
            cases.push(Case::new(form, plan, drift).trap("a drift through blocks", &may));

            if set.time().is_some() {
                let mut first = set.clone();
                for row in 0..first.len() {
                    for channel in 0..first.width() {
                        let place = first.place(channel, 0);
                        first.x[row][place] =
                            (first.x[row][place] / 8.0 + 100.0 * first.y[row] as f32).round();
                    }
                }
                let may = [May::Say("beginning")];
                cases.push(Case::new(form, plan, first).trap("the first time step says the class", &may));
            }
        }
    }
    // Names and order of files say the class.
    for ending in ["csv", "npy", "png", "mcap"] {
        let form = Form::Files(ending, By::Table);
        let layout = layouts(form)[0];
        let set = plain(form, layout, Plan::KFold);
        let set = set.select(&set.by_class());
        let may = [May::Chance, May::Say("blocks")];
        cases.push(Case::new(form, Plan::KFold, set.clone()).trap("the order of files says the class", &may));
        let form = Form::Files(ending, By::Class);
        let blocks = Case::new(form, Plan::ByGroup, set).data("group_block = 8");
        cases.push(blocks.trap("groups by the place in the folder", &[May::Chance]));
    }
}

/// Plants splits that leave a class untrained, folders of parts, and marks of other kinds.
fn splits(cases: &mut Vec<Case>) {
    let untrained = [May::Say("untrained")];
    let forms = [
        Form::Arrays("npz"),
        Form::Arrays("mat"),
        Form::Arrays("h5"),
        Form::Halves,
        Form::Files("csv", By::Session),
        Form::Files("npy", By::Table),
        Form::Files("png", By::Session),
        Form::Wide("csv"),
        Form::Long("parquet"),
        Form::Pair("ts"),
        Form::Pair("tsv"),
    ];
    for form in forms {
        let layout = layouts(form)[0];
        for plan in plans(form).into_iter().filter(|plan| plan.needs_groups() || *plan == Plan::Official) {
            if plan == Plan::RandomByGroup {
                continue;
            }
            let mut set = plain(form, layout, plan);
            for row in 0..set.len() {
                if set.y[row] != 2 {
                    continue;
                }
                if let Some(groups) = &mut set.groups {
                    groups[row] = 9;
                }
                if let Some(marks) = &mut set.marks {
                    marks[row] = 1;
                }
            }
            cases.push(Case::new(form, plan, set).trap("a class is never trained", &untrained));
        }
    }
    for ending in ["csv", "npy", "jsonl", "png", "mcap"] {
        let form = Form::Files(ending, By::Parts);
        let layout = layouts(form)[0];
        for plan in [Plan::KFold, Plan::Official] {
            let set = plain(form, layout, plan);
            let may = [May::Chance, May::Refuse("train")];
            cases.push(Case::new(form, plan, set).trap("train and test are folders", &may));
        }
    }
    // Marks of training, validation and test; a validation sample is a copy of a training sample.
    for form in [Form::Arrays("npz"), Form::Arrays("h5"), Form::Wide("csv"), Form::Long("csv")] {
        let layout = layouts(form)[0];
        let plan = Plan::Official;
        let set = noise(&format!("marks {form:?}"), layout, &shape(layout), 90);
        let rows: Vec<usize> = (0..30).chain(0..90).collect();
        let mut set = set.select(&rows);
        set.marks = Some((0..120).map(|row| [1, 0, 2, 2][row / 30]).collect());
        let may = [May::Refuse("is no mark")];
        cases.push(Case { units: 90, ..Case::new(form, plan, set) }.trap("marks 0, 1 and 2", &may));
        let mut set = plain(form, layout, plan);
        set.marks = Some((0..set.len()).map(|row| 1 + (row / 3 % 2) as i64).collect());
        cases.push(Case::new(form, plan, set).trap("marks 1 and 2", &[May::Refuse("is no mark")]));
    }
    // So that the classes are used.
    assert_eq!(CLASSES.len(), 3);
}
