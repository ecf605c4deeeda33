//! The mean of several rows as a row and a model of its own.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use allocation_counter::measure;
use ndarray::Axis;
use serde_json::json;
use support::{bits, mlp, presses, recipe, record, run_at, three_folds};
use taxel_baselines::Method;
use taxel_data::{Dataset, Quantity, Targets, Values};
use taxel_graph::Loss;
use taxel_learn::{Candidate, Encoding, FoldKey, Model, ModelKind, Recipe, RunFolder, fit};

/// Presses with the height of each channel's last reading.
fn measured() -> Dataset {
    let mut dataset = presses(30, 12);
    let heights: Vec<f32> = dataset.x.index_axis(Axis(2), 11).iter().copied().collect();
    let names = ["height", "offset"].map(|name| Quantity { name: name.into(), unit: Some("N".into()) });
    dataset.targets = Targets::Values(Values::new(names.to_vec(), heights));
    dataset
}

/// A network of values whose outputs are wider than the quantities.
fn line(dataset: &Dataset) -> Candidate {
    let loss = Loss::GaussianLikelihood;
    let net = taxel_graph::Network::new("line");
    let flow = net.input("signal", &dataset.spec.shape.clone()).flatten().linear("fc1", 8).relu();
    let graph = net.finish(&[("values", flow.linear("fc2", 2 * loss.outputs_per_target()))]).unwrap();
    Candidate::network(graph, Recipe { loss: Some(loss), ..recipe(json!({})) })
}

/// The model of each fold of the average predicts what its row says, which is the mean of the rows of its members.
fn check(folder: &RunFolder, dataset: &Dataset, members: &[&str]) {
    for key in folder.keys().unwrap().into_iter().filter(|key| key.network == "both") {
        let own = record(folder, &key);
        let mut sums = vec![0.0; own.outcome.outputs().len()];
        for name in members {
            let row = record(folder, &FoldKey { network: (*name).into(), ..key.clone() });
            sums.iter_mut().zip(row.outcome.outputs()).for_each(|(sum, output)| *sum += output);
        }
        sums.iter_mut().for_each(|sum| *sum /= members.len() as f32);
        assert_eq!(bits(own.outcome.outputs()), bits(&sums), "{key}");
        let model = Model::open(&folder.model_path(&key)).unwrap();
        let test = dataset.x.select(Axis(0), &own.index);
        assert_eq!(bits(&model.predict(&test).unwrap().outputs), bits(&sums), "{key}");
        let predictor = model.predictor(8, 2).unwrap();
        let mut workspace = predictor.workspace().unwrap();
        let reading: Vec<f32> = test.index_axis(Axis(0), 0).iter().copied().collect();
        let one = predictor.predict_one(&mut workspace, &reading).unwrap().to_vec();
        assert_eq!(bits(&one), bits(&sums[..one.len()]), "{key}");
        let allocated = measure(|| {
            predictor.predict_one(&mut workspace, &reading).unwrap();
        });
        assert_eq!(allocated.count_total, 0, "{key}");
        let costs = own.costs.unwrap();
        assert!(costs.parameters > 0 && costs.macs > 0, "{costs:?}");
    }
}

#[test]
fn the_mean_of_values_is_that_of_the_rows() {
    let dataset = measured();
    let rows =
        [line(&dataset), Candidate::baseline(Method::of_values()[4]), Candidate::baseline(Method::Ridge)];
    let both = Candidate::average("both".into(), &rows);
    let dir = tempfile::tempdir().unwrap();
    let candidates = [rows.to_vec(), vec![both]].concat();
    let folder = run_at(three_folds(&dataset, candidates), &dir.path().join("run")).unwrap();
    check(&folder, &dataset, &["line", "extra-trees", "ridge"]);
}

#[test]
fn the_mean_of_classes_is_that_of_probabilities() {
    let dataset = presses(30, 12);
    let rows = [mlp(&dataset, recipe(json!({}))), Candidate::baseline(Method::MiniRocket { features: 84 })];
    let both = Candidate::average("both".into(), &rows);
    let dir = tempfile::tempdir().unwrap();
    let candidates = [rows.to_vec(), vec![both]].concat();
    let folder = run_at(three_folds(&dataset, candidates), &dir.path().join("run")).unwrap();
    check(&folder, &dataset, &["mlp", "mini-rocket"]);
}

#[test]
fn an_average_is_refused_where_a_member_is() {
    let dataset = measured();
    let refused = |members: &[Candidate]| {
        let both = Candidate::average("both".into(), members);
        fit(&both, &dataset, &Encoding::default()).unwrap_err().to_string()
    };
    let ridge = Candidate::baseline(Method::Ridge);
    assert!(refused(std::slice::from_ref(&ridge)).contains("needs two members or more"));
    let majority = Candidate::baseline(Method::Majority);
    let text = refused(&[ridge, majority]);
    assert!(text.contains("majority") && text.contains("the targets are values"), "{text}");
}

#[test]
fn a_model_of_an_average_is_one_file() {
    let dataset = measured();
    let rows = [Candidate::baseline(Method::Ridge), Candidate::baseline(Method::of_values()[4])];
    let model = fit(&Candidate::average("both".into(), &rows), &dataset, &Encoding::default()).unwrap();
    let again = Model::from_bytes(&model.to_bytes().unwrap(), "both.safetensors").unwrap();
    assert_eq!(again.card(), model.card());
    let tensor = |name: &str| again.weights().get(name).map(|tensor| bits(&tensor.data));
    for (name, own) in model.weights().iter() {
        assert_eq!(tensor(name), Some(bits(&own.data)), "{name}");
    }
    let ModelKind::Average { members } = &model.card().kind else { panic!("an average") };
    assert_eq!(
        members.iter().map(|member| (member.name.as_str(), member.inputs)).collect::<Vec<_>>(),
        [("ridge", 1), ("extra-trees", 1)]
    );
    assert!(model.card().to_string().contains("both: the mean of ridge and extra-trees"), "{}", model.card());
}
