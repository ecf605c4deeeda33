//! The fingertip scene: its physics, its reproducibility and its honest difficulty.

mod common;

use common::{all_but, removable, truth};
use ndarray::{Array2, ArrayD, Axis};
use taxel_scenes::{Error, Fingertip, Scene, explain, fingertip::young_modulus, names, simulate};

const FINGERTIP: &str = "fingertip";

#[test]
fn gents_relation_gives_the_moduli_of_the_paper_s_three_cylinders() {
    // By hand: 5.4936 / 34.92627, 12.97214 / 31.43364 and 20.45068 / 27.94102.
    for (shore, mpa) in [(0.0, 0.15729), (10.0, 0.41268), (20.0, 0.73192)] {
        assert!((young_modulus(shore) - mpa).abs() < 1e-4, "{shore}: {}", young_modulus(shore));
    }
}

#[test]
fn readings_are_whole_counts_and_classes_and_sessions_balance() {
    let scene = simulate(FINGERTIP, 300, 1, &[]).unwrap();
    assert_eq!(scene.x.shape(), [300, 5, 50]);
    assert!(scene.x.iter().all(|v| (0.0..=1023.0).contains(v) && v.fract() == 0.0));
    assert!(scene.x.iter().any(|&v| v > 500.0), "nothing was grasped");
    for class in 0..3 {
        assert_eq!(scene.y.iter().filter(|&&y| y == class).count(), 100);
        for group in 0..10 {
            let both = scene.y.iter().zip(&scene.group).filter(|&(&y, &g)| (y, g) == (class, group));
            assert_eq!(both.count(), 10);
        }
    }
    assert_eq!((scene.unit, scene.full_scale), ("ADC counts", 1023.0));
    assert_eq!(scene.channel_names.len(), 5);
    for (name, values) in &scene.truth {
        assert_eq!(values.len(), 300, "{name}");
        assert!(values.iter().all(|v| v.is_finite()), "{name}");
        let share = name.starts_with("contact_quality");
        assert!(!share || values.iter().all(|q| (0.0..=1.0).contains(q)), "{name} is a share");
    }
}

#[test]
fn a_sample_depends_on_seed_and_index_and_not_on_how_many_there_are() {
    let few = simulate(FINGERTIP, 20, 5, &[]).unwrap();
    let many = simulate(FINGERTIP, 200, 5, &[]).unwrap();
    assert_eq!(few, simulate(FINGERTIP, 20, 5, &[]).unwrap());
    assert_eq!(few.x, many.x.select(Axis(0), &(0..20).collect::<Vec<_>>()));
    assert_eq!(few.truth[2].1, many.truth[2].1[..20]);
    assert_ne!(few.x, simulate(FINGERTIP, 20, 6, &[]).unwrap().x);
}

#[test]
fn harder_presses_more_and_relaxes_less() {
    let shore = vec![0.0, 5.0, 10.0, 20.0, 40.0, 60.0];
    let without = ["contact-quality", "placement", "servo", "session", "noise"].map(String::from);
    let hands = Fingertip { shore, ..Fingertip::default() };
    let scene = hands.simulate(6, 3, &without).unwrap();
    let force = &scene.truth.iter().find(|(n, _)| n == "hold_force_n").unwrap().1;
    assert!(force.is_sorted_by(|a, b| a < b), "{force:?}");
    for finger in 0..5 {
        // After 2.4 s the hand holds still.
        let at = |t: usize| (0..6).map(|i| scene.x[[i, finger, t]]).collect::<Vec<_>>();
        let (peak, end) = (at(24), at(49));
        assert!(end.is_sorted_by(|a, b| a < b), "finger {finger}: {end:?}");
        let kept: Vec<f32> = peak.iter().zip(&end).map(|(p, e)| e / p).collect();
        assert!(kept.iter().all(|&k| k < 1.0) && kept.is_sorted(), "finger {finger}: {kept:?}");
    }
}

/// Everything but the named effects removed, one grasp of Shore A 20.
fn only(effects: &[&str], samples: usize) -> taxel_scenes::Result<Scene> {
    let hands = Fingertip { shore: vec![20.0], ..Fingertip::default() };
    hands.simulate(samples, 4, &all_but(FINGERTIP, effects))
}

/// Hertz' coefficient in N/mm^1.5 for Shore A 20, tip radius 8 mm, cylinder radius 25 mm.
const HERTZ: f64 = 4.0 / 3.0 * 0.731923 / 0.75 * 2.461_830;
/// Squeeze of each finger at the end of the motion: 18 mm less the gap.
const SQUEEZE: [f64; 5] = [5.0, 6.0, 6.5, 6.0, 5.0];

