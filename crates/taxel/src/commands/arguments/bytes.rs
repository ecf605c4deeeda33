//! Sizes of memories: 64k, 1M, or bytes.

/// Reads a size of memory in bytes; `k` stands for 1,024 and `M` for 1,048,576 of them.
///
/// # Errors
/// A text that is no such size.
pub fn bytes(text: &str) -> Result<u64, String> {
    let (number, unit) = match text.strip_suffix(['k', 'K']) {
        Some(number) => (number, 1 << 10),
        None => text.strip_suffix('M').map_or((text, 1), |number| (number, 1 << 20)),
    };
    let whole = number.parse::<u64>().ok().and_then(|number| number.checked_mul(unit));
    whole.ok_or_else(|| "is no size of memory: write bytes, 64k or 1M".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_units() {
        assert_eq!(bytes("64k"), Ok(65_536));
        assert_eq!(bytes("1M"), Ok(1_048_576));
        assert_eq!(bytes("1500"), Ok(1_500));
        for wrong in ["", "k", "1.5k", "64 k", "-1", "99999999999999M"] {
            assert!(bytes(wrong).is_err(), "{wrong}");
        }
    }
}
