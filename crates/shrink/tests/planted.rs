//! Runs on data whose truth is planted: what carries the classes is kept, what does not may go, and the test parts choose
//! nothing.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use taxel_data::{Dataset, Npz};
use taxel_judge::Case;
use taxel_learn::{Model, Protocol, RunFolder, RunOptions, Silent, inner_folds, quantize_run};
use taxel_shrink::{Axis, Curve, Error, Finished, ShrinkOptions, Shrunk, shrink};
use taxel_trainer::{Experiment, Overrides, Runner};
use taxel_zoo::Registry;

const SAMPLES: usize = 96;
const CHANNELS: usize = 5;
const READINGS: usize = 16;
const KNN: &str = "k-nn";

/// A number in [-1, 1) that looks random.
fn noise(i: usize) -> f32 {
    let mut h = (i as u32).wrapping_mul(2_654_435_761).wrapping_add(12_345);
    for (shift, factor) in [(15, 2_246_822_519u32), (13, 3_266_489_917)] {
        h ^= h >> shift;
        h = h.wrapping_mul(factor);
    }
    (h >> 8) as f32 / 8_388_608.0 - 1.0
}

/// A run on samples of four classes, 0 to 3, whose reading is `value(sample, class, channel, time)` and some noise.
struct Planted {
    folder: tempfile::TempDir,
    case: Case,
    experiment: Experiment,
    registry: Registry,
    network: &'static str,
}

fn planted(value: impl Fn(usize, usize, usize, usize) -> f32, protocol: &str, test: bool) -> Planted {
    planted_for("mlp", value, protocol, test)
}

fn planted_for(
    network: &'static str,
    value: impl Fn(usize, usize, usize, usize) -> f32,
    protocol: &str,
    test: bool,
) -> Planted {
    planted_by("{ name = \"adam\", lr = 0.01 }", network, value, protocol, test)
}

fn planted_by(
    optimizer: &str,
    network: &'static str,
    value: impl Fn(usize, usize, usize, usize) -> f32,
    protocol: &str,
    test: bool,
) -> Planted {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("planted.npz");
    let class = |sample: usize| (sample / 2) % 4;
    let mut x = vec![];
    for sample in 0..SAMPLES {
        for channel in 0..CHANNELS {
            for time in 0..READINGS {
                x.push(value(sample, class(sample), channel, time) + 0.3 * noise(x.len()));
            }
        }
    }
    let labels: Vec<u32> = (0..SAMPLES).map(|sample| class(sample) as u32).collect();
    let tested: Vec<u32> = (0..SAMPLES).map(|sample| u32::from(is_tested(sample))).collect();
    let mut archive = Npz::default();
    archive.add("x", &[SAMPLES, CHANNELS, READINGS], &x).unwrap();
    archive.add("y", &[SAMPLES], &labels).unwrap();
    archive.add("test", &[SAMPLES], &tested).unwrap();
    std::fs::write(&path, archive.finish().unwrap()).unwrap();
    let test = if test { "test = \"test\"" } else { "" };
    // Beside a baseline stands a network that its smaller twin does not need.
    let (baselines, label) = if network == KNN { ("\"k-nn\"", "mlp") } else { ("", network) };
    let text = format!(
        "name = \"planted\"\nbaselines = [{baselines}]\n[data]\npath = {path:?}\nlayout = \"series\"\nrate = 16.0\n{test}\n\
         [protocol]\n{protocol}\n[train]\nepochs = 12\nbatch_size = 16\n\
         optimizer = {optimizer}\n[[networks]]\nname = \"{label}\"\n"
    );
    let registry = Registry::built_in();
    let experiment = Experiment::parse(&text, "planted.toml", &Overrides::default(), &registry).unwrap();
    let options = RunOptions { threads: Some(2), ..RunOptions::default() };
    let out = folder.path().join("run");
    let run =
        taxel_trainer::run(&experiment, &registry, Some(&out), &options, &Silent, &AtomicBool::new(false));
    run.unwrap();
    let run = RunFolder::open(&out).unwrap();
    let (experiment, dataset) = taxel_trainer::open(&run, &registry).unwrap();
    let case = Case::new(run, dataset).unwrap();
    Planted { folder, case, experiment, registry, network }
}

fn is_tested(sample: usize) -> bool {
    sample % 6 >= 4
}