#[test]
fn force_and_counts_are_the_balance_of_object_and_spring() {
    let scene = only(&["compliance"], 1).unwrap();
    let mut sum = 0.0;
    for (finger, squeeze) in SQUEEZE.into_iter().enumerate() {
        // Bisection on d + F(d) / k = squeeze, k = 2 N/mm.
        let (mut low, mut high) = (0.0, squeeze);
        for _ in 0..60 {
            let d: f64 = (low + high) / 2.0;
            if d + HERTZ * d.powf(1.5) / 2.0 > squeeze { high = d } else { low = d }
        }
        let force = HERTZ * f64::powf(low, 1.5);
        sum += force;
        let ratio = 0.16 * force.powf(0.85) * 10.0;
        let counts = (1023.0 * ratio / (1.0 + ratio)).round();
        assert_eq!(f64::from(scene.x[[0, finger, 49]]), counts, "finger {finger}");
        assert_eq!(scene.x[[0, finger, 5]], 0.0, "before contact");
    }
    let got = f64::from(truth(&scene, "hold_force_n")[0]);
    assert!((got - sum).abs() < 1e-3 * sum, "{got} N, by hand {sum} N");
}

#[test]
fn a_rigid_finger_shows_the_relaxation_of_the_material() {
    let scene = only(&["relaxation"], 1).unwrap();
    // The hereditary integral of one Prony term, g = 0.3 and tau = 1 s, at t = 4.9 s; the ramp of
    // 18 mm takes 2 s from t = 0.4 s.
    let (mut want, ds) = (0.0, 1e-4);
    for squeeze in SQUEEZE {
        let elastic = |t: f64| HERTZ * (9.0 * (t - 0.4).min(2.0) - 18.0 + squeeze).max(0.0).powf(1.5);
        for i in 0..49_000 {
            let s = (f64::from(i) + 0.5) * ds;
            let kept = 1.0 - 0.3 * (1.0 - (-(4.9 - s)).exp());
            want += kept * (elastic(s + ds / 2.0) - elastic(s - ds / 2.0));
        }
    }
    let got = f64::from(truth(&scene, "hold_force_n")[0]);
    assert!((got - want).abs() < 1e-3 * want, "{got} N, by hand {want} N");
}

#[test]
fn an_object_nearer_to_the_fingers_is_farther_from_the_thumb() {
    let scene = only(&["compliance", "placement"], 50).unwrap();
    let shift = truth(&scene, "placement_shift_mm");
    let level = |i: usize, finger: usize| scene.x[[i, finger, 49]];
    let (near, far) = (
        (0..50).max_by(|&a, &b| shift[a].total_cmp(&shift[b])).unwrap(),
        (0..50).min_by(|&a, &b| shift[a].total_cmp(&shift[b])).unwrap(),
    );
    assert!(level(near, 0) < level(far, 0), "thumb");
    assert!(level(near, 2) > level(far, 2), "middle finger");
}

#[test]
fn a_session_has_its_own_slowly_drifting_placement_and_contact() {
    let scene = only(&["session"], 500).unwrap();
    for name in ["placement_shift_mm", "contact_quality_little"] {
        let values = truth(&scene, name);
        let mean_step = |apart: usize| {
            let steps = values.iter().zip(&values[apart..]).map(|(a, b)| (a - b).abs());
            steps.sum::<f32>() / (values.len() - apart) as f32
        };
        // One class and ten sessions: the session's next grasp is ten rows on.
        let (drift, other_session) = (mean_step(10), mean_step(1));
        assert!(drift > 0.0 && other_session > 3.0 * drift, "{name}: {drift}, {other_session}");
    }
}

#[test]
fn every_removable_effect_changes_the_readings() {
    let whole = simulate(FINGERTIP, 60, 9, &[]).unwrap();
    assert_eq!(removable(FINGERTIP).len(), 7);
    for effect in removable(FINGERTIP) {
        let without = simulate(FINGERTIP, 60, 9, std::slice::from_ref(&effect)).unwrap();
        let gap = (&whole.x - &without.x).mapv(f32::abs).mean().unwrap();
        assert!(gap > 0.5, "without {effect} the mean reading moves by {gap} counts");
        assert_eq!(whole.y, without.y);
    }
    let all = simulate(FINGERTIP, 60, 9, &removable(FINGERTIP)).unwrap();
    assert_eq!(all.x.index_axis(Axis(0), 0), all.x.index_axis(Axis(0), 57), "something is still random");
}

