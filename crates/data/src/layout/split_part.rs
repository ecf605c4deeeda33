//! The parts of a split by the names of their folders.

/// A part of the split that the authors of a data set made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum SplitPart {
    Training,
    Validation,
    Test,
}

/// The use of each recording of a split.
pub(crate) struct Marks {
    /// 1 for the recordings that are tested on.
    pub marks: Vec<i64>,
    /// Says for the card which part is used for what.
    pub read_as: String,
}

impl SplitPart {
    /// Finds the part that a folder is, whatever the case of its name.
    pub fn of(name: &str) -> Option<Self> {
        match name.to_lowercase().as_str() {
            "train" | "training" => Some(Self::Training),
            "val" | "valid" | "validation" | "dev" => Some(Self::Validation),
            "test" | "testing" => Some(Self::Test),
            _ => None,
        }
    }

    /// Returns the marks of recordings by the folders of their parts; none unless these are a training part and another.
    ///
    /// A validation part is trained on beside a test part, and tested on where there is none.
    pub fn marks(folders: &[&str]) -> Option<Marks> {
        let parts: Vec<Self> = folders.iter().map(|name| Self::of(name)).collect::<Option<_>>()?;
        let tested = parts.iter().max().copied().filter(|part| *part != Self::Training)?;
        if !parts.contains(&Self::Training) {
            return None;
        }
        let names = |is_it: &dyn Fn(Self) -> bool| {
            let mut names: Vec<&str> =
                folders.iter().zip(&parts).filter(|(_, part)| is_it(**part)).map(|(name, _)| *name).collect();
            names.sort_unstable();
            names.dedup();
            names.join(" and ")
        };
        let (trained, held) = (names(&|part| part != tested), names(&|part| part == tested));
        Some(Marks {
            marks: parts.iter().map(|part| i64::from(*part == tested)).collect(),
            read_as: format!("an official split by folders: {trained} to train on, {held} to test on"),
        })
    }
}