const FOLDS: &str = "kind = \"k-fold\"\nfolds = 3";

impl Planted {
    fn shrunk(&self, axes: &[Axis], options: ShrinkOptions) -> Finished {
        self.try_shrink("shrink", axes, options, &AtomicBool::new(false)).unwrap()
    }

    fn try_shrink(
        &self,
        name: &str,
        axes: &[Axis],
        options: ShrinkOptions,
        cancel: &AtomicBool,
    ) -> Result<Finished, Error> {
        let options = ShrinkOptions { axes: axes.to_vec(), ..options };
        let run = (&self.case, &self.experiment, &self.registry);
        shrink(run, self.network, &self.folder.path().join(name), &options, &|_| {}, &Silent, cancel)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join("shrink").join(name)
    }
}

fn left(shrunk: &Shrunk, curve: usize) -> Option<&str> {
    let curve = &shrunk.curves[curve];
    Some(curve.steps[curve.knee?].short.as_str())
}

/// The first bit of the class is in channel 1, the second in channel 3: a step up in the second half of the recording.
fn two_of_five(_: usize, class: usize, channel: usize, time: usize) -> f32 {
    let bit = match channel {
        1 => class & 1,
        3 => class >> 1,
        _ => 0,
    };
    if time >= READINGS / 2 { 2.0 * bit as f32 } else { 0.0 }
}

#[test]
fn channels_that_carry_the_classes_are_kept_and_the_model_reads_no_others() {
    let planted = planted(two_of_five, FOLDS, false);
    let finished = planted.shrunk(&[Axis::Sensors, Axis::Bits], ShrinkOptions::default());
    let Finished { shrunk, model, .. } = &finished;
    assert_eq!(left(shrunk, 0), Some("2"), "{:#?}", shrunk.curves[0]);
    let curve: &Curve = &shrunk.curves[0];
    let knee = &curve.steps[curve.knee.unwrap()];
    assert_eq!(knee.kept, ["channels 1, 3"; 3], "every fold keeps both");
    let one = &curve.steps[curve.knee.unwrap() + 1];
    assert!(one.inner.unwrap().difference < -30.0, "{one:?}");
    assert!(curve.words.starts_with("2 of 5 channels suffice: "), "{}", curve.words);
    // A step of the full range needs few bits.
    assert!(["1", "2"].contains(&left(shrunk, 1).unwrap()), "{:#?}", shrunk.curves[1]);
    let combined = shrunk.combined.as_ref().unwrap();
    assert_eq!(combined.parts.len(), 2, "{combined:?}");
    assert!(combined.outer.suffices(5.0, &taxel_judge::Primary::default()), "{combined:?}");

    // The model takes whole recordings, and what other channels say is nothing to it.
    let model = Model::open(model.as_ref().unwrap()).unwrap();
    let dataset = &planted.case.dataset;
    let predictions = model.predict(&dataset.x).unwrap();
    let mut other = dataset.x.clone();
    other.indexed_iter_mut().filter(|(at, _)| ![1, 3].contains(&at[1])).for_each(|(_, v)| *v = 1e6);
    assert_eq!(predictions.outputs, model.predict(&other).unwrap().outputs);
    let card = model.card().to_string();
    assert!(card.contains("of which     channels 1, 3; "), "{card}");
    let right = (0..SAMPLES).filter(|&i| predictions.labels[i] == dataset.strata().to_vec()[i]).count();
    assert!(right * 100 >= 95 * SAMPLES, "{right} of {SAMPLES}");

    // Its config makes it again, by itself.
    let text = std::fs::read_to_string(planted.file("shrunk.toml")).unwrap();
    let experiment =
        Experiment::parse(&text, "shrunk.toml", &Overrides::default(), &planted.registry).unwrap();
    let runner = Runner { experiment: &experiment, registry: &planted.registry, dataset };
    let (session, cancel) = (planted.folder.path().join("s.safetensors"), AtomicBool::new(false));
    let again = runner.fit("mlp", &RunOptions::default(), Some(&session), &Silent, &cancel).unwrap().unwrap();
    let apart = again.weights().iter().map(|(name, tensor)| {
        let other = &model.weights().get(name).unwrap().data;
        tensor.data.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    });
    assert_eq!(again.card().inputs, model.card().inputs);
    assert_eq!(apart.fold(0.0, f32::max), 0.0);
    assert_eq!(experiment.config().encoding.reduce.channels, Some(vec![1, 3]));
}

