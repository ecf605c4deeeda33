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

    fn add_all(&mut self, other: &Moments) {
        self.add(other.count, |c| other.mean[c], |c| other.deviations[c]);
    }
}

/// One batch norm of the graph.
#[derive(Debug)]
pub(crate) struct Norm {
    pub channels: usize,
    /// Positions of one sample.
    pub positions: usize,
    eps: f64,
    momentum: f64,
    pub params: Range<usize>,
    pub buffers: Range<usize>,
    pub mean: Vec<f32>,
    inverse_sd: Vec<f64>,
    /// What readers multiply with and add.
    pub scale: Vec<f32>,
    pub shift: Vec<f32>,
    gradient: InputGradient,
    /// The same for further views of one batch norm.
    again: InputGradient,
    population: Option<Moments>,
}

impl Norm {
    pub fn new(
        channels: usize,
        positions: usize,
        eps: f32,
        momentum: f32,
        params: Range<usize>,
        buffers: Range<usize>,
    ) -> Self {
        let zeros = || vec![0.0; channels];
        let gradient = InputGradient { dy: zeros(), x: zeros(), mean: zeros(), constant: zeros() };
        Norm {
            channels,
            positions,
            eps: f64::from(eps),
            momentum: f64::from(momentum),
            params,
            buffers,
            mean: vec![0.0; channels],
            inverse_sd: vec![1.0; channels],
            scale: vec![1.0; channels],
            shift: vec![0.0; channels],
            again: gradient.clone(),
            gradient,
            population: None,
        }
    }

    /// Readers see running statistics.
    pub fn evaluate(&mut self, params: &[f32], buffers: &[f32]) {
        let (mean, var) = buffers[self.buffers.clone()].split_at(self.channels);
        self.mean.copy_from_slice(mean);
        for (inverse, var) in self.inverse_sd.iter_mut().zip(var) {
            *inverse = 1.0 / (f64::from(*var) + self.eps).sqrt();
        }
        self.see(params);
        // Statistics that do not depend on the batch leave the gradient a factor.
        self.gradient.dy.copy_from_slice(&self.scale);
        self.gradient.mean.copy_from_slice(&self.mean);
        self.gradient.x.fill(0.0);
        self.gradient.constant.fill(0.0);
        self.again.dy.copy_from_slice(&self.scale);
    }

    /// Readers see the batch's statistics; running ones move, or the population grows.
    pub fn train<'a>(
        &mut self,
        parts: impl Iterator<Item = &'a Moments>,
        params: &[f32],
        buffers: &mut [f32],
    ) {
        let mut batch = Moments::new(self.channels);
        parts.for_each(|part| batch.add_all(part));
        let (running_mean, running_var) = buffers[self.buffers.clone()].split_at_mut(self.channels);
        for c in 0..self.channels {
            let var = batch.deviations[c] / batch.count;
            self.mean[c] = batch.mean[c] as f32;
            self.inverse_sd[c] = 1.0 / (var + self.eps).sqrt();
            if self.population.is_none() {
                let unbiased = batch.deviations[c] / (batch.count - 1.0).max(1.0);
                let moved =
                    |from: f32, to: f64| (f64::from(from) + self.momentum * (to - f64::from(from))) as f32;
                running_mean[c] = moved(running_mean[c], batch.mean[c]);
                running_var[c] = moved(running_var[c], unbiased);
            }
        }
        if let Some(population) = &mut self.population {
            population.add_all(&batch);
        }
        self.see(params);
    }

    fn see(&mut self, params: &[f32]) {
        let (weight, bias) = params[self.params.clone()].split_at(self.channels);
        for c in 0..self.channels {
            let scale = f64::from(weight[c]) * self.inverse_sd[c];
            self.scale[c] = scale as f32;
            self.shift[c] = (f64::from(bias[c]) - f64::from(self.mean[c]) * scale) as f32;
        }
    }

    /// From Σ dy and Σ dy · (x − mean) over a batch of `samples`: the gradients of weight and bias, and
    /// the coefficients of the input's.
    pub fn backward(&mut self, samples: usize, sums: &[f64], params: &[f32], dparams: &mut [f32]) {
        let count = (samples * self.positions) as f64;
        let weight = &params[self.params.clone()];
        let (dweight, dbias) = dparams[self.params.clone()].split_at_mut(self.channels);
        for c in 0..self.channels {
            let inverse = self.inverse_sd[c];
            let normalised = sums[self.channels + c] * inverse;
            dweight[c] = normalised as f32;
            dbias[c] = sums[c] as f32;
            // dx = γ/σ · (dy − mean(dy) − x̂ · mean(dy · x̂)), with x̂ = (x − μ)/σ.
            let scale = f64::from(weight[c]) * inverse;
            self.gradient.dy[c] = scale as f32;
            self.again.dy[c] = scale as f32;
            self.gradient.x[c] = (-scale * normalised / count * inverse) as f32;
            self.gradient.mean[c] = self.mean[c];
            self.gradient.constant[c] = (-scale * sums[c] / count) as f32;
        }
    }

    /// Coefficients of the input gradient; what the whole batch contributes is in the `first` alone.
    pub fn gradient(&self, first: bool) -> &InputGradient {
        if first { &self.gradient } else { &self.again }
    }

    /// From now on, training passes gather statistics instead of moving the running ones.
    pub fn begin_population(&mut self) {
        self.population = Some(Moments::new(self.channels));
    }

    /// Running statistics become those gathered; without any they stay.
    pub fn end_population(&mut self, buffers: &mut [f32]) {
        let Some(population) = self.population.take().filter(|p| p.count > 0.0) else { return };
        let (mean, var) = buffers[self.buffers.clone()].split_at_mut(self.channels);
        for c in 0..self.channels {
            mean[c] = population.mean[c] as f32;
            var[c] = (population.deviations[c] / population.count) as f32;
        }
    }
}
