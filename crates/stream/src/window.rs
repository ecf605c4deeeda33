//! The last time steps of a stream, and the sample that they make.

use taxel_data::{Padding, SampleSpec};

/// The last time steps of a stream, at most as many as a sample has.
#[derive(Debug, Clone)]
pub struct Window {
    /// Values of a sample before its time axis, time steps along it, values after it.
    around: (usize, usize, usize),
    /// Time step after time step; the oldest is overwritten.
    ring: Vec<f32>,
    /// Where the next time step goes, in time steps.
    next: usize,
    known: usize,
}

impl Window {
    /// Makes an empty window for samples of this kind.
    pub fn new(spec: &SampleSpec) -> Self {
        let around = spec.around_time();
        let (before, ticks, after) = around;
        Window { around, ring: vec![0.0; before * ticks * after], next: 0, known: 0 }
    }

    /// Returns the number of time steps of a full window, at least 1.
    pub fn ticks(&self) -> usize {
        self.around.1
    }

    /// Returns the number of values of one time step.
    pub fn each(&self) -> usize {
        self.around.0 * self.around.2
    }

    /// Returns the number of time steps that are there.
    pub fn known(&self) -> usize {
        self.known
    }

    /// Adds a time step, row-major as in a sample; of a full window the oldest goes. A time step of another length is no
    /// time step of this window: nothing happens.
    pub fn push(&mut self, reading: &[f32]) {
        let (each, ticks) = (self.each(), self.ticks());
        if reading.len() != each || ticks == 0 {
            return;
        }
        self.ring[self.next * each..][..each].copy_from_slice(reading);
        self.next = (self.next + 1) % ticks;
        self.known = (self.known + 1).min(ticks);
    }

    /// Forgets all but the last `readings`.
    pub fn keep(&mut self, readings: usize) {
        self.known = self.known.min(readings);
    }

    /// Writes the sample that the time steps make, the oldest first, filled up by `padding`. A `sample` of another length
    /// than the model's is left as it is.
    pub fn sample(&self, padding: Padding, sample: &mut [f32]) {
        if sample.len() != self.ring.len() {
            return;
        }
        let (before, ticks, after) = self.around;
        let each = self.each();
        for tick in 0..self.known {
            let slot = (self.next + ticks - self.known + tick) % ticks;
            let reading = &self.ring[slot * each..][..each];
            for (outer, values) in reading.chunks_exact(after.max(1)).enumerate() {
                sample[(outer * ticks + tick) * after..][..after].copy_from_slice(values);
            }
        }
        padding.fill(sample, (before, after), self.known);
    }
}

#[cfg(test)]
mod tests {
    use taxel_data::Layout;

    use super::*;

    fn sample(window: &Window, padding: Padding) -> Vec<f32> {
        let mut sample = vec![f32::NAN; window.ticks() * window.each()];
        window.sample(padding, &mut sample);
        sample
    }

    #[test]
    fn a_series_slides_channel_by_channel() {
        let mut window = Window::new(&SampleSpec::new(Layout::Series, &[2, 3]));
        (0..5).for_each(|t| window.push(&[t as f32, 10.0 + t as f32]));
        assert_eq!(sample(&window, Padding::Zero), [2.0, 3.0, 4.0, 12.0, 13.0, 14.0]);
        window.keep(2);
        assert_eq!((window.known(), window.ticks(), window.each()), (2, 3, 2));
        assert_eq!(sample(&window, Padding::Zero), [3.0, 4.0, 0.0, 13.0, 14.0, 0.0]);
        assert_eq!(sample(&window, Padding::Edge), [3.0, 4.0, 4.0, 13.0, 14.0, 14.0]);
        window.push(&[5.0, 15.0]);
        assert_eq!(sample(&window, Padding::Edge), [3.0, 4.0, 5.0, 13.0, 14.0, 15.0]);
        window.push(&[1.0]);
        assert_eq!(sample(&window, Padding::Edge)[0], 3.0, "no reading of this window");
    }

    #[test]
    fn frames_fingers_and_single_images_lie_as_in_their_samples() {
        let mut frames = Window::new(&SampleSpec::new(Layout::Sequence, &[2, 1, 2]));
        (0..3).for_each(|t| frames.push(&[t as f32, 10.0 + t as f32]));
        assert_eq!(sample(&frames, Padding::Zero), [1.0, 11.0, 2.0, 12.0]);
        frames.keep(1);
        assert_eq!(sample(&frames, Padding::Edge), [2.0, 12.0, 2.0, 12.0]);
        let mut fingers = Window::new(&SampleSpec::new(Layout::Fingers, &[2, 2, 2]));
        (0..2).for_each(|t| fingers.push(&[0.0, 1.0, 2.0, 3.0].map(|v| v * 10.0 + t as f32)));
        assert_eq!(sample(&fingers, Padding::Zero), [0.0, 1.0, 10.0, 11.0, 20.0, 21.0, 30.0, 31.0]);
        let mut image = Window::new(&SampleSpec::new(Layout::Image, &[2, 2]));
        (0..2).for_each(|t| image.push(&[t as f32; 4]));
        assert_eq!((image.ticks(), image.known()), (1, 1));
        assert_eq!(sample(&image, Padding::Zero), [1.0; 4]);
    }
}
