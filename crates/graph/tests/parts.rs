//! Parts of a network, and tensors that go from one network to another; on all networks of the zoo in
//! `crates/devices/tests/transfer.rs`.

#![allow(clippy::unwrap_used, clippy::panic)]

use taxel_graph::{Conv, Graph, Network, Pool, Scheme, Tensor, Weights};

/// Two inputs that meet before a hidden layer; two outputs of `classes` and two.
fn branched(classes: usize) -> Graph {
    let net = Network::new("branched");
    let x = net.input("image", &[2, 6, 6]);
    let stem = x.conv("stem.conv", Conv::new(4, 3).pad(1).no_bias()).batch_norm("stem.bn").relu();
    let body = stem.conv("body.left", Conv::new(4, 3).pad(1)).add(&stem).max_pool(Pool::new(2));
    let series = net.input("series", &[3, 5]).conv("stemless.conv", Conv::new(2, 3)).global_average_pool();
    let pooled = body.batch_norm("body.bn").global_average_pool().dropout(0.5);
    let hidden = series.concat(&pooled).linear("head.fc1", 5).relu();
    let scaled = hidden.linear("head.fc3", 2).scale("head.k", 1.0);
    net.finish(&[("a", hidden.linear("head.fc2", classes)), ("b", scaled)]).unwrap()
}

fn fresh(graph: &Graph, seed: u64) -> Weights {
    Weights::init(graph, Scheme::Pytorch, seed, "init")
}

/// Names of the nodes that have tensors.
fn layers(graph: &Graph) -> Vec<&str> {
    graph.nodes().iter().filter(|node| !node.params.is_empty()).map(|node| node.name.as_str()).collect()
}

#[test]
fn a_name_covers_its_node_or_its_block() {
    let net = branched(3);
    let covered = |names: &[&str]| -> Vec<&str> {
        let names: Vec<String> = names.iter().map(ToString::to_string).collect();
        let covered = net.covered(&names).unwrap();
        assert_eq!(covered.len(), net.nodes().len());
        let both = net.nodes().iter().zip(covered);
        both.filter(|(_, covered)| *covered).map(|(node, _)| node.name.as_str()).collect()
    };
    assert_eq!(covered(&["stem"]), ["stem.conv", "stem.bn"]);
    assert_eq!(covered(&["stemless.conv"]), ["stemless.conv"]);
    assert_eq!(covered(&["head.k", "body"]), ["body.left", "body.bn", "head.k"]);
    assert!(covered(&[]).is_empty());
    // A part of a name, and a node without tensors.
    for name in ["ste", "head.fc1/relu", "image"] {
        let error = net.covered(&["stem".into(), name.into()]).unwrap_err().to_string();
        assert_eq!(error, format!("branched: cannot freeze `{name}`: no node with tensors has that name"));
    }
}

