//! Every frame of a recording as a sample of its own.

use ndarray::{ArrayD, IxDyn};
use taxel_base::Layout;

use crate::dataset::dataset::Dataset;
use crate::{Error, Result};

impl Dataset {
    /// Takes samples `[N, frames, rows, columns]` apart into `[N * frames, rows, columns]`, frame after frame of recording
    /// after recording, for methods for single images (Pastor et al. 2019, section 4.2).
    ///
    /// The frames of a recording are one [unit](Dataset::units), and where there are no groups one group: splits keep them
    /// together, and a bootstrap draws them together.
    ///
    /// # Errors
    ///
    /// Samples that are no sequences of frames.
    pub fn each_frame(mut self) -> Result<Self> {
        let (Layout::Sequence, &[frames, height, width]) = (self.spec.layout, &self.spec.shape[..]) else {
            let (what, shape) = (self.spec.layout.describe(), &self.spec.shape);
            let why = format!("a sample of shape {shape:?} is {what}, and has no frames to take apart");
            return Err(Error::file(self.name, why));
        };
        let recordings = self.len();
        // All but the values, which stay where they are.
        let x = std::mem::replace(&mut self.x, ArrayD::zeros(IxDyn(&[recordings, 0])));
        self.row_hash = vec![];
        let recording = |row: usize| row / frames;
        let rows: Vec<usize> = (0..recordings * frames).map(recording).collect();
        let first = |recording: u32| recording * frames as u32;
        let units = self.units.take().unwrap_or_else(|| (0..recordings as u32).collect());
        self.units = Some(units.into_iter().map(first).collect());
        let mut each = self.rows(&rows);
        if each.groups.is_none() {
            each.groups = Some(rows.iter().map(|&row| row as u32).collect());
            each.group_name = Some("recording".into());
        }
        for (row, origin) in each.origins.iter_mut().enumerate() {
            origin.push_str(&format!(", frame {}", row % frames));
        }
        each.spec.layout = Layout::Image;
        each.spec.shape = vec![height, width];
        (each.spec.length, each.spec.rate, each.spec.stamped) = (None, None, None);
        #[expect(clippy::expect_used, reason = "the number of values stays, and samples lie in C order")]
        let x =
            x.into_shape_with_order(IxDyn(&[recordings * frames, height, width])).expect("as many values");
        each.x = x;
        each.update_digest();
        Ok(each)
    }
}
