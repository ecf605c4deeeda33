//! Views and the gradients through them against PyTorch's numbers.

use taxel_kernels::batch_norm::{self, InputGradient};
use taxel_kernels::reduce::add_gradient_sums;
use taxel_kernels::{AffineView, Rectifier};

/// ```python
/// x = torch.tensor([-1, 0, 2, 6, 7, torch.nan], requires_grad=True)
/// torch.nn.functional.relu6(x).sum().backward()  # 0 0 1 0 0 1; and relu: 0 0 1 1 1 1
/// ```
#[test]
fn corners_are_those_of_pytorch_with_and_without_a_norm() {
    let x = [-1.0, 0.0, 2.0, 6.0, 7.0, f32::NAN];
    for (rectifier, seen, passes) in [
        (Rectifier::None, [-1.0, 0.0, 2.0, 6.0, 7.0], [1.0; 6]),
        (Rectifier::Relu, [0.0, 0.0, 2.0, 6.0, 7.0], [0.0, 0.0, 1.0, 1.0, 1.0, 1.0]),
        (Rectifier::Relu6, [0.0, 0.0, 2.0, 6.0, 6.0], [0.0, 0.0, 1.0, 0.0, 0.0, 1.0]),
    ] {
        // One channel, and rows of 35 that fill vectors and leave a rest.
        for channels in [1, 35] {
            let wide =
                |values: &[f32]| -> Vec<f32> { values.iter().flat_map(|v| vec![*v; channels]).collect() };
            let (ones, zeros) = (vec![1.0; channels], vec![0.0; channels]);
            let norm = InputGradient {
                dy: ones.clone(),
                x: zeros.clone(),
                mean: zeros.clone(),
                constant: zeros.clone(),
            };
            // Without the NaN, since 0 · NaN is NaN in the norm's gradient.
            let finite = wide(&x[..5]);
            for affine in [None, Some((&ones[..], &zeros[..]))] {
                let view = AffineView { affine, rectifier };
                let (x, mut y) = (wide(&x), vec![1.0; 6 * channels]);
                view.apply(channels, &x, &mut y);
                assert_eq!(y[..5 * channels], wide(&seen), "{view:?}");
                assert!(y[5 * channels..].iter().all(|v| v.is_nan()), "{view:?}");
                let (dy, mut dx) = (vec![1.0; 6 * channels], vec![2.0; 6 * channels]);
                if affine.is_some() {
                    let (dy, dx) = (&dy[..finite.len()], &mut dx[..finite.len()]);
                    batch_norm::backward(channels, &finite, &view, Some(&norm), dy, dx, false);
                    assert_eq!(*dx, wide(&passes[..5]), "{view:?}");
                    let (mut sums, mut deviations) = (zeros.clone(), zeros.clone());
                    add_gradient_sums(channels, &finite, &view, dy, &zeros, &mut sums, &mut deviations);
                    assert_eq!(sums, vec![passes[..5].iter().sum::<f32>(); channels], "{view:?}");
                } else {
                    batch_norm::backward(channels, &x, &view, None, &dy, &mut dx, false);
                    assert_eq!(dx, wide(&passes), "{view:?}");
                }
            }
        }
    }
}
