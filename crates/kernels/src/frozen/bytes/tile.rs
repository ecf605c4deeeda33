//! The one inner loop of convolution in bytes: a block of sums held in registers.

#[cfg(target_arch = "aarch64")]
use crate::simd::Neon;
#[cfg(target_arch = "x86_64")]
use crate::simd::{Avx2, Avx512};
use crate::simd::{Portable, Simd};

#[cfg(target_arch = "aarch64")]
use super::arm::DotProduct;
use super::dot::{Dot, Width};
use super::output::{Ending, Pointer};

/// One block of outputs: addresses and strides.
pub(super) struct Tile<'a> {
    pub a: *const u8,
    pub a_row: usize,
    pub b: *const i8,
    /// Offsets into `a` and `b` where a stretch begins.
    pub segments: &'a [(usize, usize)],
    /// Fours of bytes in a stretch.
    pub fours: usize,
    /// The start of the sums, and then their factors: one value per lane of all vectors.
    pub start: *const i32,
    pub factor: *const f32,
    /// The addend of the sums: address, distance of its rows, zero, factor.
    pub addend: Option<(*const u8, usize, f32, f32)>,
    pub ending: Ending,
    pub c: Pointer,
    pub c_row: usize,
    /// Lanes in the last vector.
    pub last: usize,
}

/// Computes a block of outputs, `M` rows of `N` vectors.
///
/// # Safety
/// The CPU has the features of `S` and `D`; all addresses that the strides of `t` form for `M` rows and `N` vectors (of
/// bytes and outputs the last has `t.last` lanes) are valid, and `c` overlaps nothing that is read.
#[inline(always)]
unsafe fn tile<S: Simd, D: Dot<S>, const M: usize, const N: usize>(t: &Tile) {
    // SAFETY: the caller's contract; every access below is one of those addresses.
    unsafe {
        let first = D::sums(t.start);
        let mut sums = [[first; N]; M];
        for n in 1..N {
            let start = D::sums(t.start.add(n * S::LANES));
            for row in &mut sums {
                row[n] = start;
            }
        }
        for &(from_a, from_b) in t.segments {
            let mut a = t.a.add(from_a);
            let mut b = t.b.add(from_b);
            let mut left = t.fours;
            while D::FOURS > 1 && left >= D::FOURS {
                let mut x = [D::fours(a); M];
                for (m, x) in x.iter_mut().enumerate().skip(1) {
                    *x = D::fours(a.add(m * t.a_row));
                }
                b = products::<S, D, M, N, 0>(&mut sums, &x, b);
                b = products::<S, D, M, N, 1>(&mut sums, &x, b);
                if D::FOURS == 4 {
                    b = products::<S, D, M, N, 2>(&mut sums, &x, b);
                    b = products::<S, D, M, N, 3>(&mut sums, &x, b);
                }
                a = a.wrapping_add(4 * D::FOURS);
                left -= D::FOURS;
            }
            for _ in 0..left {
                let mut x = [D::four(a); M];
                for (m, x) in x.iter_mut().enumerate().skip(1) {
                    *x = D::four(a.add(m * t.a_row));
                }
                b = products::<S, D, M, N, 0>(&mut sums, &x, b);
                a = a.wrapping_add(4);
            }
        }
        // Short loops of their own: sums stay in registers only where every loop over them unrolls.
        let mut y = [[S::splat(0.0); N]; M];
        for (sums, y) in sums.iter().zip(&mut y) {
            for (n, (sum, y)) in sums.iter().zip(y).enumerate() {
                *y = S::mul(D::floats(*sum), S::load(t.factor.add(n * S::LANES)));
            }
        }
        if let Some((addend, distance, zero, factor)) = t.addend {
            let (zero, factor) = (S::splat(zero), S::splat(factor));
            for (m, row) in y.iter_mut().enumerate() {
                for (n, y) in row.iter_mut().enumerate() {
                    let lanes = if n + 1 < N { S::LANES } else { t.last };
                    let x = S::load_bytes(addend.add(m * distance + n * S::LANES), lanes);
                    *y = S::add(*y, S::mul(S::sub(x, zero), factor));
                }
            }
        }
        let Ending { zero, low, high } = t.ending;
        let (zero, low, high) = (S::splat(zero), S::splat(low), S::splat(high));
        for row in &mut y {
            for y in row {
                *y = S::clamp(S::add(*y, zero), low, high);
            }
        }
        for (m, row) in y.iter().enumerate() {
            for (n, y) in row.iter().enumerate() {
                let (at, lanes) = (m * t.c_row + n * S::LANES, if n + 1 < N { S::LANES } else { t.last });
                match t.c {
                    Pointer::Bytes(c) => S::store_bytes(c.add(at), *y, lanes),
                    Pointer::Floats(c) if lanes == S::LANES => S::store(c.add(at), *y),
                    Pointer::Floats(c) => S::store_first(c.add(at), *y, lanes),
                }
            }
        }
    }
}

/// Adds the products of one four of each row with the weights at `b`; returns where the next weights are.
///
/// # Safety
/// As [`tile`]; `b` is one of its addresses.
#[inline(always)]
unsafe fn products<S: Simd, D: Dot<S>, const M: usize, const N: usize, const F: u8>(
    sums: &mut [[D::Sums; N]; M],
    x: &[D::Bytes; M],
    b: *const i8,
) -> *const i8 {
    // SAFETY: as in `tile`.
    unsafe {
        let mut weights = [D::weights(b); N];
        for (n, w) in weights.iter_mut().enumerate().skip(1) {
            *w = D::weights(b.add(n * 4 * S::LANES));
        }
        for (row, &x) in sums.iter_mut().zip(x) {
            for (sum, &w) in row.iter_mut().zip(&weights) {
                *sum = D::dot::<F>(*sum, x, w);
            }
        }
        b.wrapping_add(N * 4 * S::LANES)
    }
}

