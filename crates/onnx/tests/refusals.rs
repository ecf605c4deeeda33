//! Networks that taxel cannot express are refused by node and operation, and no file takes more memory than it is worth.
#![allow(clippy::unwrap_used)]

use std::fs;

use taxel_onnx::{Imported, from_bytes, read};

/// A protobuf field with content of its own length.
fn field(number: u64, content: &[u8]) -> Vec<u8> {
    [&varint(number << 3 | 2), &varint(content.len() as u64), content].concat()
}

/// A protobuf field with a number.
fn number(at: u64, value: u64) -> Vec<u8> {
    [varint(at << 3), varint(value)].concat()
}

fn varint(mut value: u64) -> Vec<u8> {
    let mut bytes = vec![];
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
    bytes
}

/// A value `name` of samples of `shape`.
fn port(name: &str, kind: u64, shape: &[u64]) -> Vec<u8> {
    let dims = shape.iter().map(|&size| field(1, &number(1, size)));
    let dims: Vec<u8> = std::iter::once(field(1, &field(2, b"batch"))).chain(dims).flatten().collect();
    let tensor = [number(1, kind), field(2, &dims)].concat();
    [field(1, name.as_bytes()), field(2, &field(1, &tensor))].concat()
}

fn node(name: &str, op: &str, inputs: &[&str], outputs: &[&str], attributes: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes: Vec<u8> = inputs.iter().flat_map(|input| field(1, input.as_bytes())).collect();
    bytes.extend(outputs.iter().flat_map(|output| field(2, output.as_bytes())));
    bytes.extend([field(3, name.as_bytes()), field(4, op.as_bytes())].concat());
    bytes.extend(attributes.iter().flat_map(|attribute| field(5, attribute)));
    field(1, &bytes)
}

fn int(name: &str, value: u64) -> Vec<u8> {
    [field(1, name.as_bytes()), number(3, value), number(20, 2)].concat()
}

fn ints(name: &str, values: &[u64]) -> Vec<u8> {
    let values: Vec<u8> = values.iter().flat_map(|&value| number(8, value)).collect();
    [field(1, name.as_bytes()), values, number(20, 7)].concat()
}

/// A stored tensor with raw values.
fn tensor(name: &str, kind: u64, shape: &[u64], raw: &[u8]) -> Vec<u8> {
    let dims: Vec<u8> = shape.iter().flat_map(|&size| number(1, size)).collect();
    field(5, &[dims, number(2, kind), field(8, name.as_bytes()), field(9, raw)].concat())
}

fn floats(name: &str, shape: &[u64]) -> Vec<u8> {
    tensor(name, 1, shape, &vec![0; 4 * shape.iter().product::<u64>() as usize])
}

/// A model whose input `x` is 3 channels of length 8, and whose output is `y`.
fn model(parts: &[Vec<u8>]) -> Vec<u8> {
    whole(17, &port("x", 1, &[3, 8]), parts)
}

fn whole(opset: u64, input: &[u8], parts: &[Vec<u8>]) -> Vec<u8> {
    let mut graph = parts.concat();
    graph.extend(field(11, input));
    graph.extend(field(12, &port("y", 1, &[2])));
    [number(1, 8), field(7, &graph), field(8, &number(2, opset))].concat()
}

fn refused(bytes: Vec<u8>) -> String {
    from_bytes(bytes, "own", None).unwrap_err().to_string()
}

fn accepted(parts: &[Vec<u8>]) -> Imported {
    from_bytes(model(parts), "own", None).unwrap()
}

#[test]
fn the_hand_written_model_is_sound() {
    let read = accepted(&[
        node("mean", "GlobalAveragePool", &["x"], &["m"], &[]),
        node("flat", "Flatten", &["m"], &["f"], &[]),
        node("fc", "Gemm", &["f", "w"], &["y"], &[int("transB", 1)]),
        floats("w", &[2, 3]),
    ]);
    assert_eq!(read.graph.nodes().len(), 3);
    assert_eq!(read.notes, ["input `x` is called `signal`"]);
}