#[test]
fn removing_an_effect_leaves_the_random_numbers_of_the_others_alone() {
    let whole = simulate(FINGERTIP, 40, 2, &[]).unwrap();
    let without = simulate(FINGERTIP, 40, 2, &["servo".into()]).unwrap();
    for ((name, a), (_, b)) in whole.truth.iter().zip(&without.truth) {
        let servos = ["hold_error_mm", "start_error_s", "hold_force_n"].contains(&name.as_str());
        assert_eq!(a != b, servos, "{name}");
    }
}

#[test]
fn impossible_requests_are_refused_by_name() {
    let message = |hands: Fingertip, samples| hands.simulate(samples, 0, &[]).unwrap_err().to_string();
    let shore = |shore: &[f32]| Fingertip { shore: shore.to_vec(), ..Fingertip::default() };
    assert_eq!(message(Fingertip::default(), 0), "samples = 0: must be at least 1");
    assert!(message(shore(&[]), 3).starts_with("shore = []:"));
    for bad in [-1.0, 100.0, f32::NAN, f32::INFINITY] {
        assert!(message(shore(&[0.0, bad]), 3).contains("must be in [0, 95]"), "{bad}");
    }
    assert!(message(shore(&[5.0, 5.0]), 3).contains("must differ"));
    let none = Fingertip { sessions: 0, ..Fingertip::default() };
    assert!(message(none, 3).starts_with("sessions = 0:"));

    for fixed in ["sensor", "nois", ""] {
        let error = simulate(FINGERTIP, 3, 0, &[fixed.into()]).unwrap_err().to_string();
        assert!(error.contains(&format!("`{fixed}`; ")), "{error}");
        assert!(error.contains("known: compliance, relaxation"), "{error}");
    }
    assert!(matches!(simulate("slip", 3, 0, &[]), Err(Error::UnknownScene { .. })));
    assert_eq!(
        explain("slip").unwrap_err().to_string(),
        "there is no scene `slip`; known: fingertip, palpation, gripper, imprint, gel, hand, vision"
    );
    assert!(names().iter().all(|name| simulate(name, 1, 0, &[]).is_ok() && explain(name).is_ok()));
}

#[test]
fn every_parameter_has_a_source_and_a_reason() {
    for effect in explain(FINGERTIP).unwrap() {
        let texts = [&effect.name, &effect.parameter, &effect.value, &effect.source, &effect.why];
        assert!(texts.iter().all(|text| !text.is_empty()), "{effect:?}");
    }
}

/// Confusion counts `[true, predicted]` of 3-NN on raw readings; sample i is in fold `fold(i)` of 5.
fn three_nearest(scene: &Scene, fold: impl Fn(usize) -> usize) -> Array2<usize> {
    let n = scene.y.len();
    let rows: Vec<Vec<f32>> = scene.x.outer_iter().map(|r| r.iter().copied().collect()).collect();
    let mut confusion = Array2::zeros((3, 3));
    for i in 0..n {
        let mut near: Vec<(f32, u32)> = (0..n)
            .filter(|&j| fold(j) != fold(i))
            .map(|j| (rows[i].iter().zip(&rows[j]).map(|(a, b)| (a - b).powi(2)).sum(), scene.y[j]))
            .collect();
        near.select_nth_unstable_by(2, |a, b| a.0.total_cmp(&b.0));
        near.truncate(3);
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        // A majority, or the nearest of three different ones.
        let majority = if near[1].1 == near[2].1 { near[1].1 } else { near[0].1 };
        confusion[[scene.y[i] as usize, majority as usize]] += 1;
    }
    confusion
}

fn accuracy(confusion: &Array2<usize>) -> f64 {
    confusion.diag().sum() as f64 / confusion.sum() as f64
}

/// Nearest class mean of `x`, means and scores on all samples: a bound from above.
fn nearest_centroid(x: &ArrayD<f32>, y: &[u32]) -> f64 {
    let mean = |class: u32| {
        let rows: Vec<usize> = (0..y.len()).filter(|&i| y[i] == class).collect();
        x.select(Axis(0), &rows).mean_axis(Axis(0)).unwrap_or_else(|| ArrayD::zeros(vec![5, 50]))
    };
    let means = [mean(0), mean(1), mean(2)];
    let right = x.outer_iter().zip(y).filter(|(row, y)| {
        let gap = |class: usize| (row - &means[class]).mapv(|v| v * v).sum();
        (0..3).all(|other| gap(**y as usize) <= gap(other))
    });
    right.count() as f64 / y.len() as f64
}