/// A compiled block of `rows` × `vectors`.
pub(super) type BlockKernel = unsafe fn(&Tile);

/// Kernels of one width, of one, two and four vectors: `[..][rows - 1]`.
pub(super) struct Kernels {
    pub lanes: usize,
    /// A number that the kernels take from every byte.
    pub taken: u8,
    /// Where weight `k` of a lane lies.
    pub place: fn(usize, usize) -> usize,
    table: [&'static [BlockKernel]; 3],
}

macro_rules! kernels {
    ($simd:ty, $dot:ty, $vectors:literal, $attribute:meta, [$($rows:literal)*]) => {
        &[$({
            #[$attribute]
            unsafe fn kernel(t: &Tile) {
                // SAFETY: the caller of the kernel keeps the contract of `tile`.
                unsafe { tile::<$simd, $dot, $rows, $vectors>(t) }
            }
            kernel as BlockKernel
        }),*]
    };
}

static PORTABLE: Kernels = Kernels {
    lanes: Portable::LANES,
    taken: <Portable as Dot<Portable>>::TAKEN,
    place: <Portable as Dot<Portable>>::place,
    table: [
        kernels!(Portable, Portable, 1, inline(never), [1 2 3 4]),
        kernels!(Portable, Portable, 2, inline(never), [1 2]),
        kernels!(Portable, Portable, 4, inline(never), [1]),
    ],
};

#[cfg(target_arch = "x86_64")]
static AVX2: Kernels = Kernels {
    lanes: Avx2::LANES,
    taken: <Avx2 as Dot<Avx2>>::TAKEN,
    place: <Avx2 as Dot<Avx2>>::place,
    table: [
        kernels!(Avx2, Avx2, 1, target_feature(enable = "avx2,fma"), [1 2 3 4 5 6 7 8]),
        kernels!(Avx2, Avx2, 2, target_feature(enable = "avx2,fma"), [1 2 3 4]),
        kernels!(Avx2, Avx2, 4, target_feature(enable = "avx2,fma"), [1]),
    ],
};

#[cfg(target_arch = "x86_64")]
static VNNI: Kernels = Kernels {
    lanes: Avx512::LANES,
    taken: <Avx512 as Dot<Avx512>>::TAKEN,
    place: <Avx512 as Dot<Avx512>>::place,
    table: [
        kernels!(Avx512, Avx512, 1, target_feature(enable = "avx512f,avx512bw,avx512vnni"), [1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24]),
        kernels!(Avx512, Avx512, 2, target_feature(enable = "avx512f,avx512bw,avx512vnni"), [1 2 3 4 5 6 7 8 9 10 11 12]),
        kernels!(Avx512, Avx512, 4, target_feature(enable = "avx512f,avx512bw,avx512vnni"), [1 2 3 4 5 6]),
    ],
};

#[cfg(target_arch = "aarch64")]
static NEON: Kernels = Kernels {
    lanes: Neon::LANES,
    taken: <Neon as Dot<Neon>>::TAKEN,
    place: <Neon as Dot<Neon>>::place,
    table: [
        kernels!(Neon, Neon, 1, inline(never), [1 2 3 4 5 6 7 8 9 10]),
        kernels!(Neon, Neon, 2, inline(never), [1 2 3 4 5 6 7 8]),
        kernels!(Neon, Neon, 4, inline(never), [1 2 3 4]),
    ],
};

#[cfg(target_arch = "aarch64")]
static DOT_PRODUCT: Kernels = Kernels {
    lanes: Neon::LANES,
    taken: DotProduct::TAKEN,
    place: <DotProduct as Dot<Neon>>::place,
    table: [
        kernels!(Neon, DotProduct, 1, target_feature(enable = "dotprod"), [1 2 3 4 5 6 7 8 9 10 11 12]),
        kernels!(Neon, DotProduct, 2, target_feature(enable = "dotprod"), [1 2 3 4 5 6 7 8]),
        kernels!(Neon, DotProduct, 4, target_feature(enable = "dotprod"), [1 2 3 4 5]),
    ],
};

impl Kernels {
    pub fn of(width: Width) -> &'static Kernels {
        match width {
            #[cfg(target_arch = "aarch64")]
            Width::Neon => &NEON,
            #[cfg(target_arch = "aarch64")]
            Width::DotProduct => &DOT_PRODUCT,
            #[cfg(target_arch = "x86_64")]
            Width::Avx2 => &AVX2,
            #[cfg(target_arch = "x86_64")]
            Width::Vnni => &VNNI,
            _ => &PORTABLE,
        }
    }

    /// Returns the number of vectors of the next kernel, where `lanes` outputs are left and rows of outputs are
    /// `columns` long.
    pub fn vectors(&self, lanes: usize, columns: usize) -> usize {
        let most = if columns <= self.rows(4) { 4 } else { 2 };
        [4, 2, 1].into_iter().find(|&v| v <= most && v <= lanes.div_ceil(self.lanes)).unwrap_or(1)
    }

    fn column(vectors: usize) -> usize {
        vectors.trailing_zeros() as usize
    }

    /// Returns the most rows of a block of 1, 2 or 4 vectors.
    pub fn rows(&self, vectors: usize) -> usize {
        self.table[Self::column(vectors)].len()
    }

    pub fn kernel(&self, vectors: usize, rows: usize) -> BlockKernel {
        self.table[Self::column(vectors)][rows - 1]
    }
}