#[test]
fn an_operation_that_taxel_lacks_is_named_with_its_node() {
    let lone = |op: &str, attributes: &[Vec<u8>]| {
        refused(model(&[node("mine", op, &["x", "w"], &["y"], attributes), floats("w", &[4, 3, 3])]))
    };
    for (op, attributes, reason) in [
        ("Einsum", vec![], "taxel has no such operation; it reads Add, AveragePool"),
        ("QuantizeLinear", vec![], "export it before it is quantised"),
        ("ConvTranspose", vec![], "no such operation"),
        ("Conv", vec![int("group", 3)], "in 3 groups does not fit an input of channels 3 × length 8"),
        ("Conv", vec![ints("pads", &[1])], "`pads` has to be 2 numbers"),
        ("Conv", vec![ints("strides", &[0])], "stride [0] must be at least 1"),
        ("Gemm", vec![], "taxel's linear layers read features, flatten them first"),
        ("Mul", vec![], "is not one number per channel"),
        ("ReduceMean", vec![ints("axes", &[1])], "reduces the axes [1]; taxel reduces all of space"),
        ("Transpose", vec![ints("perm", &[0, 0, 1])], "is no order of 3 axes"),
        ("Softmax", vec![], "taxel knows a softmax over classes, at the end, alone"),
    ] {
        let text = lone(op, &attributes);
        assert!(text.starts_with(&format!("node `mine` ({op}): ")) && text.contains(reason), "{op}: {text}");
    }
    let foreign = node("mine", "Gelu", &["x"], &["y"], &[]);
    let foreign = field(1, &[foreign[2..].to_vec(), field(7, b"com.microsoft")].concat());
    assert!(refused(model(&[foreign])).contains("of the domain \"com.microsoft\""));
    let all = refused(model(&[node("mine", "ReduceMean", &["x"], &["y"], &[])]));
    assert!(all.starts_with("node `mine` (ReduceMean): reduces all axes, samples among them"), "{all}");
    let unknown = refused(model(&[node("", "Relu", &["z"], &["y"], &[])]));
    assert!(unknown.starts_with("node `y` (Relu): reads `z`, which no node before it gives"), "{unknown}");
    let turned = [
        node("turn", "Transpose", &["x"], &["t"], &[ints("perm", &[0, 2, 1])]),
        node("conv", "Conv", &["t", "w"], &["y"], &[]),
        floats("w", &[4, 8, 1]),
    ];
    assert!(
        refused(model(&turned))
            .contains("node `conv` (Conv): reads axes that are not samples, channels and space")
    );
}

#[test]
fn a_gru_of_another_kind_is_refused() {
    let refusal = |sequence: &str, attributes: &[Vec<u8>], hidden: u64| {
        let steps = ints("perm", &[2, 0, 1]);
        refused(model(&[
            node("turn", "Transpose", &["x"], &["t"], &[steps]),
            node("mine", "GRU", &[sequence, "w", "r"], &["y"], attributes),
            floats("w", &[1, 3 * hidden, 3]),
            floats("r", &[1, 3 * hidden, 4]),
        ]))
    };
    let after = || int("linear_before_reset", 1);
    for (text, reason) in [
        (refusal("t", &[], 4), "resets the hidden state before its product (linear_before_reset = 0)"),
        (refusal("x", &[after()], 4), "x.transpose(1, 2) before the GRU"),
        (refusal("t", &[after()], 5), "its weights [1, 15, 3] and [1, 15, 4] do not fit 3 channels"),
    ] {
        assert!(text.starts_with("node `mine` (GRU): ") && text.contains(reason), "{text}");
    }
}

