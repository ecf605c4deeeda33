//! Whether the readings of a sample are like those of the training, as C.

use crate::literals::{float, floats};

/// The gate of the readings of a model: the numbers that summarise a sample, their Mahalanobis distance from those of known samples,
/// and how far is too far.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadingsGate {
    /// Channels of a sample; of still images rows.
    pub channels: usize,
    /// Steps of a channel; of still images columns.
    pub steps: usize,
    /// Distance of two steps of a channel.
    pub by_step: usize,
    /// Whether steps follow each other in time.
    pub has_time: bool,
    /// Number that is added to deviations before their logarithm is taken.
    pub floor: f32,
    /// Mean of each number.
    pub center: Vec<f32>,
    /// Lower triangle of the matrix that brings deviations from the center to variance 1, row by row.
    pub around: Vec<f32>,
    /// A sample that is farther is unknown.
    pub limit: f32,
}

impl ReadingsGate {
    /// Returns the bytes of the tables.
    pub(crate) fn table_bytes(&self) -> usize {
        4 * (self.center.len() + self.around.len())
    }

    /// Returns about the bytes of the code, with those of the logarithm and the root.
    pub(crate) fn code_bytes(&self) -> usize {
        1700
    }

    /// Writes tables and functions.
    pub(crate) fn text(&self) -> String {
        let ReadingsGate { channels, steps, by_step, has_time, floor, center, around, limit } = self;
        let tables = floats("readings_center", center) + &floats("readings_around", around);
        let by_channel = if *by_step == 1 { *steps } else { 1 };
        let shared = if *has_time { 12 } else { 8 };
        // Further numbers are the means of single channels, or features.
        let (each_mean, features) = match center.len() - shared {
            0 => ("", ""),
            single if single == *channels => ("        numbers[@shared@u + i] = own.mean;\n", ""),
            _ => ("", include_str!("../c/answers/readings_features.c")),
        };
        let (ends, each, set, across) = if *has_time {
            let ends =
                "    float low_spread = 0.0f, high_spread = 0.0f, low_mean = 0.0f, high_mean = 0.0f;\n";
            let each = include_str!("../c/answers/readings_ends.c");
            (ends, each, include_str!("../c/answers/readings_time.c"), "")
        } else {
            let across = include_str!("../c/answers/readings_across.c");
            ("", "", include_str!("../c/answers/readings_still.c"), across)
        };
        let mut functions = include_str!("../c/answers/readings.c").to_string();
        for (key, value) in [
            ("@across@", across.to_string()),
            ("@ends@", ends.into()),
            ("@each_end@", format!("{each}{each_mean}")),
            ("@set@", format!("{set}{features}")),
            ("@shared@", shared.to_string()),
            ("@channel_count@", channels.to_string()),
            ("@steps_of_channel@", steps.to_string()),
            ("@distance_of_steps@", by_step.to_string()),
            ("@distance_of_channels@", by_channel.to_string()),
            ("@numbers@", center.len().to_string()),
            ("@floor@", float(*floor)),
            ("@limit@", float(*limit)),
        ] {
            functions = functions.replace(key, &value);
        }
        format!("\n{tables}\n{functions}")
    }
}
