//! Sorts names in counting order.

use std::cmp::Ordering;
use std::path::PathBuf;

/// Sorts paths in counting order.
pub(crate) fn in_order(mut paths: Vec<PathBuf>) -> Vec<PathBuf> {
    paths.sort_by(|a, b| natural(&a.to_string_lossy(), &b.to_string_lossy()));
    paths
}

/// Compares texts with their runs of digits as numbers.
pub(crate) fn natural(a: &str, b: &str) -> Ordering {
    let (mut a_rest, mut b_rest) = (a, b);
    while let (Some(x), Some(y)) = (a_rest.chars().next(), b_rest.chars().next()) {
        if x.is_ascii_digit() && y.is_ascii_digit() {
            let digits = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
            let (i, j) = (digits(a_rest), digits(b_rest));
            let number = |text: &'_ str| text.trim_start_matches('0').to_string();
            let (m, n) = (number(&a_rest[..i]), number(&b_rest[..j]));
            let order = m.len().cmp(&n.len()).then_with(|| m.cmp(&n));
            if order != Ordering::Equal {
                return order;
            }
            (a_rest, b_rest) = (&a_rest[i..], &b_rest[j..]);
        } else if x == y {
            (a_rest, b_rest) = (&a_rest[x.len_utf8()..], &b_rest[y.len_utf8()..]);
        } else {
            return x.cmp(&y);
        }
    }
    a_rest.len().cmp(&b_rest.len()).then_with(|| a.cmp(b))
}

#[cfg(test)]
mod tests {
    use super::natural;

    #[test]
    fn files_are_in_the_order_people_count() {
        let mut names = ["b2", "a10", "a9", "a010", "a1b", "a", "a99999999999999999999999"];
        names.sort_by(|a, b| natural(a, b));
        assert_eq!(names, ["a", "a1b", "a9", "a010", "a10", "a99999999999999999999999", "b2"]);
    }
}