#[test]
fn an_axis_of_one_value_may_go_before_a_recurrent_layer_alone() {
    let image = [
        node("thin", "Unsqueeze", &["x", "axes"], &["i"], &[]),
        tensor("axes", 7, &[1], &2u64.to_le_bytes()),
        node("conv", "Conv", &["i", "w"], &["c"], &[]),
        floats("w", &[4, 3, 1, 1]),
        node("drop", "Squeeze", &["c", "axes"], &["s"], &[]),
        node("norm", "Conv", &["s", "v"], &["y"], &[]),
        floats("v", &[2, 4, 1]),
    ];
    let text = refused(model(&image));
    assert!(text.starts_with("node `"), "{text}");
}

#[test]
fn inputs_outputs_and_versions_are_refused_by_name() {
    let relu = || vec![node("r", "Relu", &["x"], &["y"], &[])];
    let with = |kind, shape: &[u64]| refused(whole(17, &port("x", kind, shape), &relu()));
    assert!(with(7, &[3, 8]).contains("input `x`: is int64"), "{}", with(7, &[3, 8]));
    assert!(with(1, &[]).contains("input `x`: has 0 axes after the samples"));
    assert!(with(1, &[1; 5]).contains("has 5 axes after the samples"));
    let open = [
        field(1, b"x"),
        field(2, &field(1, &[number(1, 1), field(2, &[field(1, &[]), field(1, &[])].concat())].concat())),
    ]
    .concat();
    assert!(refused(whole(17, &open, &relu())).contains("export the network for the shape of your samples"));
    assert!(refused(whole(3, &port("x", 1, &[3, 8]), &relu())).contains("opset 3; taxel reads 7 to"));
    assert!(refused(model(&[])).contains("output `y`: is given by no node"));
    assert!(refused(vec![]).contains("no ONNX model: it holds no graph"));
    assert!(refused(b"PK\x03\x04 this is something else".to_vec()).contains("no ONNX model"));
    assert!(refused(model(&relu())[..40].to_vec()).contains("longer than the file"));
}

#[test]
fn stored_tensors_fill_their_shapes() {
    let with = |w: Vec<u8>| refused(model(&[node("c", "Conv", &["x", "w"], &["y"], &[]), w]));
    let short = with(tensor("w", 1, &[4, 3, 3], &[0; 8]));
    assert!(short.contains("tensor `w`: holds 8 bytes, its shape [4, 3, 3] takes 144"), "{short}");
    assert!(with(tensor("w", 3, &[4, 3, 3], &[0; 36])).contains("tensor `w`: is int8; taxel reads float32"));
    assert!(with(tensor("w", 1, &[1 << 40, 1 << 40, 3], &[])).contains("tensor `w`: has the shape"));
    assert!(with(tensor("w", 1, &[u64::MAX, 3, 3], &[])).contains("tensor `w`: has the shape [-1, 3, 3]"));
    let huge = with(tensor("w", 1, &[1 << 20, 3, 1 << 10], &[]));
    assert!(huge.contains("more memory than the file is worth"), "{huge}");
}

/// A convolution whose weight lies in another file.
fn outside(location: &str, offset: &str) -> Vec<u8> {
    let entry =
        |key: &str, value: &str| field(13, &[field(1, key.as_bytes()), field(2, value.as_bytes())].concat());
    let dims: Vec<u8> = [4, 3, 3].iter().flat_map(|&size| number(1, size)).collect();
    let place = [entry("location", location), entry("offset", offset), number(14, 1)].concat();
    let weight = field(5, &[dims, number(2, 1), field(8, b"w"), place].concat());
    model(&[
        node("c", "Conv", &["x", "w"], &["c"], &[]),
        node("m", "ReduceMean", &["c"], &["y"], &[ints("axes", &[2]), int("keepdims", 0)]),
        weight,
    ])
}