#[test]
fn slow_signals_need_few_readings_and_fast_ones_all() {
    // The class is how high it steps in the middle.
    let step = |_, class, _, time| if time >= READINGS / 2 { class as f32 } else { 0.0 };
    let slow = planted(step, FOLDS, false);
    let finished = slow.shrunk(&[Axis::Rate, Axis::Window], ShrinkOptions::default());
    assert_eq!(left(&finished.shrunk, 0), Some("2 Hz"), "{:#?}", finished.shrunk.curves[0]);
    assert_eq!(left(&finished.shrunk, 1), Some("12"), "the first half is the same for all classes");
    // Every second reading is the same for all classes.
    let fast = planted(|_, class, _, time| if time % 2 == 1 { class as f32 } else { 0.0 }, FOLDS, false);
    let finished = fast.shrunk(&[Axis::Rate], ShrinkOptions::default());
    assert_eq!(left(&finished.shrunk, 0), None);
    assert!(finished.model.is_none() && !fast.file("shrunk.safetensors").exists());
    assert!(finished.shrunk.words.last().unwrap().contains("no smaller model was written"));
    // What comes after a hopeless setting is not trained.
    let refused = finished.shrunk.curves[0].steps[1].refused.as_ref().unwrap();
    assert!(refused.starts_with("not tried: 8 of 16 readings, 8 Hz lost "), "{refused}");
}

#[test]
fn test_parts_choose_nothing() {
    // Channel 1 tells the classes of training samples, channel 3 those of test samples and nothing else.
    let value = |sample: usize, class: usize, channel: usize, _: usize| match (channel, is_tested(sample)) {
        (1, false) | (3, true) => class as f32,
        _ => 0.0,
    };
    let planted = planted(value, "kind = \"official\"", true);
    let finished = planted.shrunk(&[Axis::Sensors], ShrinkOptions { inner: 3, ..ShrinkOptions::default() });
    let curve = &finished.shrunk.curves[0];
    assert_eq!(left(&finished.shrunk, 0), Some("1"), "{curve:#?}");
    assert_eq!(curve.steps[curve.knee.unwrap()].kept, ["channels 1"]);
    let last = curve.steps.last().unwrap();
    assert!(last.inner.unwrap().score > 90.0 && last.outer.unwrap().score < 60.0, "{last:?}");
    assert_eq!((finished.shrunk.parts, finished.shrunk.inner), (1, 3));
}

#[test]
fn inner_folds_lie_in_the_training_part_and_keep_groups_together() {
    let x = ndarray::ArrayD::from_shape_fn(vec![60, 4], |at| at[0] as f32 + noise(at[1]));
    let labels: Vec<u32> = (0..60).map(|row| row % 2).collect();
    let dataset = Dataset::new("own", taxel_data::Layout::Features, x, &labels).unwrap();
    let groups: Vec<u32> = (0..60).map(|row| row / 10).collect();
    let dataset = Dataset { groups: Some(groups.clone()), ..dataset };
    for protocol in [Protocol::k_fold(3), Protocol::group_k_fold(3)] {
        for outer in protocol.folds(&dataset, 7, 0).unwrap() {
            let inner = inner_folds(&protocol, &dataset, &outer, 2, 7, 0).unwrap();
            assert_eq!(inner.len(), 2);
            let mut tested = vec![];
            for fold in &inner {
                let rows = fold.train.iter().chain(&fold.test);
                assert!(rows.clone().all(|row| outer.train.contains(row)), "{outer:?}, {fold:?}");
                assert!(rows.clone().all(|row| !outer.test.contains(row)));
                assert!(fold.test.iter().all(|row| !fold.train.contains(row)));
                tested.extend(fold.test.clone());
                let grouped = protocol == Protocol::group_k_fold(3);
                let apart = |a: &usize, b: &usize| groups[*a] != groups[*b];
                assert!(!grouped || fold.test.iter().all(|a| fold.train.iter().all(|b| apart(a, b))));
            }
            tested.sort_unstable();
            let mut train = outer.train.clone();
            train.sort_unstable();
            assert_eq!(tested, train, "every training sample is tested once");
        }
    }
}

