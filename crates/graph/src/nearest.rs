//! The name that was meant.

/// How many names are offered at most.
const MOST: usize = 3;
/// Characters that a part of a name must have to be one.
const PART: usize = 3;

/// Those of `known` that `name` is nearest to, at most three: by the number of characters to insert, delete,
/// replace or swap, or where that is more than half of the longer name, those that `name` is a part of. Case does
/// not count.
///
/// ```
/// assert_eq!(taxel_graph::nearest("resnet81d", ["mlp", "resnet8-1d"]), ["resnet8-1d"]);
/// assert_eq!(taxel_graph::nearest("net", ["mlp", "resnet8-1d"]), ["resnet8-1d"]);
/// assert!(taxel_graph::nearest("svm", ["mlp", "resnet8-1d"]).is_empty());
/// ```
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let name: Vec<char> = name.to_lowercase().chars().collect();
    let (mut found, mut least) = (vec![], usize::MAX);
    let mut around = vec![];
    for candidate in known {
        let other: Vec<char> = candidate.to_lowercase().chars().collect();
        if found.contains(&candidate) || around.contains(&candidate) {
            continue;
        }
        if around.len() < MOST && name.len() >= PART && other.windows(name.len()).any(|part| part == name) {
            around.push(candidate);
        }
        let most = name.len().max(other.len()) / 2;
        // Names are at least as far apart as their lengths are.
        if name.len().abs_diff(other.len()) > most.min(least) {
            continue;
        }
        let distance = distance(&name, &other);
        if distance > most.min(least) {
            continue;
        }
        if distance < least {
            found.clear();
        }
        least = distance;
        if found.len() < MOST {
            found.push(candidate);
        }
    }
    if found.is_empty() { around } else { found }
}

/// Insertions, deletions, replacements and swaps of neighbours (optimal string alignment).
fn distance(a: &[char], b: &[char]) -> usize {
    let mut before: Vec<usize> = vec![];
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for i in 0..a.len() {
        let mut next = vec![i + 1];
        for j in 0..b.len() {
            let replaced = row[j] + usize::from(a[i] != b[j]);
            let mut least = replaced.min(row[j + 1] + 1).min(next[j] + 1);
            if i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j] {
                least = least.min(before[j - 1] + 1);
            }
            next.push(least);
        }
        (before, row) = (row, next);
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_are_counted_and_neighbours_swapped() {
        let apart = |a: &str, b: &str| {
            let chars = |text: &str| text.chars().collect::<Vec<_>>();
            distance(&chars(a), &chars(b))
        };
        for (a, b, want) in [
            ("", "", 0),
            ("", "abc", 3),
            ("abc", "", 3),
            ("mpl", "mlp", 1),
            ("kitten", "sitting", 3),
            ("ca", "abc", 3),
            ("résnet", "resnet", 1),
        ] {
            assert_eq!((apart(a, b), apart(b, a)), (want, want), "{a} {b}");
        }
    }

    #[test]
    fn ties_are_offered_together_and_far_names_not_at_all() {
        let known = ["resnet8-lite-1d", "resnet8-lite-2d", "vgg6-lite-1d", "mlp"];
        assert_eq!(nearest("resnet8-lite", known), ["resnet8-lite-1d", "resnet8-lite-2d"]);
        assert_eq!(nearest("MPL", known), ["mlp"]);
        assert_eq!(nearest("lite", known), ["resnet8-lite-1d", "resnet8-lite-2d", "vgg6-lite-1d"]);
        assert_eq!(nearest("vgg", known), ["vgg6-lite-1d"]);
        assert!(nearest("2d", known).is_empty() && nearest("transformer", known).is_empty());
        assert!(nearest("", known).is_empty());
        assert_eq!(nearest("a", ["b1", "a1", "a2", "a3", "a4"]), ["a1", "a2", "a3"]);
    }
}