#[test]
fn values_beside_the_model_are_read_from_its_own_folder_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.onnx");
    fs::write(folder.path().join("own.data"), [0; 150]).unwrap();
    let read_with = |location: &str, offset: &str| {
        fs::write(&path, outside(location, offset)).unwrap();
        read(&path)
    };
    assert_eq!(read_with("own.data", "6").unwrap().graph.parameter_count(), 36);
    for (location, offset, reason) in [
        ("own.data", "7", "ends after byte 150"),
        ("own.data", "18446744073709551615", "ends after byte 150"),
        ("own.data", "-1", "has the offset \"-1\""),
        ("gone.data", "0", "keep that file beside the model"),
        ("../own.data", "0", "is not below the model's folder"),
        ("/etc/passwd", "0", "is not below the model's folder"),
        ("", "0", "is not below the model's folder"),
    ] {
        let text = read_with(location, offset).unwrap_err().to_string();
        assert!(
            text.contains("own.onnx: tensor `w`") && text.contains(reason),
            "{location} {offset}: {text}"
        );
    }
    assert!(refused(outside("own.data", "0")).contains("read the model from its file"));
}

#[test]
fn messages_without_content_take_no_memory() {
    let graph: Vec<u8> = field(1, &[]).repeat(2_000_000);
    let text = refused([field(7, &graph), field(8, &number(2, 17))].concat());
    assert!(text.contains("more memory than any network needs"), "{text}");
}

/// Names are made of names: a long chain must not become as long as its square.
#[test]
fn a_chain_without_end_ends() {
    let chain = |length: usize| {
        let relu = |at: usize| node("", "Relu", &[&format!("v{at}")], &[&format!("v{}", at + 1)], &[]);
        let mut parts = vec![node("", "Relu", &["x"], &["v0"], &[])];
        parts.extend((0..length).map(relu));
        let last = format!("v{length}");
        parts.push(node("", "ReduceMean", &[&last], &["y"], &[ints("axes", &[2]), int("keepdims", 0)]));
        model(&parts)
    };
    let read = from_bytes(chain(2_000), "own", None).unwrap();
    assert!(read.graph.nodes().iter().all(|node| node.name.len() < 250));
    let text = refused(chain(30_000));
    assert!(text.contains("is one of more than 20000 nodes"), "{text}");
}

#[test]
fn a_tensor_that_many_nodes_share_is_not_copied_without_end() {
    let mut parts = vec![
        floats("w", &[512, 512, 1]),
        node("first", "Conv", &["x", "a"], &["v0"], &[]),
        floats("a", &[512, 3, 1]),
    ];
    for at in 0..64 {
        parts.push(node("", "Conv", &[&format!("v{at}"), "w"], &[&format!("v{}", at + 1)], &[]));
    }
    assert!(refused(model(&parts)).contains("is read so often"));
}

#[test]
fn constants_per_channel_are_a_z_score_a_bias_or_a_scale() {
    let kinds = |parts: &[Vec<u8>]| -> Vec<&'static str> {
        let mean = node("m", "ReduceMean", &["last"], &["y"], &[ints("axes", &[2]), int("keepdims", 0)]);
        let read = accepted(&[parts, &[mean]].concat());
        read.graph.nodes()[1..].iter().map(|node| node.op.kind()).collect()
    };
    let ones = |name: &str, shape: &[u64]| {
        tensor(name, 1, shape, &1.0f32.to_le_bytes().repeat(shape.iter().product::<u64>() as usize))
    };
    let z_score = [
        node("", "Sub", &["x", "mean"], &["c"], &[]),
        node("", "Div", &["c", "sd"], &["last"], &[]),
        ones("mean", &[3, 1]),
        ones("sd", &[1, 3, 1]),
    ];
    assert_eq!(kinds(&z_score), ["standardize", "global_average_pool"]);
    let biased = [
        node("", "Conv", &["x", "w"], &["c"], &[]),
        node("", "Add", &["b", "c"], &["last"], &[]),
        floats("w", &[4, 3, 1]),
        ones("b", &[4, 1]),
    ];
    assert_eq!(kinds(&biased), ["conv", "global_average_pool"]);
    let scaled = [node("", "Mul", &["x", "gain"], &["last"], &[]), ones("gain", &[])];
    assert_eq!(kinds(&scaled), ["scale", "global_average_pool"]);
}

