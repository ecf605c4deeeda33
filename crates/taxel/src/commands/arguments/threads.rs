//! `--threads` and its default, `TAXEL_THREADS`.

use clap::Args;

use crate::terminal::messages::{detail, note};

/// Environment variable with the default of `--threads`.
pub const VARIABLE: &str = "TAXEL_THREADS";

/// The `--threads` of commands that compute.
#[derive(Args)]
pub struct Threads {
    /// Most threads at a time [default: TAXEL_THREADS, or else all cores]; results do not depend on it.
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
}

impl Threads {
    /// Returns how many threads to use: no more than there are cores, which is said.
    ///
    /// # Errors
    /// A `TAXEL_THREADS` that is no number.
    pub fn count(&self) -> Result<usize, String> {
        let variable = std::env::var(VARIABLE).ok().filter(|text| !text.is_empty());
        let (wanted, source) = match (self.threads, variable) {
            (Some(wanted), _) => (Some(wanted), format!("--threads {wanted}")),
            (None, Some(text)) => (Some(from_variable(&text)?), format!("{VARIABLE}={text}")),
            (None, None) => (None, String::new()),
        };
        let threads = taxel::learn::threads(wanted);
        if wanted.is_some_and(|wanted| wanted > threads) {
            note(format!("{source}: this machine has {threads} cores, so {threads} threads run"));
        }
        detail(format!("threads: {threads}"));
        Ok(threads)
    }
}

fn from_variable(text: &str) -> Result<usize, String> {
    let number = text.trim().parse().ok().filter(|count| *count > 0);
    number
        .ok_or_else(|| format!("{VARIABLE}={text}: must be a number of threads from 1, such as {VARIABLE}=2"))
}

#[cfg(test)]
mod tests {
    use super::from_variable;

    #[test]
    fn the_variable_is_a_number_from_1() {
        assert_eq!(from_variable(" 2 "), Ok(2));
        for text in ["two", "0", "-1", "1.5"] {
            let error = from_variable(text).unwrap_err();
            assert!(error.starts_with(&format!("TAXEL_THREADS={text}: must be a number")), "{error}");
        }
    }
}
