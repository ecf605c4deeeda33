//! Fresh tensors by their scheme, and tensors that do not fit a network.

#![allow(clippy::unwrap_used, clippy::panic)]

use taxel_graph::{Conv, Graph, Network, Scheme, Tensor, Weights};

/// A grouped convolution and a wide linear layer.
fn net() -> Graph {
    let net = Network::new("net");
    let x = net.input("x", &[8, 4, 4]).conv("c", Conv::new(80, 3).pad(1).groups(2)).batch_norm("n");
    net.finish(&[("y", x.global_average_pool().linear("fc", 400))]).unwrap()
}

fn spread(values: &[f32]) -> (f64, f64, f64) {
    let (mut low, mut high, mut squares) = (f64::MAX, f64::MIN, 0.0);
    for &v in values {
        (low, high, squares) = (low.min(v.into()), high.max(v.into()), squares + f64::from(v).powi(2));
    }
    (low, high, (squares / values.len() as f64).sqrt())
}

/// Glorot and Bengio (2010), equation 16; He et al. (2015), equation 10.
#[test]
fn schemes_draw_with_their_bounds_and_deviations() {
    let net = net();
    // Values in and out: of a group of the convolution 4 · 9 and 40 · 9, of the linear layer 80 and 400.
    for (name, fan_in, fan_out) in [("c.weight", 36.0f64, 360.0), ("fc.weight", 80.0, 400.0)] {
        let of = |scheme| spread(&Weights::init(&net, scheme, 5, "init").get(name).unwrap().data);
        for (scheme, bound) in
            [(Scheme::Glorot, (6.0 / (fan_in + fan_out)).sqrt()), (Scheme::Pytorch, 1.0 / fan_in.sqrt())]
        {
            let (low, high, deviation) = of(scheme);
            assert!((0.98 * bound..=1.000_001 * bound).contains(&high), "{name}: {high} of {bound}");
            assert!((0.98 * bound..=1.000_001 * bound).contains(&-low), "{name}: {low} of {bound}");
            assert!((deviation * 3f64.sqrt() / bound - 1.0).abs() < 0.05, "{name}: {deviation} of {bound}");
        }
        let (low, high, deviation) = of(Scheme::He);
        let want = (2.0 / fan_in).sqrt();
        assert!((deviation / want - 1.0).abs() < 0.05, "{name}: {deviation}, not {want}");
        assert!(low < -2.5 * want && high > 2.5 * want, "{name}: {low} to {high}");
    }
    let he = Weights::init(&net, Scheme::He, 5, "init");
    let constant = |name: &str, value| he.get(name).unwrap().data.iter().all(|v| *v == value);
    assert!(constant("fc.bias", 0.0) && constant("n.weight", 1.0) && constant("n.running_mean", 0.0));
}

#[test]
fn tensors_that_do_not_fit_are_named() {
    let net = net();
    let drawn = Weights::init(&net, Scheme::Pytorch, 1, "init");
    assert_eq!((drawn.len(), drawn.is_empty()), (8, false));
    assert_eq!((Weights::new().len(), Weights::new().is_empty()), (0, true));
    let with = |name: &str, shape: &[usize], count: usize| {
        let mut weights = drawn.clone();
        weights.insert(name, Tensor { shape: shape.to_vec(), data: vec![0.0; count] });
        weights.check(&net).map_err(|error| error.to_string())
    };
    // As many values in another shape; the shape with too few values.
    let error = with("fc.weight", &[80, 400], 32_000).unwrap_err();
    assert!(error.contains("tensor `fc.weight` has shape [80, 400], expected [400, 80]"), "{error}");
    assert!(with("fc.weight", &[400, 80], 31_999).unwrap_err().contains("tensor `fc.weight`"));
    let error = with("fc2.weight", &[1], 1).unwrap_err();
    assert!(error.contains("fc2.weight"), "{error}");
    // PyTorch's counter of batches is no tensor of the network.
    assert_eq!(with("n.num_batches_tracked", &[], 1), Ok(()));
}
