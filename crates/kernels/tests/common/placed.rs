//! Convolutions between places with margins and other channels.

use proptest::prelude::*;
use taxel_kernels::Rectifier;
use taxel_kernels::frozen::{self, ImagePlace};

use super::{Case, cases};

/// A convolution and where its values lie: margins beyond what windows reach, and channels beside them.
#[derive(Debug, Clone)]
pub struct Placed {
    pub case: Case,
    pub wider: [usize; 2],
    pub beside: [usize; 2],
    pub rectifier: Rectifier,
}

pub fn placed() -> impl Strategy<Value = Placed> {
    let rectifier = prop_oneof![Just(Rectifier::None), Just(Rectifier::Relu), Just(Rectifier::Relu6)];
    (cases(1..40, 2), [0usize..3, 0..3], [0usize..5, 0..5], rectifier)
        .prop_map(|(case, wider, beside, rectifier)| Placed { case, wider, beside, rectifier })
}

impl Placed {
    pub fn from(&self) -> ImagePlace {
        let [before, after] = frozen::margins(&self.case.window, self.case.dilation);
        let margin = [before + self.wider[0], after + self.wider[1]];
        let Case { window, channels, .. } = self.case;
        ImagePlace::new(window.input, channels, margin, channels + self.beside[0], self.beside[0] / 2)
    }

    pub fn to(&self) -> ImagePlace {
        let Case { window, filters, .. } = self.case;
        ImagePlace::new(window.output, filters, self.wider, filters + self.beside[1], self.beside[1] / 2)
    }
}

/// Dense values at `place`: margins are zero, other channels hold what nobody may read.
pub fn spread(place: &ImagePlace, dense: &[f32]) -> Vec<f32> {
    let mut buffer = vec![0.0; place.buffer_len()];
    for row in 0..place.size[0] * place.size[1] {
        for column in 0..place.size[2] {
            let at = place.at([row / place.size[1], row % place.size[1], column]);
            let start = at - at % place.pitch[2];
            buffer[start..start + place.pitch[2]].fill(f32::NAN);
        }
    }
    frozen::copy(&ImagePlace::dense(place.size, place.channels), dense, place, &mut buffer);
    buffer
}

pub fn gathered(place: &ImagePlace, buffer: &[f32]) -> Vec<f32> {
    let mut dense = vec![0.0; place.len()];
    frozen::copy(place, buffer, &ImagePlace::dense(place.size, place.channels), &mut dense);
    dense
}