#[test]
fn dropout_in_training_is_refused_and_switched_off_is_read() {
    let dropout = |mode: &[u8]| {
        model(&[
            node("drop", "Dropout", &["x", "ratio", "mode"], &["d"], &[]),
            tensor("ratio", 1, &[], &0.5f32.to_le_bytes()),
            tensor("mode", 9, &[], mode),
            node("m", "ReduceMean", &["d"], &["y"], &[ints("axes", &[2]), int("keepdims", 0)]),
        ])
    };
    let text = refused(dropout(&[1]));
    assert!(text.starts_with("node `drop` (Dropout): drops values in use too (training_mode)"), "{text}");
    assert!(from_bytes(dropout(&[0]), "own", None).is_ok());
}

#[test]
fn values_that_no_training_gives_are_refused_by_tensor() {
    let raw = |values: &[f32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let norm = |variance: f32, bias: f32| {
        let three = |name: &str, values: &[f32]| tensor(name, 1, &[3], &raw(values));
        model(&[
            node(
                "bn",
                "BatchNormalization",
                &["x", "bn.weight", "bn.bias", "bn.running_mean", "bn.running_var"],
                &["b"],
                &[],
            ),
            three("bn.weight", &[1.0; 3]),
            three("bn.bias", &[0.0, bias, 0.0]),
            three("bn.running_mean", &[-1.0; 3]),
            three("bn.running_var", &[1.0, 1.0, variance]),
            node("m", "ReduceMean", &["b"], &["y"], &[ints("axes", &[2]), int("keepdims", 0)]),
        ])
    };
    assert!(from_bytes(norm(1.0, 0.0), "own", None).is_ok());
    for (variance, bias, reason) in [
        (-0.5, 0.0, "tensor `bn.running_var` is -0.5 at [2], a variance below 0"),
        (1.0, f32::NAN, "tensor `bn.bias` is NaN at [1]"),
        (f32::INFINITY, 0.0, "tensor `bn.running_var` is inf at [2]"),
    ] {
        let text = refused(norm(variance, bias));
        assert!(text.contains(reason), "{text}");
    }
}

#[cfg(unix)]
#[test]
fn a_link_out_of_the_models_folder_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (inside, beside) = (folder.path().join("model"), folder.path().join("own.data"));
    fs::create_dir(&inside).unwrap();
    fs::write(&beside, [0; 150]).unwrap();
    fs::write(inside.join("own.onnx"), outside("own.data", "6")).unwrap();
    std::os::unix::fs::symlink(&beside, inside.join("own.data")).unwrap();
    let text = read(&inside.join("own.onnx")).unwrap_err().to_string();
    assert!(text.contains("tensor `w`") && text.contains("is a link out of the model's folder"), "{text}");
    // A link that stays inside is no way out.
    fs::rename(&beside, inside.join("there.data")).unwrap();
    fs::remove_file(inside.join("own.data")).unwrap();
    std::os::unix::fs::symlink("there.data", inside.join("own.data")).unwrap();
    assert!(read(&inside.join("own.onnx")).is_ok());
}

/// The network of a model up to `last`, which is averaged over space.
fn network(parts: &[Vec<u8>]) -> (taxel_graph::Graph, taxel_graph::Weights) {
    let mean = node("m", "ReduceMean", &["last"], &["y"], &[ints("axes", &[2]), int("keepdims", 0)]);
    let Imported { graph, weights, .. } = accepted(&[parts, &[mean]].concat());
    (graph, weights)
}

