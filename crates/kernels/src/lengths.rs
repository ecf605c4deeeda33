//! Assertions on the lengths of slices, with messages that name the slice.
//!
//! The unchecked loops of this crate rely on them. They stand before the loops, never inside.

/// The most values that sizes may add up to: offsets made of a few such lengths still fit a `usize`.
const MOST: usize = usize::MAX >> 8;

/// Panics unless `len` values are exactly as many as needed.
#[inline]
#[track_caller]
pub(crate) fn exactly(what: &str, len: usize, needed: usize) {
    if len != needed {
        fail(what, len, "", needed);
    }
}

/// Panics where `len` values are fewer than needed.
#[inline]
#[track_caller]
pub(crate) fn at_least(what: &str, len: usize, needed: usize) {
    if len < needed {
        fail(what, len, "at least ", needed);
    }
}

/// Panics unless `len` values are rows of `channels`.
#[inline]
#[track_caller]
pub(crate) fn whole_rows(what: &str, len: usize, channels: usize) {
    if channels == 0 || !len.is_multiple_of(channels) {
        fail(what, len, "rows of ", channels);
    }
}

/// Panics with a message; stands apart from the comparisons, so that those stay short where they are inlined.
#[cold]
#[inline(never)]
#[track_caller]
#[expect(clippy::panic, reason = "slices that do not fit are a programming error of the caller")]
fn fail(what: &str, len: usize, how: &str, needed: usize) -> ! {
    panic!("{what}: {len} values where {how}{needed} are needed")
}

/// Returns the number of values of an image of `size` positions × `channels`; panics where no memory could hold them.
#[track_caller]
pub(crate) fn image(size: [usize; 3], channels: usize) -> usize {
    let len = size.into_iter().try_fold(channels, usize::checked_mul);
    let fits = len.filter(|&len| len <= MOST);
    #[expect(clippy::expect_used, reason = "sizes that overflow are a programming error of the caller")]
    fits.expect("no memory holds an image of this size")
}

/// Returns the number of values from the first to the last of `rows` that start `pitch` apart; panics where no memory
/// could hold them.
#[track_caller]
pub(crate) fn reach(rows: usize, pitch: usize, columns: usize) -> usize {
    if rows == 0 || columns == 0 {
        return 0;
    }
    let last = (rows - 1).checked_mul(pitch).and_then(|last| last.checked_add(columns));
    #[expect(clippy::expect_used, reason = "sizes that overflow are a programming error of the caller")]
    last.expect("no memory holds rows that lie so far apart")
}
