//! A graph as a file: it comes back equal, and what is wrong with a file is named.

#![allow(clippy::unwrap_used, clippy::panic)]

use proptest::prelude::*;
use serde_json::{Value, json};
use taxel_graph::{Activation, Conv, Fill, Graph, Network, Pool};

/// Every operation, odd attributes, two outputs.
fn every() -> Graph {
    let net = Network::new("every");
    net.conv_init(Fill::KaimingNormalFanOut, Fill::Constant(0.1));
    let x = net.input("image", &[4, 9, 7]).within("body").standardize("mean", "std");
    let conv = Conv::new(6, [3, 2]).same().stride([2, 1]).groups(2).no_bias();
    let mut y = x.conv("conv", conv).batch_norm_with("bn", 1e-3, 3e-4).relu();
    for activation in [
        Activation::Relu6,
        Activation::LeakyRelu { slope: 0.01 },
        Activation::Sigmoid,
        Activation::Tanh,
        Activation::HardSwish,
    ] {
        y = y.activation(activation);
    }
    y = y.dropout(0.3).channel_shuffle(3).scale("k", 0.7).slice(1, 4).switch_scale(&x);
    let pooled = y.max_pool(Pool::new(2).round_up()).average_pool(Pool::new(3).stride(1).pad(1));
    let left = y.average_pool(Pool::new(3).stride(2).pad(1).round_up().ignore_padding());
    let right = pooled.concat(&left.adaptive_average_pool([3, 4]));
    let a = right.add(&right).flatten().layer_norm_with("ln", 1e-4).linear_no_bias("fc", 3);
    let signal = net.input("signal", &[2, 11]);
    let b = signal.lstm("rnn", 5).concat(&signal.gru("gru", 4)).linear("fc2", 3);
    let dilated = y.conv("dilated", Conv::new(4, 2).dilation([1, 2]));
    let c = y.global_average_pool().concat(&dilated.global_standard_deviation(1e-4));
    net.finish_weighted(&[("a", a), ("b", b), ("c", c)], &[1.0, 0.3, -2.5]).unwrap()
}

fn tiny() -> Value {
    let net = Network::new("tiny");
    let x = net.input("signal", &[5, 50]).conv("conv", Conv::new(8, 3).pad(1).no_bias());
    let pool = Pool::new(3).stride(1).pad(1);
    let x = x.average_pool(pool).lstm("rnn", 4).linear("fc", 3).dropout(0.5);
    serde_json::to_value(net.finish(&[("logits", x)]).unwrap()).unwrap()
}

fn read(json: &Value) -> Result<Graph, String> {
    serde_json::from_value(json.clone()).map_err(|error| error.to_string())
}

#[test]
fn every_operation_comes_back_equal() {
    let graph = every();
    let text = serde_json::to_string(&graph).unwrap();
    assert_eq!(serde_json::from_str::<Graph>(&text).unwrap(), graph);
    let value = serde_json::to_value(&graph).unwrap();
    assert_eq!(read(&value).unwrap(), graph);
    // Also through numbers of 64 bits.
    assert_eq!(serde_json::from_str::<Graph>(&value.to_string()).unwrap(), graph);
}

#[test]
fn operations_are_tagged_with_their_kind() {
    let graph = every();
    let value = serde_json::to_value(&graph).unwrap();
    let tag = |op: &Value| match op {
        Value::String(tag) => tag.clone(),
        Value::Object(map) => map.keys().next().unwrap().clone(),
        other => panic!("{other}"),
    };
    for (node, json) in graph.nodes().iter().zip(value["nodes"].as_array().unwrap()) {
        let op = &json["op"];
        let tag = op.get("activation").map_or_else(|| tag(op), tag);
        assert_eq!(tag, node.op.kind(), "{}", node.name);
    }
}

#[test]
fn the_format_is_the_documented_one() {
    let documented = include_str!("../src/serial.rs");
    let block = documented.split("//! ```").nth(1).unwrap();
    let json = block.trim_start_matches("json").replace("//!", "");
    let net = Network::new("tiny");
    let x = net.input("signal", &[5, 50]).conv("conv", Conv::new(8, 3).pad(1).no_bias());
    let graph = net.finish(&[("features", x.global_average_pool())]).unwrap();
    assert_eq!(serde_json::to_string(&graph).unwrap(), json.split_whitespace().collect::<String>());
}

