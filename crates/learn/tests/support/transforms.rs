//! Every transform, with samples for it.

use ndarray::ArrayD;
use taxel_base::Layout;
use taxel_encodings::numatac::Offset;
use taxel_encodings::{
    Colormap, Converter, ElectrodeImage, Filter, Gaf, HardnessImage, History, NumaTac, OneFrame,
    QuantileCode, Range, Reduction, Resize, Scaling, TactileTensor,
};
use taxel_learn::Transform;
use taxel_learn::encoding::Rocket;

fn z_score(channels: usize) -> Scaling {
    let mean = (0..channels).map(|c| 0.3 * c as f32 - 1.0).collect();
    Scaling::ZScore { mean, sd: (0..channels).map(|c| 0.7 + 0.1 * c as f32).collect() }
}

/// Five samples that look like nothing in particular.
pub fn samples(shape: &[usize]) -> ArrayD<f32> {
    let all: Vec<usize> = [&[5], shape].concat();
    let n = all.iter().product::<usize>();
    let value = |i: usize| ((i * 37 % 101) as f32 * 0.37).sin() * 20.0 + 40.0;
    ArrayD::from_shape_vec(all, (0..n).map(value).collect()).unwrap()
}

/// A code that knows samples of two channels.
fn code() -> Transform {
    let x = samples(&[2, 30]).into_dimensionality().unwrap();
    Transform::QuantileCode(QuantileCode::new(64, 7).fit(x.view()).unwrap())
}

/// MiniRocket's features of samples of two channels.
fn rocket() -> Transform {
    let x = samples(&[2, 30]).into_dimensionality().unwrap();
    Transform::Rocket(Box::new(Rocket::new(170).fit(x.view(), "samples").unwrap()))
}

/// The last reading of each channel and its differences to earlier ones.
fn history(channels: usize) -> Transform {
    let then = Box::new(Transform::Signal(z_score(7 * channels)));
    Transform::History { history: History::default(), then }
}

fn picture(frame: Option<OneFrame>, red: bool, resize: Option<[usize; 2]>, channels: usize) -> Transform {
    let resize = resize.map(|[height, width]| Resize { height, width, filter: Filter::Bilinear });
    Transform::Picture { frame, red, resize, scaling: z_score(channels) }
}

fn field(range: Range, colormap: Colormap) -> Transform {
    Transform::Field(HardnessImage { gaf: Gaf { size: 12, range, ..Gaf::default() }, colormap })
}

/// Every transform, with shapes of samples that it takes.
pub fn transforms() -> Vec<(Transform, Vec<usize>)> {
    let after = |readings, then| Transform::Baseline { readings, then: Box::new(then) };
    let series = |layout| Transform::Series { layout, then: Box::new(Transform::Signal(Scaling::Raw)) };
    // Contact from the first tick on leaves no rest to take an offset from.
    let offset = Offset::Fixed { dc: 20.0, ac: 30.0 };
    let frames = |frames, scaling| Transform::Tensor { tensor: TactileTensor { frames }, scaling };
    let reduced = |layout, reduction, then| Transform::Reduced { layout, reduction, then: Box::new(then) };
    let converter = Some(Converter { bits: 5, low: 0.0, high: 80.0 });
    let less =
        Reduction { channels: Some(vec![3, 1]), window: Some(30), every: Some(2), ..Reduction::default() };
    let coarse = Reduction { rows: Some(vec![0, 2, 3, 5]), pool: Some(2), converter, ..Reduction::default() };
    vec![
        (reduced(Layout::Series, less.clone(), Transform::Signal(z_score(2))), vec![4, 33]),
        (reduced(Layout::Series, less, after(4, Transform::Signal(z_score(2)))), vec![4, 33]),
        (reduced(Layout::Image, coarse.clone(), Transform::Image(z_score(1))), vec![6, 7]),
        (reduced(Layout::Image, coarse, picture(None, true, Some([9, 5]), 3)), vec![6, 7]),
        (
            reduced(
                Layout::Sequence,
                Reduction { every: Some(3), pool: Some(3), ..Reduction::default() },
                series(Layout::Sequence),
            ),
            vec![8, 6, 7],
        ),
        (Transform::Signal(z_score(1)), vec![9]),
        (Transform::Signal(z_score(5)), vec![5, 50]),
        (Transform::Signal(Scaling::FullScale { full_scale: 1023.0 }), vec![3, 7]),
        (history(5), vec![5, 34]),
        (after(3, history(2)), vec![2, 40]),
        (Transform::Rows(z_score(4)), vec![4, 11]),
        (code(), vec![2, 30]),
        (after(4, code()), vec![2, 30]),
        (rocket(), vec![2, 30]),
        (after(4, rocket()), vec![2, 30]),
        (Transform::Image(z_score(1)), vec![6, 7]),
        (Transform::Image(z_score(3)), vec![3, 6, 7]),
        (field(Range::PerSample, Colormap::Jet), vec![3, 17]),
        (field(Range::Fixed { low: 30.0, high: 55.0 }, Colormap::Grey), vec![40]),
        (after(3, field(Range::PerSample, Colormap::Viridis)), vec![2, 20]),
        (picture(None, true, Some([9, 5]), 3), vec![6, 7]),
        (picture(Some(OneFrame::Peak), false, None, 1), vec![8, 6, 7]),
        (picture(Some(OneFrame::At(2)), true, Some([4, 12]), 3), vec![8, 6, 7]),
        (frames(None, z_score(1)), vec![8, 6, 7]),
        (frames(Some(5), Scaling::Raw), vec![8, 6, 7]),
        (
            Transform::Numatac {
                numatac: NumaTac { window: 9, offset, ..NumaTac::default() },
                scaling: z_score(6),
            },
            vec![2, 3, 40],
        ),
        (Transform::Electrodes { image: ElectrodeImage::default(), scaling: z_score(3) }, vec![705, 7, 3]),
        (series(Layout::Features), vec![7]),
        (series(Layout::Image), vec![6, 7]),
        (series(Layout::Colour), vec![3, 6, 7]),
        (series(Layout::Sequence), vec![8, 6, 7]),
    ]
}
