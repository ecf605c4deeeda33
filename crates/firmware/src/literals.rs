//! Numbers, names and tables as C writes them.

use std::fmt::{Display, Write};

/// Columns of a line of C.
const WIDTH: usize = 100;

/// Writes a float so that every compiler reads the same bits; infinities as the largest numbers.
pub(crate) fn float(value: f32) -> String {
    let value = value.clamp(-f32::MAX, f32::MAX);
    if value == 0.0 {
        return "0.0f".into();
    }
    let bits = value.to_bits();
    let sign = if value < 0.0 { "-" } else { "" };
    let (exponent, fraction) = ((bits >> 23 & 0xff) as i32, bits & 0x007f_ffff);
    if exponent == 0 {
        return format!("{sign}0x0.{:06x}p-126f", fraction << 1);
    }
    format!("{sign}0x1.{:06x}p{}f", fraction << 1, exponent - 127)
}

/// Writes a double of 64 bits so that every compiler reads the same bits; infinities as the largest numbers.
pub(crate) fn double(value: f64) -> String {
    let value = value.clamp(-f64::MAX, f64::MAX);
    if value == 0.0 || value.is_subnormal() {
        return "0.0".into();
    }
    let bits = value.to_bits();
    let sign = if value < 0.0 { "-" } else { "" };
    let (exponent, fraction) = ((bits >> 52 & 0x7ff) as i32, bits & 0x000f_ffff_ffff_ffff);
    format!("{sign}0x1.{fraction:013x}p{}", exponent - 1023)
}

/// Makes an identifier of a name: small letters, digits and underscores.
pub(crate) fn identifier(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' };
    let name: String = name.chars().map(plain).collect();
    let name = name.trim_matches('_').to_string();
    if name.is_empty() { "model".into() } else { name }
}

/// Writes a text in quotes; letters outside ASCII as UTF-8 bytes.
pub(crate) fn text(value: &str) -> String {
    let mut quoted = String::from("\"");
    let (mut in_digits, mut parts) = (false, 1);
    for byte in value.bytes() {
        let is_plain = (b' '..=b'~').contains(&byte);
        if in_digits && is_plain {
            // Another literal, which C joins: readers and MISRA want digits of an escape to end.
            quoted.push_str("\" \"");
            parts += 1;
        }
        in_digits = !is_plain;
        match byte {
            b'"' | b'\\' => {
                quoted.push('\\');
                quoted.push(char::from(byte));
            }
            // Not a trigraph.
            b'?' => quoted.push_str("\\?"),
            b' '..=b'~' => quoted.push(char::from(byte)),
            _ => {
                let _ = write!(quoted, "\\{byte:03o}");
            }
        }
    }
    quoted.push('"');
    if parts > 1 { format!("({quoted})") } else { quoted }
}

/// Writes a text for a comment, which it must not end.
pub(crate) fn comment(value: &str) -> String {
    let plain = |c: char| if c.is_control() || c == '\\' { ' ' } else { c };
    value.chars().map(plain).collect::<String>().replace("*/", "* /").replace("/*", "/ *")
}

/// Writes numbers in a row.
pub(crate) fn numbers(values: &[usize]) -> String {
    values.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")
}

/// Writes a constant table.
pub(crate) fn table<T: Display>(kind: &str, name: &str, values: &[T]) -> String {
    let mut out = format!("static const {kind} {name}[{}] = {{\n", values.len().max(1));
    let mut line = String::from("   ");
    for value in values {
        let item = format!(" {value},");
        if line.len() + item.len() > WIDTH {
            out.push_str(&line);
            out.push('\n');
            line = String::from("   ");
        }
        line.push_str(&item);
    }
    if values.is_empty() {
        line.push_str(" 0");
    }
    out.push_str(&line);
    out.push_str("\n};\n");
    out
}

/// Writes a constant table of floats.
pub(crate) fn floats(name: &str, values: &[f32]) -> String {
    let values: Vec<String> = values.iter().map(|value| float(*value)).collect();
    table("float", name, &values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_are_written_bit_by_bit() {
        assert_eq!(float(1.0), "0x1.000000p0f");
        assert_eq!(float(-0.1), "-0x1.99999ap-4f");
        assert_eq!(float(f32::from_bits(3)), "0x0.000006p-126f");
        assert_eq!(float(f32::INFINITY), "0x1.fffffep127f");
        assert_eq!(double(-0.1), "-0x1.999999999999ap-4");
    }

    #[test]
    fn names_and_texts_are_safe() {
        assert_eq!(identifier("ResNet8 lite-1d"), "resnet8_lite_1d");
        assert_eq!(identifier("--"), "model");
        assert_eq!(text("a\"b\\?"), r#""a\"b\\\?""#);
        assert_eq!(text("ä1"), r#"("\303\244" "1")"#);
        assert_eq!(comment("a */ b"), "a * / b");
    }
}