#[test]
fn what_is_wrong_with_a_file_is_named() {
    for (path, value, words) in [
        ("/nodes/0/shape/0", json!(6), "conv: states the parameter `conv.weight` [8, 5, 3]"),
        ("/nodes/0/shape", json!([]), "signal: an input needs 1 to 4 axes of at least 1, got []"),
        ("/nodes/0/shape/1", json!(u64::MAX), "signal: an input of channels 5 × length 18446744073709551615"),
        ("/nodes/0/inputs", json!([0]), "signal: input 0 is none of the 0 nodes before it"),
        ("/nodes/0/op", json!("relu"), "signal: reads one input, got 0"),
        (
            "/nodes/1/op",
            json!("relu"),
            "conv: states the shape channels 8 × length 50, `relu` makes channels 5",
        ),
        ("/nodes/1/op", json!("input"), "conv: an input is given, not computed"),
        ("/nodes/1/op", json!("add"), "conv: reads two inputs, got 1"),
        ("/nodes/1/op", json!("conf"), "the node after `signal`: unknown variant `conf`"),
        ("/nodes/1/inputs", json!([0, 0]), "conv: reads one input, got 2"),
        ("/nodes/1/inputs/0", json!(1), "conv: input 1 is none of the 1 nodes before it"),
        ("/nodes/1/inputs/0", json!(-1), "the node after `signal`: invalid value: integer `-1`"),
        ("/nodes/1/inputs/0", json!(u64::MAX), "conv: input 18446744073709551615 is none of the 1 nodes"),
        ("/nodes/1/name", json!("signal"), "signal: states the parameter"),
        ("/nodes/1/shape/1", json!(49), "conv: states the shape channels 8 × length 49, `conv` makes"),
        ("/nodes/1/op/conv/groups", json!(2), "conv: 2 groups must divide 5 input and 8 output channels"),
        ("/nodes/1/op/conv/groups", json!(0), "conv: 0 groups must divide"),
        ("/nodes/1/op/conv/bias", json!(true), "conv: states 1 tensors, `conv` has 2"),
        ("/nodes/1/op/conv/out_channels", json!(u64::MAX), "conv: a weight of channels 18446744073709551615"),
        (
            "/nodes/1/op/conv/window/kernel_size/0",
            json!(0),
            "conv: kernel [0] and stride [1] must be at least 1",
        ),
        (
            "/nodes/1/op/conv/window/kernel_size",
            json!([]),
            "conv: kernel [] has 0 axes, the input has 1 spatial",
        ),
        (
            "/nodes/1/op/conv/window/kernel_size/0",
            json!(99),
            "conv: kernel 99 along length is larger than the padded",
        ),
        ("/nodes/1/op/conv/window/stride/0", json!(0), "conv: kernel [3] and stride [0] must be at least 1"),
        (
            "/nodes/1/op/conv/window/padding/0/1",
            json!(u64::MAX),
            "conv: kernel, stride and padding must be at most 16777216",
        ),
        ("/nodes/1/op/conv/window/padding", json!([]), "conv: padding [] has 0 axes"),
        (
            "/nodes/1/params/0/name",
            json!("c.weight"),
            "conv: states the parameter `c.weight` [8, 5, 3], `conv` has",
        ),
        (
            "/nodes/1/params/0/kind",
            json!("buffer"),
            "conv: states the buffer `conv.weight` [8, 5, 3], `conv` has",
        ),
        ("/nodes/1/params/0/init/uniform/bound", json!(-1), "conv.weight: bound -1 must be in 0..=1.7"),
        ("/nodes/1/params/0/init/uniform/bound", json!(3e38), "conv.weight: bound 300000000"),
        ("/nodes/1/params/0/init", json!({"constant": 1e40}), "conv.weight: value inf must be finite"),
        ("/nodes", json!(3), "invalid type: integer `3`, expected a list of nodes"),
        ("/nodes/1/params", json!([]), "conv: states 0 tensors, `conv` has 1"),
        (
            "/nodes/2/op/average_pool/window/padding/0/0",
            json!(2),
            "conv/average_pool: padding must be at most half",
        ),
        (
            "/nodes/2/op/average_pool/window/padding/0/1",
            json!(9),
            "conv/average_pool: the last window starts after",
        ),
        (
            "/nodes/2/op/average_pool/window",
            json!({"kernel_size": [3], "stride": [3], "padding": [[1, 4]]}),
            "conv/average_pool: the last window starts after",
        ),
        (
            "/nodes/2/op/average_pool/counted/0/1",
            json!(2),
            "conv/average_pool: counts padding [(1, 2)] of [(1, 1)]",
        ),
        ("/nodes/2/op/average_pool/counted", json!([]), "conv/average_pool: counted padding [] has 0 axes"),
        ("/nodes/3/op/lstm/steps", json!(51), "rnn: 51 steps, the input is channels 8 × length 50"),
        (
            "/nodes/3/op/lstm/hidden_size",
            json!(1u64 << 62),
            "rnn: a weight of channels 4 × rows 4611686018427387904",
        ),
        (
            "/nodes/5/op/dropout/p",
            json!(1.0),
            "fc/dropout: drop probability 1 must be at least 0 and below 1",
        ),
        ("/nodes/5/op/dropout", json!({"p": 0.5, "q": 1}), "the node after `fc`: unknown field `q`"),
        ("/nodes/5/op/dropout/p", json!("much"), "the node after `fc`: invalid type: string \"much\""),
        ("/outputs/0/node", json!(6), "tiny: output `logits` is node 6 of 6"),
        ("/outputs/0/loss_weight", json!(1e39), "tiny: loss weight inf of output `logits` must be finite"),
        ("/outputs", json!([]), "tiny: needs at least one output"),
        ("/nodes", json!([]), "tiny: output `logits` is node 5 of 0"),
    ] {
        let mut json = tiny();
        let (parent, key) = path.rsplit_once('/').unwrap();
        match json.pointer_mut(parent).unwrap() {
            Value::Array(list) => list[key.parse::<usize>().unwrap()] = value.clone(),
            object => object[key] = value.clone(),
        }
        let refusal = read(&json).expect_err(path);
        assert!(refusal.starts_with(words), "{path} = {value}: {refusal}");
    }
}

