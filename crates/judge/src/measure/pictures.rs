//! Readings and encodings as pictures: long ones thinned out, of sequences a few frames.

use ndarray::{ArrayD, ArrayViewD, Axis};
use taxel_data::Layout;
use taxel_report::pictures::{ArrayPicture, PictureKind};

/// Frames shown of a sequence.
const FRAMES: usize = 5;
/// Readings shown of a line; longer ones are thinned out.
const READINGS: usize = 400;

/// Returns a picture of a raw sample, as its layout says.
pub(super) fn reading(x: ArrayViewD<f32>, layout: Layout) -> ArrayPicture {
    match layout {
        Layout::Features => picture("reading", PictureKind::Lines, thinned(x.insert_axis(Axis(0)))),
        Layout::Series => picture("reading", PictureKind::Lines, thinned(x)),
        Layout::Image => picture("reading", PictureKind::Grey, x.to_owned()),
        Layout::Colour => picture("reading", PictureKind::Colour, x.to_owned()),
        Layout::Sequence => picture("reading", PictureKind::Frames, spread(x, 0)),
        Layout::Fingers => picture("reading", PictureKind::Frames, x.to_owned()),
    }
}

/// Returns a picture of an encoded input; none of an input whose axes have no picture.
pub(super) fn picture_of(name: &str, x: ArrayViewD<f32>) -> Option<ArrayPicture> {
    let one = |x: ArrayViewD<f32>| x.index_axis_move(Axis(0), 0).to_owned();
    match x.shape() {
        [_, _] => Some(picture(name, PictureKind::Lines, thinned(x))),
        [1, _, _] => Some(picture(name, PictureKind::Grey, one(x))),
        [3, _, _] => Some(picture(name, PictureKind::Colour, x.to_owned())),
        [_, _, _] => Some(picture(name, PictureKind::Frames, x.to_owned())),
        // [C, H, W, T]
        [1, _, _, _] => {
            let frames = spread(one(x).view(), 2).permuted_axes(vec![2, 0, 1]);
            Some(picture(name, PictureKind::Frames, frames))
        }
        _ => None,
    }
}

/// Returns a picture of an array.
pub(super) fn picture(name: &str, kind: PictureKind, x: ArrayD<f32>) -> ArrayPicture {
    ArrayPicture { name: name.into(), kind, shape: x.shape().to_vec(), values: x.iter().copied().collect() }
}

/// Returns a few entries along `axis`, from the first to the last.
fn spread(x: ArrayViewD<f32>, axis: usize) -> ArrayD<f32> {
    let (axis, all) = (Axis(axis), x.len_of(Axis(axis)));
    let count = FRAMES.min(all);
    let at = |i: usize| if count > 1 { i * (all - 1) / (count - 1) } else { 0 };
    x.select(axis, &(0..count).map(at).collect::<Vec<_>>())
}

fn thinned(x: ArrayViewD<f32>) -> ArrayD<f32> {
    let axis = Axis(x.ndim() - 1);
    let every = x.len_of(axis).div_ceil(READINGS).max(1);
    x.select(axis, &(0..x.len_of(axis)).step_by(every).collect::<Vec<_>>())
}
