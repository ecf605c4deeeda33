//! Reflects, moves, scales and turns an image.
//!
//! # Reference
//!
//! Bilinear sampling as `scipy.ndimage.affine_transform` does it (`order=1, mode="grid-constant"`).

/// The changes of one image: reflect, scale, turn about the middle, then move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Warp {
    /// Rows in reverse order.
    pub flip_rows: bool,
    /// Columns in reverse order.
    pub flip_columns: bool,
    /// Taxels down and to the right.
    pub shift: [f64; 2],
    /// Magnification.
    pub scale: f64,
    /// Turn in degrees, from the rows' axis towards the columns'.
    pub degrees: f64,
}

impl Warp {
    /// Warps an image `[channels, rows, columns, frames]` in C order in place; all channels and
    /// frames alike, 1 frame for a plain image. Outside of the image lies `outside`: the value of
    /// a taxel at rest, as the image holds it.
    ///
    /// # Panics
    ///
    /// If `image` does not have as many values as `shape` says.
    pub fn apply(&self, image: &mut [f32], shape: [usize; 4], outside: f32) {
        let [_, rows, columns, frames] = shape;
        assert_eq!(image.len(), shape.iter().product::<usize>(), "an image of shape {shape:?}");
        let clean = image.to_vec();
        let turn = self.degrees.to_radians().sin_cos();
        let plane = rows * columns * frames;
        for (at, pixel) in image.chunks_exact_mut(frames).enumerate() {
            let (channel, at) = (at / (rows * columns), at % (rows * columns));
            let source = &clean[channel * plane..][..plane];
            let from = self.source([at / columns, at % columns], [rows, columns], turn);
            pixel.fill(0.0);
            for ([row, column], weight) in corners(from) {
                // A weight of zero would make NaN of an infinity.
                if weight == 0.0 {
                    continue;
                }
                let inside = (0..rows as isize).contains(&row) && (0..columns as isize).contains(&column);
                if inside {
                    let start = (row as usize * columns + column as usize) * frames;
                    pixel.iter_mut().zip(&source[start..]).for_each(|(sum, v)| *sum += weight * v);
                } else {
                    pixel.iter_mut().for_each(|sum| *sum += weight * outside);
                }
            }
        }
    }

    /// Finds the place that the pixel at `row`, `column` comes from, with the sine and cosine of the turn.
    fn source(
        &self,
        [row, column]: [usize; 2],
        [rows, columns]: [usize; 2],
        (sin, cos): (f64, f64),
    ) -> [f64; 2] {
        let middle = [(rows as f64 - 1.0) / 2.0, (columns as f64 - 1.0) / 2.0];
        let down = row as f64 - middle[0] - self.shift[0];
        let right = column as f64 - middle[1] - self.shift[1];
        let sign = |flip: bool| if flip { -1.0 } else { 1.0 };
        [
            middle[0] + sign(self.flip_rows) * (cos * down + sin * right) / self.scale,
            middle[1] + sign(self.flip_columns) * (cos * right - sin * down) / self.scale,
        ]
    }
}

/// Returns the four pixels around a point with their bilinear weights.
fn corners([row, column]: [f64; 2]) -> [([isize; 2], f32); 4] {
    let (top, left) = (row.floor(), column.floor());
    let (below, beside) = (row - top, column - left);
    let (top, left) = (top as isize, left as isize);
    [
        ([top, left], ((1.0 - below) * (1.0 - beside)) as f32),
        ([top, left + 1], ((1.0 - below) * beside) as f32),
        ([top + 1, left], (below * (1.0 - beside)) as f32),
        ([top + 1, left + 1], (below * beside) as f32),
    ]
}
