//! Shapes that the builder infers, and networks that it refuses.

#![allow(clippy::unwrap_used, clippy::panic)]

use taxel_graph::{
    Activation, Conv, Fill, Flow, Graph, Init, Loss, Network, Op, Pool, Scheme, Targets, Weights,
};

fn graph(input: &[usize], body: impl Fn(&Network, &Flow) -> Flow) -> Result<Graph, String> {
    let net = Network::new("law");
    let y = body(&net, &net.input("x", input));
    net.finish(&[("y", y)]).map_err(|error| error.to_string())
}

fn shape_after(input: &[usize], body: impl Fn(&Flow) -> Flow) -> Vec<usize> {
    graph(input, |_, x| body(x)).unwrap().nodes().last().unwrap().shape.clone()
}

fn refusal(input: &[usize], body: impl Fn(&Flow) -> Flow) -> String {
    graph(input, |_, x| body(x)).unwrap_err()
}

#[test]
fn pools_round_down_or_up() {
    for (size, down, up) in [(50, 25, 25), (25, 12, 13), (13, 6, 7), (2, 1, 1), (3, 1, 2)] {
        assert_eq!(shape_after(&[3, size], |x| x.max_pool(Pool::new(2))), [3, down]);
        assert_eq!(shape_after(&[3, size], |x| x.max_pool(Pool::new(2).round_up())), [3, up]);
    }
    // A window that would start in the padding after the end is left out (PyTorch's rule).
    assert_eq!(shape_after(&[1, 4], |x| x.max_pool(Pool::new(2).stride(3).pad(1).round_up())), [1, 2]);
    assert_eq!(shape_after(&[1, 5], |x| x.max_pool(Pool::new(2).stride(6).pad(1).round_up())), [1, 1]);
    assert_eq!(shape_after(&[2, 8, 9], |x| x.average_pool(Pool::new(2).stride(3).round_up())), [2, 3, 3]);
}

/// `torch.nn.MaxPool1d(ceil_mode=True)`, by the formula of its documentation.
#[test]
fn pools_that_round_up_have_pytorchs_sizes() {
    for size in 1usize..14 {
        for (kernel, stride) in (1..6).flat_map(|kernel| (1..6).map(move |stride| (kernel, stride))) {
            for pad in (0..=kernel / 2).filter(|pad| size + 2 * pad >= kernel) {
                let mut want = (size + 2 * pad - kernel).div_ceil(stride) + 1;
                if (want - 1) * stride >= size + pad {
                    want -= 1;
                }
                let pool = || Pool::new(kernel).stride(stride).pad(pad).round_up();
                let case = format!("size {size}, kernel {kernel}, stride {stride}, padding {pad}");
                assert_eq!(shape_after(&[1, size], |x| x.max_pool(pool())), [1, want], "{case}");
            }
        }
    }
}

#[test]
fn what_rounding_up_hangs_over_is_not_counted() {
    let pooled = graph(&[1, 5], |_, x| x.average_pool(Pool::new(2).round_up())).unwrap();
    let Op::AveragePool { window, counted } = &pooled.nodes().last().unwrap().op else { panic!("no pool") };
    assert_ne!(window.padding, [(0, 0)]);
    assert_eq!(*counted, [(0, 0)]);
}

#[test]
fn same_padding_divides_by_the_stride_rounding_up() {
    for size in 1..20 {
        for kernel in 1..8 {
            for stride in 1..5 {
                let conv = || Conv::new(4, kernel).same().stride(stride);
                let shape = shape_after(&[2, size], |x| x.conv("c", conv()));
                assert_eq!(shape, [4, size.div_ceil(stride)], "{size} {kernel} {stride}");
            }
        }
    }
}