#[test]
fn names_that_come_twice_are_refused() {
    let mut json = tiny();
    json["nodes"][5]["name"] = json!("conv/average_pool");
    assert_eq!(read(&json).unwrap_err(), "conv/average_pool: two nodes carry this name");
    let mut json = tiny();
    let again = json["outputs"][0].clone();
    json["outputs"].as_array_mut().unwrap().push(again);
    assert_eq!(read(&json).unwrap_err(), "tiny: two outputs are called `logits`");
    let net = Network::new("twice");
    let x = net.input("x", &[2, 3]).conv("a", Conv::new(2, 1)).scale("a.weight", 1.0);
    let refusal = net.finish(&[("y", x)]).unwrap_err().to_string();
    assert_eq!(refusal, "a.weight: two tensors carry this name");
}

#[test]
fn what_the_builder_could_not_write_it_refuses() {
    let net = Network::new("numbers");
    let x = net.input("x", &[2]).scale("k", f32::NAN);
    assert_eq!(net.finish(&[("y", x)]).unwrap_err().to_string(), "k: value NaN must be finite");
    let net = Network::new("numbers");
    let x = net.input("x", &[2]);
    let refusal = net.finish_weighted(&[("y", x)], &[f32::INFINITY]).unwrap_err().to_string();
    assert_eq!(refusal, "numbers: loss weight inf of output `y` must be finite");
    let net = Network::new("numbers");
    let x = net.input("x", &[65_536, 65_536]);
    let refusal = net.finish(&[("y", x)]).unwrap_err().to_string();
    assert_eq!(refusal, "x: an input of channels 65536 × length 65536 has more than 2147483648 values");
}

/// Every place in a JSON value, by pointer.
fn places(json: &Value, at: String, found: &mut Vec<String>) {
    let children: Vec<(String, &Value)> = match json {
        Value::Object(map) => map.iter().map(|(key, value)| (key.clone(), value)).collect(),
        Value::Array(list) => list.iter().enumerate().map(|(i, value)| (i.to_string(), value)).collect(),
        _ => vec![],
    };
    for (key, value) in children {
        let at = format!("{at}/{}", key.replace('~', "~0").replace('/', "~1"));
        found.push(at.clone());
        places(value, at, found);
    }
}

fn anything() -> impl Strategy<Value = Value> {
    let number = prop_oneof![0u64..12, Just(u64::MAX), Just(1 << 31), Just(1 << 62), any::<u64>()];
    prop_oneof![
        number.clone().prop_map(Value::from),
        any::<f64>().prop_map(Value::from),
        Just(json!(null)),
        Just(json!(-1)),
        Just(json!("relu")),
        Just(json!("add")),
        Just(json!("concat")),
        prop::collection::vec(number, 0..4).prop_map(Value::from),
        Just(json!({})),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Whatever is read is what was written there, and never a panic.
    #[test]
    fn no_file_panics_and_none_is_read_as_another(place in any::<prop::sample::Index>(), value in anything()) {
        let mut json = serde_json::to_value(every()).unwrap();
        let mut all = vec![];
        places(&json, String::new(), &mut all);
        *json.pointer_mut(&all[place.index(all.len())]).unwrap() = value;
        if let Ok(graph) = read(&json) {
            let written = serde_json::to_value(&graph).unwrap();
            prop_assert_eq!(read(&written).unwrap(), graph.clone());
            prop_assert!(graph.cost().bytes() > 0);
        }
    }
}
