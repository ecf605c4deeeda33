//! Batch normalisation: batch statistics in training, running ones in evaluation.

use std::ops::Range;

use taxel_kernels::batch_norm::InputGradient;

/// Count, mean and sum of squared deviations of every channel (Chan et al. 1979).
#[derive(Debug, Clone)]
pub(crate) struct Moments {
    count: f64,
    mean: Vec<f64>,
    deviations: Vec<f64>,
}

impl Moments {
    pub fn new(channels: usize) -> Self {
        Moments { count: 0.0, mean: vec![0.0; channels], deviations: vec![0.0; channels] }
    }

    pub fn clear(&mut self) {
        self.count = 0.0;
        self.mean.fill(0.0);
        self.deviations.fill(0.0);
    }

    /// Adds `count` values of each channel with their mean and squared deviations from it.
    pub fn add(&mut self, count: f64, mean: impl Fn(usize) -> f64, deviations: impl Fn(usize) -> f64) {
        if count == 0.0 {
            return;
        }
        let total = self.count + count;
        for c in 0..self.mean.len() {
            let delta = mean(c) - self.mean[c];
            self.mean[c] += delta * count / total;
            self.deviations[c] += deviations(c) + delta * delta * self.count * count / total;
        }
        self.count = total;
    }

    pub fn add_all(&mut self, other: &Moments) {
        self.add(other.count, |c| other.mean[c], |c| other.deviations[c]);
    }
}

/// Where a batch norm of the graph finds what it needs.
#[derive(Debug)]
pub(crate) struct NormLayout {
    pub channels: usize,
    /// Positions of one sample.
    pub positions: usize,
    pub eps: f64,
    pub momentum: f64,
    /// Running statistics in training too, which keeps them.
    pub keeps: bool,
    /// Weight and bias among the parameters.
    pub params: Range<usize>,
    /// Running mean and variance among the buffers.
    pub buffers: Range<usize>,
}

impl NormLayout {
    /// Moves running mean and variance to a batch's.
    pub fn move_running(&self, batch: &Moments, buffers: &mut [f32]) {
        let (mean, var) = buffers[self.buffers.clone()].split_at_mut(self.channels);
        let moved = |from: f32, to: f64| (f64::from(from) + self.momentum * (to - f64::from(from))) as f32;
        for c in 0..self.channels {
            let unbiased = batch.deviations[c] / (batch.count - 1.0).max(1.0);
            mean[c] = moved(mean[c], batch.mean[c]);
            var[c] = moved(var[c], unbiased);
        }
    }

    /// Sets running mean and variance to those of all that was gathered; of nothing they stay.
    pub fn set_running(&self, gathered: &Moments, buffers: &mut [f32]) {
        if gathered.count == 0.0 {
            return;
        }
        let (mean, var) = buffers[self.buffers.clone()].split_at_mut(self.channels);
        for c in 0..self.channels {
            mean[c] = gathered.mean[c] as f32;
            var[c] = (gathered.deviations[c] / gathered.count) as f32;
        }
    }
}

/// A batch norm as the readers of one pass see it.
#[derive(Debug)]
pub(crate) struct Norm {
    pub mean: Vec<f32>,
    inverse_sd: Vec<f64>,
    /// The factors and offsets that readers apply.
    pub scale: Vec<f32>,
    pub shift: Vec<f32>,
}

impl Norm {
    pub fn new(channels: usize) -> Self {
        Norm {
            mean: vec![0.0; channels],
            inverse_sd: vec![1.0; channels],
            scale: vec![1.0; channels],
            shift: vec![0.0; channels],
        }
    }

    /// Shows readers the running statistics.
    pub fn see_running(&mut self, layout: &NormLayout, params: &[f32], buffers: &[f32]) {
        let (mean, var) = buffers[layout.buffers.clone()].split_at(layout.channels);
        self.mean.copy_from_slice(mean);
        for (inverse, var) in self.inverse_sd.iter_mut().zip(var) {
            *inverse = 1.0 / (f64::from(*var) + layout.eps).sqrt();
        }
        self.see(layout, params);
    }

    /// Shows readers a batch's statistics.
    pub fn see_batch(&mut self, layout: &NormLayout, params: &[f32], batch: &Moments) {
        for c in 0..layout.channels {
            let var = batch.deviations[c] / batch.count;
            self.mean[c] = batch.mean[c] as f32;
            self.inverse_sd[c] = 1.0 / (var + layout.eps).sqrt();
        }
        self.see(layout, params);
    }

    fn see(&mut self, layout: &NormLayout, params: &[f32]) {
        let (weight, bias) = params[layout.params.clone()].split_at(layout.channels);
        for c in 0..layout.channels {
            let scale = f64::from(weight[c]) * self.inverse_sd[c];
            self.scale[c] = scale as f32;
            self.shift[c] = (f64::from(bias[c]) - f64::from(self.mean[c]) * scale) as f32;
        }
    }
}

/// The gradient of a batch norm in one pass.
#[derive(Debug)]
pub(crate) struct NormGradient {
    /// Σ dy and Σ dy · (x − mean) over the batch.
    pub sums: Vec<f64>,
    /// Coefficients of the input's gradient.
    first: InputGradient,
    /// The same for further views of one batch norm.
    again: InputGradient,
}

impl NormGradient {
    pub fn new(channels: usize) -> Self {
        let zeros = || vec![0.0; channels];
        let first = InputGradient { dy: zeros(), x: zeros(), mean: zeros(), constant: zeros() };
        NormGradient { sums: vec![0.0; 2 * channels], again: first.clone(), first }
    }

    /// Takes statistics that do not depend on the batch: they leave the gradient a factor.
    pub fn see_running(&mut self, norm: &Norm) {
        self.first.dy.copy_from_slice(&norm.scale);
        self.first.mean.copy_from_slice(&norm.mean);
        self.again.dy.copy_from_slice(&norm.scale);
    }

    /// Computes from the sums over a batch of `samples` the gradients of weight and bias, unless these are frozen, and
    /// the coefficients of the input's.
    pub fn see_batch(
        &mut self,
        layout: &NormLayout,
        norm: &Norm,
        samples: usize,
        params: &[f32],
        dparams: &mut [f32],
    ) {
        let count = (samples * layout.positions) as f64;
        let weight = &params[layout.params.clone()];
        let (plain, weighted) = self.sums.split_at(layout.channels);
        // Frozen ones lie after all that has gradients.
        if let Some(dparams) = dparams.get_mut(layout.params.clone()) {
            let (dweight, dbias) = dparams.split_at_mut(layout.channels);
            for c in 0..layout.channels {
                dweight[c] = (weighted[c] * norm.inverse_sd[c]) as f32;
                dbias[c] = plain[c] as f32;
            }
        }
        for c in 0..layout.channels {
            let inverse = norm.inverse_sd[c];
            let normalised = weighted[c] * inverse;
            // dx = γ/σ · (dy − mean(dy) − x̂ · mean(dy · x̂)), with x̂ = (x − μ)/σ.
            let scale = f64::from(weight[c]) * inverse;
            self.first.dy[c] = scale as f32;
            self.again.dy[c] = scale as f32;
            self.first.x[c] = (-scale * normalised / count * inverse) as f32;
            self.first.mean[c] = norm.mean[c];
            self.first.constant[c] = (-scale * plain[c] / count) as f32;
        }
    }

    /// Returns the coefficients of the input's gradient; what the whole batch contributes is in the `first` alone.
    pub fn input(&self, first: bool) -> &InputGradient {
        if first { &self.first } else { &self.again }
    }
}
