//! The claims of the papers, with the place where each is printed.

use super::benchmark::Benchmark;
use super::finding::Finding;
use super::palpation::{
    both_do_well, few_beat_many, margin_shrinks, three_beats_two, twins_told_apart, within_look_alikes,
};
use super::questions::{beat, beats, close, commonest_error, larger_spreads, recognised, smallest_spread};
use super::sensors::{channels_alike, frozen_at_chance, optical_first, single_step_at_chance};
use super::times::{predicts_faster, trains_fastest};
use super::transfer::{
    best_from_checkpoint, changes_least, cheapest_to_freeze, early_layers_change_most, freezing_costs,
    resolution_matters, stitched, tuned_beats_frozen, tuned_close,
};
use crate::measure::Measure;
use taxel::judge::Result;

/// A claim, and its test on a run.
pub(crate) struct Definition {
    pub paper: &'static str,
    pub place: &'static str,
    pub says: &'static str,
    /// The run in question, and all others.
    pub(super) test: fn(&Benchmark, &[&Benchmark]) -> Result<Finding>,
}

const fn claim(
    paper: &'static str,
    place: &'static str,
    says: &'static str,
    test: fn(&Benchmark, &[&Benchmark]) -> Result<Finding>,
) -> Definition {
    Definition { paper, place, says, test }
}

/// The light networks of Kaewrakmuk and Srinonchat 2026, the best first.
const LIGHT: [&str; 3] = ["hybrid-resvgg", "resnet8-lite-1d", "vgg6-lite-2d"];
const STRENGTH: [&str; 4] = ["mnasnet1-0", "resnet18", "shufflenet-v2", "mobilenet-v2"];
const PALPATION: [&str; 3] = ["tactnet3d-4-8", "tactnet3d-fc32", "tactnet3d-8-16-32"];
const OWN: Measure = Measure::Accuracy;
const BODIES: [&str; 5] =
    ["vgg6-lite-1d", "resnet8-lite-1d", "vgg6-lite-2d", "resnet8-lite-2d", "densenet6-lite-2d"];
/// Each hybrid of Table 3 with its 1D branch.
const HYBRIDS: [[&str; 2]; 4] = [
    ["hybrid-vgg", "vgg6-lite-1d"],
    ["hybrid-resnet", "resnet8-lite-1d"],
    ["hybrid-densenet", "densenet6-lite-1d"],
    ["hybrid-resvgg", "resnet8-lite-1d"],
];
/// Ranges of layers in Table 6 beside the one that is kept.
const RANGES: [&str; 6] = ["1:150", "1:144", "1:134", "10:150", "10:144", "16:138"];

/// Points above chance that Rouhafzay et al. 2021 still call around a random guess: frozen ResNet50's in Table 3.
pub(crate) const AROUND_CHANCE: f64 = 7.62;
/// "Negligible misclassification" and "high recognition rates" have no number in print: these are ours, in percent.
const NEARLY_ALL: f64 = 99.0;
const HIGH_RATE: f64 = 90.0;

/// Places that several claims name, or that are long.
const FIG_6A: &str = "Fig. 6a, section 5.1";
const FIG_6B: &str = "Fig. 6b, section 5.1";
const TABLE_5: &str = "section 5.3, Table 5";
const LARGE: &str = "sections 5.3 and 5.4, Table 5";
const TUNING: &str = "section 6, Tables 1 to 5";
const ELEMENTS: &str = "section 8, Tables 3 and 4";
const FIG_6: &str = "section 5, Fig. 6";
const LEVELS: &str = "section 5.2.1, Table 2";
const F1: &str = "section 5.2.4, Table 2";

/// Places whose own tables contradict the claim, or do not support it; tests compute from the printed numbers that they do.
const HEAD_SPREAD: &str = "section 5.2, Table 4; its own SDs do not support it (F-test, p = 0.77)";
const RESNET50: &str = "section 6, Tables 1 to 5; its own Table 1 has MobileNetV2 ahead";
const RECALL: &str = "section 5.2.3; its own Table 2 has MnasNet ahead";

/// The claim that `scripts/stitch_experiment.py` answers.
pub(crate) const STITCHED: &str = "The stitched network loses nothing against its parents";

