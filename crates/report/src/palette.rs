//! The colours of page and charts, light and dark; the page's style sheet takes them from here.

use kuva::render::color::Color;

/// Purpose of a colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ink {
    /// Text and axes.
    Text,
    /// Text of less weight, and what is dominated.
    Muted,
    /// Grid lines.
    Grid,
    /// Background.
    Paper,
    /// Marks that a reader should see first.
    Accent,
    /// The same without insisting: what joins marks.
    Soft,
    /// Cells of a heat map and of a confusion matrix, by their opacity.
    Heat,
    /// One of several things, by its number.
    Series(usize),
    /// Nothing.
    None,
}

/// Different colours of [`Ink::Series`].
pub const SERIES: usize = 10;

/// Names of the style sheet's variables with their light and dark values. On their backgrounds, text has a
/// contrast of at least 4.5, marks of at least 3 (a test holds that).
pub const COLOURS: [(&str, &str, &str); 7 + SERIES] = [
    ("text", "#1b1f24", "#e8eaed"),
    ("muted", "#626a73", "#9aa3ad"),
    ("grid", "#dde1e6", "#343b43"),
    ("paper", "#ffffff", "#15181c"),
    ("accent", "#0b5fa5", "#6db7f5"),
    ("heat", "#e8871e", "#b8620a"),
    ("soft", "#a8cdec", "#2a557a"),
    ("s0", "#0b6fb8", "#5fb2f2"),
    ("s1", "#c84e00", "#ff9557"),
    ("s2", "#0a8a5f", "#43c899"),
    ("s3", "#a03d92", "#dd8fd2"),
    ("s4", "#8f6b00", "#e0b93d"),
    ("s5", "#12829a", "#5cc8dc"),
    ("s6", "#c2185b", "#ff7fae"),
    ("s7", "#5b6ee1", "#9aa6ff"),
    ("s8", "#64800a", "#b4d147"),
    ("s9", "#7a4a2b", "#cf9d7b"),
];

/// Where a chart is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Paint {
    /// In the page: colours are the style sheet's variables.
    Page,
    /// In a file: the light colours.
    Print,
}

impl Ink {
    /// Returns the colour, as a variable of the style sheet or as a value.
    pub fn colour(self, paint: Paint) -> Color {
        let at = match self {
            Ink::Text => 0,
            Ink::Muted => 1,
            Ink::Grid => 2,
            Ink::Paper => 3,
            Ink::Accent => 4,
            Ink::Heat => 5,
            Ink::Soft => 6,
            Ink::Series(number) => 7 + number % SERIES,
            Ink::None => return Color::None,
        };
        let (name, light, _) = COLOURS[at];
        match paint {
            Paint::Page => Color::Css(format!("var(--{name})").into()),
            Paint::Print => light.into(),
        }
    }
}

/// Returns the variables of one theme as CSS declarations.
pub fn variables(dark: bool) -> String {
    let value = |&(name, light, night): &(&str, &str, &str)| {
        format!("--{name}:{};", if dark { night } else { light })
    };
    COLOURS.iter().map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Computes the relative luminance (WCAG 2.2).
    fn luminance(hex: &str) -> f64 {
        let part = |i: usize| {
            let value = f64::from(u8::from_str_radix(&hex[i..i + 2], 16).unwrap()) / 255.0;
            if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * part(1) + 0.7152 * part(3) + 0.0722 * part(5)
    }

    #[test]
    fn colours_stand_out_from_their_paper() {
        let contrast = |a: &str, b: &str| {
            let (a, b) = (luminance(a), luminance(b));
            (a.max(b) + 0.05) / (a.min(b) + 0.05)
        };
        let paper = COLOURS[3];
        for (name, light, dark) in COLOURS {
            let least = match name {
                "text" | "muted" | "accent" => 4.5,
                "grid" | "paper" | "heat" | "soft" => continue,
                _ => 3.0,
            };
            assert!(contrast(light, paper.1) >= least, "{name} on light: {}", contrast(light, paper.1));
            assert!(contrast(dark, paper.2) >= least, "{name} on dark: {}", contrast(dark, paper.2));
        }
        // Numbers stand in heat cells.
        assert!(contrast(COLOURS[0].1, COLOURS[5].1) >= 4.5 && contrast(COLOURS[0].2, COLOURS[5].2) >= 3.0);
    }
}
