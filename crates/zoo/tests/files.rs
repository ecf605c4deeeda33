//! Every network as a file, and what strangers may put into one.

#![allow(clippy::unwrap_used, clippy::panic)]

use proptest::prelude::*;
use proptest::sample::Index;
use serde_json::{Value, json};
use taxel_graph::Graph;
use taxel_zoo::{Settings, built_in, find};

fn written(network: &str) -> Value {
    serde_json::to_value(find(network).unwrap().graph(&Settings::new()).unwrap()).unwrap()
}

fn refusal(json: Value) -> String {
    serde_json::from_value::<Graph>(json).unwrap_err().to_string()
}

#[test]
fn every_network_comes_back_equal() {
    for entry in built_in().entries() {
        let graph = entry.graph(&Settings::new()).unwrap();
        let text = serde_json::to_string(&graph).unwrap();
        let read: Graph = serde_json::from_str(&text).unwrap();
        assert_eq!(read, graph, "{}", entry.name);
        assert_eq!(serde_json::to_string(&read).unwrap(), text, "{}", entry.name);
    }
    let aux = Settings::from_iter([("aux".to_string(), true.into())]);
    let graph = find("googlenet").unwrap().graph(&aux).unwrap();
    assert_eq!(serde_json::from_value::<Graph>(json!(graph)).unwrap(), graph, "three outputs");
    let part = graph.cut("inception4a").unwrap();
    assert_eq!(serde_json::from_value::<Graph>(json!(part)).unwrap(), part, "a part");
}

/// Where a node states a number, and which it is: (pointer, node).
fn numbers(json: &Value) -> Vec<(String, String)> {
    fn walk(json: &Value, at: String, node: &str, found: &mut Vec<(String, String)>) {
        match json {
            Value::Object(map) => map.iter().for_each(|(k, v)| walk(v, format!("{at}/{k}"), node, found)),
            Value::Array(list) => {
                list.iter().enumerate().for_each(|(i, v)| walk(v, format!("{at}/{i}"), node, found));
            }
            Value::Number(number) if number.is_u64() => found.push((at, node.into())),
            _ => {}
        }
    }
    let mut found = vec![];
    for (i, node) in json["nodes"].as_array().unwrap().iter().enumerate() {
        walk(node, format!("/nodes/{i}"), node["name"].as_str().unwrap(), &mut found);
    }
    found
}

fn network() -> impl Strategy<Value = String> {
    prop::sample::select(built_in().entries().map(|entry| entry.name.clone()).collect::<Vec<_>>())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// A shape, a kernel, a stride, an input: whatever it is, no other network is read without a word. What is
    /// refused names the node, or one that reads it.
    #[test]
    fn another_number_is_refused_by_name(network in network(), place in any::<Index>(), by in prop_oneof![
        Just(0u64), Just(1), Just(u64::MAX), Just(1 << 31), Just(1 << 62), 1u64..100_000
    ]) {
        let mut json = written(&network);
        let places = numbers(&json);
        let (pointer, node) = &places[place.index(places.len())];
        let number = json.pointer_mut(pointer).unwrap();
        prop_assume!(number.as_u64() != Some(by));
        *number = by.into();
        match serde_json::from_value::<Graph>(json.clone()) {
            // Such as an input that another node could be: then that is what was read.
            Ok(graph) => prop_assert_eq!(json!(graph), json),
            Err(error) => {
                let error = error.to_string();
                let id: usize = pointer.split('/').nth(2).unwrap().parse().unwrap();
                let after = json["nodes"].as_array().unwrap()[id..].iter();
                let named = after.map(|node| node["name"].as_str().unwrap());
                let by_name = named.clone().any(|name| error.starts_with(&format!("{name}: ")))
                    || named.clone().any(|name| error.starts_with(&format!("{name}.")));
                prop_assert!(by_name, "{} of {}: {}", pointer, node, error);
            }
        }
    }

    /// Inputs count nodes, so that those after a dropped one read others than they say.
    #[test]
    fn a_dropped_or_doubled_node_is_refused_by_name(network in network(), place in any::<Index>()) {
        let json = written(&network);
        let count = json["nodes"].as_array().unwrap().len();
        let at = place.index(count);
        let mut dropped = json.clone();
        dropped["nodes"].as_array_mut().unwrap().remove(at);
        prop_assert!(refusal(dropped).contains(": "));
        let mut doubled = json.clone();
        let name = json["nodes"][at]["name"].clone();
        let node = &mut doubled["nodes"][(at + 1) % count];
        node["name"] = name.clone();
        let error = refusal(doubled);
        prop_assert!(error.starts_with(name.as_str().unwrap()), "{}", error);
    }
}
