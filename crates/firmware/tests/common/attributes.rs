//! Several attributes, and what has to come of their outputs.

use taxel_base::exponential;
use taxel_firmware::{Answers, Attribute, Shares};

/// Makes probabilities of the outputs of an attribute.
pub fn of_shares(row: &mut [f32], shares: Shares) {
    match shares {
        Shares::Sigmoid => row.iter_mut().for_each(|v| *v = 1.0 / (1.0 + exponential::exp(-*v))),
        Shares::Cut => row.iter_mut().for_each(|v| *v = v.clamp(0.0, 1.0)),
        Shares::Ordered => {
            let mut sum = 0.0;
            for logit in &mut row[1..] {
                sum += *logit;
                *logit = sum;
            }
            row[0] = 0.0;
            exponential::softmax(row);
        }
    }
}

/// Two attributes with awkward names, of two and three classes.
pub fn attributes(shares: Shares, temperature: Option<f64>) -> Answers {
    let attribute = |name: &str, classes: &[&str]| Attribute {
        name: name.into(),
        classes: classes.iter().map(ToString::to_string).collect(),
    };
    let attributes = vec![attribute("\"shore\" */", &["5", "10"]), attribute("größe", &["s", "m?", "l"])];
    Answers::Attributes { attributes, shares, temperature }
}