#[test]
fn operations_keep_or_change_shapes() {
    let image = [6, 4, 5];
    assert_eq!(shape_after(&image, |x| x.activation(Activation::HardSwish).dropout(0.5)), image);
    assert_eq!(shape_after(&image, |x| x.channel_shuffle(3).scale("k", 1.0)), image);
    assert_eq!(shape_after(&image, |x| x.slice(2, 3)), [3, 4, 5]);
    assert_eq!(shape_after(&image, |x| x.standardize("mean", "std").switch_scale(&x.slice(0, 1))), image);
    assert_eq!(shape_after(&image, |x| x.switch_scale(&x.slice(0, 1).adaptive_average_pool([1, 1]))), image);
    let (signal, stream) = ([6, 20], |x: &Flow| x.slice(0, 1).max_pool(Pool::new(2)));
    assert_eq!(shape_after(&signal, |x| x.switch_scale(&stream(x))), signal);
    assert_eq!(shape_after(&image, |x| x.slice(0, 2).concat(&x.slice(2, 4))), image);
    assert_eq!(shape_after(&image, |x| x.adaptive_average_pool(7)), [6, 7, 7]);
    assert_eq!(shape_after(&image, |x| x.adaptive_average_pool([2, 1])), [6, 2, 1]);
    assert_eq!(shape_after(&image, |x| x.global_standard_deviation(1e-5)), [6]);
    let dilated = || Conv::new(2, [3, 2]).dilation([1, 3]);
    assert_eq!(shape_after(&image, |x| x.conv("c", dilated())), [2, 2, 2]);
    assert_eq!(shape_after(&image, |x| x.conv("c", dilated().same())), [2, 4, 5]);
    assert_eq!(shape_after(&[5, 50], |x| x.lstm("lstm", 128)), [128]);
    assert_eq!(shape_after(&[5, 50], |x| x.gru("gru", 128)), [128]);
    assert_eq!(shape_after(&[5, 1, 1, 50], |x| x.gru("gru", 7)), [7]);
    assert_eq!(shape_after(&[7], |x| x.batch_norm("bn").linear_no_bias("fc", 3)), [3]);
    assert_eq!(shape_after(&[7], |x| x.layer_norm("ln")), [7]);
}

#[test]
fn windows_joins_and_layers_that_do_not_fit() {
    let same = |got: String, want: &str| assert_eq!(got, want);
    same(
        refusal(&[2, 4], |x| x.concat(&x.max_pool(Pool::new(2)))),
        "x/concat: cannot join channels 2 × length 4 and channels 2 × length 2 along channels",
    );
    same(
        refusal(&[2, 4], |x| x.add(&x.slice(0, 1))),
        "x/add: cannot add channels 2 × length 4 and channels 1 × length 4",
    );
    same(refusal(&[2, 4], |x| x.linear("fc", 3)), "fc: needs features, the input is channels 2 × length 4");
    same(refusal(&[2], |x| x.linear("fc", 0)), "fc: must have at least one output");
    same(
        refusal(&[3, 4], |x| x.conv("c", Conv::new(4, 1).groups(2))),
        "c: 2 groups must divide 3 input and 4 output channels",
    );
    same(
        refusal(&[3], |x| x.global_standard_deviation(1e-5)),
        "x/global_standard_deviation: needs a spatial axis, the input is features 3",
    );
    same(
        refusal(&[3, 4], |x| x.global_standard_deviation(0.0)),
        "x/global_standard_deviation: ε 0 must be above 0",
    );
    same(refusal(&[3, 4], |x| x.layer_norm("ln")), "ln: needs features, the input is channels 3 × length 4");
    same(refusal(&[3], |x| x.layer_norm_with("ln", -1.0)), "ln: ε -1 must be above 0");
    same(
        refusal(&[3, 4], |x| x.conv("c", Conv::new(4, 3).dilation(2))),
        "c: kernel 5 along length is larger than the padded size 4; the input is channels 3 × length 4",
    );
    same(
        refusal(&[3, 4], |x| x.conv("c", Conv::new(4, 3).dilation(0))),
        "c: kernel [3] must be at least 1, dilation [0] 1 to 16777216",
    );
    same(
        refusal(&[3, 4], |x| x.conv("c", Conv::new(4, 3).dilation([2, 2]))),
        "c: dilation [2, 2] has 2 axes, the input has 1 spatial axes",
    );
    same(
        refusal(&[3, 4], |x| x.conv("c", Conv::new(4, [1, 1]))),
        "c: kernel [1, 1] has 2 axes, the input has 1 spatial axes",
    );
    const MOST: usize = 1 << 24;
    assert_eq!(shape_after(&[3, 4], |x| x.conv("c", Conv::new(4, 3).stride(MOST))), [4, 1]);
    for conv in [|| Conv::new(4, 3).stride(MOST + 1), || Conv::new(4, MOST).dilation(2)] {
        same(
            refusal(&[3, 4], |x| x.conv("c", conv())),
            "c: kernel, stride and padding must be at most 16777216",
        );
    }
    same(
        refusal(&[3, 4], |x| x.max_pool(Pool::new(2).pad(2))),
        "x/max_pool: padding must be at most half of the kernel",
    );
    same(
        refusal(&[3, 2, 2, 9], |x| x.linear("fc", 3)),
        "fc: needs features, the input is channels 3 × rows 2 × columns 2 × frames 9",
    );
    same(refusal(&[3, 0], Flow::relu), "x: an input needs 1 to 4 axes of at least 1, got [3, 0]");
}

