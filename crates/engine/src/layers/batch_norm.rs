//! Batch normalisation: batch statistics in training, running ones in evaluation.

use taxel_kernels::batch_norm::{self, InputGradient};

use super::{Layer, Pass};
use crate::Mode;
use crate::threads::{Parts, add_parts_f64};

pub(crate) struct BatchNorm {
    channels: usize,
    eps: f32,
    momentum: f32,
    /// Rows (positions) of one sample.
    positions: usize,
    mean: Vec<f32>,
    inverse_sd: Vec<f32>,
    /// Σ dy and Σ dy·x̂ of the last backward pass.
    gradient: InputGradient,
    population: Option<Population>,
}

/// Count, mean and sum of squared deviations over everything seen so far (Chan et al. 1979).
struct Population {
    count: f64,
    mean: Vec<f64>,
    deviations: Vec<f64>,
}

impl BatchNorm {
    pub fn new(channels: usize, eps: f32, momentum: f32, positions: usize) -> Self {
        BatchNorm {
            channels,
            eps,
            momentum,
            positions,
            mean: vec![0.0; channels],
            inverse_sd: vec![1.0; channels],
            gradient: InputGradient::default(),
            population: None,
        }
    }

    /// Starts to gather statistics over all following training passes.
    pub fn begin_population(&mut self) {
        let zeros = vec![0.0; self.channels];
        self.population = Some(Population { count: 0.0, mean: zeros.clone(), deviations: zeros });
    }

    /// Replaces the running statistics by those gathered.
    pub fn end_population(&mut self, buffers: &mut [f32]) {
        let Some(population) = self.population.take().filter(|p| p.count > 0.0) else { return };
        let (mean, var) = buffers.split_at_mut(self.channels);
        for c in 0..self.channels {
            mean[c] = population.mean[c] as f32;
            var[c] = (population.deviations[c] / population.count) as f32;
        }
    }

    /// Sums over fixed parts of the batch, added in their order.
    fn reduce(
        &self,
        pass: &Pass,
        width: usize,
        part: impl Fn(std::ops::Range<usize>, &mut [f64]) + Sync,
    ) -> Vec<f64> {
        let parts = Parts::of(pass.n, usize::MAX);
        let mut partials = vec![0.0; parts.count * width];
        let row = self.positions * self.channels;
        pass.threads.each(&mut partials, width, |i, sums| {
            let samples = parts.range(i, pass.n);
            part(samples.start * row..samples.end * row, sums);
        });
        add_parts_f64(&partials, width)
    }

    /// Batch mean and inverse standard deviation into `self`, and what follows from them into the
    /// running statistics or the population.
    fn measure(&mut self, pass: &Pass, x: &[f32], buffers: &mut [f32]) {
        let count = (pass.n * self.positions) as f64;
        let channels = self.channels;
        let sums = self.reduce(pass, channels, |range, sums| batch_norm::sum(channels, &x[range], sums));
        let mean: Vec<f32> = sums.iter().map(|s| (s / count) as f32).collect();
        let deviations = self.reduce(pass, channels, |range, sums| {
            batch_norm::squared_deviations(channels, &x[range], &mean, sums);
        });
        let (running_mean, running_var) = buffers.split_at_mut(channels);
        for c in 0..channels {
            let var = deviations[c] / count;
            self.inverse_sd[c] = (1.0 / (var + f64::from(self.eps)).sqrt()) as f32;
            match &mut self.population {
                Some(population) => {
                    let total = population.count + count;
                    let delta = sums[c] / count - population.mean[c];
                    population.mean[c] += delta * count / total;
                    population.deviations[c] +=
                        deviations[c] + delta * delta * population.count * count / total;
                }
                None => {
                    let unbiased = deviations[c] / (count - 1.0).max(1.0);
                    running_mean[c] += self.momentum * (mean[c] - running_mean[c]);
                    running_var[c] += self.momentum * (unbiased as f32 - running_var[c]);
                }
            }
        }
        if let Some(population) = &mut self.population {
            population.count += count;
        }
        self.mean = mean;
    }
}

impl Layer for BatchNorm {
    fn forward(&mut self, pass: &Pass, xs: &[&[f32]], params: &[f32], buffers: &mut [f32], y: &mut [f32]) {
        let channels = self.channels;
        if pass.mode == Mode::Train {
            self.measure(pass, xs[0], buffers);
        } else {
            self.mean.copy_from_slice(&buffers[..channels]);
            for (inverse, var) in self.inverse_sd.iter_mut().zip(&buffers[channels..]) {
                *inverse = 1.0 / (var + self.eps).sqrt();
            }
        }
        let (weight, bias) = params.split_at(channels);
        let scale: Vec<f32> = (0..channels).map(|c| weight[c] * self.inverse_sd[c]).collect();
        let shift: Vec<f32> = (0..channels).map(|c| bias[c] - self.mean[c] * scale[c]).collect();
        let len = self.positions * channels;
        pass.threads.each(y, len, |i, y| {
            batch_norm::affine(channels, &xs[0][i * len..][..len], &scale, &shift, y);
        });
    }

    fn backward_params(
        &mut self,
        pass: &Pass,
        xs: &[&[f32]],
        dy: &[f32],
        params: &[f32],
        dparams: &mut [f32],
    ) {
        let channels = self.channels;
        let count = (pass.n * self.positions) as f64;
        let mean = &self.mean;
        let sums = self.reduce(pass, 2 * channels, |range, sums| {
            let (dy_sums, deviation_sums) = sums.split_at_mut(channels);
            batch_norm::backward_sums(
                channels,
                &xs[0][range.clone()],
                &dy[range],
                mean,
                dy_sums,
                deviation_sums,
            );
        });
        let (dweight, dbias) = dparams.split_at_mut(channels);
        let mut gradient = InputGradient {
            dy: vec![0.0; channels],
            x: vec![0.0; channels],
            mean: self.mean.clone(),
            constant: vec![0.0; channels],
        };
        for c in 0..channels {
            let inverse = f64::from(self.inverse_sd[c]);
            let normalised = sums[channels + c] * inverse;
            dweight[c] = normalised as f32;
            dbias[c] = sums[c] as f32;
            // dx = γ/σ · (dy − mean(dy) − x̂ · mean(dy · x̂)), with x̂ = (x − μ)/σ.
            let scale = f64::from(params[c]) * inverse;
            gradient.dy[c] = scale as f32;
            gradient.x[c] = (-scale * normalised / count * inverse) as f32;
            gradient.constant[c] = (-scale * sums[c] / count) as f32;
        }
        self.gradient = gradient;
    }

    fn backward_input(
        &mut self,
        pass: &Pass,
        _: usize,
        xs: &[&[f32]],
        _: &[f32],
        dy: &[f32],
        _: &[f32],
        dx: &mut [f32],
        accumulate: bool,
    ) {
        let (channels, len) = (self.channels, self.positions * self.channels);
        pass.threads.each(dx, len, |i, dx| {
            let range = i * len..(i + 1) * len;
            let (x, dy) = (&xs[0][range.clone()], &dy[range]);
            batch_norm::backward_input(channels, x, dy, &self.gradient, dx, accumulate);
        });
    }

    fn batch_norm(&mut self) -> Option<&mut BatchNorm> {
        Some(self)
    }
}
