//! Levels of significance in words.

/// Returns a p-value in words: `= 0.043`, `< 0.001`.
pub(super) fn shown(p: f64) -> String {
    if p < 0.001 { "< 0.001".into() } else { format!("= {p:.3}") }
}