#[test]
fn difficulty_is_that_of_the_paper_s_kind() {
    let scene = simulate(FINGERTIP, 1500, 42, &[]).unwrap();
    // 30 samples are one grasp of each class in each session: every fold has all of them.
    let confusion = three_nearest(&scene, |i| i / 30 % 5);
    println!("3-NN {:.3}\n{confusion}", accuracy(&confusion));
    assert!((0.6..0.93).contains(&accuracy(&confusion)), "{confusion}");
    let recall = |class: usize| confusion[[class, class]];
    assert!(recall(0) > recall(1) && recall(0) > recall(2), "{confusion}");
    let (middle, hard) = (confusion[[1, 2]], confusion[[2, 1]]);
    let others = [confusion[[0, 1]], confusion[[0, 2]], confusion[[1, 0]], confusion[[2, 0]]];
    assert!(others.iter().all(|&other| other < middle.min(hard)), "{confusion}");

    let centroid = nearest_centroid(&scene.x, &scene.y);
    println!("nearest centroid {centroid:.3}");
    assert!((0.45..0.85).contains(&centroid), "{centroid}");
}

#[test]
fn nuisances_make_it_hard() {
    let nuisances = ["contact-quality", "placement", "servo", "session"].map(String::from);
    let clean = simulate(FINGERTIP, 150, 42, &nuisances).unwrap();
    assert_eq!(accuracy(&three_nearest(&clean, |i| i / 30 % 5)), 1.0);
}

#[test]
fn hardness_may_be_continuous() {
    let hands = Fingertip { between: Some([2.0, 40.0]), ..Fingertip::default() };
    let scene = hands.simulate(300, 1, &[]).unwrap();
    let shore = truth(&scene, "shore");
    assert!(shore.iter().all(|s| (2.0..=40.0).contains(s)));
    assert!(shore.iter().any(|s| *s > 35.0) && shore.iter().any(|s| *s < 5.0));
    for (shore, class) in shore.iter().zip(&scene.y) {
        assert_eq!(*class, if *shore < 5.0 { 0 } else { u32::from(*shore > 15.0) + 1 });
    }
    assert_eq!(truth(&hands.simulate(30, 1, &[]).unwrap(), "shore"), &shore[..30]);
    for bad in [[5.0, 5.0], [20.0, 10.0], [-1.0, 5.0], [0.0, 96.0], [f32::NAN, 5.0]] {
        let hands = Fingertip { between: Some(bad), ..Fingertip::default() };
        assert!(hands.simulate(3, 0, &[]).unwrap_err().to_string().starts_with("between = ["), "{bad:?}");
    }
}

#[test]
fn hardnesses_of_the_last_samples_may_be_unseen_ones() {
    let levels = Fingertip { shore: vec![0.0, 20.0, 40.0], ..Fingertip::default() };
    let hands = Fingertip { between: Some([0.0, 40.0]), unseen: Some(0.25), ..levels.clone() };
    let scene = hands.simulate(80, 1, &[]).unwrap();
    let shore = truth(&scene, "shore");
    assert_eq!(scene.test.as_deref().unwrap(), (0..80).map(|i| i >= 60).collect::<Vec<_>>());
    assert!(shore[60..].iter().all(|s| s.fract() != 0.0 && (0.0..=40.0).contains(s)));
    // The first are those of a world of levels alone.
    let known = levels.simulate(60, 1, &[]).unwrap();
    assert_eq!(&shore[..60], truth(&known, "shore"));
    assert!(known.test.is_none());
    assert_eq!(known.x, scene.x.slice_axis(Axis(0), (0..60).into()));
    let refused = |hands: &Fingertip, samples| hands.simulate(samples, 0, &[]).unwrap_err().to_string();
    for bad in [0.0, 1.0, -0.5, f32::NAN] {
        let message = refused(&Fingertip { unseen: Some(bad), ..hands.clone() }, 80);
        assert!(message.starts_with("unseen = ") && message.contains("above 0 and below 1"), "{message}");
    }
    assert!(refused(&Fingertip { between: None, ..hands.clone() }, 80).contains("between = [0, 40]"));
    assert!(refused(&Fingertip { unseen: Some(0.01), ..hands }, 9).contains("simulate more"));
}

#[test]
fn joined_worlds_keep_their_true_values() {
    let worlds: Vec<Scene> = [1, 2, 3].map(|seed| simulate(FINGERTIP, 6, seed, &[]).unwrap()).to_vec();
    let force = |scene: &Scene| truth(scene, "hold_force_n").to_vec();
    let wanted: Vec<f32> = worlds.iter().flat_map(force).collect();
    assert_eq!(force(&Scene::joined(worlds).unwrap()), wanted);
}

#[test]
fn more_samples_than_memory_holds_are_refused_before_they_are_asked_for() {
    for samples in [10usize.pow(13), usize::MAX] {
        let error = simulate("fingertip", samples, 0, &[]).unwrap_err().to_string();
        assert!(error.starts_with(&format!("samples = {samples}: they do not fit into memory")), "{error}");
    }
}