#[test]
fn a_stopped_shrinking_goes_on_to_the_same_bytes_at_any_thread_count() {
    let planted = planted(two_of_five, FOLDS, false);
    let axes = [Axis::Sensors, Axis::Window];
    let quick = |threads, resume| ShrinkOptions { quick: true, threads, resume, ..ShrinkOptions::default() };
    let whole = planted.try_shrink("shrink", &axes, quick(1, false), &AtomicBool::new(false)).unwrap();
    assert!(whole.shrunk.notes[0].starts_with("A quick look: 2 of 3 test parts"));
    assert!(whole.shrunk.notes[1].contains("for 3 epochs"), "{:?}", whole.shrunk.notes);
    let stopped = planted.try_shrink("other", &axes, quick(2, false), &AtomicBool::new(true));
    assert!(matches!(stopped, Err(Error::Stopped { .. })));
    let used = planted.try_shrink("shrink", &axes, quick(2, false), &AtomicBool::new(false));
    assert!(used.err().unwrap().to_string().contains("--resume goes on with it"));
    // As if it had been killed in the middle.
    let records = planted.folder.path().join("other").join("records");
    for (at, entry) in std::fs::read_dir(planted.file("records")).unwrap().enumerate() {
        let entry = entry.unwrap();
        if at % 2 == 0 {
            std::fs::copy(entry.path(), records.join(entry.file_name())).unwrap();
        }
    }
    let again = planted.try_shrink("other", &axes, quick(2, true), &AtomicBool::new(false)).unwrap();
    assert_eq!(again.shrunk, whole.shrunk);
    let bytes =
        |folder: &str, name: &str| std::fs::read(planted.folder.path().join(folder).join(name)).unwrap();
    for name in ["shrink.json", "shrunk.safetensors", "shrunk.toml", "tables/curve-sensors.csv"] {
        assert_eq!(bytes("shrink", name), bytes("other", name), "{name}");
    }
    let kept = |folder: &Path| std::fs::read_dir(folder.join("records")).unwrap().count();
    assert_eq!(kept(&planted.folder.path().join("shrink")), kept(&planted.folder.path().join("other")));
    let page = std::fs::read_to_string(planted.file("index.html")).unwrap();
    for part in
        ["how little mlp needs", "The smaller model", "Sensors", "Length of the window", "A quick look"]
    {
        assert!(page.contains(part), "{part}");
    }
}

#[test]
fn what_cannot_be_shrunk_is_refused_before_anything_is_trained() {
    let planted = planted(two_of_five, FOLDS, false);
    let refused = |options: ShrinkOptions| {
        let result = planted.try_shrink("shrink", &[Axis::Bits], options, &AtomicBool::new(false));
        result.err().unwrap().to_string()
    };
    assert!(
        refused(ShrinkOptions { margin: Some(0.0), ..ShrinkOptions::default() }).starts_with("margin = 0: ")
    );
    assert!(refused(ShrinkOptions { inner: 1, ..ShrinkOptions::default() }).starts_with("inner = 1: "));
    assert!(
        refused(ShrinkOptions { epochs: Some(0), ..ShrinkOptions::default() }).starts_with("epochs = 0: ")
    );
    assert!(!planted.file("records").exists());
    let error = "sensor".parse::<Axis>().err().unwrap().to_string();
    assert!(
        error.contains("axes = sensor: is nothing that can become less") && error.contains("sensors"),
        "{error}"
    );
}

#[test]
fn a_network_gets_narrower_and_shallower_and_learns_from_the_whole() {
    let planted = planted_for("dilated-resnet-1d", two_of_five, FOLDS, false);
    let finished = planted
        .shrunk(&[Axis::Width, Axis::Depth], ShrinkOptions { epochs: Some(8), ..ShrinkOptions::default() });
    let Shrunk { curves, combined, models, .. } = &finished.shrunk;
    let shorts = |at: usize| curves[at].steps.iter().map(|step| step.short.as_str()).collect::<Vec<_>>();
    assert_eq!(shorts(0), ["32", "16", "8", "4", "2"]);
    assert_eq!((shorts(1), left(&finished.shrunk, 1)), (vec!["1"], Some("1")), "{:#?}", curves[1]);
    assert!(curves[0].knee.is_some(), "{:#?}", curves[0]);
    assert!(combined.is_some());
    let [whole, small] = models.as_slice() else { panic!() };
    assert!(small.macs < whole.macs / 2 && small.parameters < whole.parameters / 2, "{models:?}");
    assert_eq!(small.readings, whole.readings);
    let text = std::fs::read_to_string(planted.file("shrunk.toml")).unwrap();
    assert!(text.contains("blocks = 1") && text.contains("epochs = 8"), "{text}");
    let none = planted
        .try_shrink("mlp", &[Axis::Resolution], ShrinkOptions::default(), &AtomicBool::new(false))
        .unwrap();
    assert_eq!(none.shrunk.left_out[0].0, "Resolution of the array");
}

