//! Networks on images, of the zoo and small ones that have each operation.

use taxel_encodings::Scaling;
use taxel_firmware::{Answers, Samples};
use taxel_graph::{Conv, Flow, Graph, Network, Pool};

use super::{COUNT, Case, Own};

/// Channels, rows and columns of an image.
pub type Size = [usize; 3];

/// A network of the zoo for images of this size.
pub fn graph(name: &str, size: Size, outputs: usize) -> Graph {
    let entry = taxel_zoo::find(name).unwrap();
    let settings = entry.fit(outputs, |input| match input {
        "image" => Some(size.to_vec()),
        _ => None,
    });
    entry.graph(&settings.unwrap()).unwrap()
}

/// A separable convolution as those of MobileNet.
fn separable(x: &Flow, name: &str, filters: usize, depthwise: Conv) -> Flow {
    x.conv_bn_relu(&format!("{name}.depthwise"), depthwise.groups(x.shape()[0]).no_bias())
        .conv_bn_relu(&format!("{name}.pointwise"), Conv::new(filters, 1).no_bias())
}

/// A small network of separable convolutions: kernels of 3 and 5, strides, rows and columns apart, a sum, means of windows.
pub fn separables(size: Size, outputs: usize) -> Graph {
    let net = Network::new("separables");
    let x = net.input("image", &size).conv_bn_relu("stem", Conv::new(8, 3).stride(2).pad(1).no_bias());
    let x = separable(&x, "one", 12, Conv::new(8, 3).same());
    let y = separable(&x, "two", 12, Conv::new(12, 5).same());
    let x = separable(&x.add(&y), "three", 16, Conv::new(12, 3).dilation(2).pad(2));
    let x = separable(&x, "four", 16, Conv::new(16, [3, 1]).stride([2, 1]).pad([1, 0]));
    let x = x.average_pool(Pool::new(2).pad(1)).max_pool(Pool::new([2, 3]).stride([1, 2]));
    net.finish(&[("logits", x.flatten().linear("fc", outputs))]).unwrap()
}

/// A network whose convolutions read parts of values, whose means leave padding out, and whose last values are numbers of each filter.
pub fn parts(size: Size, outputs: usize) -> Graph {
    let net = Network::new("parts");
    let x = net.input("image", &size).conv_bn_relu("stem", Conv::new(8, [3, 5]).pad([0, 2]));
    let grouped = x.conv_bn_relu("grouped", Conv::new(8, 3).pad(1).groups(2));
    let x = x.concat(&grouped).channel_shuffle(2);
    let half = x.slice(0, 8).conv_bn_relu("half", Conv::new(7, 3).pad(1));
    let x = x.slice(8, 8).concat(&half).average_pool(Pool::new(3).stride(2).pad(1).ignore_padding());
    let x = x.conv("last", Conv::new(11, [1, 3]).dilation([1, 2]).pad([1, 2]));
    let means = x.relu().global_average_pool();
    let spread = x.global_standard_deviation(1e-5);
    net.finish(&[("logits", means.concat(&spread).linear("fc", outputs))]).unwrap()
}

/// The case of a network in eight bits on images.
pub fn case(graph: &Graph, [channels, rows, columns]: Size, encoding: Own, answers: Answers) -> Case {
    let range = |channel: usize| [0.0, [255.0, 1.7, 40.0][channel % 3]];
    let ranges: Vec<[f32; 2]> = (0..channels).map(range).collect();
    let samples = Samples::new(COUNT, &ranges, rows * columns);
    let case = Case::of(graph, (samples, [channels, rows * columns]), encoding, answers);
    Case { image: Some([rows, columns]), ..case }
}

/// The case of a network of the zoo that was counted: three classes of grey images of 16 × 16.
pub fn measured(name: &str) -> Case {
    let size = [1, 16, 16];
    case(&graph(name, size, 3), size, z_score(1), super::classes(None))
}

/// Z-scores of channels of these ranges.
pub fn z_score(channels: usize) -> Own {
    let of = |values: [f32; 3]| (0..channels).map(|channel| values[channel % 3]).collect();
    Own::Scaled(Scaling::ZScore { mean: of([120.0, 0.9, 19.5]), sd: of([71.3, 0.41, 11.0]) })
}