#[test]
fn operations_out_of_range_are_refused_with_axis_names() {
    let same = |got: String, want: &str| assert_eq!(got, want);
    same(refusal(&[4], |x| x.lstm("rnn", 3)), "rnn: needs channels × length, the input is features 4");
    same(refusal(&[4, 2], |x| x.lstm("rnn", 0)), "rnn: must have at least one hidden unit");
    same(refusal(&[4], |x| x.gru("rnn", 3)), "rnn: needs channels × length, the input is features 4");
    same(refusal(&[4, 2], |x| x.gru("rnn", 0)), "rnn: must have at least one hidden unit");
    for recurrent in [Flow::lstm, Flow::gru] {
        same(
            refusal(&[4, 1, 2, 3], |x| recurrent(x, "rnn", 3)),
            "rnn: reads the last axis step by step, so all axes between it and the channels must be 1; the input is \
             channels 4 × rows 1 × columns 2 × frames 3",
        );
    }
    same(
        refusal(&[4], |x| x.adaptive_average_pool(1)),
        "x/adaptive_average_pool: needs a spatial axis, the input is features 4",
    );
    same(
        refusal(&[4, 2], |x| x.adaptive_average_pool(0)),
        "x/adaptive_average_pool: output [0] must be at least 1",
    );
    same(
        refusal(&[4, 2, 2], |x| x.adaptive_average_pool([1])),
        "x/adaptive_average_pool: output [1] has 1 axes, the input has 2 spatial axes",
    );
    same(
        refusal(&[4, 2], |x| x.channel_shuffle(3)),
        "x/channel_shuffle: 3 groups must divide the channels; the input is channels 4 × length 2",
    );
    same(
        refusal(&[4, 2], |x| x.switch_scale(&x.flatten())),
        "x/switch_scale: the stream needs a spatial axis, it is features 8",
    );
    same(
        refusal(&[4, 2], |x| x.slice(3, 2)),
        "x/slice: cannot take 2 channels from channel 3 on; the input is channels 4 × length 2",
    );
    for probability in [1.0, -0.1, f32::NAN] {
        same(
            refusal(&[4, 2], |x| x.dropout(probability)),
            &format!("x/dropout: drop probability {probability} must be at least 0 and below 1"),
        );
    }
    for (eps, momentum) in [(0.0, 0.1), (f32::NAN, 0.1), (f32::INFINITY, 0.1), (0.1, 1.1), (0.1, f32::NAN)] {
        same(
            refusal(&[4, 2], |x| x.batch_norm_with("bn", eps, momentum)),
            &format!("bn: ε {eps} must be above 0 and momentum {momentum} in 0..=1"),
        );
    }
    same(
        refusal(&[4, 2], |x| x.activation(Activation::LeakyRelu { slope: f32::INFINITY })),
        "x/leaky_relu: slope inf must be finite",
    );
    assert!(refusal(&[4, 2], |x| x.slice(usize::MAX, 2)).starts_with("x/slice: cannot take"));
    assert!(refusal(&[4, 2], |x| x.slice(1, 0)).starts_with("x/slice: cannot take"));
    assert!(refusal(&[4, 2], |x| x.channel_shuffle(0)).starts_with("x/channel_shuffle: 0 groups"));
}

#[test]
fn a_grouped_convolution_sees_only_its_group() {
    let grouped =
        graph(&[8, 6, 6], |_, x| x.conv("c", Conv::new(12, [3, 2]).groups(4)).batch_norm("n")).unwrap();
    let weight = grouped.params().next().unwrap();
    // Two channels in and three filters out of a group, six values under each window.
    assert_eq!((weight.shape.as_slice(), weight.fan), (&[12, 2, 3, 2][..], Some((12, 18))));
    assert_eq!((grouped.parameter_count(), grouped.buffer_count()), (144 + 12 + 24, 24));
    for (filters, groups) in [(0, 1), (12, 0), (12, 3), (6, 4)] {
        let error = refusal(&[8, 6, 6], |x| x.conv("c", Conv::new(filters, 3).groups(groups)));
        let want = format!("c: {groups} groups must divide 8 input and {filters} output channels");
        assert_eq!(error, want);
    }
}