fn int64s(name: &str, values: &[i64]) -> Vec<u8> {
    let raw: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    tensor(name, 7, &[values.len() as u64], &raw)
}

#[test]
fn series_that_are_pooled_as_images_of_one_row_are_pooled_as_series() {
    for op in ["AveragePool", "MaxPool"] {
        let direct = [node("p", op, &["x"], &["last"], &[ints("kernel_shape", &[4]), ints("strides", &[2])])];
        let turned = |kernel: &[u64], pads: &[u64]| {
            let pool = [ints("kernel_shape", kernel), ints("strides", &[1, 2]), ints("pads", pads)];
            [
                int64s("axis", &[-2]),
                node("u", "Unsqueeze", &["x", "axis"], &["row"], &[]),
                node("p", op, &["row"], &["pooled"], &pool),
                node("s", "Squeeze", &["pooled", "axis"], &["last"], &[]),
            ]
        };
        assert_eq!(network(&turned(&[1, 4], &[0; 4])), network(&direct), "{op}");
        let padded = [node(
            "p",
            op,
            &["x"],
            &["last"],
            &[ints("kernel_shape", &[4]), ints("strides", &[2]), ints("pads", &[1, 1])],
        )];
        assert_eq!(network(&turned(&[1, 4], &[0, 1, 0, 1])), network(&padded), "{op}");
        let text = refused(model(&turned(&[2, 4], &[1, 0, 0, 0])));
        assert!(text.contains("pools over an axis of one value with a kernel of more"), "{text}");
    }
}

#[test]
fn paddings_that_pytorchs_older_exporter_calculates_are_read() {
    let conv = node("c", "Conv", &["p", "w"], &["last"], &[ints("dilations", &[2])]);
    let weight = floats("w", &[4, 3, 3]);
    let pad = |pads: &str| node("p", "Pad", &["x", pads, "zero"], &["p"], &[]);
    let zero = tensor("zero", 1, &[], &0f32.to_le_bytes());
    let direct =
        [int64s("pads", &[0, 0, 4, 0, 0, 0]), zero.clone(), pad("pads"), conv.clone(), weight.clone()];
    let value = |values: &[i64]| {
        let raw: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let tensor = [number(1, values.len() as u64), number(2, 7), field(9, &raw)].concat();
        [field(1, b"value"), field(5, &tensor), number(20, 4)].concat()
    };
    let constant = |name: &str, values: &[i64]| node("", "Constant", &[], &[name], &[value(values)]);
    let calculated = |step: i64, zeros: i64| {
        [
            constant("count", &[zeros]),
            constant("given", &[4, 0]),
            node("", "ConstantOfShape", &["count"], &["zeros"], &[value(&[0])]),
            node("", "Concat", &["given", "zeros"], &["list"], &[int("axis", 0)]),
            constant("pairs", &[-1, 2]),
            node("", "Reshape", &["list", "pairs"], &["table"], &[]),
            constant("axis", &[0]),
            constant("start", &[-1]),
            constant("end", &[-i64::MAX]),
            constant("step", &[step]),
            node("", "Slice", &["table", "start", "end", "axis", "step"], &["turned"], &[]),
            node("", "Transpose", &["turned"], &["columns"], &[ints("perm", &[1, 0])]),
            constant("flat", &[-1]),
            node("", "Reshape", &["columns", "flat"], &["pads"], &[]),
            node("", "Cast", &["pads"], &["cast"], &[int("to", 7)]),
            zero.clone(),
            pad("cast"),
            conv.clone(),
            weight.clone(),
        ]
    };
    assert_eq!(network(&calculated(-1, 4)), network(&direct));
    assert!(refused(model(&calculated(-2, 4))).contains("cuts a table of integers"));
    assert!(refused(model(&calculated(-1, 3))).contains("makes a table [-1, 2] of a list"));
    assert!(
        refused(model(&calculated(-1, 1 << 40))).contains("makes integers that are no list of at most 64")
    );
}