#[test]
fn a_network_is_halved_behind_what_stays() {
    let net = branched(3);
    let halves = |names: &[&str]| {
        let names: Vec<String> = names.iter().map(ToString::to_string).collect();
        net.halves(&net.covered(&names).unwrap())
    };
    // One of two inputs, dropout right behind the other, nothing, everything.
    assert_eq!(halves(&["stem", "body", "stemless"]), None);
    assert_eq!(halves(&[]), None);
    assert_eq!(halves(&["stem", "body", "stemless", "head"]), None);
    let line = |width: usize| {
        let net = Network::new("line");
        let x = net.input("image", &[2, 6, 6]);
        let stem = x.conv("stem.conv", Conv::new(4, 3).pad(1).no_bias()).batch_norm("stem.bn").relu();
        let x = stem.conv("body", Conv::new(4, 3).pad(1)).add(&stem).global_average_pool();
        let x = x.linear("fc1", width).relu().dropout(0.5).linear("fc2", 3);
        net.finish(&[("a", x.clone()), ("b", x.linear("fc3", 2))]).unwrap()
    };
    let at = |width: usize, unchanged: &[&str]| {
        let (net, names) = (line(width), unchanged.iter().map(ToString::to_string).collect::<Vec<_>>());
        let halves = net.halves(&net.covered(&names).unwrap())?;
        assert_eq!(halves.head.inputs().len(), 1);
        let outputs: Vec<&str> = halves.head.outputs().iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(outputs, ["a", "b"]);
        let both = [layers(&halves.body), layers(&halves.head)].concat();
        assert_eq!(both, layers(&net), "every tensor is in one of the two");
        Some((halves.body.outputs()[0].0.clone(), layers(&halves.head).len()))
    };
    let some = |name: &str, left| Some((name.to_string(), left));
    assert_eq!(at(5, &["stem.conv"]), some("stem.conv", 5));
    assert_eq!(at(5, &["stem"]), some("stem.bn/relu", 4));
    // Not before the addition, which reads the stem as well; the mean has the fewest values.
    assert_eq!(at(5, &["stem", "body"]), some("body/add/global_average_pool", 3));
    // The last of those with as many values that is before the dropout.
    assert_eq!(at(5, &["stem", "body", "fc1", "fc2"]), some("fc1/relu", 2));
    // A batch norm whose statistics move, a layer before what stays.
    assert_eq!(at(5, &["stem.bn", "body"]), None);
    let net = line(5);
    let no_norm: Vec<bool> =
        net.nodes().iter().map(|node| node.name == "stem.conv" || node.name == "body").collect();
    assert_eq!(net.halves(&no_norm).unwrap().body.outputs()[0].0, "stem.conv");
    // Nodes of the head have the numbers of the head.
    let head = line(5).halves(&line(5).covered(&["stem".into()]).unwrap()).unwrap().head;
    assert_eq!(head.nodes()[0].name, "stem.bn/relu");
    assert!(head.nodes().iter().enumerate().all(|(id, node)| node.inputs.iter().all(|&input| input < id)));
    assert_eq!(head.nodes()[2].inputs, [1, 0], "body plus stem");
}

#[test]
fn a_network_is_cut_after_a_node_or_a_block() {
    let net = branched(3);
    let stem = net.cut("stem").unwrap();
    // Both inputs stay, and what lies beside the way to the node goes.
    assert_eq!(layers(&stem), ["stem.conv", "stem.bn"]);
    assert_eq!(stem.inputs().count(), 2);
    assert_eq!(stem.outputs(), [("stem.bn/relu".to_string(), 3)]);
    assert_eq!(net.cut("stem.conv").unwrap().outputs(), [("stem.conv".to_string(), 1)]);
    // Not the mean and the dropout that come after the block, nor the concatenation after the mean: they carry its
    // name for want of one of their own.
    let body = net.cut("body").unwrap();
    assert_eq!(body.outputs()[0].0, "body.bn");
    assert_eq!(body.nodes().last().unwrap().shape, [4, 3, 3]);
    // Numbers of nodes are those of the part.
    let series = net.cut("stemless").unwrap();
    assert_eq!(layers(&series), ["stemless.conv"]);
    assert_eq!((series.nodes().len(), series.nodes()[2].inputs.as_slice()), (3, &[1][..]));
    let whole = net.cut("head.k").unwrap();
    assert_eq!(whole.nodes().len(), net.nodes().len() - 1);
    for (name, says) in [
        ("stm", "; did you mean `stem`"),
        ("head.fc4", "; did you mean `head.fc1`"),
        ("wholly-else", "; its nodes are `image` to `head.fc2`"),
    ] {
        let error = net.cut(name).unwrap_err().to_string();
        assert!(error.starts_with(&format!("branched: has no node `{name}`{says}")), "{error}");
    }
}

const HEADS: [&str; 5] = ["head.fc2.weight", "head.fc2.bias", "head.k", "head.fc3.weight", "head.fc3.bias"];

#[test]
fn heads_go_back_to_the_last_layer() {
    assert_eq!(branched(3).head_tensors(), HEADS);
}

