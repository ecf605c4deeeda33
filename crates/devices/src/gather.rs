//! Sliding windows as one gather, whose gradient (an indexed sum) candle computes correctly.

use candle_core::{Device, Result, Tensor};
use taxel_graph::Window;

/// Which input position every (kernel offset, window) pair reads.
///
/// Positions count the input's spatial axes in row-major order; one more position after the last
/// stands for the padding.
pub(crate) struct Gather {
    /// Row-major [kernel volume × windows].
    index: Vec<u32>,
    volume: usize,
    positions: usize,
}

impl Gather {
    /// Makes the index of `window` over the spatial `size`.
    pub fn new(window: &Window, size: &[usize]) -> Self {
        Self::dilated(window, &[], size)
    }

    /// Makes the index of a `window` whose kernel offsets lie `dilation` apart (empty: 1).
    pub fn dilated(window: &Window, dilation: &[usize], size: &[usize]) -> Self {
        let out = window.dilated(dilation).positions(size);
        let padding = size.iter().product::<usize>() as u32;
        let (volume, positions) = (window.volume(), out.iter().product());
        let mut index = Vec::with_capacity(volume * positions);
        for offset in 0..volume {
            let offset = unravel(offset, &window.kernel);
            for position in 0..positions {
                let position = unravel(position, &out);
                let at = (0..size.len()).try_fold(0, |at, axis| {
                    let step = dilation.get(axis).unwrap_or(&1);
                    let padded = position[axis] * window.stride[axis] + offset[axis] * step;
                    let inside = padded.checked_sub(window.padding[axis].0).filter(|&i| i < size[axis])?;
                    Some(at * size[axis] as u32 + inside as u32)
                });
                index.push(at.unwrap_or(padding));
            }
        }
        Gather { index, volume, positions }
    }

    /// Makes the index for means over windows that cut the spatial `size` into `output` parts, with the number of
    /// values in each window. Windows differ in size; the rest of the smaller ones reads padding.
    pub fn adaptive(size: &[usize], output: &[usize]) -> (Self, Vec<f32>) {
        let part = |axis: usize, i: usize| {
            i * size[axis] / output[axis]..((i + 1) * size[axis]).div_ceil(output[axis])
        };
        let largest = |axis: usize| (0..output[axis]).map(|i| part(axis, i).len()).max().unwrap_or(1);
        let kernel: Vec<usize> = (0..size.len()).map(largest).collect();
        let padding = size.iter().product::<usize>() as u32;
        let (volume, positions) = (kernel.iter().product(), output.iter().product());
        let mut index = Vec::with_capacity(volume * positions);
        for offset in 0..volume {
            let offset = unravel(offset, &kernel);
            for position in 0..positions {
                let position = unravel(position, output);
                let at = (0..size.len()).try_fold(0, |at, axis| {
                    let inside = part(axis, position[axis]).nth(offset[axis])?;
                    Some(at * size[axis] as u32 + inside as u32)
                });
                index.push(at.unwrap_or(padding));
            }
        }
        let count = |position: usize| {
            let position = unravel(position, output);
            (0..size.len()).map(|axis| part(axis, position[axis]).len()).product::<usize>() as f32
        };
        let divisors = (0..positions).map(count).collect();
        (Gather { index, volume, positions }, divisors)
    }

    /// Takes the patches [n, channels, volume, positions] of `x` [n, channels, spatial…]; outside is `fill`.
    pub fn patches(&self, x: &Tensor, fill: f32, device: &Device) -> Result<Tensor> {
        let x = x.flatten_from(2)?;
        let (n, channels, _) = x.dims3()?;
        let outside = Tensor::full(fill, (n, channels, 1), device)?;
        let index = Tensor::from_slice(&self.index, self.index.len(), device)?;
        Tensor::cat(&[&x, &outside], 2)?.contiguous()?.index_select(&index, 2)?.reshape((
            n,
            channels,
            self.volume,
            self.positions,
        ))
    }

    /// Counts the values in each window that `counted` padding or the input covers, [positions].
    pub fn divisors(window: &Window, size: &[usize], counted: &[(usize, usize)]) -> Vec<f32> {
        let out = window.positions(size);
        let count = |position: usize| {
            let position = unravel(position, &out);
            let along = |axis: usize| {
                let start = position[axis] * window.stride[axis];
                let before = window.padding[axis].0;
                let low = before - counted[axis].0;
                let high = before + size[axis] + counted[axis].1;
                (start..start + window.kernel[axis]).filter(|at| (low..high).contains(at)).count()
            };
            (0..size.len()).map(along).product::<usize>().max(1) as f32
        };
        (0..out.iter().product()).map(count).collect()
    }
}

fn unravel(mut flat: usize, shape: &[usize]) -> Vec<usize> {
    let mut at = vec![0; shape.len()];
    for axis in (0..shape.len()).rev() {
        at[axis] = flat % shape[axis];
        flat /= shape[axis];
    }
    at
}