#[test]
fn targets_that_do_not_suit_the_loss_are_refused() {
    use Loss::{GaussianLikelihood, MeanSquaredError, Quantiles, SoftmaxCrossEntropy};
    let check = |loss, targets: Targets| targets.check("net", loss, 2, 3).map_err(|error| error.to_string());
    assert_eq!(check(SoftmaxCrossEntropy, Targets::Labels(&[0, 2])), Ok(()));
    assert_eq!(check(SoftmaxCrossEntropy, Targets::Values(&[0.5; 6])), Ok(()));
    assert_eq!(check(Quantiles, Targets::Values(&[0.5; 2])), Ok(()));
    for (loss, targets, want) in [
        (SoftmaxCrossEntropy, Targets::Labels(&[0]), "net: 1 labels for a batch of 2 samples"),
        (SoftmaxCrossEntropy, Targets::Labels(&[0, 3]), "net: label 3 of sample 1 is not one of 3 classes"),
        (SoftmaxCrossEntropy, Targets::Values(&[0.5; 5]), "net: 5 target values for 2 samples of 3 outputs"),
        (MeanSquaredError, Targets::Labels(&[0, 1]), "net: this loss needs target values, not labels"),
        (Quantiles, Targets::Values(&[0.5; 6]), "net: 6 target values for 2 samples of 3 outputs"),
        (GaussianLikelihood, Targets::Values(&[0.5; 2]), "net: 3 outputs; this loss takes 2 for each target"),
    ] {
        assert_eq!(check(loss, targets).unwrap_err(), want);
    }
}

#[test]
fn the_first_error_wins_and_names_its_scope() {
    let error = refusal(&[2, 4], |x| {
        let y = x.clone().within("block1").conv("a", Conv::new(3, 9));
        y.linear("b", 0).concat(x).flatten().slice(9, 9).lstm("c", 0)
    });
    assert_eq!(
        error,
        "block1.a: kernel 9 along length is larger than the padded size 4; the input is channels 2 × length 4"
    );
}

#[test]
fn two_nodes_of_one_name_are_refused() {
    let error = refusal(&[2, 4], |x| x.batch_norm("n").batch_norm("n"));
    assert_eq!(error, "n: two nodes carry this name");
    // Nodes without tensors are numbered.
    assert_eq!(shape_after(&[2, 4], |x| x.relu().add(&x.relu())), [2, 4]);
}

#[test]
fn lstm_and_scale_carry_the_names_of_their_checkpoints() {
    let graph = graph(&[5, 50], |_, x| x.scale("k1", 0.5).lstm("lstm", 128)).unwrap();
    let tensors: Vec<_> = graph.params().map(|p| (p.name.as_str(), p.shape.as_slice())).collect();
    let want: [(&str, &[usize]); 5] = [
        ("k1", &[1]),
        ("lstm.weight_ih_l0", &[512, 5]),
        ("lstm.weight_hh_l0", &[512, 128]),
        ("lstm.bias_ih_l0", &[512]),
        ("lstm.bias_hh_l0", &[512]),
    ];
    assert_eq!(tensors, want);
    assert_eq!(graph.cost().macs, 50 * 512 * (5 + 128));
    let bound = 1.0 / 128f32.sqrt();
    let weights = Weights::init(&graph, Scheme::Pytorch, 1, "init");
    assert_eq!(weights.get("k1").unwrap().data, [0.5]);
    for name in ["lstm.weight_ih_l0", "lstm.weight_hh_l0", "lstm.bias_ih_l0", "lstm.bias_hh_l0"] {
        let largest = weights.get(name).unwrap().data.iter().fold(0.0f32, |a, v| a.max(v.abs()));
        assert!((0.95 * bound..=bound).contains(&largest), "{name}: {largest} of {bound}");
    }
}

