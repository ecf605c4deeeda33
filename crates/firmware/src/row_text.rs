//! The text of kernels of images: those of series, called for one row after the other, and those that read several rows at once.

use crate::fuse::TOGETHER;
use crate::layer::{Layer, Work};

/// Which kernels read several rows at once.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Lines {
    pub pool: bool,
    pub depthwise: bool,
    /// Whether numbers of the filters of an image remain.
    pub numbers: bool,
}

impl Lines {
    pub fn of(layers: &[Layer]) -> Self {
        let mut lines = Lines::default();
        for layer in layers {
            match &layer.work {
                Work::Most(_) | Work::Mean { .. } | Work::MeanFloats { .. } => {
                    lines.pool |= layer.from[0].rows > 1;
                }
                Work::Depthwise(conv) => lines.depthwise |= conv.lines > 1,
                Work::Conv(_) => lines.numbers |= has_numbers_of_rows(layer),
                _ => {}
            }
        }
        lines
    }
}

/// Checks whether numbers of the filters remain, whose values lie side by side.
pub(crate) fn has_numbers_of_rows(layer: &Layer) -> bool {
    matches!(&layer.work, Work::Conv(conv) if !conv.statistics.is_empty()) && layer.to.pitch == TOGETHER
}

/// Returns the text of the kernel that runs `name` row by row; `fields` have the distances of rows.
pub(crate) fn text(name: &str, fields: &[&str]) -> String {
    let arguments: String = fields.iter().map(|field| format!(", uint32_t {field}_row")).collect();
    let steps: String = fields.iter().map(|field| format!("        row.{field} += {field}_row;\n")).collect();
    include_str!("c/image/rows.c")
        .replace("@name@", name)
        .replace("@distances@", &arguments)
        .replace("@steps@", &steps)
}

/// Returns the text of a kernel whose windows have several rows, `step` from the end of one to the start of the next; without
/// `step` that of a kernel of series.
pub(crate) fn windows(text: &str, step: Option<&str>) -> String {
    let (mut lines, mut inside) = (vec![], false);
    for line in text.lines() {
        let indent = &line[..line.len() - line.trim_start().len()];
        match (line.trim_start(), step) {
            ("LINES", _) => {
                inside = true;
                lines.extend(step.map(|_| format!("{indent}for (line = 0; line < l->lines; line++) {{")));
            }
            ("END LINES", _) => {
                inside = false;
                lines.extend(step.map(|step| format!("{indent}    {step}")));
                lines.extend(step.map(|_| format!("{indent}}}")));
            }
            ("MORE_FIELDS", _) => {}
            (rest, Some(_)) if rest.starts_with("uint32_t position, channel, ") => {
                lines.push(line.replace("channel, ", "channel, line, "));
            }
            (_, Some(_)) if inside => lines.push(format!("    {line}")),
            _ => lines.push(line.into()),
        }
    }
    lines.join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_of_series_have_no_loop_over_rows() {
        let text = "{\n    uint32_t position, channel, at;\n    LINES\n    a();\n    END LINES\n}\n";
        assert_eq!(windows(text, None), "{\n    uint32_t position, channel, at;\n    a();\n}\n");
        let image = windows(text, Some("x += 1;"));
        let wanted = "{\n    uint32_t position, channel, line, at;\n    for (line = 0; line < l->lines; line++) {\n        a();\n        \
                      x += 1;\n    }\n}\n";
        assert_eq!(image, wanted);
    }
}
