//! Which values a dropout drops: the same on every execution, for any number of threads.

use rand::Rng;

/// The mask of one dropout node in one training step.
///
/// Whether a value is kept is a pure function of (seed, node, step, sample, element): no state moves, so
/// the forward and the backward pass, and all threads, ask in any order and agree. A key is drawn from
/// [`taxel_base::seed::rng`] with the purpose `dropout/<node>/<step>`; SplitMix64's finaliser turns key, sample
/// and element into 24 bits that are held against the probability.
///
/// ```
/// use taxel_graph::DropoutMask;
///
/// let mask = DropoutMask::new(7, "fc3/dropout", 0, 0.2);
/// let kept = (0..10_000).filter(|&element| mask.keeps(0, element)).count();
/// assert!((7_800..8_200).contains(&kept));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DropoutMask {
    key: u64,
    dropped: u64,
}

const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;
const BITS: u32 = 24;

impl DropoutMask {
    /// Draws the mask of `node` in training step `step` (counted from 0) of a run with `seed`.
    pub fn new(seed: u64, node: &str, step: u64, probability: f32) -> Self {
        let key = taxel_base::seed::rng(seed, &format!("dropout/{node}/{step}")).next_u64();
        let dropped = (f64::from(probability) * f64::from(1u32 << BITS)).round() as u64;
        DropoutMask { key, dropped }
    }

    /// Checks whether `element` of `sample` survives. Samples count from 0 in the batch, elements in PyTorch's
    /// row-major order of one sample (channels first).
    #[inline]
    pub fn keeps(&self, sample: usize, element: usize) -> bool {
        let row = mix(self.key.wrapping_add(GOLDEN.wrapping_mul(sample as u64 + 1)));
        let bits = mix(row.wrapping_add(GOLDEN.wrapping_mul(element as u64 + 1)));
        bits >> (64 - BITS) >= self.dropped
    }
}

/// Applies SplitMix64's finaliser (Steele, Lea and Flood 2014).
#[inline]
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_key_is_pinned() {
        // scripts/fixtures/dropout.py holds the same number.
        assert_eq!(DropoutMask::new(0, "pre/dropout", 0, 0.5).key, 17_506_755_000_153_716_510);
    }

    #[test]
    fn the_mask_is_pinned() {
        // By SplitMix64 in Python, from the key above: bit e of a word says whether element e is kept.
        let mask = DropoutMask::new(0, "pre/dropout", 0, 0.5);
        for (sample, kept) in [
            (0, 0x593745b7e94d3f53_u64),
            (1, 0xc92420764ce59a5b),
            (2, 0x6bb294b35ea797b6),
            (5, 0xf83c9f29a0767183),
        ] {
            let bits =
                (0..64).fold(0, |word, element| word | u64::from(mask.keeps(sample, element)) << element);
            assert_eq!(bits, kept, "sample {sample}: {bits:#x}");
        }
    }

    #[test]
    fn seed_node_step_sample_and_element_all_matter() {
        let row =
            |mask: DropoutMask, sample| -> Vec<bool> { (0..256).map(|e| mask.keeps(sample, e)).collect() };
        let base = row(DropoutMask::new(1, "a", 2, 0.5), 3);
        assert_eq!(base, row(DropoutMask::new(1, "a", 2, 0.5), 3));
        for (mask, sample) in [
            (DropoutMask::new(2, "a", 2, 0.5), 3),
            (DropoutMask::new(1, "b", 2, 0.5), 3),
            (DropoutMask::new(1, "a", 3, 0.5), 3),
            (DropoutMask::new(1, "a", 2, 0.5), 4),
        ] {
            let other = row(mask, sample);
            let equal = base.iter().zip(&other).filter(|(a, b)| a == b).count();
            assert!((88..168).contains(&equal), "{equal} of 256 values agree; 128 ± 8 is chance");
        }
    }

    #[test]
    fn the_share_dropped_is_the_probability() {
        for probability in [0.0, 0.2, 0.7] {
            let mask = DropoutMask::new(5, "x", 0, probability);
            let dropped = (0..100).map(|s| (0..1000).filter(|&e| !mask.keeps(s, e)).count()).sum::<usize>();
            let share = dropped as f32 / 1e5;
            assert!((share - probability).abs() < 0.006, "{share} dropped at {probability}");
        }
        assert!((0..10_000).all(|e| DropoutMask::new(5, "x", 0, 0.0).keeps(0, e)));
    }
}
