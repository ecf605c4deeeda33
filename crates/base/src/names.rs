//! Finds the name that was meant, for messages about an unknown one.
//!
//! ```
//! let hint = taxel_base::names::hint("resnet18-lite", ["mlp", "resnet8-lite"]);
//! assert_eq!(hint, "did you mean `resnet8-lite`? known: mlp, resnet8-lite");
//! ```

/// Most names that are offered.
const MOST: usize = 3;
/// Fewest characters of a part of a name.
const PART: usize = 3;
/// Most names that are listed although one of them is near.
const LIST: usize = 20;

/// Finds the names of `known` that are nearest to `name`, at most three, by the number of characters to insert, delete,
/// replace or swap. Where that is more than half of the longer name, finds those that `name` is a part of. Case does not
/// count.
///
/// ```
/// assert_eq!(taxel_base::names::nearest("resnet81d", ["mlp", "resnet8-1d"]), ["resnet8-1d"]);
/// assert_eq!(taxel_base::names::nearest("net", ["mlp", "resnet8-1d"]), ["resnet8-1d"]);
/// assert!(taxel_base::names::nearest("svm", ["mlp", "resnet8-1d"]).is_empty());
/// ```
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let name = name.to_lowercase();
    let length = name.chars().count();
    let (mut found, mut least) = (vec![], usize::MAX);
    let mut around = vec![];
    for candidate in known {
        let other = candidate.to_lowercase();
        if found.contains(&candidate) || around.contains(&candidate) {
            continue;
        }
        if around.len() < MOST && length >= PART && other.contains(&name) {
            around.push(candidate);
        }
        let most = length.max(other.chars().count()) / 2;
        let distance = strsim::osa_distance(&name, &other);
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

/// Returns the hint about an unknown name: those that may be meant, and all of a list that is short.
///
/// ```
/// let hint = taxel_base::names::hint("mpl", ["mlp", "lstm"]);
/// assert_eq!(hint, "did you mean `mlp`? known: mlp, lstm");
/// assert_eq!(taxel_base::names::hint("transformer", ["mlp", "lstm"]), "known: mlp, lstm");
/// ```
pub fn hint<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    match (meant(name, known.iter().copied()), known.len() <= LIST) {
        (Some(meant), true) => format!("{meant} known: {}", known.join(", ")),
        (Some(meant), false) => meant,
        (None, _) => format!("known: {}", known.join(", ")),
    }
}

/// Says that a name is unknown, with the nearest known one and all that are expected; `what` is its kind.
///
/// ```
/// let said = taxel_base::names::unknown("field", "epoch", &["epochs", "loss"]);
/// assert_eq!(said, "unknown field `epoch`: did you mean `epochs`? expected `epochs` or `loss`");
/// ```
pub fn unknown(what: &str, name: &str, expected: &[&str]) -> String {
    let all = match expected {
        [] => format!("there are no {what}s"),
        [one] => format!("expected `{one}`"),
        [one, two] => format!("expected `{one}` or `{two}`"),
        several => format!("expected one of `{}`", several.join("`, `")),
    };
    match meant(name, expected.iter().copied()) {
        Some(meant) => format!("unknown {what} `{name}`: {meant} {all}"),
        None => format!("unknown {what} `{name}`, {all}"),
    }
}

/// Asks `did you mean ...?`, where a name is near.
fn meant<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    match nearest(name, known).as_slice() {
        [] => None,
        names => Some(format!("did you mean `{}`?", names.join("` or `"))),
    }
}

/// Adds the nearest of the expected names to a message of serde about an unknown key or value; leaves other messages as
/// they are.
///
/// ```
/// let message = taxel_base::names::with_meant("unknown field `epoch`, expected one of `epochs`, `loss`");
/// assert_eq!(message, "unknown field `epoch`: did you mean `epochs`? expected one of `epochs`, `loss`");
/// ```
pub fn with_meant(message: &str) -> String {
    let hinted = || {
        let start = ["unknown field `", "unknown variant `"]
            .iter()
            .find_map(|start| message.find(start).map(|at| at + start.len()))?;
        let (name, expected) = message[start..].split_once("`, expected ")?;
        let known = expected.split('`').skip(1).step_by(2);
        let meant = meant(name, known)?;
        Some(format!("{}{name}`: {meant} expected {expected}", &message[..start]))
    };
    hinted().unwrap_or_else(|| message.into())
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn swapped_letters_are_one_mistake() {
        assert_eq!(nearest("mpl", ["mlp", "m"]), ["mlp"]);
        assert_eq!(nearest("résnet", ["resnet", "mlp"]), ["resnet"]);
    }

    #[test]
    fn serde_is_led_to_the_nearest() {
        let message = "settings: unknown variant `sdg`, expected `sgdm` or `adam`";
        assert_eq!(
            with_meant(message),
            "settings: unknown variant `sdg`: did you mean `sgdm`? expected `sgdm` or `adam`"
        );
        for same in
            ["missing field `name`", "unknown field `x`, expected one of `epochs`", "unknown field `x`"]
        {
            assert_eq!(with_meant(same), same);
        }
    }
}