#[test]
fn a_gru_has_three_gates_and_the_names_of_pytorch() {
    let graph = graph(&[5, 50], |_, x| x.gru("gru", 128)).unwrap();
    let tensors: Vec<_> = graph.params().map(|p| (p.name.as_str(), p.shape.as_slice())).collect();
    let want: [(&str, &[usize]); 4] = [
        ("gru.weight_ih_l0", &[384, 5]),
        ("gru.weight_hh_l0", &[384, 128]),
        ("gru.bias_ih_l0", &[384]),
        ("gru.bias_hh_l0", &[384]),
    ];
    assert_eq!(tensors, want);
    assert_eq!(graph.cost().macs, 50 * 384 * (5 + 128));
}

#[test]
fn networks_choose_how_their_layers_are_drawn() {
    let init_of = |conv: (Fill, Fill), linear: (Fill, Fill)| -> Vec<Init> {
        let graph = graph(&[8, 6, 6], |net, x| {
            net.conv_init(conv.0, conv.1);
            net.linear_init(linear.0, linear.1);
            x.conv("c", Conv::new(16, 3).groups(8)).global_average_pool().linear("fc", 10)
        });
        graph.unwrap().params().map(|p| p.init).collect()
    };
    let zero = Fill::Constant(0.0);
    // torch.nn.init leaves groups out of sight: a weight 16×1×3×3 has 1·9 in and 16·9 out.
    assert_eq!(
        init_of((Fill::KaimingNormalFanOut, zero), (Fill::Normal { sd: 0.01 }, zero)),
        [
            Init::Normal { sd: (2.0f32 / 144.0).sqrt() },
            Init::Constant(0.0),
            Init::Normal { sd: 0.01 },
            Init::Constant(0.0),
        ]
    );
    assert_eq!(
        init_of((Fill::KaimingNormalFanIn, Fill::Pytorch), (Fill::KaimingUniformFanOut, zero)),
        [
            Init::Normal { sd: (2.0f32 / 9.0).sqrt() },
            Init::Uniform { bound: 1.0 / 3.0 },
            Init::Uniform { bound: (3.0f32 / 10.0).sqrt() },
            Init::Constant(0.0),
        ]
    );
    let drawn = |sd| {
        graph(&[2], |net, x| {
            net.linear_init(Fill::Normal { sd }, Fill::Pytorch);
            x.linear("fc", 2)
        })
    };
    assert_eq!(drawn(-1.0).unwrap_err(), "fc.weight: standard deviation -1 must be at least 0");
    assert_eq!(drawn(f32::INFINITY).unwrap_err(), "fc.weight: standard deviation inf must be finite");
    assert!(drawn(0.0).unwrap().params().all(|param| !param.is_empty()));
}

#[test]
fn batch_norm_keeps_the_values_it_is_given() {
    let graph = graph(&[2, 3], |_, x| x.batch_norm_with("a", 1e-3, 3e-4).batch_norm("b")).unwrap();
    let ops: Vec<String> = graph.nodes().iter().skip(1).map(|n| format!("{:?}", n.op)).collect();
    assert_eq!(ops, ["BatchNorm { eps: 0.001, momentum: 0.0003 }", "BatchNorm { eps: 1e-5, momentum: 0.1 }"]);
}

#[test]
fn a_network_is_checked_as_it_grows_and_described_from_any_thread() {
    let net = Network::new("shared");
    let x = net.input("signal", &[5, 50]).conv("stem", Conv::new(8, 3));
    assert!(net.check().is_ok());
    let head =
        std::thread::scope(|scope| scope.spawn(|| x.global_average_pool().linear("fc", 3)).join().unwrap());
    let graph = net.clone().finish(&[("logits", head)]).unwrap();
    assert_eq!(graph.nodes().len(), 4);
    x.conv("deep", Conv::new(8, 60));
    let error = net.check().unwrap_err().to_string();
    assert!(error.starts_with("deep: kernel 60"), "{error}");
    assert_eq!(net.finish(&[("logits", x)]).unwrap_err().to_string(), error);
}

#[test]
fn threads_that_describe_one_network_give_no_name_twice() {
    let net = Network::new("shared");
    let x = net.input("signal", &[5]);
    let start = std::sync::Barrier::new(2);
    let grow = || {
        for _ in 0..300 {
            start.wait();
            x.relu();
        }
    };
    std::thread::scope(|scope| (0..2).for_each(|_| drop(scope.spawn(grow))));
    let graph = net.finish(&[("y", x)]).unwrap();
    assert_eq!(graph.nodes().len(), 601);
}
