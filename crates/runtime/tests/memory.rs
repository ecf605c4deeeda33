//! A prediction allocates nothing.
#![allow(clippy::unwrap_used)]

use allocation_counter::measure;
use taxel_graph::{Scheme, Weights};
use taxel_runtime::{Frozen, Observer};

#[test]
fn no_answer_allocates() {
    for name in
        ["mlp", "lstm", "resnet8-lite-1d", "densenet6-lite-2d", "hybrid-resvgg", "multiscale-cnn", "tactnet4"]
    {
        let graph = taxel_zoo::find(name).unwrap().graph(&taxel_zoo::Settings::new()).unwrap();
        let weights = Weights::init(&graph, Scheme::Pytorch, 0, "memory");
        let inputs: Vec<Vec<f32>> =
            graph.inputs().map(|node| vec![0.5; node.shape.iter().product()]).collect();
        let inputs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
        let mut observer = Observer::new(&graph, &weights).unwrap();
        observer.see(&inputs).unwrap();
        let ranges = observer.ranges();
        let floats = Frozen::new(&graph, &weights).unwrap();
        let bytes = Frozen::quantized(&graph, &weights, &ranges).unwrap();
        // Only some processors have products of bf16.
        let half = Frozen::half(&graph, &weights).ok();
        for frozen in [floats, bytes].into_iter().chain(half) {
            let mut workspace = frozen.workspace();
            // What is looked up once per process (the width of the vectors) is looked up here.
            frozen.predict(&mut workspace, &inputs).unwrap();
            let again = measure(|| {
                frozen.predict(&mut workspace, &inputs).unwrap();
            });
            assert_eq!(again.count_total, 0, "{name}");
        }
    }
}