#[test]
fn weights_of_another_task_leave_the_heads_fresh() {
    let (net, other) = (branched(3), branched(7));
    let (drawn, checkpoint) = (fresh(&net, 1), fresh(&other, 2));
    let mut sorted = HEADS.to_vec();
    sorted.sort_unstable();
    for (checkpoint, new_head, kept) in
        [(&checkpoint, false, true), (&fresh(&net, 3), true, true), (&fresh(&net, 3), false, false)]
    {
        let mut weights = drawn.clone();
        let mut stayed = weights.start_from(&net, checkpoint, new_head).unwrap();
        stayed.sort_unstable();
        assert_eq!(stayed, if kept { sorted.clone() } else { vec![] });
        for param in net.params() {
            let from = if stayed.contains(&param.name) { &drawn } else { checkpoint };
            assert_eq!(weights.get(&param.name), from.get(&param.name), "{}", param.name);
        }
        assert_eq!(weights.iter().count(), net.params().count());
    }
    // Of another size in front of the head, or a body of another size: no other number of classes.
    for name in ["head.fc2.weight", "stem.conv.weight"] {
        let (mut weights, mut wrong) = (drawn.clone(), drawn.clone());
        wrong.insert(name, Tensor { shape: vec![3, 9], data: vec![0.0; 27] });
        let error = weights.start_from(&net, &wrong, false).unwrap_err().to_string();
        assert!(error.contains(&format!("tensor `{name}` has shape [3, 9]")), "{error}");
        assert_eq!(weights, drawn, "nothing is replaced");
    }
    let part = net.cut("stem").unwrap();
    assert_eq!(drawn.only(&part).iter().map(|(name, _)| name).collect::<Vec<_>>().len(), 5);
}

#[test]
fn two_networks_are_stitched_where_they_share() {
    let parent = |names: [&str; 3]| {
        let net = Network::new("parent");
        let x = net.input("x", &[2, 4]).conv(names[0], Conv::new(2, 1)).conv(names[1], Conv::new(2, 1));
        net.finish(&[("y", x.flatten().linear(names[2], 2))]).unwrap()
    };
    let plain = parent(["first", "second", "third"]);
    let graph = parent(["touch.first", "both.second", "third"]);
    let (touch, others) = (fresh(&plain, 1), fresh(&plain, 3));
    let mut vision = fresh(&plain, 2);
    for name in ["second.weight", "second.bias"] {
        vision.insert(name, touch.get(name).unwrap().clone());
    }
    let parents = [("vision", &vision), ("touch", &touch)];
    let stitched = Weights::stitched(&graph, &parents, "both", &others).unwrap();
    assert_eq!(stitched.get("touch.first.weight"), touch.get("first.weight"));
    assert_eq!(stitched.get("both.second.bias"), touch.get("second.bias"));
    assert_eq!(stitched.get("third.weight"), others.get("third.weight"));
    let error = Weights::stitched(&graph, &parents[..1], "both", &others).unwrap_err().to_string();
    assert!(error.contains("tensor `touch.first.weight` is missing"), "{error}");
    vision.insert("second.bias", Tensor { shape: vec![2], data: vec![9.0; 2] });
    let error = Weights::stitched(&graph, &[("vision", &vision), ("touch", &touch)], "both", &others);
    let error = error.unwrap_err().to_string();
    assert!(error.contains("`second.bias` is another in `vision` than in `touch`"), "{error}");
}

/// Rouhafzay et al. 2021, Figs. 3 and 4.
#[test]
fn changes_are_squared_differences_of_kernels_scaled_to_0_and_1() {
    let net = Network::new("two");
    let x = net.input("x", &[1, 2, 2]).conv("a", Conv::new(1, 2)).conv("b", Conv::new(2, 1));
    let net = net.finish(&[("logits", x.flatten().linear("fc", 2))]).unwrap();
    let with = |a: [f32; 4], b: [f32; 2]| {
        let mut weights = fresh(&net, 0);
        weights.insert("a.weight", Tensor { shape: vec![1, 1, 2, 2], data: a.to_vec() });
        weights.insert("b.weight", Tensor { shape: vec![2, 1, 1, 1], data: b.to_vec() });
        weights
    };
    let start = with([-1.0, 0.0, 1.0, 3.0], [5.0, 5.0]);
    assert!(start.changes(&start, &net).unwrap().iter().all(|(_, change)| *change == 0.0));
    // 0, ¼, ½, 1 against 0, ½, ½, 1; zeros against 0, 1.
    let tuned = with([10.0, 12.0, 12.0, 14.0], [1.0, 2.0]);
    let changes = start.changes(&tuned, &net).unwrap();
    assert_eq!(changes, [("a".to_string(), 0.0625 / 4.0), ("b".to_string(), 0.5)]);
    for (a, b) in [(&start, &Weights::new()), (&Weights::new(), &start)] {
        let refusal = a.changes(b, &net).unwrap_err().to_string();
        assert!(refusal.contains("tensor `a.weight` is missing"), "{refusal}");
    }
}