/// In the order of the papers.
pub(crate) const CLAIMS: &[Definition] = &[
    claim("000", "section 5.1, Table 2", "1D beats 2D: Vgg6-Lite", |run, _| {
        beats(run, "vgg6-lite-1d", &["vgg6-lite-2d"], OWN)
    }),
    claim("000", "section 5.1, Table 2", "1D beats 2D: ResNet8-Lite", |run, _| {
        beats(run, "resnet8-lite-1d", &["resnet8-lite-2d"], OWN)
    }),
    claim("000", "section 5.1, Table 2", "1D beats 2D: DenseNet6-Lite", |run, _| {
        beats(run, "densenet6-lite-1d", &["densenet6-lite-2d"], OWN)
    }),
    claim("000", "section 5.1, Table 2", "ResNet8-Lite is the best 1D body", |run, _| {
        beats(run, "resnet8-lite-1d", &["vgg6-lite-1d", "densenet6-lite-1d"], OWN)
    }),
    claim("000", "section 5.1, Table 2", "Vgg6-Lite is the best 2D body", |run, _| {
        beats(run, "vgg6-lite-2d", &["resnet8-lite-2d", "densenet6-lite-2d"], OWN)
    }),
    claim(
        "000",
        "section 5.1, Table 2",
        "1D-DenseNet6-Lite varies least of the six light bodies",
        |run, _| smallest_spread(run, "densenet6-lite-1d", &BODIES),
    ),
    claim("000", "section 5.1, Fig. 6", "Shore 00 is nearly never mistaken for another", |run, _| {
        recognised(run, &["resnet8-lite-1d", "vgg6-lite-2d"], "shore-00", NEARLY_ALL)
    }),
    claim("000", FIG_6A, "Shore 20 taken for 10 is the commonest error of 1D-ResNet8-Lite", |run, _| {
        commonest_error(run, "resnet8-lite-1d", ["shore-20", "shore-10"])
    }),
    claim("000", FIG_6B, "Shore 20 taken for 10 is the commonest error of 2D-Vgg6-Lite", |run, _| {
        commonest_error(run, "vgg6-lite-2d", ["shore-20", "shore-10"])
    }),
    claim("000", "Tables 2 and 3", "Hybrid-CNN-Vgg beats both of its branches", |run, _| {
        beats(run, "hybrid-vgg", &["vgg6-lite-1d", "vgg6-lite-2d"], OWN)
    }),
    claim("000", "Tables 2 and 3", "Hybrid-CNN-ResNet beats both of its branches", |run, _| {
        beats(run, "hybrid-resnet", &["resnet8-lite-1d", "resnet8-lite-2d"], OWN)
    }),
    claim("000", "Tables 2 and 3", "Hybrid-CNN-DenseNet beats both of its branches", |run, _| {
        beats(run, "hybrid-densenet", &["densenet6-lite-1d", "densenet6-lite-2d"], OWN)
    }),
    claim("000", "section 5.2, Tables 2 and 3", "Hybrid-CNN-ResVgg beats both of its branches", |run, _| {
        beats(run, "hybrid-resvgg", &["resnet8-lite-1d", "vgg6-lite-2d"], OWN)
    }),
    claim("000", "section 5.2, Table 3", "ResVgg is the best hybrid", |run, _| {
        beats(run, "hybrid-resvgg", &["hybrid-vgg", "hybrid-resnet", "hybrid-densenet"], OWN)
    }),
    claim(
        "000",
        "section 5.2, Tables 2 and 3",
        "Hybrids vary more over folds than their 1D branches",
        |run, _| larger_spreads(run, &HYBRIDS),
    ),
    claim("000", "section 5.2, Table 4", "The fully connected head adds accuracy (0.80 points)", |run, _| {
        beats(run, "hybrid-resvgg", &["hybrid-resvgg-nofc"], OWN)
    }),
    claim("000", HEAD_SPREAD, "The fully connected head adds spread over folds", |run, _| {
        larger_spreads(run, &[["hybrid-resvgg", "hybrid-resvgg-nofc"]])
    }),
    claim("000", TABLE_5, "Hybrid-CNN-ResVgg beats MLP and LSTM", |run, _| {
        beats(run, "hybrid-resvgg", &["mlp", "lstm"], OWN)
    }),
    claim("000", TABLE_5, "1D-ResNet8-Lite and 2D-Vgg6-Lite beat MLP and LSTM", |run, _| {
        beat(run, &["resnet8-lite-1d", "vgg6-lite-2d"], &["mlp", "lstm"], OWN)
    }),
    claim("000", TABLE_5, "Hybrid-CNN-ResVgg beats the tactile perception models", |run, _| {
        beats(run, "hybrid-resvgg", &["tactnet4", "tactnet6", "tactresnet"], OWN)
    }),
    claim("000", LARGE, "The large ImageNet networks do not beat the light ones", |run, _| {
        // One point is ours: two networks that tie are not one that beats the other.
        close(run, &LIGHT, &["vgg16", "resnet18", "densenet201"], 1.0)
    }),
    claim(
        "000",
        "section 5.3, Fig. 7a",
        "The MLP predicts fastest, faster than LSTM and light networks",
        |run, _| {
            predicts_faster(run, &["mlp"], &["lstm", "resnet8-lite-1d", "vgg6-lite-2d", "hybrid-resvgg"])
        },
    ),
    claim(
        "000",
        "section 5.3, Fig. 7a",
        "The large ImageNet networks predict slower than light ones",
        |run, _| predicts_faster(run, &LIGHT, &["vgg16", "resnet18", "densenet201"]),
    ),
    claim("001", RESNET50, "ResNet50 is the best network, tuned and frozen", |run, _| {
        best_from_checkpoint(run, "resnet50")
    }),
    claim(
        "001",
        "section 6, Tables 1 to 5",
        "Optical sensors are further above chance than others",
        optical_first,
    ),
    claim("001", "section 6, Table 3", "Frozen networks are around chance on 16 × 16 elements", |run, _| {
        frozen_at_chance(run, 16, AROUND_CHANCE)
    }),
    claim(
        "001",
        "sections 3.4 and 6",
        "Single time steps of 7 × 3 electrodes cannot be classified",
        |run, _| single_step_at_chance(run, AROUND_CHANCE),
    ),
    claim("001", "section 5", "Grey in red alone does as well as in three channels", |run, _| {
        channels_alike(run)
    }),
    claim("001", "section 6, Fig. 4", "Tuning changes ResNet50 least of all networks", |run, _| {
        changes_least(run, "resnet50")
    }),
    claim("001", TUNING, "Tuning all weights beats freezing all but the classifier", |run, _| {
        tuned_beats_frozen(run)
    }),
    claim("001", TUNING, "MobileNetV2 is within 3.33 points of ResNet50 when tuned", |run, _| {
        tuned_close(run, "mobilenet-v2", "resnet50", 3.33)
    }),
    claim("001", "section 6, Fig. 4", "Tuning changes the early layers of MobileNetV2 most", |run, _| {
        early_layers_change_most(run, "mobilenet-v2")
    }),
    claim("001", "section 7, Table 6", "Freezing layers 18 to 139 costs less than a point", |run, _| {
        freezing_costs(run, "18:139", 1.0)
    }),
    claim(
        "001",
        "section 7, Table 6",
        "Only the first and last block need tuning: no other range costs as little",
        |run, _| cheapest_to_freeze(run, "18:139", &RANGES),
    ),
    claim("001", "section 7, Fig. 6", STITCHED, |run, _| stitched(run)),
    claim("001", ELEMENTS, "128 × 128 elements add tens of points to 16 × 16", |run, others| {
        resolution_matters(run, others, [16, 128], 10.0)
    }),
    claim("002", "section III-D, Table I", "TactNet3D is the best of the four 3D networks", |run, _| {
        beats(run, "tactnet3d", &PALPATION, OWN)
    }),
    claim("002", "section III-D, Table I", "TactNet3D varies least of the four 3D networks", |run, _| {
        smallest_spread(run, "tactnet3d", &PALPATION)
    }),
    claim(
        "002",
        "section III-D, Table I",
        "The shallowest of the four 3D networks trains fastest",
        |run, _| trains_fastest(run, "tactnet3d-4-8", &["tactnet3d", "tactnet3d-fc32", "tactnet3d-8-16-32"]),
    ),
    claim(
        "002",
        "section I",
        "A sequence tells an object from its twin with inclusions, a frame does not",
        |run, _| twins_told_apart(run, "_inclusions"),
    ),
    claim("003", FIG_6, "TactNet3D beats every 2D network with 1 grasp per object", |run, _| {
        three_beats_two(run, 1)
    }),
    claim("003", FIG_6, "TactNet3D beats every 2D network with 2 grasps per object", |run, _| {
        three_beats_two(run, 2)
    }),
    claim("003", FIG_6, "TactNet3D beats every 2D network with 5 grasps per object", |run, _| {
        three_beats_two(run, 5)
    }),
    claim("003", FIG_6, "TactNet3D beats every 2D network with 10 grasps per object", |run, _| {
        three_beats_two(run, 10)
    }),
    claim("003", FIG_6, "TactNet3D beats every 2D network with 20 grasps per object", |run, _| {
        three_beats_two(run, 20)
    }),
    claim("003", FIG_6, "The margin of TactNet3D is largest with few grasps", |run, _| margin_shrinks(run)),
    claim("003", "section 6", "Both 3D and 2D networks do well with 20 grasps per object", |run, _| {
        both_do_well(run, 20, HIGH_RATE)
    }),
    claim("003", FIG_6, "1 or 2 grasps of TactNet3D beat 5 or 10 of 2D networks in some cases", |run, _| {
        few_beat_many(run, &[1, 2], &[5, 10])
    }),
    claim(
        "003",
        "section 5, Figs. 7 and 8",
        "Errors of TactNet3D stay inside groups of look-alikes more than those of 2D networks",
        |run, _| within_look_alikes(run, 2),
    ),
    claim("004", LEVELS, "Multi-scale is the most accurate on elasticity levels", |run, _| {
        beats(run, "multiscale-cnn", &STRENGTH, Measure::Attribute("elasticity"))
    }),
    claim("004", LEVELS, "Multi-scale is the most accurate on hardness levels", |run, _| {
        beats(run, "multiscale-cnn", &STRENGTH, Measure::Attribute("hardness"))
    }),
    claim(
        "004",
        "section 5.2.2, Table 2",
        "The worst elasticity level of multi-scale is better than the others' worst",
        |run, _| beats(run, "multiscale-cnn", &STRENGTH, Measure::WorstPrecision("elasticity")),
    ),
    claim(
        "004",
        "section 5.2.2, Table 2",
        "The worst hardness level of multi-scale is better than the others' worst",
        |run, _| beats(run, "multiscale-cnn", &STRENGTH, Measure::WorstPrecision("hardness")),
    ),
    claim(
        "004",
        RECALL,
        "The worst recall of an elasticity level of multi-scale is better than the others'",
        |run, _| beats(run, "multiscale-cnn", &STRENGTH, Measure::WorstRecall("elasticity")),
    ),
    claim(
        "004",
        "section 5.2.3, Table 2",
        "The worst recall of a hardness level of multi-scale is better than the others'",
        |run, _| beats(run, "multiscale-cnn", &STRENGTH, Measure::WorstRecall("hardness")),
    ),
    claim("004", F1, "The best F1 of an elasticity level is multi-scale's", |run, _| {
        beats(run, "multiscale-cnn", &STRENGTH, Measure::BestF1("elasticity"))
    }),
    claim("004", F1, "The best F1 of a hardness level is multi-scale's", |run, _| {
        beats(run, "multiscale-cnn", &STRENGTH, Measure::BestF1("hardness"))
    }),
    claim("004", F1, "Multi-scale varies less over elasticity levels than the others", |run, _| {
        beats(run, "multiscale-cnn", &STRENGTH, Measure::Steadiness("elasticity"))
    }),
    claim("004", F1, "Multi-scale varies less over hardness levels than the others", |run, _| {
        beats(run, "multiscale-cnn", &STRENGTH, Measure::Steadiness("hardness"))
    }),
];