#[test]
fn a_baseline_is_shrunk_and_stopped_as_a_network_is() {
    let planted = planted_for(KNN, two_of_five, FOLDS, false);
    let finished = planted.shrunk(&[Axis::Sensors], ShrinkOptions::default());
    assert_eq!(left(&finished.shrunk, 0), Some("2"), "{:#?}", finished.shrunk.curves[0]);
    let [whole, small] = finished.shrunk.models.as_slice() else { panic!() };
    // It compares two channels of five.
    assert_eq!(small.macs * 5, whole.macs * 2, "{:?}", finished.shrunk.models);
    let baseline_only = Experiment::load(
        &finished.page.with_file_name("shrunk.toml"),
        &Overrides::default(),
        &planted.registry,
    );
    assert!(baseline_only.unwrap().config().networks.is_empty(), "it would train what nobody asked for");
    assert!(small.parameters < whole.parameters && small.bytes < whole.bytes, "{:?}", finished.shrunk.models);
    let stopped =
        planted.try_shrink("other", &[Axis::Sensors], ShrinkOptions::default(), &AtomicBool::new(true));
    assert!(matches!(stopped, Err(Error::Stopped { .. })), "it was cancelled before the first training");
}

#[test]
fn rows_in_eight_bits_are_neither_shrunk_nor_teachers() {
    let mut planted = planted_for("dilated-resnet-1d", two_of_five, FOLDS, false);
    let Case { folder, dataset, .. } = &planted.case;
    quantize_run(folder, dataset, &|_| {}).unwrap();
    planted.case = Case::new(folder.clone(), dataset.clone()).unwrap();
    let accuracy = |row: usize| planted.case.results.networks[row].score("accuracy").unwrap();
    assert_eq!(planted.case.results.networks[1].network, "dilated-resnet-1d.int8");
    assert!(accuracy(1) >= accuracy(0), "else the row would teach nobody in any case");
    planted.network = "dilated-resnet-1d.int8";
    let refused =
        planted.try_shrink("shrink", &[Axis::Depth], ShrinkOptions::default(), &AtomicBool::new(false));
    let reason = refused.err().unwrap().to_string();
    assert_eq!(
        reason,
        "network = dilated-resnet-1d.int8: is in eight bits: shrink \"dilated-resnet-1d\", then quantize the smaller model"
    );
    assert!(!planted.file("records").exists(), "the corrected command may use the folder");
    planted.network = "dilated-resnet-1d";
    let finished = planted.shrunk(&[Axis::Depth], ShrinkOptions::default());
    assert_eq!(finished.shrunk.curves[0].steps[0].refused, None);
}

#[test]
fn a_smaller_model_that_diverges_on_all_samples_leaves_a_page_without_it() {
    // What is tested has a channel so large that no network learns from it; every other training never sees it.
    let value = |sample: usize, class: usize, channel: usize, time: usize| match (is_tested(sample), channel)
    {
        (true, 0) => 1e30,
        _ => two_of_five(sample, class, channel, time),
    };
    let protocol = "kind = \"official\"\n[encoding]\nsignal = { scale = \"raw\" }";
    let planted = planted_by("{ name = \"sgdm\", lr = 0.05 }", "mlp", value, protocol, true);
    let Finished { shrunk, model, speed, page } = planted.shrunk(&[Axis::Rate], ShrinkOptions::default());
    assert!(model.is_none() && speed.is_none() && shrunk.models.is_empty());
    assert!(shrunk.combined.is_some(), "what suffices is said all the same: {:?}", shrunk.words);
    let last = shrunk.notes.last().unwrap();
    assert!(
        last.starts_with("No smaller model was written: on all samples it could not be trained ("),
        "{last}"
    );
    let page = std::fs::read_to_string(page).unwrap();
    assert!(page.contains("No smaller model was written") && !page.contains("shrunk.safetensors"));
    assert!(!planted.file("shrunk.safetensors").exists());
}
